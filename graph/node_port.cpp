// SPDX-License-Identifier: MIT
// Ports of a node declaration. Each kind and direction has its own list of keys; a key of the vocabulary in
// the wrong place is told apart from an unknown one.
#include "graph/node_port.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "graph/interface.h"
#include "graph/json_reader.h"

namespace penumbra {

namespace {

constexpr uint32_t max_factor = 1u << 16;  // of div and mul: far beyond any image, and products fit 64 bits
constexpr size_t max_variants = 24;
constexpr size_t max_channels = 4;

const std::vector<std::string> kind_words = {"image", "texels", "buffer", "block"};
const std::vector<std::string> port_keys = {
    "kind",    "format", "as",       "filter",   "layers",   "levels", "element", "extent", "count", "writes",
    "updates", "first",  "previous", "indirect", "optional", "if",     "range",   "memo",   "doc"};
const std::vector<std::string> elements = {"u32", "uvec2", "uvec4", "f32", "vec4"};

std::vector<std::string> keys_of(PortKind kind, bool output, bool updates) {
    if (kind == PortKind::bundle) return {"kind", "doc"};
    std::vector<std::string> keys = {"kind", "optional", "if", "doc"};
    const auto add = [&](std::initializer_list<const char*> more) {
        keys.insert(keys.end(), more.begin(), more.end());
    };
    const bool texels = kind == PortKind::image || kind == PortKind::texels;
    if (kind == PortKind::block) add({"element"});
    if (kind == PortKind::block) return keys;
    if (!output) add({"previous"});
    if (output) add({"updates", "first", "range"});
    if (kind == PortKind::buffer) add({"indirect"});
    if (kind == PortKind::image) add({"as"});
    if (kind == PortKind::image && !output) add({"filter"});
    if (updates) return keys;  // the rest comes from the port that it updates
    if (output) add({"writes", "memo"});
    if (texels) add({"format"});
    if (texels && output) add({"extent"});
    if (kind == PortKind::image) add({"layers", "levels"});
    if (kind == PortKind::buffer) add({"element"});
    if (kind == PortKind::buffer && output) add({"count"});
    return keys;
}

bool is_struct_name(std::string_view name) {
    const auto upper = [](char c) { return c >= 'A' && c <= 'Z'; };
    const auto rest = [&](char c) { return upper(c) || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); };
    return !name.empty() && name.size() <= 64 && upper(name.front()) && std::ranges::all_of(name, rest);
}

void read_formats(const ObjectReader& reader, Port& port) {
    const Json* json = reader.require("format");
    if (!json) return;
    const std::string path = reader.path("format");
    Diagnostics& diagnostics = reader.diagnostics();
    const bool list = json->kind == Json::Kind::array;
    if (list && json->items.empty()) reader.error(*json, "format", "the list is empty");
    for (size_t i = 0; i < (list ? json->items.size() : 1); ++i) {
        const Json& item = list ? json->items[i] : *json;
        const std::string item_path = list ? fmt::format("{}[{}]", path, i) : path;
        const std::optional<Format> format = read_format(item, item_path, diagnostics);
        if (!format) continue;
        const FormatInfo& texel = info(*format);
        const bool linear_memory = port.kind == PortKind::texels;
        if (std::ranges::find(port.formats, *format) != port.formats.end())
            diagnostics.add(item.place, item_path, fmt::format("\"{}\" is listed twice", texel.name));
        else if (!texel.glsl && (port.storage || linear_memory))
            diagnostics.add(item.place, item_path,
                            fmt::format("{} cannot be {}: depth formats are only sampled", texel.name,
                                        linear_memory ? "a texel buffer" : "a storage image"));
        else if (!port.formats.empty() &&
                 (info(port.formats[0]).kind == FormatClass::uint) != (texel.kind == FormatClass::uint))
            diagnostics.add(item.place, item_path,
                            fmt::format("{} and {} have different types in GLSL (integer and real)",
                                        texel.name, info(port.formats[0]).name));
        else
            port.formats.push_back(*format);
    }
}

void read_access(const ObjectReader& reader, Port& port) {
    const std::vector<std::string> accesses = {"sampled", "storage"}, filters = {"nearest", "linear"};
    port.storage = port.output;
    if (const auto access = reader.choice("as", accesses)) {
        port.storage = *access == 1;
        if (port.output && !port.storage)
            reader.error(*reader.find("as"), "as", "outputs are written as storage");
    }
    if (const auto filter = reader.choice("filter", filters)) {
        port.linear = *filter == 1;
        if (port.storage) reader.error(*reader.find("filter"), "filter", "only sampled images are filtered");
    }
}

void read_element(const ObjectReader& reader, Port& port) {
    if (!reader.require("element")) return;
    const std::optional<std::string> element = reader.text("element");
    if (!element) return;
    port.element = *element;
    const bool plain = std::ranges::find(elements, *element) != elements.end();
    if (is_struct_name(*element) || (plain && port.kind == PortKind::buffer)) return;
    const std::string wanted = port.kind == PortKind::block
                                   ? "struct's name (like \"Sun\")"
                                   : fmt::format("struct's name and none of {}", join(elements));
    reader.error(*reader.find("element"), "element",
                 fmt::format("\"{}\" is no {}{}", *element, wanted,
                             port.kind == PortKind::block ? "" : did_you_mean(*element, elements)));
}

// [least, greatest] of one channel; null: open.
std::optional<std::array<double, 2>> read_range(const Json& json, const std::string& path,
                                                Diagnostics& diagnostics) {
    std::array<double, 2> range = {-std::numeric_limits<double>::infinity(),
                                   std::numeric_limits<double>::infinity()};
    bool good = json.kind == Json::Kind::array && json.items.size() == 2;
    for (size_t end = 0; good && end < 2; ++end) {
        const Json& item = json.items[end];
        good = item.is_number() || item.kind == Json::Kind::null;
        if (item.is_number()) range[end] = item.real;
    }
    if (!good)
        diagnostics.add(json.place, path,
                        "expected the least and the greatest value, null where there is none");
    else if (range[0] > range[1])
        diagnostics.add(json.place, path, "the least value exceeds the greatest");
    else
        return range;
    return std::nullopt;
}

// One range for every channel, or a list with one per channel.
void read_ranges(const ObjectReader& reader, Port& port) {
    const Json* json = reader.find("range");
    if (!json || !expect(*json, Json::Kind::array, reader.path("range"), reader.diagnostics())) return;
    if (json->items.empty() || json->items.front().kind != Json::Kind::array) {
        if (const auto range = read_range(*json, reader.path("range"), reader.diagnostics()))
            port.ranges.assign(max_channels, *range);
        return;
    }
    for (size_t i = 0; i < json->items.size(); ++i)
        if (const auto range = read_range(json->items[i], fmt::format("{}[{}]", reader.path("range"), i),
                                          reader.diagnostics()))
            port.ranges.push_back(*range);
    if (json->items.size() > max_channels)
        reader.error(*json, "range", fmt::format("no format has more than {} channels", max_channels));
}

// A port's name; "" means "none" to all that follows, so nobody may write it.
std::string read_name(const ObjectReader& reader, const char* key, const char* fallback) {
    const std::optional<std::string> name = reader.text(key);
    if (name && name->empty()) reader.error(*reader.find(key), key, "the name is empty");
    return name.value_or(fallback);
}

ExtentRule read_extent(const ObjectReader& reader) {
    ExtentRule rule;
    const Json* json = reader.find("extent");
    if (!json) return rule;
    if (json->kind == Json::Kind::string) {
        rule.of.name = json->string;
        if (rule.of.name.empty()) reader.error(*json, "extent", "the name is empty");
        return rule;
    }
    const std::vector<std::string> keys = {"of", "div", "mul"};
    const ObjectReader extent(*json, reader.path("extent"), keys, reader.diagnostics());
    if (extent.require("of")) rule.of.name = read_name(extent, "of", "frame");
    rule.div = extent.pair("div", 1, max_factor).value_or(rule.div);
    rule.mul = extent.pair("mul", 1, max_factor).value_or(rule.mul);
    return rule;
}

CountRule read_count(const ObjectReader& reader) {
    CountRule rule;
    constexpr uint32_t most = 1u << 28;
    const Json* json = reader.require("count");
    if (!json) return rule;
    if (json->kind == Json::Kind::integer) {
        rule.add = reader.whole("count", 1, most).value_or(1);
        return rule;
    }
    const std::vector<std::string> keys = {"of", "div", "mul", "add"};
    const ObjectReader count(*json, reader.path("count"), keys, reader.diagnostics());
    if (count.require("of")) rule.of.name = read_name(count, "of", "frame");
    rule.div = count.pair("div", 1, max_factor).value_or(rule.div);
    rule.mul = count.whole("mul", 1, max_factor).value_or(1);
    rule.add = count.whole("add", 0, most).value_or(0);
    return rule;
}

void read_port(const JsonMember& member, bool output, NodeType& type, Diagnostics& diagnostics) {
    const std::string path = fmt::format("{}.{}", output ? "outputs" : "inputs", member.key);
    const ObjectReader reader(member.value, path, port_keys, diagnostics);
    Port port{.name = member.key, .output = output, .place = member.key_place};
    const Json* kind_json = reader.require("kind");
    if (!kind_json) return;
    std::vector<std::string> words = kind_words;
    for (const Bundle& bundle : type.domain->bundles) words.push_back(bundle.kind);
    const std::optional<size_t> kind = reader.choice("kind", words);
    if (!kind) return;
    port.kind = static_cast<PortKind>(std::min(*kind, kind_words.size()));
    if (port.kind == PortKind::bundle) port.bundle = &type.domain->bundles[*kind - kind_words.size()];
    if (output && (port.kind == PortKind::block || port.kind == PortKind::bundle)) {
        reader.error(*kind_json, "kind",
                     fmt::format("a {} comes from the host; it cannot be an output", words[*kind]));
        return;
    }

    const bool updates = output && reader.find("updates");
    const std::vector<std::string> keys = keys_of(port.kind, output, updates);
    const auto applies = [&](std::string_view key) { return std::ranges::find(keys, key) != keys.end(); };
    for (const JsonMember& given : member.value.members) {
        const bool known = std::ranges::find(port_keys, given.key) != port_keys.end();
        if (!known || applies(given.key)) continue;
        const std::string owner =
            updates && given.key != "previous" && given.key != "filter"
                ? "a port that updates another (it is inherited)"
                : fmt::format("an {} of kind {}", output ? "output" : "input", words[*kind]);
        diagnostics.add(given.key_place, path,
                        fmt::format("key \"{}\" does not apply to {}", given.key, owner));
    }

    if (applies("as")) read_access(reader, port);
    if (applies("format")) read_formats(reader, port);
    if (port.linear && !port.formats.empty() && info(port.formats[0]).kind == FormatClass::uint)
        reader.error(*reader.find("filter"), "filter", "integer formats cannot be filtered");
    if (applies("element")) read_element(reader, port);
    if (applies("extent")) port.extent = read_extent(reader);
    if (applies("count")) port.count = read_count(reader);
    if (applies("layers")) port.layers = reader.flag("layers");
    if (applies("levels")) port.levels = reader.flag("levels");
    if (applies("indirect")) port.indirect = reader.flag("indirect");
    if (applies("previous")) port.previous = reader.flag("previous");
    if (port.levels && !output && port.storage)
        reader.error(*reader.find("levels"), "levels", "a mip chain is read through a sampler");
    port.optional = reader.flag("optional");
    if (applies("writes")) {
        const std::vector<std::string> extents = {"all", "tiles", "some", "kept"};
        port.writes = static_cast<Writes>(reader.choice("writes", extents).value_or(0));
    }
    if (applies("memo")) port.memo = reader.flag("memo");
    if (applies("first")) {
        const std::vector<std::string> firsts = {"any", "clear"};
        port.first = static_cast<First>(reader.choice("first", firsts).value_or(0));
    }
    if (applies("range")) read_ranges(reader, port);
    if (updates) port.updates = read_name(reader, "updates", "");
    if (const Json* condition = reader.find("if"))
        port.condition = read_condition(*condition, reader.path("if"), type, diagnostics);
    port.doc = reader.one_line("doc");
    type.ports.push_back(std::move(port));
}

std::vector<std::string> names_of(const NodeType& type, bool outputs_too) {
    std::vector<std::string> names;
    for (const Port& port : type.ports)
        if (!port.output || outputs_too) names.push_back(port.name);
    return names;
}

// Links ports; places of its errors are looked up in the declaration.
class Linker {
  public:
    Linker(const Json& declaration, NodeType& type, Diagnostics& diagnostics)
        : declaration_(declaration), type_(type), diagnostics_(diagnostics) {}

