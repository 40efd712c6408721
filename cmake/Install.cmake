# What `cmake --install` puts where: the programs with their completions, every room as a library with its headers, a
# CMake package, and configurations with the small scans they name.
include(CMakePackageConfigHelpers)

install(TARGETS meshmser meshmser-scan RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})

# A header is included by the same path as here: stages/tree/component_tree.hpp.
get_property(rooms GLOBAL PROPERTY MESHMSER_ROOMS)
install(TARGETS ${rooms} EXPORT meshmserTargets ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
foreach(folder pipeline stages data/scanner)
  install(DIRECTORY ${folder}/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/meshmser/${folder} FILES_MATCHING PATTERN *.hpp
          PATTERN page EXCLUDE)
endforeach()

set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/meshmser)
install(EXPORT meshmserTargets NAMESPACE meshmser:: DESTINATION ${package_folder})
configure_package_config_file(cmake/meshmserConfig.cmake.in ${PROJECT_BINARY_DIR}/meshmserConfig.cmake
                              INSTALL_DESTINATION ${package_folder})
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/meshmserConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/meshmserConfig.cmake ${PROJECT_BINARY_DIR}/meshmserConfigVersion.cmake
              cmake/Dependencies.cmake
        DESTINATION ${package_folder})

install(CODE "
  foreach(shell bash zsh)
    execute_process(COMMAND \"$<TARGET_FILE:meshmser>\" completion \${shell} COMMAND_ERROR_IS_FATAL ANY
                    OUTPUT_FILE \"${PROJECT_BINARY_DIR}/completion.\${shell}\")
  endforeach()")
install(FILES ${PROJECT_BINARY_DIR}/completion.bash RENAME meshmser
        DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(FILES ${PROJECT_BINARY_DIR}/completion.zsh RENAME _meshmser
        DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions)

install(DIRECTORY configs DESTINATION ${CMAKE_INSTALL_DATADIR}/meshmser FILES_MATCHING PATTERN *.yaml)
install(DIRECTORY data/demo data/hills DESTINATION ${CMAKE_INSTALL_DATADIR}/meshmser/data FILES_MATCHING PATTERN *.ply)
install(FILES LICENSE README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
