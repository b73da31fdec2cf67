# cpack -G DEB: Debian packages, one for each component of cmake/install.cmake. The preset deb builds
# for them (cmake --workflow --preset deb); tests/packages/run.sh installs them in a bare Debian.
# cpack -G TGZ: all in one archive, to be unpacked anywhere.
set(CPACK_PACKAGE_VENDOR "The weft authors")
set(CPACK_PACKAGE_CONTACT "The weft authors <weft@localhost>")
if(DEFINED ENV{DEBEMAIL} AND DEFINED ENV{DEBFULLNAME}) # as Debian's tools have it
    set(CPACK_PACKAGE_CONTACT "$ENV{DEBFULLNAME} <$ENV{DEBEMAIL}>")
endif()
set(CPACK_RESOURCE_FILE_LICENSE ${PROJECT_SOURCE_DIR}/LICENSE)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "") # each package has its own
set(CPACK_GENERATOR TGZ)
set(CPACK_STRIP_FILES ON)
set(CPACK_THREADS 0)
set(CPACK_SOURCE_GENERATOR TGZ)
set(CPACK_SOURCE_IGNORE_FILES "^${PROJECT_SOURCE_DIR}/(build|demo|\\\\.git)(/|$)")

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING IGNORE)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
# The library's own, which is in no package yet.
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR})
set(version ${PROJECT_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})

# What Debian wants of each package: its licence, and the changes of the packages.
set(weft_debian ${PROJECT_BINARY_DIR}/debian)
file(WRITE ${weft_debian}/triggers "activate-noawait ldconfig\n")
if(WEFT_GZIP)
    string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
    file(WRITE ${weft_debian}/changelog.Debian "weft (${version}) bookworm; urgency=medium\n\n"
        "  * As CHANGELOG.md of the package weft tells.\n\n -- ${CPACK_PACKAGE_CONTACT}  ${date}\n")
    execute_process(COMMAND ${WEFT_GZIP} -9nf ${weft_debian}/changelog.Debian)
endif()

# weft_package(NAME SECTION DEPENDS SUMMARY TEXT): a component and its package. LIBRARY where it has
# a shared one.
function(weft_package name section depends summary text)
    string(TOUPPER ${name} upper)
    set(names CPACK_COMPONENTS_ALL)
    list(APPEND CPACK_COMPONENTS_ALL ${name})
    set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
    set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
    set(CPACK_DEBIAN_${upper}_PACKAGE_DEPENDS "${depends}")
    set(CPACK_DEBIAN_${upper}_DESCRIPTION
        "reconstruction filtering of volumes and images, ${summary}\n${text}")
    if("LIBRARY" IN_LIST ARGN)
        set(CPACK_DEBIAN_${upper}_PACKAGE_CONTROL_EXTRA ${weft_debian}/triggers)
    endif()
    foreach(part NAME SECTION DEPENDS CONTROL_EXTRA)
        list(APPEND names CPACK_DEBIAN_${upper}_PACKAGE_${part})
    endforeach()
    foreach(variable IN LISTS names ITEMS CPACK_DEBIAN_${upper}_DESCRIPTION)
        set(${variable} "${${variable}}" PARENT_SCOPE)
    endforeach()
    # Not of `cmake --install`, which installs all components at once.
    set(folder ${CMAKE_INSTALL_DATAROOTDIR}/doc/${name})
    install(FILES LICENSE DESTINATION ${folder} RENAME copyright COMPONENT ${name} EXCLUDE_FROM_ALL)
    if(WEFT_GZIP)
        install(FILES ${weft_debian}/changelog.Debian.gz DESTINATION ${folder}
            COMPONENT ${name} EXCLUDE_FROM_ALL)
    endif()
endfunction()

weft_package(weft graphics "${weft_lib} (= ${version})" "the command"
"weft cuts slices of any orientation out of sparse volumes (OpenVDB, NRRD,
NIfTI), scales and warps images, and averages frames, with the
reconstruction kernel that is asked for, on OpenGL or on the CPU, and
measures how far results are from a reference in double precision.")
set(CPACK_DEBIAN_WEFT_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_WEFT_PACKAGE_SUGGESTS "gnuplot-nox | gnuplot, weft-doc")

weft_package(${weft_lib} libs "" "the library"
"libweft plans and runs slices, resampling and anti-aliasing with chosen
reconstruction kernels, on OpenGL or on the CPU. Files are read by the
programs of the package weft."
    LIBRARY)
string(TOUPPER ${weft_lib} upper)
set(CPACK_DEBIAN_${upper}_PACKAGE_SHLIBDEPS ON)
# Loaded when a context is made; either will do, and without one what needs no OpenGL runs.
set(CPACK_DEBIAN_${upper}_PACKAGE_RECOMMENDS "libosmesa6 | libegl1, weft (= ${version})")

weft_package(libweft-dev libdevel
    "${weft_lib} (= ${version}), libpng-dev, libdeflate-dev, libxxhash-dev, libopenexr-dev"
    "for programs"
"Headers, the static library, and what CMake and pkg-config need to find
libweft.")

weft_package(weft-doc doc "" "documentation"
"A page for each of weft's jobs, with pictures.")
set(CPACK_DEBIAN_WEFT-DOC_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_WEFT-DOC_PACKAGE_SUGGESTS weft)

set(weft_mpi_dev_openmpi libopenmpi-dev)
set(weft_mpi_dev_mpich libmpich-dev)
set(weft_mpi_run_openmpi openmpi-bin)
set(weft_mpi_run_mpich mpich)
foreach(mpi IN LISTS weft_mpis)
    weft_package(weft-${mpi} graphics
        "weft (= ${version}), ${weft_lib} (= ${version}), ${weft_mpi_run_${mpi}}" "on ${mpi}"
"The library and the program that divide weft's work among the ranks of
${mpi}."
        LIBRARY)
    string(TOUPPER ${mpi} upper)
    set(CPACK_DEBIAN_WEFT-${upper}_PACKAGE_SHLIBDEPS ON)
    weft_package(libweft-${mpi}-dev libdevel
        "weft-${mpi} (= ${version}), libweft-dev (= ${version}), ${weft_mpi_dev_${mpi}}"
        "programs on ${mpi}"
"What CMake and pkg-config need to find libweft-${mpi}.")
endforeach()
include(CPack)
