// SPDX-License-Identifier: MIT
// A node declaration read from JSON (docs: formats of node declarations); ports are read by node_port.cpp,
// parameters by node_param.cpp. Every rule that one declaration can break by itself is checked here, so that
// later phases need not look again.
#include "penumbra/node_type.h"

#include <fmt/format.h>

#include <algorithm>

#include "graph/json_reader.h"
#include "graph/node_param.h"
#include "graph/node_port.h"

namespace penumbra {

namespace {

constexpr uint32_t max_group_threads =
    1024;  // Vulkan guarantees 128; every device of the last decade has 1024

class DeclarationReader {
  public:
    DeclarationReader(const Json& json, const std::vector<std::string>& keys,
                      std::shared_ptr<const Domain> domain, Diagnostics& diagnostics)
        : reader_(json, "", keys, diagnostics), diagnostics_(diagnostics) {
        type_.place = json.place;
        type_.domain = std::move(domain);
    }

    NodeType read(const std::string& basename) {
        if (!reader_.is_object()) return {};
        reader_.text("$schema");  // for editors
        read_name(basename);
        if (reader_.require("doc")) type_.doc = reader_.one_line("doc");
        read_shader();
        read_needs();
        if (const Json* params = reader_.find("params")) parse_params(*params, type_, diagnostics_);
        if (const Json* tables = reader_.find("tables")) read_tables(*tables);
        if (const Json* inputs = reader_.find("inputs")) parse_ports(*inputs, false, type_, diagnostics_);
        if (const Json* outputs = reader_.find("outputs")) parse_ports(*outputs, true, type_, diagnostics_);
        const bool writes = std::ranges::any_of(type_.ports, &Port::output);
        const Json* outputs = reader_.find("outputs");
        const bool none_given = !outputs || (outputs->kind == Json::Kind::object && outputs->members.empty());
        check_names();
        read_counters();
        if (!writes && none_given && (type_.counters.empty() || type_.host))
            error(reader_.json().place, "", "a node writes at least one output, or its shader counts");
        link_ports(reader_.json(), type_, diagnostics_);
        read_dispatch();
        if (const Json* classes = reader_.find("classes")) read_classes(*classes);
        return std::move(type_);
    }

  private:
    void error(const Place& place, std::string path, std::string message) {
        diagnostics_.add(place, std::move(path), std::move(message));
    }

    void read_name(const std::string& basename) {
        const Json* json = reader_.require("node");
        const std::optional<std::string> name = reader_.text("node");
        if (!name) return;
        type_.name = *name;
        if (!is_id(*name))
            error(json->place, "node", fmt::format("\"{}\" is no id ([a-z][a-z0-9_]*)", *name));
        else if (*name != basename)
            error(json->place, "node", fmt::format("\"{}\" is not the file's name, \"{}\"", *name, basename));
    }

    void read_shader() {
        const Json* shader = reader_.find("shader");
        const Json* host = reader_.find("host");
        type_.host = reader_.flag("host");
        type_.shader = reader_.text("shader").value_or("");
        if (host && host->kind == Json::Kind::boolean && !host->boolean)
            error(host->place, "host", "only true may be written; leave the key out");
        if (shader && host)
            error(host->place, "host", "a node has either a shader or a host callback");
        else if (!shader && !host)
            error(reader_.json().place, "", "key \"shader\" is missing (or \"host\": true)");
        if (!shader || shader->kind != Json::Kind::string) return;
        const bool plain = type_.shader.find_first_of("/\\") == std::string::npos;
        if (!plain || !type_.shader.ends_with(".comp") || type_.shader.size() == 5)
            error(shader->place, "shader",
                  fmt::format("\"{}\" is no file name that ends in .comp", type_.shader));
    }

    struct ListItem {
        std::string text, path;
        Place place;
    };

