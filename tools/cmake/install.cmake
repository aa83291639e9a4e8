# What `cmake --install` puts where, and the package that find_package(ptet) finds: ptet::ptet, the run-time library,
# and ptet::build, the builder. They are exported apart, so that a program which only reads files needs nothing of what
# the builder is made with.
include(CMakePackageConfigHelpers)

set(ptet_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/ptet)

install(DIRECTORY lib/include/ptet DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp")
install(TARGETS ptet_runtime EXPORT ptet-runtime-targets)
install(TARGETS ptet_build EXPORT ptet-build-targets)
foreach(part runtime build)
  install(EXPORT ptet-${part}-targets NAMESPACE ptet:: DESTINATION ${ptet_package_dir})
endforeach()

get_target_property(ptet_library_type ptet_runtime TYPE)
configure_package_config_file(tools/cmake/ptet-config.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/ptet-config.cmake
                              INSTALL_DESTINATION ${ptet_package_dir})
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/ptet-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/ptet-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/ptet-config-version.cmake
        DESTINATION ${ptet_package_dir})

install(FILES README.md LICENSE formats/ptet/PTET.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
