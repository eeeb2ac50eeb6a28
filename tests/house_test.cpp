// SPDX-License-Identifier: MIT
// Rules of the house that a compiler does not check.
#include <algorithm>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "penumbra/graph.h"
#include "penumbra/shadow_nodes.h"
#include "tests/project_files.h"

namespace penumbra::test {
namespace {

// The files that a file includes by name, as the names spell them.
std::set<std::string> includes_of(const fs::path& file) {
    static const std::regex include("^[ \t]*#[ \t]*include[ \t]+\"([^\"]+)\"");
    std::set<std::string> names;
    std::istringstream lines(read(file));
    for (std::string line; std::getline(lines, line);)
        if (std::smatch match; std::regex_search(line, match, include)) names.insert(match[1]);
    return names;
}

// GROUP/NAME of every file with this suffix in the groups of nodes/ or of shaders/.
std::set<std::string> in_groups(const fs::path& folder, const std::string& suffix) {
    std::set<std::string> names;
    for (const auto& group : fs::directory_iterator(folder)) {
        if (!group.is_directory()) continue;
        for (const auto& file : fs::directory_iterator(group.path())) {
            const std::string name = file.path().filename().string();
            if (name.ends_with(suffix))
                names.insert(group.path().filename().string() + "/" +
                             name.substr(0, name.size() - suffix.size()));
        }
    }
    return names;
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

TEST(House, ANodeAndItsShaderHaveOneNameInOneGroup) {
    const std::set<std::string> declared = in_groups(root / "nodes", ".json");
    EXPECT_EQ(declared, in_groups(root / "shaders", ".comp"));
    std::set<std::string> names;
    for (const std::string& node : declared)
        EXPECT_TRUE(names.insert(fs::path(node).filename().string()).second) << node << " is there twice";
    const std::vector<std::string> built = shadow_nodes().names();
    EXPECT_EQ(names, std::set<std::string>(built.begin(), built.end()));
}

// The files that a shader is made of, as paths below shaders/; generated ones are none.
std::set<std::string> files_of(const std::string& shader) {
    std::set<std::string> files;
    std::vector<std::string> left{shader + ".comp"};
    while (!left.empty()) {
        const std::string file = left.back();
        left.pop_back();
        if (file == "node.glsl" || !files.insert(file).second) continue;
        EXPECT_TRUE(fs::is_regular_file(root / "shaders" / file)) << shader << " includes " << file;
        for (const std::string& name : includes_of(root / "shaders" / file)) left.push_back(name);
    }
    return files;
}

// Whoever asks where pixels are asks for a camera, so that a host that forgot its own is told
// (frame_check.h).
TEST(House, WhoseShaderAsksWherePixelsAreNeedsACamera) {
    const NodeSet nodes = shadow_nodes();
    size_t asking = 0;
    for (const std::string& shader : in_groups(root / "shaders", ".comp")) {
        const std::string name = fs::path(shader).filename().string();
        const bool asks = files_of(shader).contains("common/camera.glsl");
        const NodeEntry* node = nodes.find(name);
        ASSERT_TRUE(node) << name;
        EXPECT_EQ(std::ranges::count(node->type.needs, "camera"), asks) << name;
        asking += asks;
    }
    EXPECT_GT(asking, 0u);
}

// What one group alone includes lies in its folder; shaders/common/ is for what two groups or C++ share.
TEST(House, AnIncludeLiesWithTheGroupThatItServes) {
    std::map<std::string, std::set<std::string>> groups;  // that reach a file, by its path below shaders/
    for (const std::string& shader : in_groups(root / "shaders", ".comp")) {
        const std::string group = fs::path(shader).parent_path().string();
        for (const std::string& file : files_of(shader)) groups[file].insert(group);
    }
    std::set<std::string> in_cpp;
    for (const char* folder : {"nodes", "host", "app"})
        for (const auto& entry : fs::recursive_directory_iterator(root / folder))
            if (entry.path().extension() == ".h" || entry.path().extension() == ".cpp")
                in_cpp.merge(includes_of(entry.path()));

    for (const auto& entry : fs::recursive_directory_iterator(root / "shaders")) {
        if (!entry.is_regular_file()) continue;
        const std::string file = fs::relative(entry.path(), root / "shaders").generic_string();
        const std::string folder = fs::path(file).parent_path().string();
        if (folder != "common") {
            EXPECT_EQ(groups[file], std::set<std::string>{folder}) << file;
        } else if (!in_cpp.contains("shaders/" + file)) {
            EXPECT_GE(groups[file].size(), 2u)
                << file << " serves " << (groups[file].empty() ? "nobody" : *groups[file].begin())
                << " alone";
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

// Else scripts/source_mutants.py stops at it, and nobody sees the mutants behind it die.
TEST(House, AMutantsTextIsThereOnce) {
    std::istringstream lines(read(root / "tests/source_mutants.txt"));
    std::set<std::vector<std::string>> mutants;  // file, text and what it becomes
    for (std::string line; std::getline(lines, line);) {
        if (line.empty() || line[0] == '#') continue;
        std::vector<std::string> fields(1);
        for (size_t i = 0; i < line.size(); ++i)
            if (line[i] == '|')
                fields.emplace_back();
            else
                fields.back() +=
                    line[i] == '\\' && i + 1 < line.size() && line[i + 1] == '|' ? line[++i] : line[i];
        for (std::string& field : fields) {
            field.erase(0, field.find_first_not_of(' '));
            field.erase(field.find_last_not_of(' ') + 1);
        }
        ASSERT_EQ(fields.size(), 5u) << line;
        const std::string text = read(root / fields[0]);
        const size_t at = text.find(fields[1]);
        ASSERT_NE(at, std::string::npos) << line;
        EXPECT_EQ(text.find(fields[1], at + 1), std::string::npos) << line;
        EXPECT_TRUE(mutants.emplace(fields.begin(), fields.begin() + 3).second) << "twice: " << line;
    }
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
