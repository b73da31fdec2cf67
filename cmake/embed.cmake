# Turns shader files into C strings: PREFIX<name>, as passes/gl/program.h has weft_shader_. A line
# `#include "FILE"`, from the source root, becomes that file; files that are only included have no
# main of their own and no string. NAME_head.glsl stands before a text with a main, and has one.
set(text "// Made by cmake/embed.cmake from *.glsl.\n")
foreach(shader IN LISTS SHADERS)
    get_filename_component(name ${shader} NAME_WE)
    file(READ ${shader} source)
    if(NOT source MATCHES "void main\\(\\)" AND NOT name MATCHES "_head$")
        continue()
    endif()
    string(REGEX MATCHALL "#include \"[^\"\n]*\"\n" includes "${source}")
    foreach(line IN LISTS includes)
        string(REGEX REPLACE "#include \"(.*)\"\n" "\\1" path "${line}")
        file(READ ${ROOT}/${path} included)
        string(REPLACE "${line}" "${included}" source "${source}")
    endforeach()
    string(REPLACE "\\" "\\\\" source "${source}")
    string(REPLACE "\"" "\\\"" source "${source}")
    string(REPLACE "\n" "\\n\"\n    \"" source "${source}")
    string(APPEND text "extern const char ${PREFIX}${name}[];\n"
        "const char ${PREFIX}${name}[] =\n    \"${source}\";\n")
endforeach()
file(WRITE ${OUT} "${text}")
