# What reads bytes from outside, checks, compiles and packs, built once more with address and undefined-behaviour sanitisers
# as one program, from the shaders and tables of the ordinary build: a second configuration would compile those again. Not
# optimised, so that nothing undefined is optimised away, and it is the quickest to build. The whole suite: scripts/sanitize.sh.
set(SANITIZED_SOURCES
  fuzz/corpus_test.cpp fuzz/fuzz_c_api.cpp fuzz/fuzz_files.cpp fuzz/fuzz_json.cpp plan_checks.cpp plan_mutants.cpp toy_nodes.cpp
  broken_input_test.cpp check_test.cpp compile_test.cpp gltf_features_test.cpp gltf_test.cpp image_decode_test.cpp image_file_test.cpp json_text_test.cpp
  node_type_test.cpp pipeline_test.cpp shot_test.cpp)
foreach(LIBRARY penumbra_diagnostic penumbra_graph penumbra_capi penumbra_models)
  get_target_property(FILES ${LIBRARY} SOURCES)
  get_target_property(FOLDER ${LIBRARY} SOURCE_DIR)
  list(FILTER FILES INCLUDE REGEX "^[^/].*\\.cpp$")
  list(TRANSFORM FILES PREPEND ${FOLDER}/)
  list(APPEND SANITIZED_SOURCES ${FILES})
endforeach()
foreach(FILE scene/geometry scene/pose scene/scene scene/scene_alpha scene/scene_file shots/light_choice shots/light_file shots/model_lights shots/model_shot shots/shot shots/shot_facts shots/shot_file
        truth/analytic truth/analytic_model truth/sun_visibility)
  list(APPEND SANITIZED_SOURCES ${PROJECT_SOURCE_DIR}/host/${FILE}.cpp)
endforeach()
list(FILTER SANITIZED_SOURCES EXCLUDE REGEX "/tuning/")

# Whoever builds all of it with sanitisers has that already.
if(CMAKE_CXX_FLAGS MATCHES "-fsanitize")
  return()
endif()
add_executable(sanitized_test ${SANITIZED_SOURCES} $<TARGET_OBJECTS:penumbra_nodes>)
set(SANITIZERS -fsanitize=address,undefined -fno-sanitize-recover=undefined)
target_compile_options(sanitized_test PRIVATE -O0 -g1 -D_GLIBCXX_ASSERTIONS ${SANITIZERS} -fno-omit-frame-pointer)
target_link_options(sanitized_test PRIVATE ${SANITIZERS})
target_include_directories(sanitized_test PRIVATE ${PROJECT_BINARY_DIR}/include ${PROJECT_SOURCE_DIR}/include)
target_include_directories(sanitized_test SYSTEM PRIVATE ${WEBP_FOLDER})
target_compile_definitions(sanitized_test PRIVATE PENUMBRA_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
find_package(OpenEXR CONFIG REQUIRED)
target_link_libraries(sanitized_test PRIVATE OpenEXR::OpenEXR TinyGLTF::TinyGLTF draco::draco meshoptimizer::meshoptimizer
  PNG::PNG JPEG::JPEG ${WEBP_DEMUX_LIBRARY} ${WEBP_MUX_LIBRARY} ${WEBP_LIBRARY} nlohmann_json::nlohmann_json glm::glm fmt::fmt Vulkan::Headers GTest::gtest_main)
target_precompile_headers(sanitized_test PRIVATE ${PRECOMPILED} <gtest/gtest.h>)
# One test, whose files are beside those of the same tests in other programs.
file(MAKE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/sanitized)
add_test(NAME sanitized COMMAND sanitized_test --gtest_brief=1)
set_tests_properties(sanitized PROPERTIES LABELS unit TIMEOUT 900 ENVIRONMENT "TEST_TMPDIR=${CMAKE_CURRENT_BINARY_DIR}/sanitized")
