// SPDX-License-Identifier: MIT
// The public headers as a host sees them that loads Vulkan's functions by itself and has windows.h before
// them.
// The standard library's own headers come first: what is tried is penumbra's.
#define VK_NO_PROTOTYPES
#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <set>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#define near
#define far
#define small char
#define interface struct
#define min(a, b) ((a) < (b) ? (a) : (b))
#define max(a, b) ((a) > (b) ? (a) : (b))
#define ERROR 0
#define OPAQUE 2
// clang-format off
#include "penumbra/graph.h"
#include "penumbra/penumbra.h"
#include "penumbra/shadow_nodes.h"
#include "penumbra/user_nodes.h"
// clang-format on
#undef near
#undef far
#undef small
#undef interface
#undef min
#undef max
#undef ERROR
#undef OPAQUE

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>

namespace penumbra::test {
namespace {

namespace fs = std::filesystem;

// Only the standard library, Vulkan's types and each other: whatever else penumbra is made of stays inside.
TEST(PublicHeaders, IncludeNothingOfOthers) {
    const std::regex allowed(
        "#include (<[a-z_]+>|<std(def|int)\\.h>|<vulkan/vulkan_core\\.h>|\"penumbra/[a-z_]+\\.(h|glsl)\")");
    size_t seen = 0;
    for (const auto& entry : fs::directory_iterator(fs::path(PENUMBRA_SOURCE_DIR) / "include/penumbra")) {
        std::ifstream file(entry.path());
        for (std::string line; std::getline(file, line);) {
            if (!line.starts_with("#include")) continue;
            ++seen;
            EXPECT_TRUE(std::regex_match(line, allowed)) << entry.path() << ": " << line;
        }
    }
    EXPECT_GT(seen, 20u);
}

TEST(PublicHeaders, MakeAPlanWithoutADevice) {
    Diagnostics errors;
    const NodeSet nodes = shadow_nodes();
    const auto pipeline =
        load_pipeline(fs::path(PENUMBRA_SOURCE_DIR) / "pipelines/hybrid_shadows.json", {}, errors);
    const auto checked = pipeline ? check(*pipeline, nodes, errors) : std::nullopt;
    ASSERT_TRUE(checked) << errors.text();
    const auto plan = compile(*checked, {.extent = {64, 32}, .device = reference_device()}, {}, errors);
    ASSERT_TRUE(plan) << errors.text();
    EXPECT_FALSE(plan->modules.empty());
    for (const PlanPass& pass : plan->passes)
        EXPECT_LT(pass.module.value(), plan->modules.size()) << pass.node;
}

}  // namespace
}  // namespace penumbra::test
