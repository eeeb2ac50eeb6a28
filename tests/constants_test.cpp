// SPDX-License-Identifier: MIT
// docs/constants.md says of every number that moves an error or a cost where it comes from. The number itself
// stands in a shader or a declaration, and a change of one is a change of the other: no test of pictures sees
// all of them.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

namespace penumbra {
namespace {

namespace fs = std::filesystem;
const fs::path root = PENUMBRA_SOURCE_DIR;

std::string text_of(const fs::path& file) {
    std::ifstream stream(file);
    std::string text(std::istreambuf_iterator<char>(stream), {});
    std::ranges::replace(text, '\n', ' ');
    return text;
}

// "| `a` | `b` | ..." to {"a", "b", ...}; only cells of code count, and only at the beginning.
std::vector<std::string> code_cells(const std::string& line) {
    std::vector<std::string> cells;
    size_t at = 0;
    while (line.compare(at, 3, "| `") == 0) {
        const size_t end = line.find("` |", at + 3);
        if (end == std::string::npos) break;
        cells.push_back(line.substr(at + 3, end - at - 3));
        at = end + 2;
    }
    return cells;
}

bool is_in_shader(const std::string& text, std::string name, const std::string& value) {
    const size_t open = name.find("[["), close = name.find("]]");
    if (open != std::string::npos) {  // the text around a number without a name
        if (name.substr(open + 2, close - open - 2) != value) return false;
        name.erase(close, 2).erase(open, 2);
        return text.find(name) != std::string::npos;
    }
    // "NAME = VALUE;" or "NAME[COUNT] = VALUE,"
    for (size_t at = text.find(name); at != std::string::npos; at = text.find(name, at + 1)) {
        size_t after = at + name.size();
        if (after < text.size() && text[after] == '[') after = text.find(']', after) + 1;
        const bool whole = at > 0 && text[at - 1] == ' ' && text.compare(after, 3, " = ") == 0;
        if (!whole || text.compare(after + 3, value.size(), value) != 0) continue;
        const char next = text[after + 3 + value.size()];
        if (next == ';' || next == ',') return true;
    }
    return false;
}

TEST(Constants, TheTableSaysWhatTheFilesHave) {
    std::ifstream page(root / "docs/constants.md");
    size_t checked = 0;
    for (std::string line; std::getline(page, line);) {
        const std::vector<std::string> cells = code_cells(line);
        if (cells.size() < 3) continue;
        const std::string &name = cells[0], &file = cells[1], &value = cells[2];
        if (file.ends_with(".json")) {
            const auto declaration = nlohmann::json::parse(std::ifstream(root / "nodes" / file));
            const std::string param = name.substr(name.find('.') + 1);
            EXPECT_EQ(declaration.at("params").at(param).at("default"), nlohmann::json::parse(value)) << name;
        } else {
            EXPECT_TRUE(is_in_shader(text_of(root / "shaders" / file), name, value))
                << file << " has no " << name << " of " << value;
        }
        ++checked;
    }
    EXPECT_GE(checked, 90u) << "rows were not understood";
}

}  // namespace
}  // namespace penumbra
