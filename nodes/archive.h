// SPDX-License-Identifier: MIT
// Several texts or modules in one file, for what the build passes on of a node: each begins with a line
// "BYTES NAME". write_interfaces and compile_node write archives, compile_node and nodes.cpp read them.
#pragma once

#include <charconv>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>

namespace penumbra {

using Archive = std::map<std::string, std::string, std::less<>>;

inline std::string archive_text(const Archive& archive) {
    std::string text;
    for (const auto& [name, bytes] : archive)
        text += std::to_string(bytes.size()) + " " + name + "\n" + bytes + "\n";
    return text;
}

inline Archive read_archive(std::string_view text) {
    Archive archive;
    while (!text.empty()) {
        size_t size = 0;
        const auto [behind, error] = std::from_chars(text.data(), text.data() + text.size(), size);
        const size_t space = static_cast<size_t>(behind - text.data()), line = text.find('\n');
        if (error != std::errc() || line == text.npos || line < space + 1 || text.size() - line < size + 2)
            throw std::runtime_error("an archive is cut off or is none");
        archive.emplace(text.substr(space + 1, line - space - 1), text.substr(line + 1, size));
        text.remove_prefix(line + 1 + size + 1);
    }
    return archive;
}

}  // namespace penumbra