    void run() {
        for (Port& port : type_.ports)
            if (!port.updates.empty()) link_update(port);
        for (Port& port : type_.ports) {
            if (!port.output || !port.updates.empty()) continue;
            if (port.kind == PortKind::buffer)
                link_size(port, "count", port.count.of);
            else
                link_size(port, "extent", port.extent.of);
        }
        for (const Port& port : type_.ports)
            if (!port.ranges.empty()) check_ranges(port);
        check_variants();
    }

  private:
    void error(const Port& port, std::string_view key, std::string message) {
        const std::string section = port.output ? "outputs" : "inputs";
        const Json* value = declaration_.find(section)->find(port.name)->find(key);
        diagnostics_.add(value ? value->place : port.place, fmt::format("{}.{}.{}", section, port.name, key),
                         std::move(message));
    }

    void link_update(Port& port) {
        const Port* source = type_.port(port.updates);
        if (!source || source->output) {
            error(port, "updates",
                  fmt::format("no input \"{}\"{}", port.updates,
                              did_you_mean(port.updates, names_of(type_, false))));
            return;
        }
        if (source->kind != port.kind) {
            error(port, "updates", fmt::format("\"{}\" is of another kind", source->name));
            return;
        }
        if (source->previous)
            error(port, "updates", fmt::format("\"{}\" is a previous frame's value", source->name));
        if (source->optional) error(port, "updates", fmt::format("\"{}\" is optional", source->name));
        if (port.optional)
            error(port, "updates", "an update cannot be optional: its input is bound through it");
        if (source->condition != port.condition)
            error(port, "updates", fmt::format("\"{}\" has another condition (\"if\")", source->name));
        for (const Port& other : type_.ports)
            if (&other < &port && other.updates == port.updates)
                error(port, "updates",
                      fmt::format("\"{}\" already updates \"{}\"", other.name, source->name));
        for (const Format format : source->formats)
            if (!info(format).glsl)
                error(port, "updates",
                      fmt::format("\"{}\" accepts {}, which cannot be written", source->name,
                                  info(format).name));
        if (source->levels)
            error(port, "updates", fmt::format("\"{}\" is a mip chain, which is only sampled", source->name));
        port.formats = source->formats;
        port.element = source->element;
        port.layers = source->layers;
        port.levels = source->levels;
        port.updated_input = type_.index(*source);
        type_.ports[*port.updated_input].updater = type_.index(port);
    }

