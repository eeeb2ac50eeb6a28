// SPDX-License-Identifier: MIT
// SPIR-V 1.5 rather than 1.6: at 1.6 glslang emits LocalSizeId, which needs maintenance4 to be enabled by the
// host.
#include "graph/shader_compiler.h"

#include <fmt/format.h>
#include <glslang/Public/ResourceLimits.h>
#include <glslang/Public/ShaderLang.h>
#include <glslang/SPIRV/GlslangToSpv.h>

#include <algorithm>
#include <charconv>
#include <set>
#include <spirv-tools/libspirv.hpp>
#include <spirv-tools/optimizer.hpp>
#include <sstream>
#include <unordered_map>

#include "graph/read_text.h"

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

    // `depth`: 1 in the shader itself.
    IncludeResult* includeLocal(const char* header, const char*, size_t depth) override {
        open_.resize(depth - 1);
        if (!cycle.empty() || closes_cycle(header)) return nullptr;
        open_.emplace_back(header);
        if (open_.back() == "node.glsl") {
            has_interface = true;
            return keep("node.glsl", source_.node_glsl);
        }
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
    bool has_interface = false;  // whether node.glsl was included
    std::string cycle;           // "a.glsl -> b.glsl -> a.glsl", where that is why an #include failed

  private:
    // That a file is open already is no error: its guard, or a macro that counts, may end it, which only the
    // preprocessor knows. What is open this often is not going to end.
    bool closes_cycle(const std::string& header) {
        constexpr ptrdiff_t most_open = 64;
        if (std::ranges::count(open_, header) < most_open) return false;
        for (auto at = std::find(open_.rbegin(), open_.rend(), header).base() - 1; at != open_.end(); ++at)
            cycle += *at + " -> ";
        cycle += header;
        return true;
    }

    // glslang owns the result until it calls releaseInclude.
    static IncludeResult* keep(const std::string& name, std::string text) {
        auto owned = std::make_unique<std::string>(std::move(text));
        const char* data = owned->data();
        const size_t size = owned->size();
        return std::make_unique<IncludeResult>(name, data, size, owned.release()).release();
    }

    const ShaderSource& source_;
    std::vector<std::string> open_;  // one in the other, as #include spells them
};

// A line may be of any length, and std::regex takes its stack by the character: lines are taken apart by
// hand.

// Of "file:12: text" where the file's name ends, the line's number and where the text begins.
struct PlaceInText {
    size_t colon = 0, end = 0;
    int number = 0;
};
std::optional<PlaceInText> place_of(const std::string& line) {
    for (size_t colon = line.find(':'); colon != std::string::npos; colon = line.find(':', colon + 1)) {
        PlaceInText place{colon};
        const char* begin = line.data() + colon + 1;
        const auto [end, error] = std::from_chars(begin, line.data() + line.size(), place.number);
        place.end = static_cast<size_t>(end - line.data()) + 2;
        if (error == std::errc() && line.compare(place.end - 2, 2, ": ") == 0) return place;
    }
    return std::nullopt;
}

// "ERROR: file:12: 'x' : undeclared identifier" -> diagnostics with places. Of a cycle, where there is one,
// glslang says that it could not include a file, and that again of every file which is open.
void report_log(const std::string& log, const ShaderSource& source, const std::string& cycle,
                Diagnostics& diagnostics) {
    constexpr std::string_view error = "ERROR: ";
    std::istringstream lines(log);
    bool any = false;
    for (std::string line; std::getline(lines, line);) {
        const auto place = line.starts_with(error) ? place_of(line) : std::nullopt;
        if (!place) continue;
        const std::string message = line.substr(place->end);
        if (any && message.find("compilation terminated") != std::string::npos) continue;  // says nothing new
        const std::string file = line.substr(error.size(), place->colon - error.size());
        const bool in_cycle = !cycle.empty() && message.starts_with("'#include'");
        diagnostics.add({file == "0" ? source.file.string() : file, place->number, 1}, "",
                        in_cycle ? "include cycle " + cycle : message);
        if (in_cycle) return;
        any = true;
    }
    if (!any) diagnostics.add({source.file.string()}, "", "glslang: " + log);
}

// glslang would call it an unexpected token; of JSON, json_text.cpp says the same.
bool begins_with_mark(const std::string& text, const std::string& file, Diagnostics& diagnostics) {
    if (!text.starts_with("\xef\xbb\xbf")) return false;
    diagnostics.add({file, 1, 1}, "", "the file begins with a byte order mark; save it as plain UTF-8");
    return true;
}

