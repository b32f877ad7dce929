# `cmake --install build` (component dev) gives headers, static libraries and find_package(raylign).
include(CMakePackageConfigHelpers)
get_property(_modules GLOBAL PROPERTY RAYLIGN_MODULES)
install(TARGETS ${_modules} raylign_raylign EXPORT raylign-targets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT dev)
install(DIRECTORY "${PROJECT_SOURCE_DIR}/cpp/raylign" DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
        COMPONENT dev FILES_MATCHING PATTERN "*.h")
install(EXPORT raylign-targets NAMESPACE raylign:: COMPONENT dev
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/raylign)
configure_package_config_file("${PROJECT_SOURCE_DIR}/cmake/raylign-config.cmake.in"
  "${PROJECT_BINARY_DIR}/raylign-config.cmake" INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/raylign)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/raylign-config-version.cmake"
                                 COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/raylign-config.cmake"
              "${PROJECT_BINARY_DIR}/raylign-config-version.cmake"
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/raylign COMPONENT dev)

# The wheel (component python) carries the data that `raylign demo` and `raylign download` read.
if(RAYLIGN_BUILD_PYTHON)
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/data/" DESTINATION raylign/_data COMPONENT python
          FILES_MATCHING PATTERN "registry.toml" PATTERN "*.txt.gz")
endif()
