// SPDX-License-Identifier: MIT
// A user's nodes: found, compiled once, compiled again when anything they came from changes, and explained
// where they are wrong, in the file that the user wrote.
#include "penumbra/user_nodes.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <regex>
#include <set>

#include "app/commands.h"
#include "graph/interface.h"
#include "graph/read_text.h"
#include "graph/shader_cache.h"
#include "penumbra/compile.h"
#include "penumbra/pipeline.h"
#include "penumbra/shadow_nodes.h"
#include "tests/test_folder.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

const fs::path root = PENUMBRA_SOURCE_DIR;

constexpr const char* declaration = R"({
  "node": "mine", "doc": "A test.", "shader": "mine.comp",
  "outputs": { "mark": { "kind": "image", "format": ["r16f", "r8"] } },
  "dispatch": { "over": "frame", "group": [8, 8] }
})";
constexpr const char* shader = R"(#include "node.glsl"
#include "common/rounded.glsl"
#include "common/finite.glsl"
#include "value.glsl"

void main() { imageStore(mark, ivec2(gl_GlobalInvocationID.xy), vec4(VALUE)); }
)";
constexpr const char* pipeline_text =
    R"({ "penumbra": 1, "name": "mine", "outputs": ["mark"], "nodes": { "mine": { "type": "mine" } } })";

class UserNodes : public ::testing::Test {
  protected:
    void SetUp() override {
        fs::create_directories(nodes_folder());
        write("nodes/mine.json", declaration);
        write("nodes/mine.comp", shader);
        write("nodes/value.glsl", "const float VALUE = 0.25;\n");
        write("mine.json", pipeline_text);
    }

    fs::path nodes_folder() const { return folder_ / "nodes"; }
    fs::path cache_folder() const { return folder_ / "cache"; }

    void write(const std::string& name, std::string_view text) const {
        std::ofstream(folder_ / name, std::ios::binary) << text;
    }

    std::shared_ptr<ShaderCache> cache() {
        return std::make_shared<ShaderCache>(cache_folder(),
                                             [this](const std::string& text) { warnings_ += text + "\n"; });
    }

    // The SPIR-V of the node's first variant, from a fresh node set; empty where it did not come to be.
    std::vector<uint32_t> first_variant(const std::shared_ptr<ShaderCache>& cache) {
        NodeSet nodes = shadow_nodes();
        diagnostics_ = {};
        if (!add_user_nodes(nodes, nodes_folder(), diagnostics_, cache)) return {};
        const NodeEntry& entry = *nodes.find("mine");
        const auto* words = find_shader(entry, all_variants(entry.type)[0], diagnostics_);
        return words ? *words : std::vector<uint32_t>{};
    }

    std::vector<fs::path> entries() const {
        std::vector<fs::path> files;
        for (const auto& entry : fs::directory_iterator(cache_folder())) files.push_back(entry.path());
        return files;
    }

    std::string declaration_errors() {
        NodeSet nodes = shadow_nodes();
        const size_t before = nodes.names().size();
        diagnostics_ = {};
        EXPECT_FALSE(add_user_nodes(nodes, nodes_folder(), diagnostics_, cache()));
        EXPECT_EQ(nodes.names().size(), before) << "a broken folder was added in part";
        return diagnostics_.text();
    }

    test::TestFolder folder_;
    Diagnostics diagnostics_;
    std::string warnings_;
};

TEST_F(UserNodes, APlanCompilesOnlyWhatItNeeds) {
    NodeSet nodes = shadow_nodes();
    const auto shaders = cache();
    ASSERT_TRUE(add_user_nodes(nodes, nodes_folder(), diagnostics_, shaders)) << diagnostics_.text();
    EXPECT_EQ(shaders->counts().compiled, 0u) << "nobody has used the node yet";
    const auto pipeline = parse_pipeline(pipeline_text, "mine.json", {}, diagnostics_);
    const auto checked = check(*pipeline, nodes, diagnostics_);
    ASSERT_TRUE(checked) << diagnostics_.text();
    Target target;
    target.extent = {64, 32};
    target.device = reference_device();
    for (int i = 0; i < 2; ++i)
        ASSERT_TRUE(compile(*checked, target, {}, diagnostics_)) << diagnostics_.text();
    EXPECT_EQ(shaders->counts().compiled, 1u);
    EXPECT_TRUE(compile_user_nodes(*checked, diagnostics_)) << diagnostics_.text();
    EXPECT_EQ(shaders->counts().compiled, 2u) << "check looks at every variant";
}

