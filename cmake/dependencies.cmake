# What weft is built on; each is a Debian 12 package named in tools/packages.txt.
find_package(PkgConfig REQUIRED)
find_package(PNG REQUIRED)
find_package(OpenEXR 3.1 CONFIG REQUIRED)
find_package(Imath 3.1 CONFIG REQUIRED) # half floats in OpenVDB headers
find_package(Threads REQUIRED)
pkg_check_modules(jansson REQUIRED IMPORTED_TARGET jansson)
find_program(WEFT_GLAD glad REQUIRED)

# OSMesa and EGL: either alone suffices.
if(WEFT_OSMESA)
    pkg_check_modules(osmesa IMPORTED_TARGET osmesa)
    if(osmesa_FOUND)
        add_library(weft_dep_osmesa INTERFACE)
        target_link_libraries(weft_dep_osmesa INTERFACE PkgConfig::osmesa)
    endif()
endif()
if(WEFT_EGL)
    pkg_check_modules(egl IMPORTED_TARGET egl)
    if(egl_FOUND)
        add_library(weft_dep_egl INTERFACE)
        target_link_libraries(weft_dep_egl INTERFACE PkgConfig::egl)
    endif()
endif()
if(NOT TARGET weft_dep_osmesa AND NOT TARGET weft_dep_egl)
    message(FATAL_ERROR "weft needs OSMesa (libosmesa6-dev) or EGL (libegl-dev); neither was found")
endif()

# OpenVDB ships a find module only; its compile options are kept away from our warnings.
find_path(WEFT_OPENVDB_INCLUDE openvdb/openvdb.h REQUIRED)
find_library(WEFT_OPENVDB_LIBRARY openvdb REQUIRED)
find_library(WEFT_TBB_LIBRARY tbb REQUIRED)
add_library(weft_dep_openvdb INTERFACE)
# Its templates' debug information would cost more time than compiling them; lines are enough.
target_compile_options(weft_dep_openvdb INTERFACE -g1)
target_include_directories(weft_dep_openvdb SYSTEM INTERFACE ${WEFT_OPENVDB_INCLUDE})
target_link_libraries(weft_dep_openvdb INTERFACE ${WEFT_OPENVDB_LIBRARY} ${WEFT_TBB_LIBRARY}
    Imath::Imath Threads::Threads)
