# What `cmake --install` puts where, and the package that find_package(ptet) finds: ptet::ptet, the run-time library,
# and ptet::build, the builder. They are exported apart, so that a program which only reads files needs nothing of what
# the builder is made with.
include(CMakePackageConfigHelpers)

set(ptet_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/ptet)

set(ptet_parts runtime)
set(ptet_packages ptet)
if(TARGET ptet_build)
  list(APPEND ptet_parts build)
  list(APPEND ptet_packages ptet-build)
else()
  set(ptet_without_builder REGEX "/(build|pieces_build|ptet_build|validate|weld)\\.hp*$" EXCLUDE)
endif()

install(DIRECTORY lib/include/ptet DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp"
        ${ptet_without_builder})
foreach(part ${ptet_parts})
  install(TARGETS ptet_${part} EXPORT ptet-${part}-targets)
  install(EXPORT ptet-${part}-targets NAMESPACE ptet:: DESTINATION ${ptet_package_dir})
endforeach()

get_target_property(ptet_library_type ptet_runtime TYPE)
set(ptet_cxx_libs ${CMAKE_CXX_IMPLICIT_LINK_LIBRARIES})
list(FILTER ptet_cxx_libs INCLUDE REGEX "^(std)?c\\+\\+")
configure_package_config_file(tools/cmake/ptet-config.cmake.in ${CMAKE_CURRENT_BINARY_DIR}/ptet-config.cmake
                              INSTALL_DESTINATION ${ptet_package_dir})
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/ptet-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/ptet-config.cmake ${CMAKE_CURRENT_BINARY_DIR}/ptet-config-version.cmake
        DESTINATION ${ptet_package_dir})

# ptet.pc and ptet-build.pc, for everything but CMake. They find the prefix from where they are, so that the installed
# tree may be moved. A shared library brings what it needs; with a static one the program's link, by a C compiler perhaps,
# has to name it all, whether or not pkg-config is asked for --static.
set(ptet_pc_dir ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
set(PTET_PC_LIBDIR ${CMAKE_INSTALL_FULL_LIBDIR})
set(PTET_PC_INCLUDEDIR ${CMAKE_INSTALL_FULL_INCLUDEDIR})
set(PTET_PC_PREFIX ${CMAKE_INSTALL_PREFIX})
if(NOT IS_ABSOLUTE "${CMAKE_INSTALL_LIBDIR}" AND NOT IS_ABSOLUTE "${CMAKE_INSTALL_INCLUDEDIR}")
  file(RELATIVE_PATH ptet_pc_up ${CMAKE_INSTALL_FULL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
  set(PTET_PC_PREFIX "\${pcfiledir}/${ptet_pc_up}")
  set(PTET_PC_LIBDIR "\${prefix}/${CMAKE_INSTALL_LIBDIR}")
  set(PTET_PC_INCLUDEDIR "\${prefix}/${CMAKE_INSTALL_INCLUDEDIR}")
endif()
if(ptet_library_type STREQUAL "STATIC_LIBRARY")
  set(PTET_PC_REQUIRES "libzstd libxxhash")
  set(PTET_PC_BUILD_REQUIRES "openmesh tbb mpfr gmp")
  list(TRANSFORM ptet_cxx_libs PREPEND "-l" OUTPUT_VARIABLE ptet_pc_cxx_libs)
  list(JOIN ptet_pc_cxx_libs " " PTET_PC_LIBS)
  string(APPEND PTET_PC_LIBS " -lm -pthread")
endif()
foreach(package ${ptet_packages})
  configure_file(tools/cmake/${package}.pc.in ${CMAKE_CURRENT_BINARY_DIR}/${package}.pc @ONLY)
  install(FILES ${CMAKE_CURRENT_BINARY_DIR}/${package}.pc DESTINATION ${ptet_pc_dir})
endforeach()

install(FILES README.md LICENSE formats/ptet/PTET.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
