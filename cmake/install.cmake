# cmake --install: headers, libraries, what programs read (pipelines, declarations of nodes, schemas), a package for
# find_package(penumbra) and files for pkg-config. Nothing in it says where it lies: a prefix may be moved.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(DATA ${CMAKE_INSTALL_DATADIR}/penumbra)
set(PACKAGE ${CMAKE_INSTALL_LIBDIR}/cmake/penumbra)

install(DIRECTORY include/penumbra DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} PATTERN user_nodes.h EXCLUDE)
install(FILES ${PROJECT_BINARY_DIR}/include/penumbra/version.h ${PROJECT_BINARY_DIR}/include/penumbra/blocks.h
  ${PROJECT_BINARY_DIR}/include/penumbra/bvh.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/penumbra)
install(DIRECTORY pipelines DESTINATION ${DATA} FILES_MATCHING PATTERN *.json)
install(DIRECTORY nodes DESTINATION ${DATA} FILES_MATCHING PATTERN *.json)
# What a user's node may include, to read: penumbra::glsl has it in itself.
install(DIRECTORY shaders/common DESTINATION ${DATA}/shaders FILES_MATCHING PATTERN *.glsl PATTERN *.h)
install(FILES include/penumbra/frame_block.glsl DESTINATION ${DATA}/shaders/penumbra)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})

install(TARGETS penumbra_library penumbra_bvh EXPORT penumbra)
install(EXPORT penumbra NAMESPACE penumbra:: FILE penumbra-targets.cmake DESTINATION ${PACKAGE})
if(PENUMBRA_GLSL)
  install(FILES include/penumbra/user_nodes.h DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/penumbra)
  install(TARGETS penumbra_glsl_library EXPORT penumbra_glsl)
  install(EXPORT penumbra_glsl NAMESPACE penumbra:: FILE penumbra-glsl-targets.cmake DESTINATION ${PACKAGE})
endif()
if(PENUMBRA_BUILD_PROGRAM)
  install(TARGETS penumbra OPTIONAL)
endif()

configure_package_config_file(cmake/penumbra-config.cmake.in penumbra-config.cmake INSTALL_DESTINATION ${PACKAGE}
  PATH_VARS DATA)
write_basic_package_version_file(penumbra-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/penumbra-config.cmake ${PROJECT_BINARY_DIR}/penumbra-config-version.cmake
  DESTINATION ${PACKAGE})

# Static libraries hand on what they are made of.
file(RELATIVE_PATH FROM_PKGCONFIG /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
if(BUILD_SHARED_LIBS)
  set(PRIVATE_REQUIRES "")
else()
  set(PRIVATE_REQUIRES "Requires.private: fmt\nLibs.private: -lstdc++")
endif()
configure_file(cmake/penumbra.pc.in penumbra.pc @ONLY)
configure_file(cmake/penumbra-bvh.pc.in penumbra-bvh.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/penumbra.pc ${PROJECT_BINARY_DIR}/penumbra-bvh.pc
  DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