// Identifiers and keywords; of numbers nothing.
std::vector<std::string_view> words_of(std::string_view text) {
    const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
    const auto in_word = [&](char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' || is_digit(c);
    };
    std::vector<std::string_view> words;
    for (auto at = std::ranges::find_if(text, in_word); at != text.end();
         at = std::find_if(at, text.end(), in_word)) {
        const auto end = std::find_if_not(at, text.end(), in_word);
        if (!is_digit(*at)) words.emplace_back(at, end);
        at = end;
    }
    return words;
}

// Whether a line is #if, #ifdef, #ifndef or #elif.
bool is_condition(std::string_view line) {
    constexpr std::string_view blanks = " \t\r\v\f";
    const auto skip_blanks = [&] {
        line.remove_prefix(std::min(line.find_first_not_of(blanks), line.size()));
    };
    skip_blanks();
    if (!line.starts_with('#')) return false;
    line.remove_prefix(1);
    skip_blanks();
    const auto is_letter = [](char c) { return c >= 'a' && c <= 'z'; };
    const std::string_view word(line.begin(), std::ranges::find_if_not(line, is_letter));
    return word == "if" || word == "ifdef" || word == "ifndef" || word == "elif";
}

// To the preprocessor a specialisation constant is 0, without a word. Refused: #if with one of node.glsl's.
bool asks_constants(const std::string& text, const std::string& file, const std::string& node_glsl,
                    Diagnostics& diagnostics) {
    std::set<std::string_view> constants;
    const std::vector<std::string_view> declared = words_of(node_glsl);
    for (size_t i = 0; i + 3 < declared.size(); ++i)  // constant_id = 7) const uint NAME
        if (declared[i] == "constant_id" && declared[i + 1] == "const") constants.insert(declared[i + 3]);
    bool any = false;
    std::istringstream lines(text);
    std::string line;
    for (int number = 1; std::getline(lines, line); ++number) {
        line.erase(std::min(line.find("//"), line.size()));
        if (!is_condition(line)) continue;
        for (const std::string_view word : words_of(line))
            if (constants.contains(word)) {
                diagnostics.add(
                    {file, number, static_cast<int>(word.data() - line.data()) + 1}, "",
                    fmt::format("'{0}' is a constant, no macro: write if ({0}), without #", word));
                any = true;
            }
    }
    return any;
}

// A descriptor, or the push constants.
struct Resource {
    std::string name;  // the block's, where a block has none of its own
    uint32_t set = 0, binding = 0;
    bool push = false;
};

// Those that a module has: the optimiser has left what is used. Names and decorations come before the types,
// and these before what is of them. Numbers are those of the SPIR-V specification.
std::vector<Resource> resources_of(std::span<const uint32_t> spirv) {
    constexpr uint32_t op_name = 5, op_type_pointer = 32, op_function = 54, op_variable = 59,
                       op_decorate = 71, decoration_binding = 33, decoration_set = 34, uniform_constant = 0,
                       uniform = 2, push_constant = 9, storage_buffer = 12;
    std::unordered_map<uint32_t, std::string> names;
    std::unordered_map<uint32_t, uint32_t> sets, bindings, points_to;
    std::vector<Resource> resources;
    for (size_t at = 5; at < spirv.size() && (spirv[at] & 0xffff) != op_function;
         at += std::max(spirv[at] >> 16, 1u)) {
        const uint32_t* i = &spirv[at];
        switch (*i & 0xffff) {
            case op_name:
                names[i[1]] = reinterpret_cast<const char*>(i + 2);
                break;
            case op_decorate:
                if (i[2] == decoration_binding) bindings[i[1]] = i[3];
                if (i[2] == decoration_set) sets[i[1]] = i[3];
                break;
            case op_type_pointer:
                points_to[i[1]] = i[3];
                break;
            case op_variable:
                if (i[3] != uniform_constant && i[3] != uniform && i[3] != push_constant &&
                    i[3] != storage_buffer)
                    break;
                const std::string& own = names[i[2]];
                resources.push_back({own.empty() ? names[points_to[i[1]]] : own, sets[i[2]], bindings[i[2]],
                                     i[3] == push_constant});
                break;
        }
    }
    return resources;
}

