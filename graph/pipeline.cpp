// SPDX-License-Identifier: MIT
// Pipelines from JSON: `extends` is resolved first (RFC 7396, merge patch), settings follow in order, and
// what comes out is read once against the closed vocabulary. Every value still knows which file and line it
// came from.
#include "penumbra/pipeline.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "graph/json_reader.h"
#include "graph/suggestions.h"

namespace penumbra {

namespace {

namespace fs = std::filesystem;

// Two spellings of one file must count as one, or a cycle would go unseen.
std::string identity(const fs::path& path, const ReadFile& read) {
    std::error_code error;
    const fs::path canonical = read ? fs::path() : fs::weakly_canonical(path, error);
    return (read || error ? path.lexically_normal() : canonical).generic_string();
}

std::optional<Json> read_base(const fs::path& path, const ReadFile& read, const Json& extends,
                              Diagnostics& diagnostics) {
    std::error_code error;
    const std::string file = path.generic_string();
    const std::optional<std::string> text = read ? read(file) : std::nullopt;
    if (read ? !text : !fs::exists(path, error)) {
        diagnostics.add(extends.place, "extends", fmt::format("no file {}", file));
        return std::nullopt;
    }
    return read ? parse_json(*text, file, diagnostics) : read_json(path, diagnostics);
}

struct ChainLink {
    std::string file, identity;
};

// Nodes of the base that a patch gives a type: what they had is to be removed, not unbound.
std::set<std::string> retyped_nodes(const Json& base, const Json& patch) {
    std::set<std::string> ids;
    const Json *nodes = patch.find("nodes"), *before = base.find("nodes");
    for (size_t i = 0; nodes && before && i < nodes->members.size(); ++i)
        if (before->find(nodes->members[i].key) && nodes->members[i].value.find("type"))
            ids.insert(nodes->members[i].key);
    return ids;
}

// A merge patch takes away what it says null of. Of a port null is a value, unbound, and stays.
void unbind(Json& merged, const Json& patch, const std::set<std::string>& retyped) {
    const Json *nodes = patch.find("nodes"), *to = merged.find("nodes");
    for (size_t i = 0; nodes && to && i < nodes->members.size(); ++i) {
        const JsonMember& node = nodes->members[i];
        if (!to->find(node.key) || retyped.contains(node.key)) continue;
        for (const char* ports : {"in", "out"})
            if (const Json* wires = node.value.find(ports))
                for (const JsonMember& wire : wires->members)
                    if (wire.value.kind == Json::Kind::null)
                        set_path(merged, fmt::format("nodes.{}.{}.{}", node.key, ports, wire.key), "null",
                                 wire.key_place);
    }
}

// Replaces `json` by what it extends, patched with it. `chain` holds the files from the first to this one.
bool resolve_extends(Json& json, std::vector<ChainLink>& chain, const ReadFile& read,
                     Diagnostics& diagnostics) {
    const Json* extends = json.find("extends");
    if (!extends) return true;
    if (!expect(*extends, Json::Kind::string, "extends", diagnostics)) return false;
    if (extends->string.empty() || extends->string.find('\0') != std::string::npos) {
        diagnostics.add(extends->place, "extends", "expected a file name");
        return false;
    }
    const fs::path base_path =
        (fs::path(chain.back().file).parent_path() / extends->string).lexically_normal();
    const std::string base_identity = identity(base_path, read);
    const auto repeated = std::ranges::find(chain, base_identity, &ChainLink::identity);
    if (repeated != chain.end()) {
        std::string names;
        for (auto link = repeated; link != chain.end(); ++link) names += link->file + " -> ";
        diagnostics.add(extends->place, "extends",
                        "files extend each other in a cycle: " + names + repeated->file);
        return false;
    }
    std::optional<Json> base = read_base(base_path, read, *extends, diagnostics);
    if (!base || !expect(*base, Json::Kind::object, "", diagnostics)) return false;
    chain.push_back({base_path.generic_string(), base_identity});
    if (!resolve_extends(*base, chain, read, diagnostics)) return false;
    std::erase_if(json.members, [](const JsonMember& member) { return member.key == "extends"; });
    const Place place = json.place;
    const Json patch = json;
    const std::set<std::string> retyped = retyped_nodes(*base, patch);
    merge_patch(*base, json);
    unbind(*base, patch, retyped);
    base->place = place;  // what is missing altogether is missing from the file that was asked for
    json = std::move(*base);
    return true;
}

// What begins so and is no JSON is a slip, not a name that was left without quotes.
bool begins_as_json(std::string_view value) {
    return !value.empty() && std::string_view("+-.0123456789[{\"").find(value[0]) != std::string_view::npos;
}

void apply_setting(Json& json, const std::string& setting, Diagnostics& diagnostics) {
    const Place place{"--set " + setting};
    const size_t equals = setting.find('=');
    if (equals == std::string::npos) {
        diagnostics.add(place, "", "expected PATH=VALUE, as in nodes.filter0.params.step=2");
        return;
    }
    const std::string path = setting.substr(0, equals), value = setting.substr(equals + 1);
    const auto segments = std::ranges::count(path, '.') + 1;
    const bool gap =
        path.empty() || path.starts_with('.') || path.ends_with('.') || path.find("..") != std::string::npos;
    constexpr int deepest = 16;  // nothing in a pipeline lies deeper
    Diagnostics unsaid;
    if (gap || segments > deepest)
        diagnostics.add(place, "", fmt::format("\"{}\" is no path of keys joined by dots", path));
    else if (path == "extends" || path == "penumbra")
        diagnostics.add(place, path, "cannot be set: it says how the file is read");
    else if (begins_as_json(value) && !parse_json(value, place.file, unsaid))
        diagnostics.add(
            place, path,
            fmt::format("\"{}\" is no JSON: numbers have a digit before the point, lists and texts "
                        "an end, and a text that begins as they do needs quotes",
                        value));
    else
        set_path(json, path, value, place);
}

// Reads a Pipeline from the merged JSON. Errors do not stop it.
class PipelineReader {
  public:
    PipelineReader(const Json& json, Diagnostics& diagnostics)
        : reader_(json, "", vocabulary::pipeline, diagnostics), diagnostics_(diagnostics) {}