    // A list of different strings.
    std::vector<ListItem> read_list(const char* key) {
        std::vector<ListItem> list;
        const Json* json = reader_.find(key);
        if (!json || !expect(*json, Json::Kind::array, key, diagnostics_)) return list;
        for (size_t i = 0; i < json->items.size(); ++i) {
            const Json& item = json->items[i];
            const std::string path = fmt::format("{}[{}]", key, i);
            if (!expect(item, Json::Kind::string, path, diagnostics_)) continue;
            if (std::ranges::find(list, item.string, &ListItem::text) != list.end())
                error(item.place, path, fmt::format("\"{}\" is listed twice", item.string));
            else
                list.push_back({item.string, path, item.place});
        }
        return list;
    }

    void read_needs() {
        std::vector<std::string> words = type_.domain->features;
        words.emplace_back("jitter");
        for (const ListItem& need : read_list("needs")) {
            if (std::ranges::find(words, need.text) == words.end())
                error(need.place, need.path,
                      fmt::format("no need \"{}\" (needs: {}){}", need.text, join(words),
                                  did_you_mean(need.text, words)));
            else
                type_.needs.push_back(need.text);
        }
    }

    void read_counters() {
        for (const ListItem& counter : read_list("counters")) {
            type_.counters.push_back(counter.text);
            claim(counter.text, counter.place, counter.path);
        }
    }

    void read_tables(const Json& json) {
        if (!expect(json, Json::Kind::object, "tables", diagnostics_)) return;
        const std::vector<std::string> keys = {"file", "format", "extent", "if"};
        for (const JsonMember& member : json.members) {
            const ObjectReader reader(member.value, "tables." + member.key, keys, diagnostics_);
            Table table{.name = member.key};
            claim(table.name, member.key_place, reader.path());
            reader.require("file");
            reader.require("format");
            reader.require("extent");
            if (const auto file = reader.text("file")) {
                table.file = *file;
                if (file->empty()) reader.error(*reader.find("file"), "file", "the name is empty");
            }
            if (const auto format = reader.format("format")) {
                table.format = *format;
                if (info(*format).kind == FormatClass::depth)
                    reader.error(*reader.find("format"), "format", "a table cannot have a depth format");
            }
            table.extent = reader.pair("extent", 1, 16384).value_or(table.extent);
            if (const Json* condition = reader.find("if"))
                table.condition = read_condition(*condition, reader.path("if"), type_, diagnostics_);
            type_.tables.push_back(std::move(table));
        }
    }

    void read_dispatch() {
        const Json* json = reader_.find("dispatch");
        if (type_.host) {
            type_.dispatch.kind = Dispatch::Kind::host;
            if (json) error(json->place, "dispatch", "a host node records its own commands");
            return;
        }
        if (!json) {
            if (!reader_.find("host")) reader_.require("dispatch");
            return;
        }
        const std::vector<std::string> keys = {"over", "indirect", "groups", "offset", "group", "per_thread"};
        const ObjectReader reader(*json, "dispatch", keys, diagnostics_);
        if (!reader.is_object()) return;
        const int forms = (reader.find("over") != nullptr) + (reader.find("indirect") != nullptr) +
                          (reader.find("groups") != nullptr);
        if (forms != 1) {
            error(json->place, "dispatch", "expected exactly one of \"over\", \"indirect\" and \"groups\"");
            return;
        }
        Dispatch& dispatch = type_.dispatch;
        if (reader.find("over")) {
            dispatch.over.name = reader.text("over").value_or("frame");
            check_over(reader);
        } else if (reader.find("indirect")) {
            dispatch.kind = Dispatch::Kind::indirect;
            dispatch.indirect = reader.text("indirect").value_or("");
            check_indirect(reader);
        } else {
            dispatch.kind = Dispatch::Kind::groups;
            if (const auto groups = reader.wholes("groups", 3, 3, 1, 65535))  // the limit every device has
                std::ranges::copy(*groups, dispatch.groups.begin());
        }
        if (const auto group = read_group(reader)) dispatch.group = *group;
        if (const auto threads = read_per_thread(reader)) dispatch.per_thread = *threads;
        check_levels();
        if (const Json* offset = reader.find("offset")) {
            dispatch.offset = reader.whole("offset", 0, 1u << 16).value_or(0);
            if (dispatch.kind != Dispatch::Kind::indirect)
                reader.error(*offset, "offset", "only an indirect dispatch has an offset");
            else if (dispatch.offset % 4 != 0)
                reader.error(*offset, "offset", "must be a multiple of 4 bytes");
        }
    }