// Whether node.glsl has it, in the words of generate_glsl(). Names tell it from another one at the same
// binding, which may be of another kind; of push constants glslang refuses a second block.
bool declares(const std::string& node_glsl, const Resource& resource) {
    if (resource.push) return node_glsl.find("layout(push_constant") != std::string::npos;
    const std::string layout = fmt::format("layout(set = {}, binding = {}", resource.set, resource.binding);
    std::istringstream lines(node_glsl);
    for (std::string line; std::getline(lines, line);) {
        if (!line.starts_with(layout + ",") && !line.starts_with(layout + ")")) continue;
        line.erase(std::min(line.find_first_of("{;"), line.size()));
        if (words_of(line).back() == resource.name) return true;
    }
    return false;
}

struct SourceText {
    std::string file;
    const std::string* text = nullptr;
};

// The first line that has a name behind a layout, else the first that has it at all: the layout may be a
// macro's, or stand on a line of its own.
Place place_of_name(std::span<const SourceText> texts, std::string_view name) {
    Place found{texts.front().file};
    for (const auto& [file, text] : texts) {
        std::istringstream lines(*text);
        std::string line;
        for (int number = 1; std::getline(lines, line); ++number) {
            line.erase(std::min(line.find("//"), line.size()));
            const auto words = words_of(line);
            const auto word = std::ranges::find(words, name);
            if (word == words.end()) continue;
            const bool behind_layout = std::find(words.begin(), word, "layout") != word;
            if (!behind_layout && found.line) continue;
            found = {file, number, static_cast<int>(word->data() - line.data()) + 1};
            if (behind_layout) return found;
        }
    }
    return found;
}

// To a driver a descriptor that no layout has is undefined: it may well crash. A plan has what the
// declaration has, and so has node.glsl.
bool has_undeclared(std::span<const uint32_t> spirv, const std::string& node_glsl,
                    std::span<const SourceText> texts, Diagnostics& diagnostics) {
    bool any = false;
    for (const Resource& r : resources_of(spirv)) {
        if (declares(node_glsl, r)) continue;
        const std::string what =
            r.push
                ? "(push constants) is not declared: these come from the parameters of"
                : fmt::format("(set {}, binding {}) is not declared: bindings come from", r.set, r.binding);
        diagnostics.add(place_of_name(texts, r.name), "",
                        fmt::format("'{}' {} the node's declaration, through node.glsl", r.name, what));
        any = true;
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
    return fmt::format("glslang {}.{}.{}{}, {}, penumbra {}", glslang.major, glslang.minor, glslang.patch,
                       glslang.flavor, spvSoftwareVersionDetailsString(), PENUMBRA_SHADER_COMPILER);
}

std::optional<CompiledShader> compile_shader(const ShaderSource& source, Diagnostics& diagnostics) {
    static const GlslangProcess process;
    const auto text = source.text ? source.text : read_text(source.file);
    if (!text) {
        diagnostics.add({source.file.string()}, "", "cannot read the shader");
        return std::nullopt;
    }
    const std::string name = source.file.string();
    if (begins_with_mark(*text, name, diagnostics)) return std::nullopt;
    glslang::TShader shader(EShLangCompute);
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
    const bool parsed = shader.parse(GetDefaultResources(), 460, ECoreProfile, true, false, rules, includer);
    std::vector<SourceText> texts{{name, &*text}};
    for (const auto& [header, included] : includer.texts)
        texts.push_back({includer.names.at(header), &included});
    if (!parsed) {
        bool marked = false;
        for (const auto& [file, written] : texts) marked |= begins_with_mark(*written, file, diagnostics);
        if (!marked) report_log(shader.getInfoLog(), source, includer.cycle, diagnostics);
        return std::nullopt;
    }
    bool asks = false;
    for (const auto& [file, written] : texts)
        asks |= asks_constants(*written, file, source.node_glsl, diagnostics);
    if (asks) return std::nullopt;
    glslang::TProgram program;
    program.addShader(&shader);
    if (!program.link(rules)) {
        report_log(program.getInfoLog(), source, "", diagnostics);
        return std::nullopt;
    }
    std::vector<uint32_t> words;
    glslang::GlslangToSpv(*program.getIntermediate(EShLangCompute), words);
    auto spirv = validate_and_optimise(std::move(words), source, diagnostics);
    const std::string interface = includer.has_interface ? source.node_glsl : "";
    if (!spirv || has_undeclared(*spirv, interface, texts, diagnostics)) return std::nullopt;
    return CompiledShader{
        std::move(*spirv), {includer.files.begin(), includer.files.end()}, std::move(includer.texts)};
}

}  // namespace penumbra
