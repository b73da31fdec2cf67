# Sources made at build time: the GL function table (glad, offline) and the embedded shaders.
set(weft_generated_dir ${PROJECT_BINARY_DIR}/generated)

set(weft_glad_source ${weft_generated_dir}/src/gl.c)
add_custom_command(OUTPUT ${weft_glad_source} ${weft_generated_dir}/include/glad/gl.h
    COMMAND ${WEFT_GLAD} --quiet --reproducible --api gl:core=4.5 --extensions ""
        --out-path ${weft_generated_dir} c --mx
    COMMENT "Generating the GL function table" VERBATIM)
# No extensions: the loader would look for their names in copies that it does not check for NULL.
# The source is a part of passes/gl/gl_load.c.
set_source_files_properties(${weft_glad_source} PROPERTIES HEADER_FILE_ONLY ON)
set_source_files_properties(passes/gl/gl_load.c PROPERTIES COMPILE_OPTIONS -w
    INCLUDE_DIRECTORIES ${weft_generated_dir})

file(GLOB_RECURSE weft_shaders CONFIGURE_DEPENDS passes/*.glsl)
set(weft_shader_source ${weft_generated_dir}/src/shaders.c)
add_custom_command(OUTPUT ${weft_shader_source}
    COMMAND ${CMAKE_COMMAND} -D OUT=${weft_shader_source} -D ROOT=${PROJECT_SOURCE_DIR}
        -D "SHADERS=${weft_shaders}"
        -P ${PROJECT_SOURCE_DIR}/cmake/embed.cmake
    DEPENDS ${weft_shaders} cmake/embed.cmake
    COMMENT "Embedding the shaders" VERBATIM)

set(weft_generated_sources ${weft_glad_source} ${weft_shader_source})
