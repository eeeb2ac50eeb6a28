// SPDX-License-Identifier: MIT
// Build tool, the first half of compiling the node set: reads declarations and writes for each what its
// shader includes as "node.glsl" in every variant, as DIR/NAME.interface. A file that would not differ is
// left as it is, so that the build compiles shaders only where an interface did change.
//   write_interfaces DIR DECLARATION...
#include <filesystem>
#include <fstream>
#include <iostream>

#include "graph/interface.h"
#include "nodes/archive.h"
#include "penumbra/shadow_nodes.h"

namespace {

namespace fs = std::filesystem;
using namespace penumbra;

bool write_if_different(const fs::path& path, const std::string& text) {
    std::ifstream before(path, std::ios::binary);
    if (before && std::string(std::istreambuf_iterator<char>(before), {}) == text) return true;
    std::ofstream file(path, std::ios::binary);
    file << text;
    return static_cast<bool>(file.flush());
}

// What compile_node reads: the shader's path below shaders/, in a folder of the same name as the
// declaration's, and the interface of each variant.
std::string interface_text(const NodeType& type, const fs::path& declaration) {
    Archive archive{{"shader", (declaration.parent_path().filename() / type.shader).generic_string()}};
    if (!type.host)
        for (const Variant& variant : all_variants(type))
            archive["variant " + to_string(variant)] = generate_glsl(type, variant);
    return archive_text(archive);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        std::cerr << "usage: write_interfaces DIR DECLARATION...\n";
        return 2;
    }
    Diagnostics diagnostics;
    for (int i = 2; i < argc; ++i) {
        const fs::path declaration = argv[i], out = fs::path(argv[1]) / declaration.stem() += ".interface";
        const auto json = read_json(declaration, diagnostics);
        const auto type =
            json ? parse_node_type(*json, declaration.stem().string(), shadow_domain(), diagnostics)
                 : std::nullopt;
        if (type && !write_if_different(out, interface_text(*type, declaration)))
            diagnostics.add({out.string()}, "", "cannot be written");
    }
    std::cerr << diagnostics.text();
    return diagnostics.empty() ? 0 : 1;
}