    // `of` names "frame" or an image or texels port that is there whenever this one is.
    void link_size(const Port& port, const char* key, SizeOf& size) {
        const std::string& of = size.name;
        if (of == "frame" || of.empty()) {
            if (port.layers)
                error(port, "layers", "the extent must be that of a port with layers, which tells how many");
            return;
        }
        const Port* source = type_.port(of);
        if (!source) {
            std::vector<std::string> names = names_of(type_, true);
            names.emplace_back("frame");
            error(port, key, fmt::format("no port \"{}\"{}", of, did_you_mean(of, names)));
            return;
        }
        if (source->kind != PortKind::image && source->kind != PortKind::texels) {
            error(port, key, fmt::format("\"{}\" is no image and has no extent", of));
            return;
        }
        if (source->optional) error(port, key, fmt::format("\"{}\" is optional and may have no extent", of));
        if (!implies(port.condition, source->condition))
            error(port, key, fmt::format("\"{}\" exists only where {}", of, to_string(source->condition)));
        if (port.layers && !source->layers)
            error(port, "layers", fmt::format("\"{}\", whose extent it takes, has no layers", of));
        if (sized_by_itself(port)) error(port, key, "the extent depends on itself");
        size.port = type_.index(*source);
    }

    // Whether `a` says all that `b` says: one term each, the atoms of b among those of a.
    static bool implies(const Condition& a, const Condition& b) {
        if (b.always()) return true;
        if (a.terms.size() != 1 || b.terms.size() != 1) return a == b;
        return std::ranges::all_of(b.terms[0], [&](const Atom& atom) {
            return std::ranges::find(a.terms[0], atom) != a.terms[0].end();
        });
    }