    Pipeline read(const std::string& file) {
        pipeline_.file = file;
        read_version();
        pipeline_.name = reader_.text("name");
        pipeline_.doc = reader_.text("doc");
        reader_.text("$schema");
        each("inputs", [&](const JsonMember& member) { read_input(member); });
        each("nodes", [&](const JsonMember& member) { read_node(member); });
        each("instances", [&](const JsonMember& member) { read_instance(member); });
        each("resources", [&](const JsonMember& member) { read_resource(member); });
        for (const ObjectReader::Item& item : reader_.list("outputs"))
            pipeline_.outputs.push_back({item.text, item.place});
        return std::move(pipeline_);
    }

  private:
    void error(const Place& place, std::string path, std::string message) {
        diagnostics_.add(place, std::move(path), std::move(message));
    }

    void read_version() {
        const Json* version = reader_.find("penumbra");
        if (version && (version->kind != Json::Kind::integer || version->integer != 1))
            reader_.error("penumbra", "expected 1, the version of the format that this program reads");
    }

    // Calls `read` for each member of an object. A null member is none: null removes, as in a merge patch.
    template <typename Read>
    void each(const char* key, Read read) {
        const Json* json = reader_.find(key);
        if (!json || !expect(*json, Json::Kind::object, key, diagnostics_)) return;
        size_t found = 0;
        for (const JsonMember& member : json->members) {
            if (member.value.kind == Json::Kind::null) continue;
            ++found;
            if (expect_id(member.key, member.key_place, key, diagnostics_)) read(member);
        }
        if (found < vocabulary::pipeline.at(key).min_items)
            reader_.error(key, "a pipeline needs at least one");
    }

    void read_input(const JsonMember& member) {
        const ObjectReader reader(member.value, "inputs." + member.key, vocabulary::input, diagnostics_);
        HostInput input{.name = member.key, .place = member.key_place};
        input.kind_word = reader.text("kind");
        if (const Json* kind = reader.find("kind")) input.kind_place = kind->place;
        input.format = reader.format("format");
        input.history = reader.word("history").has_value();
        input.optional = reader.flag("optional");
        read_extent(reader, input);
        if (const Json* format = reader.find("format")) input.format_place = format->place;
        read_family(reader, input.instances, input.instances_place);
        pipeline_.inputs.push_back(std::move(input));
    }

    static void read_family(const ObjectReader& reader, std::string& family, Place& place) {
        family = reader.text("instances");
        if (const Json* json = reader.find("instances")) place = json->place;
    }

    void read_instance(const JsonMember& member) {
        const ObjectReader reader(member.value, "instances." + member.key, vocabulary::instance,
                                  diagnostics_);
        PipelineInstance instance{
            .name = member.key, .family = reader.text("of"), .facts = {}, .place = member.key_place};
        const Json* facts = reader.find("facts");
        if (facts && expect(*facts, Json::Kind::object, reader.path("facts"), diagnostics_))
            for (const JsonMember& fact : facts->members) {
                if (fact.value.kind == Json::Kind::null) continue;
                const std::string path = fmt::format("{}.{}", reader.path("facts"), fact.key);
                if (expect(fact.value, Json::Kind::boolean, path, diagnostics_))
                    instance.facts[fact.key] = {fact.value.boolean, fact.key_place};
            }
        pipeline_.instances.push_back(std::move(instance));
    }

    void read_extent(const ObjectReader& reader, HostInput& input) {
        const Json* json = reader.find("extent");
        if (!json) return;
        input.extent_place = json->place;
        if (json->kind == Json::Kind::array) {
            input.extent = HostInput::Extent::fixed;
            input.size = reader.pair("extent", input.size);
        } else if (reader.word("extent") == 1) {
            input.extent = HostInput::Extent::any;
        }
    }

