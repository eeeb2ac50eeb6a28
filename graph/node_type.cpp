// SPDX-License-Identifier: MIT
// A node declaration read from JSON (docs/vocabulary.md); ports are read by node_port.cpp,
// parameters by node_param.cpp. Every rule that one declaration can break by itself is checked here, so that
// later phases need not look again.
#include "penumbra/node_type.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

#include "graph/interface.h"
#include "graph/json_reader.h"
#include "graph/node_param.h"
#include "graph/node_port.h"

namespace penumbra {

namespace {

// What generate_glsl() names in every node, in lower case, since constant parameters are in capitals there.
constexpr auto generated_names = std::to_array<std::string_view>(
    {"class_cpu", "counters", "frame_block", "frame_depth_at_centres", "frame_orthographic", "frame_reset",
     "group_barrier", "group_x", "group_y", "lanes_in_step", "on_cpu", "pack_unorm", "params", "per_thread_x",
     "per_thread_y", "subgroup_barrier", "to_halves", "within_halves"});

class DeclarationReader {
  public:
    DeclarationReader(const Json& json, std::shared_ptr<const Domain> domain, Diagnostics& diagnostics)
        : json_(json), reader_(json, "", vocabulary::declaration, diagnostics), diagnostics_(diagnostics) {
        type_.place = json.place;
        type_.domain = std::move(domain);
    }

    NodeType read(const std::string& basename) {
        if (!reader_.is_object()) return {};
        reader_.text("$schema");
        type_.name = reader_.text("node", basename.c_str());
        if (type_.name != basename)
            reader_.error("node", fmt::format("\"{}\" is not the file's name, \"{}\"", type_.name, basename));
        type_.doc = reader_.text("doc");
        type_.host = reader_.flag("host");
        if (!type_.host) type_.shader = reader_.text("shader");
        read_needs();
        read_jittered();
        if (const Json* params = reader_.find("params")) parse_params(*params, type_, diagnostics_);
        if (const Json* tables = reader_.find("tables")) read_tables(*tables);
        if (const Json* inputs = reader_.find("inputs")) parse_ports(*inputs, false, type_, diagnostics_);
        if (const Json* outputs = reader_.find("outputs")) parse_ports(*outputs, true, type_, diagnostics_);
        const bool writes = std::ranges::any_of(type_.ports, &Port::output);
        const Json* outputs = reader_.find("outputs");
        const bool none_given = !outputs || (outputs->kind == Json::Kind::object && outputs->members.empty());
        check_names();
        for (const ObjectReader::Item& counter : reader_.list("counters")) {
            type_.counters.push_back(counter.text);
            claim(counter.text, counter.place, counter.path);
        }
        if (!writes && none_given && (type_.counters.empty() || type_.host))
            error(json_.place, "", "a node writes at least one output, or its shader counts");
        link_ports(json_, type_, diagnostics_);
        check_push_constants();
        read_dispatch();
        if (const Json* classes = reader_.find("classes")) read_classes(*classes);
        return std::move(type_);
    }

  private:
    void error(const Place& place, std::string path, std::string message) {
        diagnostics_.add(place, std::move(path), std::move(message));
    }

    void check_push_constants() {
        constexpr uint32_t most = 128;  // guaranteed by every Vulkan device
        const PushConstants layout = push_constants(type_);
        if (layout.size <= most) return;
        const auto last = std::find_if(type_.params.rbegin(), type_.params.rend(),
                                       [](const Param& param) { return !param.constant; });
        error(
            last->place, "params." + last->name,
            fmt::format("the parameters that may change per frame{} end at byte {}; at most {} fit the push "
                        "constants (constant parameters do not count)",
                        layout.mip_level      ? " and the level of the mip chain"
                        : layout.counter_base ? " and the place of the counters"
                                              : "",
                        layout.size, most));
    }