TEST_F(UserNodes, ACachedShaderIsTheSameAndIsNotCompiledAgain) {
    const auto first = first_variant(cache());
    ASSERT_FALSE(first.empty()) << diagnostics_.text();
    const auto later = cache();
    EXPECT_EQ(first_variant(later), first);
    EXPECT_EQ(later->counts().compiled, 0u);
    EXPECT_EQ(later->counts().found, 1u);
    EXPECT_EQ(entries().size(), 1u) << "something was left beside the entry";
    EXPECT_EQ(warnings_, "");
}

// Which a build system asks for.
TEST_F(UserNodes, ACachedShaderNamesTheFilesThatItIncludes) {
    NodeSet nodes = shadow_nodes();
    ASSERT_TRUE(add_user_nodes(nodes, nodes_folder(), diagnostics_, cache())) << diagnostics_.text();
    const NodeType& type = nodes.find("mine")->type;
    const ShaderSource source{nodes_folder() / "mine.comp",
                              generate_glsl(type, all_variants(type)[0]),
                              {nodes_folder(), root / "shaders", root / "include"}};
    const auto files_of = [&] {
        const auto shaders = cache();
        const auto compiled = shaders->compile(source, "first", diagnostics_);
        EXPECT_TRUE(compiled) << diagnostics_.text();
        return std::pair(std::set(compiled->dependencies.begin(), compiled->dependencies.end()),
                         shaders->counts().found);
    };
    const auto [files, none] = files_of();
    EXPECT_TRUE(files.contains(nodes_folder() / "value.glsl"));
    EXPECT_TRUE(files.contains(root / "shaders/common/finite.glsl"));
    EXPECT_EQ(files_of(), std::pair(files, none + 1));
}

TEST_F(UserNodes, AnyChangedSourceIsCompiledAgainIntoTheSameEntry) {
    const auto first = first_variant(cache());
    const std::pair<const char*, std::string> changes[] = {
        {"nodes/value.glsl", "const float VALUE = 0.5;\n"},
        {"nodes/mine.comp", std::string(shader) + "// as before\n"},
        {"nodes/mine.json", std::string(declaration).replace(std::string(declaration).rfind('}'), 1, R"(,
          "params": { "gain": { "type": "float", "default": 1, "doc": "factor" } } })")},
    };
    for (const auto& [file, text] : changes) {
        write(file, text);
        const auto shaders = cache();
        EXPECT_FALSE(first_variant(shaders).empty()) << diagnostics_.text();
        EXPECT_EQ(shaders->counts().compiled, 1u) << file;
    }
    EXPECT_NE(first_variant(cache()), first) << "the include's new value is in no shader";
    EXPECT_EQ(entries().size(), 1u);
    EXPECT_EQ(warnings_, "") << "out of date is not damaged";
}

// A file that comes to lie before another one in the search order changes what an #include means.
TEST_F(UserNodes, AnIncludeThatIsNowFoundElsewhereIsCompiledAgain) {
    first_variant(cache());
    for (const char* name : {"common/rounded.glsl", "common/finite.glsl"}) {
        fs::create_directories((nodes_folder() / name).parent_path());
        write(std::string("nodes/") + name, "// mine\n");
        const auto shaders = cache();
        EXPECT_FALSE(first_variant(shaders).empty()) << diagnostics_.text();
        EXPECT_EQ(shaders->counts().compiled, 1u) << name;
    }
}

