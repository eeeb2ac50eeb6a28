// SPDX-License-Identifier: MIT
// Rules of the house that a compiler does not check.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "penumbra/graph.h"
#include "penumbra/shadow_nodes.h"

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
    std::vector<fs::path> files;
    for (const char* folder : {"graph", "include/penumbra"})
        for (const auto& entry : fs::recursive_directory_iterator(root / folder))
            files.push_back(entry.path());
    for (const fs::path& file : files) {
        if (!fs::is_regular_file(file) || file.filename() == "shadow_nodes.h")
            continue;  // which is the node set's
        std::istringstream lines(read(file));
        int number = 0;
        for (std::string line; std::getline(lines, line);) {
            ++number;
            if (line.find("shadow_nodes()") != std::string::npos) continue;            // graph.h's example
            if (line.find("Knows nothing of shadows") != std::string::npos) continue;  // this very rule
            EXPECT_FALSE(std::regex_search(line, words)) << file << ":" << number << ": " << line;
        }
    }
}

// The example at the top of graph.h, compiled: the test below holds it to these lines.
[[maybe_unused]] void example(const DeviceHandles& device, VkCommandBuffer cmd, const FrameDescription& frame,
                              std::span<const SlotBinding> slots) {
    // clang-format off
    Diagnostics errors;
    NodeSet nodes = shadow_nodes();  // penumbra/shadow_nodes.h, or a set of your own
    auto pipeline = load_pipeline("pipelines/fidelityfx.json", {}, errors);
    auto checked  = check(*pipeline, nodes, errors);
    auto plan     = compile(*checked, {.extent = {1280, 720}, .device = device_table(device)}, {}, errors);
    auto program  = std::make_shared<Program>(device, std::make_shared<Plan>(std::move(*plan)));
    View view(program, {});
    view.record(cmd, frame, slots);  // into your command buffer
    // clang-format on
}

TEST(House, TheExampleOfTheGraphCompiles) {
    const std::string header = read(root / "include/penumbra/graph.h"),
                      here = read(root / "tests/house_test.cpp");
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