    void read_needs() {
        const std::vector<std::string> words = need_words(*type_.domain);
        for (const ObjectReader::Item& need : reader_.list("needs")) {
            if (std::ranges::find(words, need.text) == words.end())
                error(need.place, need.path,
                      fmt::format("no need \"{}\" (needs: {}){}", need.text, join(words),
                                  did_you_mean(need.text, words)));
            else
                type_.needs.push_back(need.text);
        }
    }

    void read_jittered() {
        for (const ObjectReader::Item& fact : reader_.list("jittered")) {
            if (const auto problem = fact_problem(*type_.domain, fact.text))
                error(fact.place, fact.path, *problem);
            else
                type_.jittered.push_back(fact.text);
        }
    }

    void read_tables(const Json& json) {
        if (!expect(json, Json::Kind::object, "tables", diagnostics_)) return;
        for (const JsonMember& member : json.members) {
            const ObjectReader reader(member.value, "tables." + member.key, vocabulary::table, diagnostics_);
            Table table{.name = member.key};
            claim(table.name, member.key_place, reader.path());
            table.file = reader.text("file");
            const std::filesystem::path file(table.file);
            if (file.is_absolute() || std::ranges::find(file, "..") != file.end())
                reader.error("file", fmt::format("\"{}\" leads out of the declaration's folder", table.file));
            table.format = reader.format("format").value_or(table.format);
            table.extent = reader.pair("extent", table.extent);
            table.storage = reader.word("as") == 1;
            if (const Json* condition = reader.find("if"))
                table.condition = read_condition(*condition, reader.path("if"), type_, diagnostics_);
            type_.tables.push_back(std::move(table));
        }
    }

    void read_dispatch() {
        Dispatch& dispatch = type_.dispatch;
        if (type_.host) dispatch.kind = Dispatch::Kind::host;
        const Json* json = reader_.find("dispatch");
        if (!json || type_.host) return;
        const ObjectReader reader(*json, "dispatch", vocabulary::dispatch, diagnostics_);
        if (reader.find("over")) {
            dispatch.over.name = reader.text("over", "frame");
            check_over(reader);
        } else if (reader.find("indirect")) {
            dispatch.kind = Dispatch::Kind::indirect;
            dispatch.indirect = reader.text("indirect");
            if (!dispatch.indirect.empty()) check_indirect(reader);
        } else if (const auto groups = reader.wholes("groups"); !groups.empty()) {
            dispatch.kind = Dispatch::Kind::groups;
            std::ranges::copy(groups, dispatch.groups.begin());
        }
        if (const auto group = read_group(reader)) dispatch.group = *group;
        dispatch.per_thread = reader.pair("per_thread", dispatch.per_thread);
        dispatch.offset = reader.whole("offset", 0);
        check_levels();
    }

    void check_over(const ObjectReader& reader) {
        const std::string& name = type_.dispatch.over.name;
        if (name == "frame") return;
        const Port* port = type_.port(name);
        if (!port)
            reader.error("over", fmt::format("no port \"{}\"{}", name, did_you_mean(name, port_names())));
        else if (port->kind != PortKind::image && port->kind != PortKind::texels)
            reader.error("over", fmt::format("\"{}\" is no image and has no extent", name));
        else if (port->optional || !port->condition.always())
            reader.error("over", fmt::format("\"{}\" may be absent", name));
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
        const Port* port = type_.port(name);
        if (!port)
            reader.error("indirect", fmt::format("no port \"{}\"{}", name, did_you_mean(name, port_names())));
        else if (port->output || !port->indirect)
            reader.error("indirect", fmt::format("\"{}\" is no input with \"indirect\": true", name));
        else if (port->optional || !port->condition.always())
            reader.error("indirect", fmt::format("\"{}\" may be absent", name));
        else
            type_.dispatch.indirect_port = type_.index(*port);
    }