    void read_node(const JsonMember& member) {
        // A variant or a setting that misspells a node's id makes a new node without a type.
        if (!member.value.find("type") && !near_nodes_) near_nodes_.emplace(typed_nodes());
        const std::string hint = member.value.find("type") ? "" : near_nodes_->nearest(member.key);
        const ObjectReader reader(member.value, "nodes." + member.key, vocabulary::node, diagnostics_,
                                  {.hint = hint});
        if (!reader.is_object()) return;
        PipelineNode node{.id = member.key, .place = member.key_place};
        node.type = reader.text("type");
        if (const Json* type = reader.find("type")) node.type_place = type->place;
        if (const Json* in = reader.find("in")) read_wires(*in, reader.path("in"), true, node.in);
        if (const Json* out = reader.find("out")) read_wires(*out, reader.path("out"), false, node.out);
        if (const Json* params = reader.find("params"))
            if (expect(*params, Json::Kind::object, reader.path("params"), diagnostics_))
                node.params = params->members;
        if (const Json* condition = reader.find("if"))
            if (expect(*condition, Json::Kind::string, reader.path("if"), diagnostics_))
                node.condition = *condition;
        node.with = reader.text("with");
        if (const Json* with = reader.find("with")) node.with_place = with->place;
        node.doc = reader.text("doc");
        read_family(reader, node.instances, node.instances_place);
        pipeline_.nodes.push_back(std::move(node));
    }

    std::vector<std::string> typed_nodes() const {
        std::vector<std::string> ids;
        for (const JsonMember& member : reader_.find("nodes")->members)
            if (member.value.find("type")) ids.push_back(member.key);
        return ids;
    }

    void read_wires(const Json& json, const std::string& path, bool in, std::vector<Wire>& wires) {
        if (!expect(json, Json::Kind::object, path, diagnostics_)) return;
        for (const JsonMember& member : json.members) {
            Wire wire{.port = member.key, .port_place = member.key_place, .place = member.value.place};
            const std::string wire_path = fmt::format("{}.{}", path, member.key);
            if (member.value.kind != Json::Kind::null) {
                if (!expect(member.value, Json::Kind::string, wire_path, diagnostics_)) continue;
                if (!read_name(member.value, wire_path, in, wire)) continue;
            }
            wires.push_back(std::move(wire));
        }
    }

    bool read_name(const Json& json, const std::string& path, bool in, Wire& wire) {
        const size_t at = json.string.find('@');
        wire.resource = json.string.substr(0, at);
        if (!expect_id(wire.resource, json.place, path, diagnostics_)) return false;
        if (at == std::string::npos) return true;
        const std::string which = json.string.substr(at + 1);
        wire.previous = which == "-1";
        if (which == "before") wire.member = Wire::Member::before;
        if (which == "last") wire.member = Wire::Member::last;
        const bool known = wire.previous || wire.member != Wire::Member::own;
        static const std::vector<std::string> members = {"before", "last"};
        if (!in)
            error(json.place, path,
                  fmt::format("an output is this frame's value; write \"{}\"", wire.resource));
        else if (!known)
            error(json.place, path,
                  which.empty() || which[0] == '-'
                      ? fmt::format("\"@{}\": only the previous frame's value is kept; write \"{}@-1\"",
                                    which, wire.resource)
                      : fmt::format("no \"@{}\"; there are @-1, @before and @last{}", which,
                                    did_you_mean(which, members)));
        return in && known;
    }

    void read_resource(const JsonMember& member) {
        const ObjectReader reader(member.value, "resources." + member.key, vocabulary::resource,
                                  diagnostics_);
        ResourceSetting setting{.name = member.key, .place = member.key_place};
        setting.format = reader.format("format");
        if (const Json* format = reader.find("format")) setting.format_place = format->place;
        if (const auto first = reader.word("first")) setting.first = static_cast<First>(*first);
        pipeline_.resources.push_back(std::move(setting));
    }

    ObjectReader reader_;
    Diagnostics& diagnostics_;
    std::optional<Suggestions> near_nodes_;
    Pipeline pipeline_;
};

std::optional<Pipeline> read_pipeline(std::optional<Json> json, const std::string& file,
                                      std::span<const std::string> settings, const ReadFile& read,
                                      Diagnostics& diagnostics) {
    const size_t errors = diagnostics.size();
    if (!json || !expect(*json, Json::Kind::object, "", diagnostics)) return std::nullopt;
    std::vector<ChainLink> chain = {{file, identity(file, read)}};
    if (!resolve_extends(*json, chain, read, diagnostics)) return std::nullopt;
    for (const std::string& setting : settings) apply_setting(*json, setting, diagnostics);
    Pipeline pipeline = PipelineReader(*json, diagnostics).read(file);
    if (diagnostics.size() != errors) return std::nullopt;
    return pipeline;
}

}  // namespace

std::optional<Pipeline> load_pipeline(const fs::path& file, std::span<const std::string> settings,
                                      Diagnostics& diagnostics) {
    return read_pipeline(read_json(file, diagnostics), file.generic_string(), settings, {}, diagnostics);
}

std::optional<Pipeline> parse_pipeline(std::string_view text, const std::string& file,
                                       std::span<const std::string> settings, Diagnostics& diagnostics,
                                       const ReadFile& read) {
    return read_pipeline(parse_json(text, file, diagnostics), file, settings, read, diagnostics);
}

}  // namespace penumbra
