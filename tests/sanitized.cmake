# What reads bytes from outside, checks, compiles and packs, and what is for C, built once more with address and undefined-behaviour
# sanitisers, from the shaders and tables of the ordinary build: a second configuration would make those again. It goes into two programs:
# its tests, and the fuzzers. clang compiles it, whatever compiles the rest, since libFuzzer is clang's. The whole suite:
# scripts/sanitize.sh.
set(SANITIZED_TESTS
  broken_input_test.cpp c_bvh_test.cpp check_conditions_test.cpp check_test.cpp compile_inputs_test.cpp compile_order_test.cpp compile_test.cpp
  compile_text.cpp gltf_animation_test.cpp gltf_features_test.cpp gltf_limits_test.cpp gltf_test.cpp image_decode_test.cpp
  image_file_test.cpp json_text_test.cpp node_type_test.cpp pipeline_test.cpp scene_test.cpp shot_test.cpp)
set(SANITIZED_SOURCES fuzz/changed_pipeline.cpp fuzz/fuzz_c_api.cpp fuzz/fuzz_files.cpp fuzz/fuzz_json.cpp plan_checks.cpp)
foreach(LIBRARY penumbra_bvh penumbra_diagnostic penumbra_graph penumbra_capi penumbra_models)
  get_target_property(FILES ${LIBRARY} SOURCES)
  get_target_property(FOLDER ${LIBRARY} SOURCE_DIR)
  list(FILTER FILES INCLUDE REGEX "^[^/].*\\.cpp$")
  list(TRANSFORM FILES PREPEND ${FOLDER}/)
  list(APPEND SANITIZED_SOURCES ${FILES})
endforeach()
foreach(FILE models/joined_models scene/geometry scene/moved_boxes scene/pose scene/scene scene/scene_alpha scene/scene_file shots/light_choice
        shots/analytic_file shots/light_file shots/model_lights shots/model_shot shots/shot shots/shot_facts shots/shot_file shots/shot_text
        truth/analytic truth/analytic_model truth/sun_visibility)
  list(APPEND SANITIZED_SOURCES ${PROJECT_SOURCE_DIR}/host/${FILE}.cpp)
endforeach()
list(FILTER SANITIZED_SOURCES EXCLUDE REGEX "/tuning/")

# Whoever builds all of it with sanitisers has that already.
if(CMAKE_CXX_FLAGS MATCHES "-fsanitize")
  return()
endif()
find_program(CLANG NAMES clang++-14 clang++ REQUIRED)
set(SANITIZERS -fsanitize=address,undefined -fno-sanitize-recover=undefined)

# penumbra_sanitized(TARGET OPTIONS...): made by clang, with the sanitisers.
function(penumbra_sanitized TARGET)
  string(JOIN " " RUNNER env ${CMAKE_CXX_COMPILER_LAUNCHER})
  set(WITH_CLANG ${CMAKE_CURRENT_SOURCE_DIR}/with_clang.sh ${RUNNER} ${CLANG})
  set_target_properties(${TARGET} PROPERTIES CXX_COMPILER_LAUNCHER "${WITH_CLANG}" CXX_LINKER_LAUNCHER "${WITH_CLANG}")
  # Without warnings: the ordinary build gives them.
  target_compile_options(${TARGET} PRIVATE -w -gline-tables-only -D_GLIBCXX_ASSERTIONS ${SANITIZERS} -fno-omit-frame-pointer ${ARGN})
  target_link_options(${TARGET} PRIVATE ${SANITIZERS})
  target_include_directories(${TARGET} PRIVATE ${PROJECT_BINARY_DIR}/include ${PROJECT_SOURCE_DIR}/include)
  target_include_directories(${TARGET} SYSTEM PRIVATE ${WEBP_FOLDER})
  target_compile_definitions(${TARGET} PRIVATE PENUMBRA_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  target_link_libraries(${TARGET} PRIVATE OpenEXR::OpenEXR TinyGLTF::TinyGLTF draco::draco meshoptimizer::meshoptimizer
    PNG::PNG ZLIB::ZLIB JPEG::JPEG ${WEBP_DEMUX_LIBRARY} ${WEBP_MUX_LIBRARY} ${WEBP_LIBRARY} nlohmann_json::nlohmann_json glm::glm fmt::fmt Vulkan::Headers)
endfunction()
add_library(sanitized OBJECT ${SANITIZED_SOURCES})
penumbra_sanitized(sanitized -O1 -fsanitize=fuzzer-no-link)
target_precompile_headers(sanitized PRIVATE ${PRECOMPILED})
# Several files read as one, which takes half of the time, but for the made scenes: each has names of its own for its materials.
set_target_properties(sanitized PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
set(SCENES ${SANITIZED_SOURCES})
list(FILTER SCENES INCLUDE REGEX "/generated/")
set_source_files_properties(${SCENES} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)

add_executable(sanitized_test ${SANITIZED_TESTS} toy_nodes.cpp $<TARGET_OBJECTS:sanitized> $<TARGET_OBJECTS:penumbra_nodes>)
penumbra_sanitized(sanitized_test -O0)  # the quickest to build
target_link_libraries(sanitized_test PRIVATE GTest::gtest_main)
target_precompile_headers(sanitized_test PRIVATE ${PRECOMPILED} <gtest/gtest.h>)
# One test, whose files are beside those of the same tests in other programs.
file(MAKE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR}/sanitized)
add_test(NAME sanitized COMMAND sanitized_test --gtest_brief=1)
set_tests_properties(sanitized PROPERTIES LABELS unit TIMEOUT 900 ENVIRONMENT "TEST_TMPDIR=${CMAKE_CURRENT_BINARY_DIR}/sanitized")

add_executable(fuzz fuzz/fuzz_main.cpp $<TARGET_OBJECTS:sanitized> $<TARGET_OBJECTS:penumbra_nodes>)
penumbra_sanitized(fuzz -O1 -fsanitize=fuzzer-no-link)
target_link_options(fuzz PRIVATE -fsanitize=fuzzer)
# Each target's corpus, then as many inputs as take about ten seconds, the same in each run, so that what breaks one breaks the
# next; a minute at most. scripts/fuzz.sh alone tries others each time, for longer.
foreach(EACH pipeline:4500 declaration:7000 shot:6000 gltf:13000 exr:28000 image:160000 c_api:60 mutant:600)
  string(REGEX MATCH "(.*):(.*)" EACH ${EACH})
  set(TARGET ${CMAKE_MATCH_1})
  add_test(NAME fuzz_${TARGET} COMMAND ${PROJECT_SOURCE_DIR}/scripts/fuzz.sh 60 ${TARGET})
  set_tests_properties(fuzz_${TARGET} PROPERTIES LABELS unit TIMEOUT 300 ENVIRONMENT
    "PENUMBRA_FUZZ_RUNS=${CMAKE_MATCH_2};PENUMBRA_FUZZER=$<TARGET_FILE:fuzz>;PENUMBRA_FUZZ_OUT=${CMAKE_CURRENT_BINARY_DIR}/fuzzed")
endforeach()
