# What is installed, and how it is found. Components are called as the packages that they become
# (cmake/package.cmake).
include(CMakePackageConfigHelpers)
set(weft_cmake_dir ${CMAKE_INSTALL_LIBDIR}/cmake/weft)
set(weft_lib libweft${PROJECT_VERSION_MAJOR})

# The public headers are weft.h and what it includes.
file(STRINGS weft.h weft_public_headers REGEX "^#include \"")
list(TRANSFORM weft_public_headers REPLACE "^#include \"(.*)\"$" "\\1")
list(PREPEND weft_public_headers weft.h)
foreach(header IN LISTS weft_public_headers)
    get_filename_component(folder ${header} DIRECTORY)
    install(FILES ${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/weft/${folder}
        COMPONENT libweft-dev)
endforeach()

# The static library names what it is linked with, which only its users have to find; hence an
# export of its own, loaded by find_package(weft COMPONENTS static).
set_target_properties(weft_shared PROPERTIES EXPORT_NAME weft)
install(TARGETS weft_shared EXPORT weftTargets
    LIBRARY COMPONENT ${weft_lib} NAMELINK_COMPONENT libweft-dev)
install(TARGETS weft_static EXPORT weftStaticTargets ARCHIVE COMPONENT libweft-dev)
install(EXPORT weftTargets NAMESPACE weft:: DESTINATION ${weft_cmake_dir} COMPONENT libweft-dev)
install(EXPORT weftStaticTargets NAMESPACE weft:: DESTINATION ${weft_cmake_dir}
    COMPONENT libweft-dev)

set_target_properties(weft PROPERTIES
    INSTALL_RPATH $ORIGIN/../${CMAKE_INSTALL_LIBDIR})
install(TARGETS weft COMPONENT weft)
install(TARGETS ${weft_readers}
    DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/weft COMPONENT weft)

# Before 1.0 a minor version may change what was there, after it none does.
set(compatibility SameMinorVersion)
if(PROJECT_VERSION_MAJOR GREATER 0)
    set(compatibility SameMajorVersion)
endif()
configure_package_config_file(cmake/weftConfig.cmake.in ${PROJECT_BINARY_DIR}/weftConfig.cmake
    INSTALL_DESTINATION ${weft_cmake_dir} NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/weftConfigVersion.cmake
    COMPATIBILITY ${compatibility})
install(FILES ${PROJECT_BINARY_DIR}/weftConfig.cmake ${PROJECT_BINARY_DIR}/weftConfigVersion.cmake
    DESTINATION ${weft_cmake_dir} COMPONENT libweft-dev)

# Relative to itself, so that the installed tree can be moved.
file(RELATIVE_PATH weft_pc_prefix ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
foreach(name weft weft-static)
    configure_file(cmake/${name}.pc.in ${PROJECT_BINARY_DIR}/${name}.pc @ONLY)
    install(FILES ${PROJECT_BINARY_DIR}/${name}.pc
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT libweft-dev)
endforeach()

# For each MPI a library, the program that weft becomes, and how to find the library.
foreach(mpi IN LISTS weft_mpis)
    set(mpi_dev libweft-${mpi}-dev)
    install(TARGETS weft_${mpi} EXPORT weft-${mpi}Targets
        LIBRARY COMPONENT weft-${mpi} NAMELINK_COMPONENT ${mpi_dev})
    install(EXPORT weft-${mpi}Targets NAMESPACE weft:: DESTINATION ${weft_cmake_dir}
        COMPONENT ${mpi_dev})
    file(RELATIVE_PATH lib_from_libexec
        ${CMAKE_INSTALL_FULL_LIBEXECDIR}/weft ${CMAKE_INSTALL_FULL_LIBDIR})
    set_target_properties(weft_${mpi} PROPERTIES INSTALL_RPATH $ORIGIN)
    set_target_properties(weft-${mpi} PROPERTIES INSTALL_RPATH $ORIGIN/${lib_from_libexec})
    install(TARGETS weft-${mpi} DESTINATION ${CMAKE_INSTALL_LIBEXECDIR}/weft COMPONENT weft-${mpi})
    set(mpi_package ${weft_package_${mpi}})
    configure_file(cmake/weft-mpi.pc.in ${PROJECT_BINARY_DIR}/weft-${mpi}.pc @ONLY)
    install(FILES ${PROJECT_BINARY_DIR}/weft-${mpi}.pc
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT ${mpi_dev})
endforeach()
if(weft_mpis)
    install(FILES weft_mpi.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/weft COMPONENT libweft-dev)
    install(FILES passes/distribute/mpi/distribute.h
        DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/weft/passes/distribute/mpi COMPONENT libweft-dev)
endif()

# What is to be read, in the folders that README.md's links name.
install(FILES README.md CHANGELOG.md LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT weft)
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT weft-doc
    FILES_MATCHING PATTERN "*.md" PATTERN "*.png" PATTERN "*.svg" PATTERN "*.json")

# Manual pages and completions, which the command itself prints. Each verb is a file.
find_program(WEFT_GZIP gzip)
if(NOT CMAKE_CROSSCOMPILING)
    set(texts ${PROJECT_BINARY_DIR}/texts)
    file(GLOB weft_verbs CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR}/tools/verbs tools/verbs/*.c)
    list(TRANSFORM weft_verbs REPLACE "\\.c$" "")
    add_custom_command(OUTPUT ${texts}/stamp
        COMMAND ${CMAKE_COMMAND} -D WEFT=$<TARGET_FILE:weft> -D OUT=${texts}
            -D "VERBS=${weft_verbs}" -D GZIP=$<$<BOOL:${WEFT_GZIP}>:${WEFT_GZIP}>
            -P ${PROJECT_SOURCE_DIR}/cmake/texts.cmake
        DEPENDS weft cmake/texts.cmake COMMENT "Writing manual pages and completions" VERBATIM)
    add_custom_target(weft-texts ALL DEPENDS ${texts}/stamp)
    install(DIRECTORY ${texts}/man1 DESTINATION ${CMAKE_INSTALL_MANDIR} COMPONENT weft)
    foreach(script weft.bash:bash-completion/completions:weft _weft:zsh/site-functions:_weft
            weft.fish:fish/vendor_completions.d:weft.fish)
        string(REPLACE : ";" script ${script})
        list(POP_FRONT script file folder name)
        install(FILES ${texts}/${file} DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/${folder}
            RENAME ${name} COMPONENT weft)
    endforeach()
endif()

add_custom_target(uninstall
    COMMAND ${CMAKE_COMMAND} -D MANIFEST=${PROJECT_BINARY_DIR}/install_manifest.txt
        -P ${PROJECT_SOURCE_DIR}/cmake/uninstall.cmake
    COMMENT "Removing what was installed last" VERBATIM USES_TERMINAL)
