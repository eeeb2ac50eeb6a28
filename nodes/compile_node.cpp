// SPDX-License-Identifier: MIT
// Build tool, the second half of compiling the node set: a shader with each interface that write_interfaces
// gave to SPIR-V, all in one archive, with a depfile for the build system. With --cache a variant that a
// folder has from another build is taken from there.
//   compile_node NAME.interface --shaders DIR --root DIR --out FILE --depfile FILE [--cache DIR]
#include <fstream>
#include <iostream>
#include <set>

#include "graph/read_text.h"
#include "graph/shader_cache.h"
#include "nodes/archive.h"

namespace {

namespace fs = std::filesystem;
using namespace penumbra;

struct Arguments {
    fs::path interface, shaders, root, out, depfile, cache;
};

std::optional<Arguments> parse(int argc, char** argv) {
    if (argc != 10 && argc != 12) return std::nullopt;
    Arguments a{argv[1], {}, {}, {}, {}, {}};
    for (int i = 2; i + 1 < argc; i += 2) {
        const std::string_view key = argv[i];
        fs::path* target = key == "--shaders"   ? &a.shaders
                           : key == "--root"    ? &a.root
                           : key == "--out"     ? &a.out
                           : key == "--depfile" ? &a.depfile
                           : key == "--cache"   ? &a.cache
                                                : nullptr;
        if (!target) return std::nullopt;
        *target = argv[i + 1];
    }
    return a;
}

struct Compiled {
    Archive modules;
    std::set<fs::path> dependencies;
};

std::optional<Compiled> compile(const Arguments& arguments, Diagnostics& diagnostics) {
    const auto text = read_text(arguments.interface);
    if (!text) {
        diagnostics.add({arguments.interface.string()}, "", "cannot be read");
        return std::nullopt;
    }
    const Archive interface = read_archive(*text);
    const fs::path file = arguments.shaders / interface.at("shader");
    ShaderCache cache(arguments.cache, [](const std::string& warning) { std::cerr << warning << "\n"; });
    Compiled result;
    for (const auto& [name, glsl] : interface) {
        if (name == "shader") continue;
        const auto shader =
            cache.compile({file, glsl, {arguments.shaders, arguments.root}}, name, diagnostics);
        if (!shader) return std::nullopt;
        result.dependencies.insert(file);
        result.dependencies.insert(shader->dependencies.begin(), shader->dependencies.end());
        result.modules[name].assign(reinterpret_cast<const char*>(shader->spirv.data()),
                                    4 * shader->spirv.size());
    }
    return result;
}

// As make and ninja read names: blanks and what they would take for their own are marked.
std::string in_depfile(const fs::path& path) {
    std::string marked;
    for (const char c : path.string())
        marked += c == ' ' || c == '#' ? std::string{'\\', c} : c == '$' ? "$$" : std::string{c};
    return marked;
}

}  // namespace

int main(int argc, char** argv) {
    const auto arguments = parse(argc, argv);
    if (!arguments) {
        std::cerr << "usage: compile_node NAME.interface --shaders DIR --root DIR --out FILE --depfile FILE "
                     "[--cache DIR]\n";
        return 2;
    }
    Diagnostics diagnostics;
    if (const auto compiled = compile(*arguments, diagnostics)) {
        std::ofstream out(arguments->out, std::ios::binary), dep(arguments->depfile);
        out << archive_text(compiled->modules);
        dep << in_depfile(arguments->out) << ":";
        for (const fs::path& d : compiled->dependencies) dep << " " << in_depfile(d);
        dep << "\n";
        if (out.flush() && dep.flush()) return 0;
        diagnostics.add({arguments->out.string()}, "", "cannot be written");
    }
    std::cerr << diagnostics.text();
    return 1;
}
