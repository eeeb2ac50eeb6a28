# What hosts link. The programs of this tree link the parts of it, which shut nothing away from tests.

# penumbra::penumbra: the graph, with the node types that ship and their shaders.
add_library(penumbra_library
  $<TARGET_OBJECTS:penumbra_diagnostic> $<TARGET_OBJECTS:penumbra_graph> $<TARGET_OBJECTS:penumbra_nodes>
  $<TARGET_OBJECTS:penumbra_capi>)
add_library(penumbra::penumbra ALIAS penumbra_library)
set_target_properties(penumbra_library PROPERTIES OUTPUT_NAME penumbra EXPORT_NAME penumbra LINKER_LANGUAGE CXX
  VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})  # before 1.0 the minor number breaks
target_compile_features(penumbra_library PUBLIC cxx_std_20)
target_include_directories(penumbra_library PUBLIC $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include>
  $<BUILD_INTERFACE:${PROJECT_BINARY_DIR}/include> $<INSTALL_INTERFACE:include>)
target_link_libraries(penumbra_library PUBLIC Vulkan::Headers PRIVATE fmt::fmt)

# penumbra::glsl: users' nodes, compiled at run time. Who does not link it needs no glslang.
if(PENUMBRA_GLSL)
  find_package(Threads REQUIRED)
  find_package(glslang REQUIRED)
  find_package(SPIRV-Tools-opt REQUIRED)
  add_library(penumbra_glsl_library $<TARGET_OBJECTS:penumbra_spirv> $<TARGET_OBJECTS:penumbra_shader_compiler>
    $<TARGET_OBJECTS:penumbra_capi_glsl>)
  add_library(penumbra::glsl ALIAS penumbra_glsl_library)
  set_target_properties(penumbra_glsl_library PROPERTIES OUTPUT_NAME penumbra_glsl EXPORT_NAME glsl LINKER_LANGUAGE CXX
    VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
  target_link_libraries(penumbra_glsl_library PUBLIC penumbra_library
    PRIVATE glslang::glslang glslang::SPIRV glslang::glslang-default-resource-limits SPIRV-Tools-opt fmt::fmt)
endif()