TEST_F(UserNodes, ADamagedEntryIsNeverUsed) {
    const auto first = first_variant(cache());
    const fs::path entry = entries().at(0);
    const std::string good = *read_text(entry);
    std::vector<std::string> damaged = {"", "x", good.substr(0, good.size() / 2),
                                        good.substr(0, good.size() - 4), good + "more"};
    for (size_t at = 0; at < good.size(); at += 1 + good.size() / 61) {
        damaged.push_back(good);
        damaged.back()[at] = static_cast<char>(damaged.back()[at] ^ 0x10);
    }
    for (const std::string& bytes : damaged) {
        std::ofstream(entry, std::ios::binary) << bytes;
        warnings_.clear();
        const auto shaders = cache();
        ASSERT_EQ(first_variant(shaders), first) << diagnostics_.text();
        EXPECT_EQ(shaders->counts().corrupt, 1u);
        EXPECT_EQ(shaders->counts().compiled, 1u);
        EXPECT_NE(warnings_.find(entry.string()), std::string::npos);
        EXPECT_EQ(*read_text(entry), good) << "the entry was not mended";
    }
}

TEST_F(UserNodes, AFolderThatCannotBeWrittenIsSaidOnceAndDoesNoHarm) {
    write("cache", "a file where the folder should be");
    const auto shaders = cache();
    EXPECT_FALSE(first_variant(shaders).empty()) << diagnostics_.text();
    EXPECT_FALSE(first_variant(shaders).empty());
    EXPECT_EQ(shaders->counts().compiled, 2u);
    EXPECT_EQ(std::ranges::count(warnings_, '\n'), 1) << warnings_;
}

TEST_F(UserNodes, GlslErrorsPointIntoTheUsersFiles) {
    write("nodes/mine.comp", std::string(shader) + "\nfloat f() { return undeclared; }\n");
    EXPECT_TRUE(first_variant(cache()).empty());
    const std::string place = (nodes_folder() / "mine.comp").string();
    EXPECT_EQ(diagnostics_.text().find(place + ":8:1: 'undeclared'"), 0u) << diagnostics_.text();

    write("nodes/mine.comp", shader);
    write("nodes/value.glsl", "\n\nconst float VALUE = vec3(1);\n");
    EXPECT_TRUE(first_variant(cache()).empty());
    EXPECT_EQ(diagnostics_.text().find((nodes_folder() / "value.glsl").string() + ":3:1: "), 0u)
        << diagnostics_.text();

    fs::remove(nodes_folder() / "value.glsl");
    EXPECT_TRUE(first_variant(cache()).empty());
    EXPECT_EQ(diagnostics_.text().find(place + ":4:1: "), 0u) << diagnostics_.text();
    EXPECT_FALSE(fs::exists(cache_folder()) && !entries().empty())
        << "a shader that does not compile was kept";
}

// The preprocessor takes a specialisation constant for 0: an #if that asks one would always be false.
TEST_F(UserNodes, AConstantInAPreprocessorConditionIsAnError) {
    std::string with_param = declaration;
    with_param.insert(
        with_param.find("\"dispatch\""),
        R"("params": { "bright": { "type": "bool", "default": true, "constant": true, "doc": "d" } }, )");
    write("nodes/mine.json", with_param);
    EXPECT_FALSE(first_variant(cache()).empty()) << diagnostics_.text();
    for (const auto& [condition, column] :
         {std::pair{"#if LIT && BRIGHT", 12}, {"  # ifdef BRIGHT  // LIT", 11}}) {
        write("nodes/value.glsl", std::string("#define LIT 1\n") + condition +
                                      "\nconst float VALUE = 1;\n#else\nconst float VALUE = 0.25;\n#endif\n");
        EXPECT_TRUE(first_variant(cache()).empty());
        EXPECT_EQ(diagnostics_.text(),
                  fmt::format("{}:2:{}: 'BRIGHT' is a constant, no macro: write if (BRIGHT), without #\n",
                              (nodes_folder() / "value.glsl").string(), column));
    }
    write("nodes/value.glsl", "const float VALUE = BRIGHT ? 1.0 : 0.25;\n");
    EXPECT_FALSE(first_variant(cache()).empty()) << diagnostics_.text();
}

