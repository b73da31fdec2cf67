# What is installed: libraries, public headers, the command, the readers, and how to find them.
include(CMakePackageConfigHelpers)
set(weft_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/weft)

# The public headers are weft.h and what it includes.
file(STRINGS weft.h weft_public_headers REGEX "^#include \"")
list(TRANSFORM weft_public_headers REPLACE "^#include \"(.*)\"$" "\\1")
list(PREPEND weft_public_headers weft.h)
foreach(header IN LISTS weft_public_headers)
    get_filename_component(folder ${header} DIRECTORY)
    install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/weft/${folder})
endforeach()

# The static library names what it is linked with, which only its users have to find; hence an
# export of its own, loaded by find_package(weft COMPONENTS static).
set_target_properties(weft_shared PROPERTIES EXPORT_NAME weft)
install(TARGETS weft_shared EXPORT weftTargets)
install(TARGETS weft_static EXPORT weftStaticTargets)
install(EXPORT weftTargets NAMESPACE weft:: DESTINATION ${weft_cmake_dir})
install(EXPORT weftStaticTargets NAMESPACE weft:: DESTINATION ${weft_cmake_dir})

set_target_properties(weft PROPERTIES
    INSTALL_RPATH $ORIGIN/../${CMAKE_INSTALL_LIBDIR})
install(TARGETS weft)
install(TARGETS ${weft_readers}
    DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/weft)

configure_package_config_file(cmake/weftConfig.cmake.in ${PROJECT_BINARY_DIR}/weftConfig.cmake
    INSTALL_DESTINATION ${weft_cmake_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/weftConfigVersion.cmake
    COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/weftConfig.cmake ${PROJECT_BINARY_DIR}/weftConfigVersion.cmake
    DESTINATION ${weft_cmake_dir})

# Relative to itself, so that the installed tree can be moved.
file(RELATIVE_PATH weft_pc_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
configure_file(cmake/weft.pc.in ${PROJECT_BINARY_DIR}/weft.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/weft.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

# For each MPI a library, the program that weft becomes, and how to find the library.
foreach(mpi IN LISTS weft_mpis)
    install(TARGETS weft_${mpi} EXPORT weft-${mpi}Targets)
    install(EXPORT weft-${mpi}Targets NAMESPACE weft:: DESTINATION ${weft_cmake_dir})
    file(RELATIVE_PATH lib_from_libexec
        ${CMAKE_INSTALL_FULL_LIBEXECDIR}/weft ${CMAKE_INSTALL_FULL_LIBDIR})
    set_target_properties(weft_${mpi} PROPERTIES INSTALL_RPATH $ORIGIN)
    set_target_properties(weft-${mpi} PROPERTIES INSTALL_RPATH $ORIGIN/${lib_from_libexec})
    install(TARGETS weft-${mpi} DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/weft)
    set(mpi_package ${weft_package_${mpi}})
    configure_file(cmake/weft-mpi.pc.in ${PROJECT_BINARY_DIR}/weft-${mpi}.pc @ONLY)
    install(FILES ${PROJECT_BINARY_DIR}/weft-${mpi}.pc
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()
if(weft_mpis)
    install(FILES weft_mpi.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/weft)
    install(FILES passes/distribute/mpi/distribute.h
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/weft/passes/distribute/mpi)
endif()
