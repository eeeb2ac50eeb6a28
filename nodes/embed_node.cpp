// SPDX-License-Identifier: MIT
// Build tool: reads nodes/<type>.json, generates its GLSL interface, compiles every variant of its shader and
// writes a C++ source that embeds the lot, with a depfile for the build system.
//   embed_node DECLARATION --shaders DIR --root DIR --tables DIR --out FILE.cpp --depfile FILE.d
#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <set>

#include "graph/interface.h"
#include "graph/shader_compiler.h"
#include "nodes/domain.h"

namespace {

namespace fs = std::filesystem;
using namespace penumbra;

struct Arguments {
    fs::path declaration, shaders, root, tables, out, depfile;
};

std::optional<Arguments> parse(int argc, char** argv) {
    Arguments a;
    if (argc < 2) return std::nullopt;
    a.declaration = argv[1];
    for (int i = 2; i + 1 < argc; i += 2) {
        const std::string_view key = argv[i];
        fs::path* target = key == "--shaders"   ? &a.shaders
                           : key == "--root"    ? &a.root
                           : key == "--tables"  ? &a.tables
                           : key == "--out"     ? &a.out
                           : key == "--depfile" ? &a.depfile
                                                : nullptr;
        if (!target) return std::nullopt;
        *target = argv[i + 1];
    }
    return a;
}

std::string read(const fs::path& path, bool& ok) {
    std::ifstream file(path, std::ios::binary);
    ok = ok && static_cast<bool>(file);
    return {std::istreambuf_iterator<char>(file), {}};
}

std::string words_text(std::span<const uint32_t> words) {
    std::string text;
    for (size_t i = 0; i < words.size(); ++i)
        text += fmt::format("{:#x},{}", words[i], i % 12 == 11 ? "\n" : "");
    return text;
}

class Embedder {
  public:
    Embedder(Arguments arguments, NodeType type) : arguments_(std::move(arguments)), type_(std::move(type)) {}

    bool compile_variants(Diagnostics& diagnostics) {
        if (type_.host) return true;
        for (const Variant& variant : all_variants(type_)) {
            const ShaderSource source{arguments_.shaders / type_.shader,
                                      generate_glsl(type_, variant),
                                      {arguments_.shaders, arguments_.root}};
            auto shader = compile_shader(source, diagnostics);
            if (!shader) return false;
            dependencies_.insert(source.file);
            dependencies_.insert(shader->dependencies.begin(), shader->dependencies.end());
            const size_t i = variants_++;
            body_ += fmt::format("const uint32_t spirv_{}[] = {{{}}};\n", i, words_text(shader->spirv));
            variant_list_ += fmt::format("    {{\"{}\", spirv_{}}},\n", to_string(variant), i);
        }
        return true;
    }

    bool embed_tables() {
        for (const Table& table : type_.tables) {
            bool ok = true;
            const fs::path file = arguments_.tables / table.file;
            const std::string bytes = read(file, ok);
            if (!ok || bytes.size() % 4 != 0) {
                std::cerr << file.string()
                          << ": cannot read the table, or its size is not a multiple of 4 bytes\n";
                return false;
            }
            dependencies_.insert(file);
            std::vector<uint32_t> words(bytes.size() / 4);
            std::copy(bytes.begin(), bytes.end(), reinterpret_cast<char*>(words.data()));
            body_ += fmt::format("const uint32_t table_{}[] = {{{}}};\n", table.name, words_text(words));
            table_list_ += fmt::format("    {{\"{0}\", table_{0}}},\n", table.name);
        }
        return true;
    }

    void write(const std::string& declaration_text) const {
        std::ofstream out(arguments_.out);
        out << "// Generated from " << arguments_.declaration.filename().string()
            << ".\n#include \"nodes/embedded.h\"\n"
            << "namespace penumbra {\nnamespace {\n"
            << body_;
        if (!variant_list_.empty())
            out << "const EmbeddedVariant variants[] = {\n" << variant_list_ << "};\n";
        if (!table_list_.empty()) out << "const EmbeddedTable tables[] = {\n" << table_list_ << "};\n";
        out << "const char declaration[] = R\"json(" << declaration_text << ")json\";\n}  // namespace\n"
            << "extern const EmbeddedNode embedded_" << type_.name << ";\n"
            << "const EmbeddedNode embedded_" << type_.name << "{\"" << type_.name << "\", declaration, "
            << (variant_list_.empty() ? "{}" : "variants") << ", " << (table_list_.empty() ? "{}" : "tables")
            << "};\n}  // namespace penumbra\n";
        std::ofstream dep(arguments_.depfile);
        dep << arguments_.out.string() << ":";
        for (const fs::path& d : dependencies_) dep << " " << d.string();
        dep << "\n";
    }

  private:
    Arguments arguments_;
    NodeType type_;
    size_t variants_ = 0;
    std::string body_, variant_list_, table_list_;
    std::set<fs::path> dependencies_;
};

}  // namespace

int main(int argc, char** argv) {
    const auto arguments = parse(argc, argv);
    if (!arguments) {
        std::cerr << "usage: embed_node DECLARATION --shaders DIR --root DIR --tables DIR --out FILE "
                     "--depfile FILE\n";
        return 2;
    }
    bool ok = true;
    const std::string text = read(arguments->declaration, ok);
    Diagnostics diagnostics;
    const auto json = parse_json(text, arguments->declaration.string(), diagnostics);
    auto type =
        json ? parse_node_type(*json, arguments->declaration.stem().string(), shadow_domain(), diagnostics)
             : std::nullopt;
    if (ok && type) {
        Embedder embedder(*arguments, std::move(*type));
        if (embedder.compile_variants(diagnostics) && embedder.embed_tables()) {
            embedder.write(text);
            return 0;
        }
    }
    std::cerr << diagnostics.text();
    return 1;
}
