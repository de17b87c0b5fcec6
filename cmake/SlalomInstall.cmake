# SPDX-License-Identifier: BSD-3-Clause
# What `cmake --install` adds to programs and plugin: settings, the records that a host is told of
# (slalom::core), and the package that `find_package(slalom)` finds. A host links slalom::navigator.
include(CMakePackageConfigHelpers)

install(TARGETS slalom_core EXPORT slalomTargets
  ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}
  FILE_SET HEADERS DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(DIRECTORY ${PROJECT_SOURCE_DIR}/configs DESTINATION ${CMAKE_INSTALL_DATADIR}/slalom)
install(FILES ${PROJECT_SOURCE_DIR}/LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/slalom)

set(slalom_package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/slalom)
install(EXPORT slalomTargets NAMESPACE slalom:: DESTINATION ${slalom_package_dir})
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/slalomConfig.cmake.in
  ${PROJECT_BINARY_DIR}/slalomConfig.cmake INSTALL_DESTINATION ${slalom_package_dir})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/slalomConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/slalomConfig.cmake ${PROJECT_BINARY_DIR}/slalomConfigVersion.cmake
  DESTINATION ${slalom_package_dir})