// A parser that takes its stack by the character would be at its end.
TEST_F(UserNodes, LinesOfAnyLengthAreRead) {
    const std::string blanks(300000, ' '), word(300000, 'w');
    write("nodes/value.glsl", "#if 1" + blanks + "\nconst float VALUE = 1;\n#endif\n");
    EXPECT_FALSE(first_variant(cache()).empty()) << diagnostics_.text().substr(0, 1000);
    write("nodes/value.glsl", "#error " + word + "\n");
    EXPECT_TRUE(first_variant(cache()).empty());
    EXPECT_EQ(diagnostics_.text().find((nodes_folder() / "value.glsl").string() + ":1:1: "), 0u)
        << diagnostics_.text().substr(0, 1000);
}

// A plan has no such descriptors: drivers crash in the shader, or read what is not there.
TEST_F(UserNodes, WhatIsBoundAndNotDeclaredIsAnError) {
    const std::string main_file = (nodes_folder() / "mine.comp").string(),
                      value_file = (nodes_folder() / "value.glsl").string();
    const std::string from =
        " is not declared: bindings come from the node's declaration, through node.glsl\n";
    const auto with = [&](const std::string& declared, const std::string& used) {
        write("nodes/mine.comp", "#include \"node.glsl\"\n" + declared + "void main() {\n" + used +
                                     "imageStore(mark, ivec2(0), vec4(0)); }\n");
        return first_variant(cache());
    };
    const std::string structure =
        "#extension GL_EXT_ray_query : require\n"
        "layout(set = 2, binding = 0) uniform accelerationStructureEXT as;\n";
    EXPECT_TRUE(with(structure,
                     "rayQueryEXT q; rayQueryInitializeEXT(q, as, 0u, 255u, vec3(0), 0.0, vec3(1), "
                     "1.0); rayQueryProceedEXT(q);\n")
                    .empty());
    EXPECT_EQ(diagnostics_.text(), main_file + ":3:63: 'as' (set 2, binding 0)" + from);
    EXPECT_FALSE(with(structure, "").empty()) << "nothing uses it: " << diagnostics_.text();

    write("nodes/value.glsl", "// words\nlayout(set = 3, binding = 1) buffer Words { uint words[]; };\n");
    EXPECT_TRUE(with("#include \"value.glsl\"\n", "words[0] = 1u;\n").empty());
    EXPECT_EQ(diagnostics_.text(), value_file + ":2:37: 'Words' (set 3, binding 1)" + from);
    write("nodes/value.glsl", "#define AT(s, b) layout(set = s, binding = b)\n");
    EXPECT_TRUE(with("#include \"value.glsl\"\nAT(0, 7) uniform\nsampler2D s[2];\n",
                     "imageStore(mark, ivec2(1), textureLod(s[1], vec2(0), 0.0));\n")
                    .empty());
    EXPECT_EQ(diagnostics_.text(), main_file + ":4:11: 's' (set 0, binding 7)" + from);
    EXPECT_TRUE(with("layout(binding = 2) uniform sampler2D s;\n",
                     "imageStore(mark, ivec2(1), textureLod(s, vec2(0), 0.0));\n")
                    .empty())
        << "the image's binding, but no image";
    EXPECT_EQ(diagnostics_.text(), main_file + ":2:39: 's' (set 0, binding 2)" + from);
    EXPECT_TRUE(with("layout(push_constant) uniform Own { uint count; } own;\n",
                     "imageStore(mark, ivec2(1), vec4(own.count));\n")
                    .empty());
    EXPECT_EQ(diagnostics_.text(),
              main_file +
                  ":2:51: 'own' (push constants) is not declared: these come from the parameters of the "
                  "node's declaration, through node.glsl\n");

    write("nodes/mine.comp",
          "layout(set = 0, binding = 2, r16f) uniform image2D mark;\n"
          "void main() { imageStore(mark, ivec2(0), vec4(0)); }\n");
    EXPECT_TRUE(first_variant(cache()).empty()) << "binding 2 today, and maybe another one tomorrow";
}

