# Ranks of MPI: for each MPI that is found a library, libweft-openmpi or libweft-mpich
# (passes/distribute/mpi), and the program that weft becomes under its launcher.
option(WEFT_MPI "Build for ranks of Open MPI and MPICH, where they are found" ON)
set(weft_mpis "")

function(weft_add_mpi name package)
    if(NOT WEFT_MPI)
        return()
    endif()
    pkg_check_modules(weft_dep_${name} QUIET IMPORTED_TARGET ${package})
    if(NOT weft_dep_${name}_FOUND)
        message(STATUS "No ${package} for pkg-config: nothing is built for ranks of ${name}")
        return()
    endif()
    add_library(weft_${name} SHARED passes/distribute/mpi/distribute.c)
    target_compile_definitions(weft_${name} PRIVATE _GNU_SOURCE)
    target_link_libraries(weft_${name} PUBLIC weft_shared PkgConfig::weft_dep_${name})
    # pkg-config names what MPI is made of, too.
    target_link_options(weft_${name} PRIVATE LINKER:--as-needed)
    set_target_properties(weft_${name} PROPERTIES OUTPUT_NAME weft-${name} EXPORT_NAME ${name}
        VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR})
    add_library(weft::${name} ALIAS weft_${name})

    add_executable(weft-${name} tools/program/main_mpi.c)
    target_link_libraries(weft-${name} PRIVATE weft_tools weft_${name})
    target_link_options(weft-${name} PRIVATE LINKER:--as-needed)
    add_dependencies(weft weft-${name}) # started without it, but then alone
    set(weft_mpis ${weft_mpis} ${name} PARENT_SCOPE)
    set(weft_package_${name} ${package} PARENT_SCOPE)
endfunction()

weft_add_mpi(openmpi ompi-c)
weft_add_mpi(mpich mpich)
