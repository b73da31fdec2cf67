# cmake -D MANIFEST=BUILD/install_manifest.txt -P uninstall.cmake: removes the files that the last
# `cmake --install` listed there, below $DESTDIR where it is set, and the folders of the prefix that
# are empty then. In /usr only folders within one called weft go: others belong to the system.
cmake_minimum_required(VERSION 3.25)
if(NOT EXISTS "${MANIFEST}")
    message(FATAL_ERROR "nothing to remove: no ${MANIFEST}, which cmake --install writes")
endif()
file(STRINGS "${MANIFEST}" files ENCODING UTF-8)

# The prefix is the deepest folder that all are in.
list(GET files 0 prefix)
foreach(file IN LISTS files)
    cmake_path(IS_PREFIX prefix "${file}" is_prefix)
    while(NOT is_prefix)
        cmake_path(GET prefix PARENT_PATH prefix)
        cmake_path(IS_PREFIX prefix "${file}" is_prefix)
    endwhile()
endforeach()

set(removed 0)
set(folders "")
foreach(file IN LISTS files)
    set(path "$ENV{DESTDIR}${file}")
    if(EXISTS "${path}" OR IS_SYMLINK "${path}")
        execute_process(COMMAND rm -f -- "${path}" COMMAND_ERROR_IS_FATAL ANY)
        math(EXPR removed "${removed} + 1")
    endif()
    cmake_path(GET file PARENT_PATH folder)
    while(NOT folder IN_LIST folders AND NOT folder STREQUAL prefix AND NOT folder STREQUAL "/")
        list(APPEND folders "${folder}")
        cmake_path(GET folder PARENT_PATH folder)
    endwhile()
endforeach()

# What is in a folder comes before it; rmdir leaves those that are not empty.
list(SORT folders ORDER DESCENDING)
foreach(folder IN LISTS folders)
    if(NOT "$ENV{DESTDIR}${folder}" MATCHES "^/usr/" OR folder MATCHES "/weft(/|$)")
        execute_process(COMMAND rmdir -- "$ENV{DESTDIR}${folder}" ERROR_QUIET)
    endif()
endforeach()
file(REMOVE "${MANIFEST}")
list(LENGTH files listed)
message(STATUS "Removed ${removed} of the ${listed} files that were installed")
