// SPDX-License-Identifier: MIT
// SPIR-V 1.5 rather than 1.6: at 1.6 glslang emits LocalSizeId, which needs maintenance4 to be enabled by the
// host.
#include "graph/shader_compiler.h"

#include <fmt/format.h>
#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>

#include <algorithm>
#include <fstream>
#include <regex>
#include <set>
#include <spirv-tools/libspirv.hpp>
#include <spirv-tools/optimizer.hpp>
#include <sstream>

namespace penumbra {
namespace {

// glslang needs the process initialised once; the last user finalises it.
struct GlslangProcess {
    GlslangProcess() { glslang::InitializeProcess(); }
    ~GlslangProcess() { glslang::FinalizeProcess(); }
};

class Includer : public glslang::TShader::Includer {
  public:
    explicit Includer(const ShaderSource& source) : source_(source) {}

    IncludeResult* includeLocal(const char* header, const char*, size_t) override {
        if (std::string_view(header) == "node.glsl") return keep("node.glsl", source_.node_glsl);
        auto found = resolve_include(source_, header);
        if (!found) return nullptr;
        if (!found->embedded) files.insert(found->name);
        texts[header] = found->text;
        names[header] = found->name;
        return keep(found->name, std::move(found->text));
    }
    void releaseInclude(IncludeResult* result) override {
        if (!result) return;
        delete static_cast<std::string*>(result->userData);
        delete result;
    }

    std::set<std::filesystem::path> files;
    std::map<std::string, std::string> texts, names;

  private:
    // glslang owns the result until it calls releaseInclude.
    static IncludeResult* keep(const std::string& name, std::string text) {
        auto owned = std::make_unique<std::string>(std::move(text));
        const char* data = owned->data();
        const size_t size = owned->size();
        return std::make_unique<IncludeResult>(name, data, size, owned.release()).release();
    }

