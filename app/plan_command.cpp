// SPDX-License-Identifier: MIT
// penumbra plan: what a pipeline becomes, without a device or for one.
#include <fmt/format.h>

#include <charconv>
#include <functional>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "app/commands.h"
#include "app/fact_list.h"
#include "app/input_files.h"
#include "app/node_folders.h"
#include "app/pipeline_file.h"
#include "app/plan_json.h"
#include "app/progress.h"
#include "app/session.h"
#include "app/wrong.h"

namespace penumbra {

std::optional<std::array<uint32_t, 2>> parse_size(const std::string& text, std::string_view option) {
    std::array<uint32_t, 2> size{};
    const char *at = text.data(), *end = at + text.size();
    const auto number = [&](uint32_t& value) {
        const auto [after, error] = std::from_chars(at, end, value);
        at = after;
        return error == std::errc() && value > 0;
    };
    if (number(size[0]) && at != end && *at++ == 'x' && number(size[1]) && at == end) return size;
    std::cerr << option << ": \"" << text << "\" is not WIDTHxHEIGHT, as 1280x720\n";
    return std::nullopt;
}

namespace {

// Per pixel; and of a family with several members, what the plan without its last one takes less.
std::string bytes_per_pixel(const CheckedPipeline& pipeline, const Plan& plan,
                            const std::function<std::optional<Plan>(const std::string& setting)>& with) {
    const double pixels = static_cast<double>(plan.extent.width) * plan.extent.height;
    const auto bytes = [&](const Plan& p) { return static_cast<double>(p.memory.heap_bytes) / pixels; };
    std::string text = fmt::format("bytes per pixel {:.2f}", bytes(plan));
    std::map<std::string, std::set<std::string>> members;
    std::map<std::string, std::string> last;
    for (const BoundNode& node : pipeline.nodes) {
        if (node.family.empty()) continue;
        members[node.family].insert(node.member);
        last[node.family] = node.member;
    }
    for (const auto& [family, member] : last) {
        if (members[family].size() == 1) continue;
        const auto fewer = with("instances." + member + "=null");
        text += fmt::format(", for the last of {} {} {}", members[family].size(), family,
                            fewer ? fmt::format("{:.2f}", bytes(plan) - bytes(*fewer))
                                  : "not known, since the pipeline names it elsewhere");
    }
    return text + "\n";
}

}  // namespace

int run_plan(const PlanArguments& arguments) {
    const auto nodes = open_nodes(arguments.node_folders);
    if (!nodes) return exit_wrong;
    const auto size = parse_size(arguments.size);
    const auto facts = parse_facts(arguments.facts, *nodes->domain());
    const auto pipeline = open_pipeline(arguments.pipeline, arguments.settings, *nodes);
    if (!size || !facts || !pipeline) return exit_wrong;
    Target target;
    target.extent = {(*size)[0], (*size)[1]};
    target.facts = *facts;
    if (arguments.no_jitter) target.jitters = false;
    target.device = reference_device();
    std::unique_ptr<Device> device;  // which the table asks until the plan is there
    if (arguments.on_device) {
        device = std::make_unique<Device>(DeviceOptions{arguments.device, false});
        target.device = device_table(handles_of(*device));
        target.device.features = features_of(*device);
    }
    // The sun's maps and the list of lights have sizes of their own: as the standalone host has them.
    for (const auto& [name, resource] :
         standalone_target(*pipeline, target.device, *size, *facts, {1024, 1024}, max_cascades).inputs)
        if (name.starts_with("cascade_") || name == "lights") target.inputs[name] = resource;
    Diagnostics diagnostics;
    CompileOptions options;
    options.alias = !arguments.no_alias;
    options.optimum_search_nodes = arguments.optimum ? report_search_nodes : render_search_nodes;
    Doing doing;
    if (arguments.optimum)
        options.optimum_progress = [&](double share) {
            doing("looking for the smallest possible heap, which may be found sooner", share);
        };
    const auto plan = compile(*pipeline, target, options, diagnostics);
    doing.clear();
    if (!plan) return wrong(diagnostics);
    print_warnings(facts_not_taken(*plan, *facts));
    if (!arguments.out.empty()) {
        const std::filesystem::path folder = arguments.out;
        FileList written{folder / "plan.json"};
        for (size_t i = 0; i < plan->modules.size(); ++i) written.push_back(folder / module_file(i));
        for (size_t i = 0; i < plan->tables.size(); ++i) written.push_back(folder / table_file(i));
        if (!spares(written, {files_of_pipelines({pipeline->file}), files_of_nodes(arguments.node_folders)},
                    diagnostics))
            return wrong(diagnostics);
        if (write_plan(*plan, arguments.out, diagnostics)) return exit_good;
        std::cerr << diagnostics.text();
        return exit_failed;
    }
    if (arguments.format == "json") {
        std::cout << to_json(*plan).dump(2) << "\n";
        return exit_good;
    }
    if (arguments.format == "dot") {
        std::cout << to_dot(*plan);
        return exit_good;
    }
    options.optimum_search_nodes = 0;
    options.optimum_progress = nullptr;
    const auto changed = [&](const std::string& setting) -> std::optional<Plan> {
        std::vector<std::string> settings = arguments.settings;
        settings.push_back(setting);
        Diagnostics unsaid;
        const auto other = read_pipeline(arguments.pipeline, settings, *nodes, nullptr, {}, unsaid);
        return other ? compile(*other, target, options, unsaid) : std::nullopt;
    };
    std::cout << to_text(*plan) << bytes_per_pixel(*pipeline, *plan, changed);
    return exit_good;
}

}  // namespace penumbra