// Without an end it would take all memory there is.
TEST_F(UserNodes, AnIncludeCycleIsAnError) {
    const std::string a = (nodes_folder() / "a.glsl").string(), b = (nodes_folder() / "b.glsl").string();
    write("nodes/mine.comp", "#include \"node.glsl\"\n#include \"a.glsl\"\nvoid main() {}\n");
    write("nodes/a.glsl", "\n#include \"a.glsl\"\n");
    EXPECT_TRUE(first_variant(cache()).empty());
    EXPECT_EQ(diagnostics_.text(), a + ":2:1: include cycle a.glsl -> a.glsl\n");
    write("nodes/a.glsl", "#include \"b.glsl\"\n");
    write("nodes/b.glsl", "#define B\n\n#include \"a.glsl\"\n#include \"a.glsl\"\n");
    EXPECT_TRUE(first_variant(cache()).empty());
    EXPECT_EQ(diagnostics_.text(), b + ":3:1: include cycle a.glsl -> b.glsl -> a.glsl\n");
    write("nodes/mine.comp", "\n#include \"a.glsl\"\nvoid main() {}\n");
    write("nodes/a.glsl", "#include \"mine.comp\"\n");
    EXPECT_TRUE(first_variant(cache()).empty());
    EXPECT_EQ(diagnostics_.text(), (nodes_folder() / "mine.comp").string() +
                                       ":2:1: include cycle a.glsl -> mine.comp -> a.glsl\n");
}

TEST_F(UserNodes, IncludesThatAGuardOrACounterEndsAreNoCycle) {
    write("nodes/mine.comp", R"(#include "node.glsl"
#include "a.glsl"
void main() { imageStore(mark, ivec2(0), vec4(A + B + F3)); }
)");
    write("nodes/a.glsl", R"(#ifndef A_GLSL
#define A_GLSL
#include "b.glsl"
#include "count.glsl"
const float A = B;
#endif
)");
    write("nodes/b.glsl", R"(#ifndef B_GLSL
#define B_GLSL
#include "a.glsl"
const float B = 1.0;
#endif
)");
    write("nodes/count.glsl", R"(#ifndef N1
#define N1
#include "count.glsl"
#elif !defined N2
#define N2
#include "count.glsl"
#else
const float F3 = 3.0;
#endif
)");
    EXPECT_FALSE(first_variant(cache()).empty()) << diagnostics_.text();
}

TEST_F(UserNodes, AByteOrderMarkIsNamed) {
    const std::string said = ":1:1: the file begins with a byte order mark; save it as plain UTF-8\n";
    for (const auto& [name, text] :
         {std::pair<std::string, std::string>{"value.glsl", "const float VALUE = 1;\n"},
          {"mine.comp", shader}}) {
        write("nodes/" + name, "\xef\xbb\xbf" + text);
        EXPECT_TRUE(first_variant(cache()).empty());
        EXPECT_EQ(diagnostics_.text(), (nodes_folder() / name).string() + said);
    }
}

TEST_F(UserNodes, ASetWithoutADomainTakesAFolderOfSeveral) {
    write("nodes/another.json", std::regex_replace(std::string(declaration), std::regex("mine"), "another"));
    write("nodes/another.comp", "#include \"node.glsl\"\nvoid main() {}\n");
    NodeSet nodes;
    EXPECT_TRUE(add_user_nodes(nodes, nodes_folder(), diagnostics_, cache())) << diagnostics_.text();
    EXPECT_EQ(nodes.names().size(), 2u);
}

TEST_F(UserNodes, AShadersNameMayBeTooLongForAFile) {
    write("nodes/mine.json", std::regex_replace(std::string(declaration), std::regex("mine.comp"),
                                                std::string(300, 'm') + ".comp"));
    EXPECT_NE(declaration_errors().find("shader: no file "), std::string::npos) << diagnostics_.text();
}

TEST_F(UserNodes, DeclarationErrorsPointIntoTheJson) {
    const std::string file = (nodes_folder() / "mine.json").generic_string();
    write("nodes/mine.json", R"({ "node": "mine", "doc": "d", "shader": "mine.comp", "output": {} })");
    EXPECT_NE(declaration_errors().find(file + ":1:54: unknown key \"output\"; did you mean \"outputs\"?"),
              std::string::npos);

    write("nodes/mine.json", declaration);
    fs::remove(nodes_folder() / "mine.comp");
    EXPECT_EQ(declaration_errors().find(file + ":2:47: shader: no file "), 0u) << diagnostics_.text();
}

