// SPDX-License-Identifier: MIT
// Ports of a node declaration. Each kind and direction has keys of its own.
#include "graph/node_port.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/interface.h"
#include "graph/json_reader.h"

namespace penumbra {

namespace {

constexpr ptrdiff_t max_variants = 16;  // besides those with rows
constexpr size_t max_compared = 1000;

void read_formats(const ObjectReader& reader, Port& port) {
    const auto integer = [](Format format) { return info(format).kind == FormatClass::uint; };
    port.formats = reader.formats("format");
    for (const Format format : port.formats)
        if (!info(format).glsl && port.storage)
            reader.error("format", fmt::format("{} cannot be a storage image: depth formats are only sampled",
                                               info(format).name));
        else if (integer(format) != integer(port.formats.front()))
            reader.error("format", fmt::format("{} and {} have different types in GLSL (integer and real)",
                                               info(format).name, info(port.formats.front()).name));
}

void read_access(const ObjectReader& reader, Port& port) {
    const auto access = reader.word("as");
    port.storage = port.kind == PortKind::image && (port.output || access == 1);
    port.linear = reader.word("filter") == 1;
    if (port.storage && reader.find("filter")) reader.error("filter", "only sampled images are filtered");
    if (port.storage && !port.output && port.levels)
        reader.error("levels", "a mip chain is read through a sampler");
}

// One range for every channel, or a list with one per channel.
void read_ranges(const ObjectReader& reader, Port& port, Diagnostics& diagnostics) {
    const Json* json = reader.find("range");
    if (!json || !expect(*json, Json::Kind::array, reader.path("range"), diagnostics)) return;
    if (json->items.empty() || json->items.front().kind != Json::Kind::array) {
        if (const auto range = read_range(*json, true, reader.path("range"), diagnostics))
            port.ranges.assign(max_channels, *range);
        return;
    }
    for (size_t i = 0; i < json->items.size(); ++i)
        if (const auto range =
                read_range(json->items[i], true, fmt::format("{}[{}]", reader.path("range"), i), diagnostics))
            port.ranges.push_back(*range);
    if (json->items.size() > max_channels)
        reader.error("range", fmt::format("no format has more than {} channels", max_channels));
}

ExtentRule read_extent(const ObjectReader& reader, Diagnostics& diagnostics) {
    ExtentRule rule;
    const Json* json = reader.find("extent");
    if (!json || json->kind != Json::Kind::object) {
        rule.of.name = reader.text("extent", "frame");
        return rule;
    }
    const ObjectReader extent(*json, reader.path("extent"), vocabulary::extent, diagnostics);
    rule.of.name = extent.text("of", "frame");
    rule.div = extent.pair("div", rule.div);
    rule.mul = extent.pair("mul", rule.mul);
    return rule;
}

CountRule read_count(const ObjectReader& reader, Diagnostics& diagnostics) {
    CountRule rule;
    const Json* json = reader.find("count");
    if (!json || json->kind != Json::Kind::object) {
        rule.add = reader.whole("count", rule.add);
        return rule;
    }
    const ObjectReader count(*json, reader.path("count"), vocabulary::count, diagnostics);
    rule.of.name = count.text("of", "frame");
    rule.div = count.pair("div", rule.div);
    rule.mul = count.whole("mul", rule.mul);
    rule.add = count.whole("add", rule.add);
    return rule;
}

void read_port(const JsonMember& member, bool output, NodeType& type, Diagnostics& diagnostics) {
    const std::vector<std::string> words = kind_words(*type.domain);
    const Json* given = member.value.find("kind");
    const size_t kind =
        given ? static_cast<size_t>(std::ranges::find(words, given->string) - words.begin()) : words.size();
    Port port{.name = member.key, .output = output, .place = member.key_place};
    port.kind = static_cast<PortKind>(std::min(kind, static_cast<size_t>(PortKind::bundle)));
    // Which keys apply depends on the kind. Where that is wrong, it alone is worth a word.
    Scope scope{
        .kinds = bit(port.kind), .output = output, .updating = output && member.value.find("updates")};
    const bool from_host = !vocabulary::port.find("kind", scope);
    if (kind == words.size() || from_host)
        scope.kinds = unknown_kind;
    else
        scope.owner = fmt::format("an {} of kind {}{}", output ? "output" : "input", words[kind],
                                  scope.updating ? " that updates an input" : "");
    const std::string path = fmt::format("{}.{}", output ? "outputs" : "inputs", member.key);
    const ObjectReader reader(member.value, path, vocabulary::port, diagnostics, scope);
    if (!reader.word("kind", words)) return;
    if (from_host) {
        reader.error("kind", fmt::format("a {} comes from the host; it cannot be an output", words[kind]));
        return;
    }
    if (port.kind == PortKind::bundle)
        port.bundle = &type.domain->bundles[kind - static_cast<size_t>(PortKind::bundle)];
    port.layers = reader.flag("layers");
    port.layers_of.name = reader.text("layers_of");
    port.levels = reader.flag("levels");
    port.in_rows = reader.flag("in_rows");
    read_access(reader, port);
    read_formats(reader, port);
    if (port.in_rows && (port.layers || port.levels))
        reader.error("in_rows", "arrays and mip chains are not laid out in rows");
    else if (port.in_rows && std::ranges::none_of(port.formats, has_rows))
        reader.error("in_rows", "none of its formats has texels that make whole words");
    if (port.linear && !port.formats.empty() && info(port.formats[0]).kind == FormatClass::uint)
        reader.error("filter", "integer formats cannot be filtered");
    port.element = reader.text("element");
    port.extent = read_extent(reader, diagnostics);
    port.count = read_count(reader, diagnostics);
    port.indirect = reader.flag("indirect");
    port.row = reader.whole("row", 0);
    port.previous = reader.flag("previous");
    port.optional = reader.flag("optional");
    port.writes = static_cast<Writes>(reader.word("writes").value_or(0));
    port.memo = reader.flag("memo");
    port.settles = reader.whole("settles", 0);
    port.first = static_cast<First>(reader.word("first").value_or(0));
    read_ranges(reader, port, diagnostics);
    reader.list("with");  // linked once all ports are known
    port.updates = reader.text("updates");
    if (const Json* condition = reader.find("if"))
        port.condition = read_condition(*condition, reader.path("if"), type, diagnostics);
    port.doc = reader.text("doc");
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
            if (!port.layers_of.name.empty()) link_layers(port);
        }
        for (Port& port : type_.ports)
            if (!port.output) link_with(port);
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
        else if (source->kind == PortKind::image && !source->storage && !type_.host)
            error(
                port, "updates",
                fmt::format("\"{}\" is only sampled; what is written is \"as\": \"storage\"", source->name));
        port.formats = source->formats;
        port.element = source->element;
        port.layers = source->layers;
        port.levels = source->levels;
        port.updated_input = type_.index(*source);
        type_.ports[*port.updated_input].updater = type_.index(port);
    }

