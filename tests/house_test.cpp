// SPDX-License-Identifier: MIT
// Rules of the house that a compiler does not check.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "graph/graph.h"
#include "nodes/nodes.h"

namespace penumbra::test {
namespace {

namespace fs = std::filesystem;

const fs::path root = PENUMBRA_SOURCE_DIR;

std::string read(const fs::path& file) {
    std::ifstream in(file);
    std::stringstream text;
    text << in.rdbuf();
    return text.str();
}

// The framework works for any domain: what a node set is about stands with the node set.
TEST(House, TheGraphKnowsNothingOfShadows) {
    const std::regex words("scene|bvh|tlas|alpha|ray_?quer|\\bsun|caster|shadow|penumbra_light",
                           std::regex::icase);
    for (const auto& entry : fs::recursive_directory_iterator(root / "graph")) {
        if (!entry.is_regular_file()) continue;
        std::istringstream lines(read(entry.path()));
        int number = 0;
        for (std::string line; std::getline(lines, line);) {
            ++number;
            if (line.find("shadow_nodes()") != std::string::npos) continue;            // graph.h's example
            if (line.find("Knows nothing of shadows") != std::string::npos) continue;  // this very rule
            EXPECT_FALSE(std::regex_search(line, words)) << entry.path() << ":" << number << ": " << line;
        }
    }
}

// The example at the top of graph.h, compiled: the test below holds it to these lines.
[[maybe_unused]] void example(const DeviceHandles& device, VkCommandBuffer cmd, const FrameDescription& frame,
                              std::span<const SlotBinding> slots) {
    // clang-format off
    Diagnostics errors;
    NodeSet nodes = shadow_nodes();  // nodes/nodes.h, or a set of your own
    auto pipeline = load_pipeline("pipelines/fidelityfx.json", {}, errors);
    auto checked  = check(*pipeline, nodes, errors);
    auto plan     = compile(*checked, {.extent = {1280, 720}, .device = device_table(device)}, {}, errors);
    auto program  = std::make_shared<Program>(device, std::make_shared<Plan>(std::move(*plan)));
    View view(program, {});
    view.record(cmd, frame, slots);  // into your command buffer
    // clang-format on
}

TEST(House, TheExampleOfTheGraphCompiles) {
    const std::string header = read(root / "graph/graph.h"), here = read(__FILE__);
    std::istringstream lines(header);
    size_t found = 0;
    for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with("//     ")) continue;
        ++found;
        EXPECT_NE(here.find("\n    " + line.substr(7) + "\n"), std::string::npos) << line;
    }
    EXPECT_EQ(found, 8u);
}

}  // namespace
}  // namespace penumbra::test
