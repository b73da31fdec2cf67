# Sources made at build time: the GL function table (glad, offline) and the embedded shaders.
set(weft_generated_dir ${PROJECT_BINARY_DIR}/generated)

set(weft_glad_source ${weft_generated_dir}/src/gl.c)
add_custom_command(OUTPUT ${weft_glad_source} ${weft_generated_dir}/include/glad/gl.h
    COMMAND ${WEFT_GLAD} --quiet --reproducible --api gl:core=4.5 --extensions ""
        --out-path ${weft_generated_dir} c --mx
    COMMENT "Generating the GL function table" VERBATIM)
# No extensions: the loader would look for their names in copies that it does not check for NULL.
# The source is a part of passes/gl/gl_load.c and, for the command, of tools/render/gl/gl_load.c.
set_source_files_properties(${weft_glad_source} PROPERTIES HEADER_FILE_ONLY ON)
set_source_files_properties(passes/gl/gl_load.c tools/render/gl/gl_load.c PROPERTIES COMPILE_OPTIONS -w
    INCLUDE_DIRECTORIES ${weft_generated_dir})

# Embeds the shaders of a folder, whose strings are called prefix and name; see cmake/embed.cmake.
function(weft_embed_shaders folder prefix out)
    file(GLOB_RECURSE shaders CONFIGURE_DEPENDS ${folder}/*.glsl)
    set(source ${weft_generated_dir}/src/${folder}_shaders.c)
    add_custom_command(OUTPUT ${source}
        COMMAND ${CMAKE_COMMAND} -D OUT=${source} -D ROOT=${PROJECT_SOURCE_DIR} -D PREFIX=${prefix}
            -D "SHADERS=${shaders}"
            -P ${PROJECT_SOURCE_DIR}/cmake/embed.cmake
        DEPENDS ${shaders} cmake/embed.cmake
        COMMENT "Embedding the shaders of ${folder}" VERBATIM)
    set(${out} ${source} PARENT_SCOPE)
endfunction()
weft_embed_shaders(passes weft_shader_ weft_shader_source)
weft_embed_shaders(tools tools_shader_ tools_shader_source)

set(weft_generated_sources ${weft_glad_source} ${weft_shader_source})