    void link_layers(Port& port) {
        const Port* source = type_.port(port.layers_of.name);
        if (source && source->kind != PortKind::texels)
            error(port, "layers_of",
                  fmt::format("\"{}\" is no texels, whose rows could be counted", source->name));
        else
            link_size(port, "layers_of", port.layers_of);
    }

    void link_with(Port& port) {
        const Json* names = declaration_.find("inputs")->find(port.name)->find("with");
        if (!names || names->kind != Json::Kind::array) return;
        for (size_t i = 0; i < names->items.size(); ++i) {
            const Json& name = names->items[i];
            const Port* other = type_.port(name.string);
            const std::string path = fmt::format("inputs.{}.with[{}]", port.name, i);
            if (!other || other->output)
                diagnostics_.add(name.place, path,
                                 fmt::format("no input \"{}\"{}", name.string,
                                             did_you_mean(name.string, names_of(type_, false))));
            else if (!other->optional || other == &port)
                diagnostics_.add(name.place, path, "an optional input other than this one is meant");
            else
                port.with.push_back(type_.index(*other));
        }
    }

    // `of` names "frame" or an image or texels port that is there whenever this one is.
    void link_size(const Port& port, const char* key, SizeOf& size) {
        const std::string& of = size.name;
        const bool layers = port.layers && port.layers_of.name.empty();  // which `of` tells
        if (of == "frame" || of.empty()) {
            if (layers)
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
        if (layers && !source->layers)
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
        if (diagnostics_.size() != errors_ || type_.host) return;
        if (compared_values(type_) > max_compared)
            return diagnostics_.add(
                type_.place, "",
                fmt::format("the conditions of outputs tell more than {} sets of values apart",
                            max_compared));
        constexpr ptrdiff_t most_made = max_variants_made;
        const auto variants = std::ranges::count(all_variants(type_), false, &Variant::rows);
        if (variants > max_variants)
            diagnostics_.add(type_.place, "",
                             fmt::format("formats, optional outputs and backends make {}{} shader variants; "
                                         "at most {} are allowed",
                                         variants > most_made ? "more than " : "",
                                         std::min(variants, most_made), max_variants));
    }

    // The backend is chosen with the device in hand, after ports and conditions.
    void check_backends(const Bundle& bundle, const Param& choice) {
        std::vector<std::string> known = {"auto"};
        for (const Bundle::Backend& backend : bundle.backends) known.push_back(backend.name);
        const auto is_known = [&](const std::string& v) {
            return std::ranges::find(known, v) != known.end();
        };
        const std::string path = "params." + choice.name;
        const auto decides = [&](const auto& port_or_table) {
            return asks_for(port_or_table.condition, choice.name);
        };
        if (choice.type != ParamType::enumeration || !choice.constant ||
            !std::ranges::all_of(choice.values, is_known))
            diagnostics_.add(choice.place, path,
                             fmt::format("beside a {} port this is a constant enum with values of {}",
                                         bundle.kind, join(known)));
        else if (std::ranges::any_of(type_.ports, decides))
            diagnostics_.add(choice.place, path, "it may vary with the device, so no port can exist by it");
        else if (std::ranges::any_of(type_.tables, decides))
            diagnostics_.add(choice.place, path, "it may vary with the device, so no table can exist by it");
    }

    const Json& declaration_;
    NodeType& type_;
    Diagnostics& diagnostics_;
    const size_t errors_ = diagnostics_.size();
};

}  // namespace

Condition read_condition(const Json& json, const std::string& path, const NodeType& type,
                         Diagnostics& diagnostics) {
    const auto condition = parse_condition(json, *type.domain, false, path, diagnostics);
    if (!condition) return {};
    // Whether it can be asked does not depend on the values: the defaults stand for them.
    const auto find = [&](const Atom& atom) -> KnownParam {
        if (const Param* param = type.param(atom.name))
            return {.param = param, .value = &param->default_value};
        std::vector<std::string> names = type.domain->fact_list();
        if (std::ranges::find(names, atom.name) != names.end())
            return {.problem = fmt::format("\"{}\" is a fact, which is compared with nothing: {} or !{}",
                                           atom.name, atom.name, atom.name)};
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
