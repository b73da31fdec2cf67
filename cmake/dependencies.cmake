# What weft is built on; each is a Debian 12 package named in tools/packages.txt.
find_package(PkgConfig REQUIRED)
find_package(PNG REQUIRED)
find_package(TIFF 4.5 REQUIRED)
find_package(OpenEXR 3.1 CONFIG REQUIRED)
find_package(Imath 3.1 CONFIG REQUIRED) # half floats in OpenVDB headers
find_package(Threads REQUIRED)
find_package(ZLIB REQUIRED) # gzipped NIfTI files
pkg_check_modules(libdeflate REQUIRED IMPORTED_TARGET libdeflate)
pkg_check_modules(jansson REQUIRED IMPORTED_TARGET jansson)
pkg_check_modules(libxxhash REQUIRED IMPORTED_TARGET libxxhash)
# Texts around previews: fontconfig finds a font, FreeType draws it; neither knows of X.
pkg_check_modules(fontconfig REQUIRED IMPORTED_TARGET fontconfig)
pkg_check_modules(freetype2 REQUIRED IMPORTED_TARGET freetype2)
pkg_check_modules(assimp REQUIRED IMPORTED_TARGET assimp)
find_program(WEFT_GLAD glad REQUIRED)

# OSMesa and EGL: either alone suffices. Their headers are needed here; the libraries are loaded when
# a context is made (passes/gl/native/library.c), so that nothing else needs them.
set(osmesa_FOUND FALSE)
set(egl_FOUND FALSE)
if(WEFT_OSMESA)
    pkg_check_modules(osmesa osmesa)
endif()
if(WEFT_EGL)
    pkg_check_modules(egl egl)
endif()
if(NOT osmesa_FOUND AND NOT egl_FOUND)
    message(FATAL_ERROR "weft needs OSMesa (libosmesa6-dev) or EGL (libegl-dev); neither was found")
endif()

# OpenVDB ships a find module only; its compile options are kept away from our warnings.
find_path(WEFT_OPENVDB_INCLUDE openvdb/openvdb.h REQUIRED)
find_library(WEFT_OPENVDB_LIBRARY openvdb REQUIRED)
find_library(WEFT_TBB_LIBRARY tbb REQUIRED)
add_library(weft_dep_openvdb INTERFACE)
# Its templates' debug information would cost more time than compiling them; lines are enough.
target_compile_options(weft_dep_openvdb INTERFACE -g1)
# tiles/readers/vdb_trees.h. Sanitizers and other compilers leave calls of what the library inlined.
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU" AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13
        AND NOT WEFT_SANITIZE)
    target_compile_definitions(weft_dep_openvdb INTERFACE WEFT_VDB_TREES_OF_LIBRARY)
endif()
target_include_directories(weft_dep_openvdb SYSTEM INTERFACE ${WEFT_OPENVDB_INCLUDE})
target_link_libraries(weft_dep_openvdb INTERFACE ${WEFT_OPENVDB_LIBRARY} ${WEFT_TBB_LIBRARY}
    Imath::Imath Threads::Threads)

# NRRD and NIfTI files. Neither library has a pkg-config file.
find_path(WEFT_NRRD_INCLUDE teem/nrrd.h REQUIRED)
find_library(WEFT_NRRD_LIBRARY teem REQUIRED)
add_library(weft_dep_teem INTERFACE)
target_include_directories(weft_dep_teem SYSTEM INTERFACE ${WEFT_NRRD_INCLUDE})
target_link_libraries(weft_dep_teem INTERFACE ${WEFT_NRRD_LIBRARY})
find_path(WEFT_NIFTI_INCLUDE nifti/nifti2_io.h REQUIRED)
find_library(WEFT_NIFTI_LIBRARY nifti2 REQUIRED)
add_library(weft_dep_nifti INTERFACE)
# nifti2_io.h looks for znzlib.h in its own folder.
target_include_directories(weft_dep_nifti SYSTEM INTERFACE ${WEFT_NIFTI_INCLUDE}
    ${WEFT_NIFTI_INCLUDE}/nifti)
target_link_libraries(weft_dep_nifti INTERFACE ${WEFT_NIFTI_LIBRARY})