    std::optional<std::array<uint32_t, 3>> read_group(const ObjectReader& reader) {
        const std::vector<uint32_t> sizes = reader.wholes("group");
        if (sizes.empty()) return std::nullopt;
        const std::array<uint32_t, 3> group = {sizes[0], sizes[1], sizes.size() > 2 ? sizes[2] : 1};
        if (uint64_t{group[0]} * group[1] * group[2] <= max_group_threads) return group;
        reader.error("group", fmt::format("more than {} threads", max_group_threads));
        return std::nullopt;
    }

    void read_classes(const Json& json) {
        const ObjectReader reader(json, "classes", vocabulary::classes, diagnostics_);
        if (const Json* cpu = reader.find("cpu")) read_class(*cpu, "classes.cpu", type_.cpu);
        if (const Json* gpu = reader.find("gpu")) read_class(*gpu, "classes.gpu", type_.gpu);
        type_.by_class = reader.flag("compiled");
        if (type_.host && type_.by_class) reader.error("compiled", "a host node has no shader");
    }

    void read_class(const Json& json, const std::string& path, ClassOverrides& overrides) {
        Scope scope;
        for (const Param& param : type_.params) scope.names.push_back(param.name);
        const ObjectReader reader(json, path, vocabulary::device_class, diagnostics_, scope);
        overrides.group = read_group(reader);
        if (reader.find("per_thread")) overrides.per_thread = reader.pair("per_thread", {1, 1});
        if (type_.host && overrides.group) reader.error("group", "a host node records its own commands");
        if (overrides.per_thread && type_.dispatch.kind != Dispatch::Kind::over)
            reader.error("per_thread", "only a dispatch over an extent has it");
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
        if (!expect_id(name, place, path, diagnostics_)) return;
        if (name == "mip_level")
            error(place, path,
                  "\"mip_level\" is taken: it tells a node which level of a mip chain it writes");
        else if (name == "counter_base")
            error(place, path, "\"counter_base\" is taken: it tells a node where its counters are");
        else if (name == "frame")
            error(place, path, "\"frame\" names the frame block and its extent");
        else if (std::ranges::find(generated_names, name) != generated_names.end())
            error(place, path,
                  fmt::format("\"{}\" is taken: the generated GLSL names something else so", name));
        else if (problem)
            error(place, path, fmt::format("\"{}\" is {}", name, problem));
        else if (const auto [other, added] = claimed_.try_emplace(name, path); !added)
            error(place, path, fmt::format("\"{}\" is already the name of {}", name, other->second));
    }

    void check_names() {
        for (const Param& param : type_.params) {
            claim(param.name, param.place, "params." + param.name,
                  !param.constant);  // constants become upper case
            if (!fact_problem(*type_.domain, param.name))
                error(param.place, "params." + param.name,
                      fmt::format("\"{}\" is a fact, which a condition would mean by it", param.name));
        }
        for (const Port& port : type_.ports)
            claim(port.name, port.place, fmt::format("{}.{}", port.output ? "outputs" : "inputs", port.name));
        for (const Port& port : type_.ports)
            if (port.optional || !port.condition.always()) claim_presence("port", port.name);
        for (const Table& table : type_.tables)
            if (!table.condition.always()) claim_presence("table", table.name);
        for (const Port& port : type_.ports)
            if (port.output && port.kind == PortKind::image) claim_stores(port);
    }

    void claim_stores(const Port& port) {
        for (const std::string& name :
             {"store_" + port.name, "store4_" + port.name, port.name + "_row", port.name + "_rows"})
            if (const auto other = claimed_.find(name); other != claimed_.end())
                error(port.place, "outputs." + port.name,
                      fmt::format("the generated GLSL stores it by the name of {}", other->second));
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

    const Json& json_;
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
    NodeType type = DeclarationReader(json, std::move(domain), diagnostics).read(basename);
    if (diagnostics.size() != errors) return std::nullopt;
    return type;
}

}  // namespace penumbra