    void check_over(const ObjectReader& reader) {
        const std::string& name = type_.dispatch.over.name;
        if (name == "frame" || reader.find("over")->kind != Json::Kind::string) return;
        const Json& json = *reader.find("over");
        const Port* port = type_.port(name);
        if (!port)
            reader.error(json, "over",
                         fmt::format("no port \"{}\"{}", name, did_you_mean(name, port_names())));
        else if (port->kind != PortKind::image && port->kind != PortKind::texels)
            reader.error(json, "over", fmt::format("\"{}\" is no image and has no extent", name));
        else if (port->optional || !port->condition.always())
            reader.error(json, "over", fmt::format("\"{}\" may be absent", name));
        else
            type_.dispatch.over.port = type_.index(*port);
    }

    // Level by level, each made from the finer one.
    void check_levels() {
        const Port* chain = type_.levelled_output();
        if (!chain) return;
        const auto complain = [&](const Port& port, std::string message) {
            error(port.place, "outputs." + port.name, std::move(message));
        };
        if (type_.dispatch.kind != Dispatch::Kind::over || type_.dispatch.over.name != chain->name)
            complain(*chain,
                     fmt::format("a mip chain is written level by level: dispatch over \"{}\"", chain->name));
        for (const Port& port : type_.ports)
            if (port.output && port.levels && &port != chain)
                complain(port, fmt::format(
                                   "\"{}\" has a mip chain already; one is all that a dispatch steps through",
                                   chain->name));
    }

    void check_indirect(const ObjectReader& reader) {
        const std::string& name = type_.dispatch.indirect;
        if (reader.find("indirect")->kind != Json::Kind::string) return;
        const Json& json = *reader.find("indirect");
        const Port* port = type_.port(name);
        if (!port)
            reader.error(json, "indirect",
                         fmt::format("no port \"{}\"{}", name, did_you_mean(name, port_names())));
        else if (port->output || !port->indirect)
            reader.error(json, "indirect", fmt::format("\"{}\" is no input with \"indirect\": true", name));
        else if (port->optional || !port->condition.always())
            reader.error(json, "indirect", fmt::format("\"{}\" may be absent", name));
        else
            type_.dispatch.indirect_port = type_.index(*port);
    }

    std::optional<std::array<uint32_t, 3>> read_group(const ObjectReader& reader) {
        const auto sizes = reader.wholes("group", 2, 3, 1, max_group_threads);
        if (!sizes) return std::nullopt;
        const std::array<uint32_t, 3> group = {(*sizes)[0], (*sizes)[1], sizes->size() > 2 ? (*sizes)[2] : 1};
        if (uint64_t{group[0]} * group[1] * group[2] <= max_group_threads) return group;
        reader.error(*reader.find("group"), "group", fmt::format("more than {} threads", max_group_threads));
        return std::nullopt;
    }

    std::optional<std::array<uint32_t, 2>> read_per_thread(const ObjectReader& reader) {
        const auto threads = reader.pair("per_thread", 1, 1024);
        if (threads && type_.dispatch.kind != Dispatch::Kind::over)
            reader.error(*reader.find("per_thread"), "per_thread", "only a dispatch over an extent has it");
        return threads;
    }

    void read_classes(const Json& json) {
        const std::vector<std::string> keys = {"cpu", "gpu"};
        const ObjectReader reader(json, "classes", keys, diagnostics_);
        if (const Json* cpu = reader.find("cpu")) read_class(*cpu, "classes.cpu", type_.cpu);
        if (const Json* gpu = reader.find("gpu")) read_class(*gpu, "classes.gpu", type_.gpu);
    }

