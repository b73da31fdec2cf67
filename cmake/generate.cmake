# Sources made at build time: the GL function table (glad, offline) and the embedded shaders.
set(weft_generated_dir ${PROJECT_BINARY_DIR}/generated)

set(weft_glad_apis gl:core=4.5)
if(TARGET weft_dep_egl)
    string(APPEND weft_glad_apis ",egl=1.5")
    set(weft_glad_egl ${weft_generated_dir}/src/egl.c)
endif()
set(weft_glad_extensions
    GL_KHR_debug,EGL_EXT_device_enumeration,EGL_EXT_device_query,EGL_EXT_platform_base)
string(APPEND weft_glad_extensions
    ",EGL_EXT_platform_device,EGL_KHR_surfaceless_context,EGL_KHR_no_config_context")
set(weft_glad_sources ${weft_generated_dir}/src/gl.c ${weft_glad_egl})
add_custom_command(OUTPUT ${weft_glad_sources} ${weft_generated_dir}/include/glad/gl.h
    COMMAND ${WEFT_GLAD} --quiet --reproducible --api ${weft_glad_apis}
        --extensions ${weft_glad_extensions} --out-path ${weft_generated_dir} c --mx
    COMMENT "Generating the GL function table" VERBATIM)
set_source_files_properties(${weft_glad_sources} PROPERTIES COMPILE_OPTIONS -w)

file(GLOB weft_shaders CONFIGURE_DEPENDS passes/shaders/*.glsl)
set(weft_shader_source ${weft_generated_dir}/src/shaders.c)
add_custom_command(OUTPUT ${weft_shader_source}
    COMMAND ${CMAKE_COMMAND} -D OUT=${weft_shader_source} -D "SHADERS=${weft_shaders}"
        -P ${PROJECT_SOURCE_DIR}/cmake/embed.cmake
    DEPENDS ${weft_shaders} cmake/embed.cmake
    COMMENT "Embedding the shaders" VERBATIM)

set(weft_generated_sources ${weft_glad_sources} ${weft_shader_source})