    const ShaderSource& source_;
};

// "ERROR: file:12: 'x' : undeclared identifier" -> diagnostics with places.
void report_log(const std::string& log, const ShaderSource& source, Diagnostics& diagnostics) {
    static const std::regex pattern(R"(^ERROR: (.+?):(\d+): (.*)$)");
    std::istringstream lines(log);
    bool any = false;
    for (std::string line; std::getline(lines, line);) {
        std::smatch match;
        if (!std::regex_match(line, match, pattern)) continue;
        if (any && match[3].str().find("compilation terminated") != std::string::npos)
            continue;  // says nothing new
        const std::string file = match[1] == "0" ? source.file.string() : match[1].str();
        diagnostics.add({file, std::stoi(match[2]), 1}, "", match[3]);
        any = true;
    }
    if (!any) diagnostics.add({source.file.string()}, "", "glslang: " + log);
}

// To the preprocessor a specialisation constant is 0, without a word. Refused: #if with one of node.glsl's.
bool asks_constants(const std::string& text, const std::string& file, const std::string& node_glsl,
                    Diagnostics& diagnostics) {
    static const std::regex declared(R"(constant_id = \d+\) const \w+ (\w+))"),
        condition(R"(\s*#\s*(?:el)?if(?:n?def)?\b.*)"), word(R"([A-Za-z_]\w*)");
    std::set<std::string> constants;
    for (std::sregex_iterator i(node_glsl.begin(), node_glsl.end(), declared), end; i != end; ++i)
        constants.insert((*i)[1]);
    bool any = false;
    std::istringstream lines(text);
    std::string line;
    for (int number = 1; std::getline(lines, line); ++number) {
        line.erase(std::min(line.find("//"), line.size()));
        if (!std::regex_match(line, condition)) continue;
        for (std::sregex_iterator i(line.begin(), line.end(), word), end; i != end; ++i)
            if (constants.contains(i->str())) {
                diagnostics.add(
                    {file, number, static_cast<int>(i->position()) + 1}, "",
                    fmt::format("'{0}' is a constant, no macro: write if ({0}), without #", i->str()));
                any = true;
            }
    }
    return any;
}

std::optional<std::vector<uint32_t>> validate_and_optimise(std::vector<uint32_t> words,
                                                           const ShaderSource& source,
                                                           Diagnostics& diagnostics) {
    std::string messages;
    const auto collect = [&](spv_message_level_t level, const char*, const spv_position_t&,
                             const char* text) {
        if (level <= SPV_MSG_ERROR) messages += std::string(text) + "\n";
    };
    spvtools::Optimizer optimizer(SPV_ENV_VULKAN_1_2);
    optimizer.SetMessageConsumer(collect);
    optimizer.RegisterPerformancePasses();
    std::vector<uint32_t> optimised;
    spvtools::SpirvTools tools(SPV_ENV_VULKAN_1_2);
    tools.SetMessageConsumer(collect);
    if (!optimizer.Run(words.data(), words.size(), &optimised) || !tools.Validate(optimised)) {
        diagnostics.add({source.file.string()}, "", "SPIR-V is not valid: " + messages);
        return std::nullopt;
    }
    return optimised;
}

}  // namespace

std::optional<std::string> read_text(const std::filesystem::path& path) {
    std::error_code error;
    if (!std::filesystem::is_regular_file(path, error))
        return std::nullopt;  // a folder opens, and reads as empty
    std::ifstream file(path, std::ios::binary);
    if (!file) return std::nullopt;
    return std::string(std::istreambuf_iterator<char>(file), {});
}

std::optional<IncludedText> resolve_include(const ShaderSource& source, const std::string& name) {
    for (const auto& dir : source.include_dirs)
        if (auto text = read_text(dir / name))
            return IncludedText{(dir / name).string(), std::move(*text), false};
    const EmbeddedFile* file = find_embedded(source.embedded, name);
    return file ? std::optional(IncludedText{name, std::string(file->bytes), true}) : std::nullopt;
}

bool is_valid_spirv(std::span<const uint32_t> words) {
    spvtools::SpirvTools tools(SPV_ENV_VULKAN_1_2);
    tools.SetMessageConsumer([](spv_message_level_t, const char*, const spv_position_t&, const char*) {});
    return tools.Validate(words.data(), words.size());
}

std::string shader_compiler_version() {
    const glslang::Version glslang = glslang::GetVersion();
    // The last number counts changes of compile_shader: options, passes, preamble, what is refused.
    return fmt::format("glslang {}.{}.{}{}, {}, penumbra 2", glslang.major, glslang.minor, glslang.patch,
                       glslang.flavor, spvSoftwareVersionDetailsString());
}

std::optional<CompiledShader> compile_shader(const ShaderSource& source, Diagnostics& diagnostics) {
    static const GlslangProcess process;
    const auto text = source.text ? source.text : read_text(source.file);
    if (!text) {
        diagnostics.add({source.file.string()}, "", "cannot read the shader");
        return std::nullopt;
    }
    glslang::TShader shader(EShLangCompute);
    const std::string name = source.file.string();
    const char* strings[] = {text->c_str()};
    const int lengths[] = {static_cast<int>(text->size())};
    const char* names[] = {name.c_str()};
    shader.setStringsWithLengthsAndNames(strings, lengths, names, 1);
    shader.setPreamble("#extension GL_GOOGLE_include_directive : require\n");
    shader.setEnvInput(glslang::EShSourceGlsl, EShLangCompute, glslang::EShClientVulkan, 100);
    shader.setEnvClient(glslang::EShClientVulkan, glslang::EShTargetVulkan_1_2);
    shader.setEnvTarget(glslang::EShTargetSpv, glslang::EShTargetSpv_1_5);

    Includer includer(source);
    const auto rules = static_cast<EShMessages>(EShMsgSpvRules | EShMsgVulkanRules);
    if (!shader.parse(GetDefaultResources(), 460, ECoreProfile, true, false, rules, includer)) {
        report_log(shader.getInfoLog(), source, diagnostics);
        return std::nullopt;
    }
    bool asks = asks_constants(*text, name, source.node_glsl, diagnostics);
    for (const auto& [header, included] : includer.texts)
        asks |= asks_constants(included, includer.names.at(header), source.node_glsl, diagnostics);
    if (asks) return std::nullopt;
    glslang::TProgram program;
    program.addShader(&shader);
    if (!program.link(rules)) {
        report_log(program.getInfoLog(), source, diagnostics);
        return std::nullopt;
    }
    std::vector<uint32_t> words;
    glslang::GlslangToSpv(*program.getIntermediate(EShLangCompute), words);
    auto spirv = validate_and_optimise(std::move(words), source, diagnostics);
    if (!spirv) return std::nullopt;
    return CompiledShader{
        std::move(*spirv), {includer.files.begin(), includer.files.end()}, std::move(includer.texts)};
}

}  // namespace penumbra