    void read_class(const Json& json, const std::string& path, ClassOverrides& overrides) {
        std::vector<std::string> keys;
        for (const Param& param : type_.params) keys.push_back(param.name);
        if (!type_.host) keys.insert(keys.end(), {"group", "per_thread"});
        const ObjectReader reader(json, path, keys, diagnostics_);
        if (!type_.host) {
            overrides.group = read_group(reader);
            overrides.per_thread = read_per_thread(reader);
        }
        for (const JsonMember& member : json.members) {
            const Param* param = type_.param(member.key);
            if (!param) continue;
            const std::string member_path = reader.path(member.key);
            const auto decides = [&](const auto& port_or_table) {
                return asks_for(port_or_table.condition, param->name);
            };
            if (!param->constant)
                error(member.key_place, member_path, "a class may override constant parameters only");
            else if (std::ranges::any_of(type_.ports, decides))
                error(member.key_place, member_path,
                      "a port exists by this parameter, so it cannot vary with the device");
            else if (std::ranges::any_of(type_.tables, decides))
                error(member.key_place, member_path,
                      "a table exists by this parameter, so it cannot vary with the device");
            else if (const auto value = parse_param_value(*param, member.value, member_path, diagnostics_))
                overrides.params[param->name] = *value;
        }
    }

    // Ports, tables, parameters and counters share one namespace: the generated GLSL names them all.
    void claim(const std::string& name, const Place& place, const std::string& path, bool in_glsl = true) {
        const char* problem = in_glsl ? glsl_name_problem(name) : nullptr;
        if (!is_id(name))
            error(place, path, fmt::format("\"{}\" is no id ([a-z][a-z0-9_]*)", name));
        else if (name == "mip_level")
            error(place, path,
                  "\"mip_level\" is taken: it tells a node which level of a mip chain it writes");
        else if (name == "frame")
            error(place, path, "\"frame\" names the frame block and its extent");
        else if (problem)
            error(place, path, fmt::format("\"{}\" is {}", name, problem));
        else if (const auto [other, added] = claimed_.try_emplace(name, path); !added)
            error(place, path, fmt::format("\"{}\" is already the name of {}", name, other->second));
    }

    void check_names() {
        for (const Param& param : type_.params)
            claim(param.name, param.place, "params." + param.name,
                  !param.constant);  // constants become upper case
        for (const Port& port : type_.ports)
            claim(port.name, port.place, fmt::format("{}.{}", port.output ? "outputs" : "inputs", port.name));
        for (const Port& port : type_.ports)
            if (port.optional || !port.condition.always()) claim_presence("port", port.name);
        for (const Table& table : type_.tables)
            if (!table.condition.always()) claim_presence("table", table.name);
    }

    void claim_presence(const char* what, const std::string& name) {
        const Param* param = type_.param("has_" + name);
        if (param && param->constant)
            error(param->place, "params." + param->name,
                  fmt::format("its name in GLSL is taken: HAS_... tells whether {} \"{}\" is bound", what,
                              name));
    }

    std::vector<std::string> port_names() const {
        std::vector<std::string> names;
        for (const Port& port : type_.ports) names.push_back(port.name);
        return names;
    }

    ObjectReader reader_;
    Diagnostics& diagnostics_;
    NodeType type_;
    std::map<std::string, std::string> claimed_;  // name -> path
};

}  // namespace

const Port* NodeType::port(std::string_view port_name) const {
    const auto found = std::ranges::find(ports, port_name, &Port::name);
    return found == ports.end() ? nullptr : &*found;
}

const Port* NodeType::levelled_output() const {
    const auto found = std::ranges::find_if(ports, [](const Port& p) { return p.output && p.levels; });
    return found == ports.end() ? nullptr : &*found;
}

bool NodeType::watches() const {
    return std::ranges::none_of(ports, &Port::output);
}

const Param* NodeType::param(std::string_view param_name) const {
    const auto found = std::ranges::find(params, param_name, &Param::name);
    return found == params.end() ? nullptr : &*found;
}

std::optional<NodeType> parse_node_type(const Json& json, const std::string& basename,
                                        std::shared_ptr<const Domain> domain, Diagnostics& diagnostics) {
    const size_t errors = diagnostics.size();
    const std::vector<std::string> keys = {"$schema",  "node",    "doc",     "shader", "host",
                                           "needs",    "inputs",  "outputs", "tables", "params",
                                           "dispatch", "classes", "counters"};
    NodeType type = DeclarationReader(json, keys, std::move(domain), diagnostics).read(basename);
    if (diagnostics.size() != errors) return std::nullopt;
    return type;
}

}  // namespace penumbra
