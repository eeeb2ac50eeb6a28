// SPDX-License-Identifier: MIT
// Tables in Markdown.
#pragma once

#include <string>
#include <vector>

namespace penumbra {

inline std::string markdown_row(const std::vector<std::string>& cells) {
    std::string out = "|";
    for (const std::string& cell : cells) out += " " + cell + " |";
    return out + "\n";
}

// With the line below it.
inline std::string markdown_head(const std::vector<std::string>& cells) {
    std::string out = markdown_row(cells) + "|";
    for (size_t i = 0; i < cells.size(); ++i) out += "---|";
    return out + "\n";
}

}  // namespace penumbra
