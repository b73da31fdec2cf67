# cmake -D SOURCE=FOLDER -D OUT=FILE.c -P commit.cmake: writes weft_commit, where it is another one:
# that of the repository whose root SOURCE is, or of the archive that git made; "" where neither is.
cmake_minimum_required(VERSION 3.25)
set(commit "")
if(EXISTS ${SOURCE}/.git)
    execute_process(COMMAND git --no-optional-locks describe --always --exclude "*" --abbrev=12 --dirty
        WORKING_DIRECTORY ${SOURCE} OUTPUT_VARIABLE commit ERROR_QUIET
        OUTPUT_STRIP_TRAILING_WHITESPACE)
else()
    file(STRINGS ${SOURCE}/cmake/archive.txt commit LIMIT_COUNT 1)
endif()
string(REGEX REPLACE "-dirty$" ", changed" commit "${commit}")
if(NOT commit MATCHES "^[0-9a-f]+(, changed)?$")
    set(commit "")
endif()
file(CONFIGURE OUTPUT ${OUT} @ONLY CONTENT
    "extern const char weft_commit[];\nconst char weft_commit[] = \"@commit@\";\n")
