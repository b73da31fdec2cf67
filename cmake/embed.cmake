# Turns shader files into C strings: weft_shader_<name>, see passes/gl/program.h.
set(text "// Made by cmake/embed.cmake from passes/*/*.glsl.\n")
foreach(shader IN LISTS SHADERS)
    get_filename_component(name ${shader} NAME_WE)
    file(READ ${shader} source)
    string(REPLACE "\\" "\\\\" source "${source}")
    string(REPLACE "\"" "\\\"" source "${source}")
    string(REPLACE "\n" "\\n\"\n    \"" source "${source}")
    string(APPEND text "extern const char weft_shader_${name}[];\n"
        "const char weft_shader_${name}[] =\n    \"${source}\";\n")
endforeach()
file(WRITE ${OUT} "${text}")