TEST_F(UserNodes, ABuiltInsNameIsAnError) {
    std::string text = declaration;
    text.replace(text.find("\"mine\""), 6, "\"filter\"");
    write("nodes/filter.json", text);
    EXPECT_NE(declaration_errors().find("filter.json:2:11: node: \"filter\" is a node type already"),
              std::string::npos)
        << diagnostics_.text();
}

TEST_F(UserNodes, AFolderWithoutDeclarationsIsAnError) {
    fs::remove(nodes_folder() / "mine.json");
    EXPECT_NE(declaration_errors().find("holds no node declarations"), std::string::npos);
    fs::remove_all(nodes_folder());
    EXPECT_NE(declaration_errors().find("cannot be read"), std::string::npos);
}

TEST_F(UserNodes, FilesOutsideOfTheFolderAreRefused) {
    write("outside.bin", "0123456789abcdef");
    for (const std::string name : {"../outside.bin", "sub/../../outside.bin", "/etc/passwd", ".."}) {
        std::string text = declaration;
        text.replace(
            text.rfind('}'), 1,
            R"(, "tables": { "noise": { "file": ")" + name + R"(", "format": "rg8", "extent": [4, 2] } } })");
        write("nodes/mine.json", text);
        EXPECT_NE(declaration_errors().find("tables.noise.file: \"" + name +
                                            "\" leads out of the declaration's folder"),
                  std::string::npos)
            << diagnostics_.text();
    }
}

TEST_F(UserNodes, TablesAreReadAndMeasured) {
    std::string text = declaration;
    text.replace(text.rfind('}'), 1,
                 R"(, "tables": { "noise": { "file": "noise.bin", "format": "rg8", "extent": [4, 2] } } })");
    write("nodes/mine.json", text);
    write("nodes/noise.bin", "0123456789abcdef");
    NodeSet nodes = shadow_nodes();
    ASSERT_TRUE(add_user_nodes(nodes, nodes_folder(), diagnostics_, cache())) << diagnostics_.text();
    ASSERT_EQ(nodes.find("mine")->tables.size(), 1u);
    EXPECT_EQ(nodes.find("mine")->tables[0].texels.size(), 16u);
    write("nodes/noise.bin", "short");
    EXPECT_NE(declaration_errors().find("tables.noise.file: has 5 bytes; format and extent ask for 16"),
              std::string::npos);
}

// The commands end with 2 and say where, as for any other file of the user's.
TEST_F(UserNodes, CommandsEndWith2OnABrokenShader) {
    ASSERT_EQ(setenv("XDG_CACHE_HOME", cache_folder().c_str(), 1), 0);
    CheckArguments check{{(folder_ / "mine.json").string()}, {nodes_folder().string()}};
    PlanArguments plan;
    plan.pipeline = check.pipelines[0];
    plan.size = "64x32";
    plan.node_folders = check.node_folders;
    const auto run = [&](auto command, const auto& arguments) {
        ::testing::internal::CaptureStderr();
        ::testing::internal::CaptureStdout();
        const int code = command(arguments);
        ::testing::internal::GetCapturedStdout();
        return std::pair(code, ::testing::internal::GetCapturedStderr());
    };
    EXPECT_EQ(run(run_check, check), std::pair(0, std::string()));
    EXPECT_EQ(run(run_plan, plan), std::pair(0, std::string()));
    EXPECT_TRUE(fs::is_directory(cache_folder() / "penumbra")) << "XDG_CACHE_HOME is not heeded";

    write("nodes/mine.comp",
          "#include \"node.glsl\"\nvoid main() { imageStore(mrak, ivec2(0), vec4(0)); }\n");
    for (const auto& [code, text] : {run(run_check, check), run(run_plan, plan)}) {
        EXPECT_EQ(code, 2);
        EXPECT_EQ(text.find((nodes_folder() / "mine.comp").string() + ":2:1: 'mrak'"), 0u) << text;
        EXPECT_EQ(text.find("'mrak'"), text.rfind("'mrak'")) << "said twice: " << text;
    }
    check.node_folders = plan.node_folders = {(folder_ / "nowhere").string()};
    EXPECT_EQ(run(run_check, check).first, 2);
    EXPECT_EQ(run(run_plan, plan).first, 2);
}

}  // namespace
}  // namespace penumbra
