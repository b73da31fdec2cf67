# What `weft --version` tells: found when configured, but for the commit, which is looked up in every
# build and compiled into the programs alone, so that a new one compiles one file.

# A version that a header defines as NAME "1.2.3".
function(weft_header_version file name out)
    file(STRINGS ${file} line REGEX "define ${name} +\"" LIMIT_COUNT 1)
    string(REGEX REPLACE ".*\"([^\"]*)\".*" "\\1" version "${line}")
    set(${out} "${version}" PARENT_SCOPE)
endfunction()
weft_header_version(${WEFT_OPENVDB_INCLUDE}/openvdb/version.h OPENVDB_LIBRARY_VERSION_STRING openvdb)
weft_header_version(${WEFT_NRRD_INCLUDE}/teem/air.h TEEM_VERSION_STRING teem)

set(libraries "OpenEXR ${OpenEXR_VERSION}" "libpng ${PNG_VERSION_STRING}"
    "libdeflate ${libdeflate_VERSION}" "xxHash ${libxxhash_VERSION}" "Jansson ${jansson_VERSION}")
set(readers "OpenVDB ${openvdb}" "libtiff ${TIFF_VERSION_STRING}" "Assimp ${assimp_VERSION}"
    "Teem ${teem}" "NIfTI-2" "zlib ${ZLIB_VERSION_STRING}")
set(contexts "")
foreach(kind osmesa egl)
    if(${kind}_FOUND)
        list(APPEND contexts ${kind})
    endif()
endforeach()
foreach(list libraries readers contexts weft_mpis)
    list(JOIN ${list} ", " ${list}_text)
endforeach()
set_source_files_properties(tools/program/version.c PROPERTIES COMPILE_DEFINITIONS
    "BUILT_WITH=\"${libraries_text}\";BUILT_READERS=\"${readers_text}\";\
BUILT_BY=\"${CMAKE_C_COMPILER_ID} ${CMAKE_C_COMPILER_VERSION}\";\
BUILT_CONTEXTS=\"${contexts_text}\";BUILT_RANKS=\"${weft_mpis_text}\"")

set(commit ${weft_generated_dir}/src/commit.c)
add_custom_target(weft-commit BYPRODUCTS ${commit}
    COMMAND ${CMAKE_COMMAND} -D SOURCE=${PROJECT_SOURCE_DIR} -D OUT=${commit}
        -P ${PROJECT_SOURCE_DIR}/cmake/commit.cmake
    COMMENT "Looking up the commit" VERBATIM)
set(programs ${weft_mpis})
list(TRANSFORM programs PREPEND weft-)
foreach(program weft ${programs})
    target_sources(${program} PRIVATE ${commit})
    add_dependencies(${program} weft-commit)
endforeach()