    // Integers are words more often than numbers: bits and packed values have no range.
    void check_ranges(const Port& port) {
        const bool numbers = port.kind == PortKind::buffer
                                 ? port.element == "f32" || port.element == "vec4"
                                 : port.formats.empty() || info(port.formats[0]).kind != FormatClass::uint;
        if (!numbers) error(port, "range", "only formats and elements that are no integers have a range");
    }

    bool sized_by_itself(const Port& port) const {
        const Port* at = &port;
        for (size_t steps = 0; steps <= type_.ports.size() && at && at->output; ++steps) {
            if (!at->updates.empty())
                at = type_.port(at->updates);
            else
                at = type_.port((at->kind == PortKind::buffer ? at->count.of : at->extent.of).name);
            if (at == &port) return true;
        }
        return false;
    }

    void check_variants() {
        for (const Port& port : type_.ports)
            if (const Param* choice = port.bundle ? type_.param(port.bundle->param) : nullptr)
                check_backends(*port.bundle, *choice);
        if (diagnostics_.size() != errors_) return;
        const size_t variants = all_variants(type_).size();
        if (variants > max_variants)
            diagnostics_.add(type_.place, "",
                             fmt::format("formats, optional outputs and backends make {} shader variants; at "
                                         "most {} are allowed",
                                         variants, max_variants));
    }

