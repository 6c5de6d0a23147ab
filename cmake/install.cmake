# Installs the libraries, with find_package(palpate) and targets such as palpate::scene.
include(CMakePackageConfigHelpers)

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/palpate)
install(EXPORT palpateTargets NAMESPACE palpate:: DESTINATION ${package_dir} COMPONENT palpate_dev)
configure_package_config_file(${CMAKE_CURRENT_LIST_DIR}/palpateConfig.cmake.in
  ${CMAKE_CURRENT_BINARY_DIR}/palpateConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/palpateConfigVersion.cmake
  COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/palpateConfig.cmake
              ${CMAKE_CURRENT_BINARY_DIR}/palpateConfigVersion.cmake
        DESTINATION ${package_dir} COMPONENT palpate_dev)
include(${CMAKE_CURRENT_LIST_DIR}/public_headers.cmake)
palpate_with_included("${palpate_public_headers}" headers)
foreach(header IN LISTS headers)
  cmake_path(GET header PARENT_PATH folder)
  install(FILES src/palpate/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/palpate/${folder} COMPONENT palpate_dev)
endforeach()
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT palpate_licence)