    // The backend is chosen with the device in hand, after ports and conditions.
    void check_backends(const Bundle& bundle, const Param& choice) {
        std::vector<std::string> known = {"auto"};
        for (const Bundle::Backend& backend : bundle.backends) known.push_back(backend.name);
        const auto is_known = [&](const std::string& v) {
            return std::ranges::find(known, v) != known.end();
        };
        const std::string path = "params." + choice.name;
        if (choice.type != ParamType::enumeration || !choice.constant ||
            !std::ranges::all_of(choice.values, is_known))
            diagnostics_.add(choice.place, path,
                             fmt::format("beside a {} port this is a constant enum with values of {}",
                                         bundle.kind, join(known)));
        else if (std::ranges::any_of(type_.ports,
                                     [&](const Port& port) { return asks_for(port.condition, choice.name); }))
            diagnostics_.add(choice.place, path, "it may vary with the device, so no port can exist by it");
    }

    const Json& declaration_;
    NodeType& type_;
    Diagnostics& diagnostics_;
    const size_t errors_ = diagnostics_.size();
};

}  // namespace

const char* kind_name(PortKind kind) {
    if (kind == PortKind::bundle) return "bundle";
    if (kind == PortKind::structure) return "acceleration structure";
    return kind_words[static_cast<size_t>(kind)].c_str();
}

Condition read_condition(const Json& json, const std::string& path, const NodeType& type,
                         Diagnostics& diagnostics) {
    const auto condition = parse_condition(json, *type.domain, false, path, diagnostics);
    if (!condition) return {};
    // Whether it can be asked does not depend on the values: the defaults stand for them.
    const auto find = [&](const Atom& atom) -> KnownParam {
        if (const Param* param = type.param(atom.name))
            return {.param = param, .value = &param->default_value};
        std::vector<std::string> names = type.domain->fact_list();
        for (const Param& p : type.params) names.push_back(p.name);
        return {.problem = fmt::format("no fact or parameter \"{}\" (facts: {}){}", atom.name,
                                       join(type.domain->fact_list()), did_you_mean(atom.name, names))};
    };
    return settle(*condition, find, path, diagnostics) ? *condition : Condition{};
}

bool asks_for(const Condition& condition, const std::string& param) {
    return std::ranges::any_of(condition.terms, [&](const std::vector<Atom>& term) {
        return std::ranges::any_of(term, [&](const Atom& atom) { return !atom.fact && atom.name == param; });
    });
}

void parse_ports(const Json& section, bool output, NodeType& type, Diagnostics& diagnostics) {
    if (!expect(section, Json::Kind::object, output ? "outputs" : "inputs", diagnostics)) return;
    for (const JsonMember& member : section.members) read_port(member, output, type, diagnostics);
}

void link_ports(const Json& declaration, NodeType& type, Diagnostics& diagnostics) {
    Linker(declaration, type, diagnostics).run();
}

}  // namespace penumbra
