// SPDX-License-Identifier: MIT
// penumbra statics: what a device's driver makes of the shaders of pipelines, pass by pass. Nothing runs.
#include <fmt/format.h>

#include <iostream>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/fact_list.h"
#include "app/node_folders.h"
#include "app/pass_statics.h"
#include "app/pipeline_file.h"
#include "app/progress.h"
#include "app/session.h"
#include "app/wrong.h"

namespace penumbra {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson passes_json(const std::vector<PassStatics>& passes) {
    OrderedJson list = OrderedJson::array();
    for (const PassStatics& pass : passes) {
        OrderedJson executables = OrderedJson::array();
        for (const ExecutableStatics& e : pass.executables) {
            OrderedJson statistics = OrderedJson::object();
            for (const Statistic& s : e.statistics)
                std::visit([&](auto value) { statistics[s.name] = value; }, s.value);
            executables.push_back(
                {{"name", e.name}, {"subgroup_size", e.subgroup_size}, {"statistics", statistics}});
        }
        list.push_back(
            {{"node", pass.node}, {"type", pass.type}, {"group", pass.group}, {"executables", executables}});
    }
    return list;
}

// A column for each executable; a row for each statistic that any of them has, in the driver's order.
void print_table(const std::vector<PassStatics>& passes) {
    struct Column {
        std::string head;
        std::map<std::string, std::string> cells;
    };
    const std::vector<std::string> own = {"lanes of a group", "lanes of a subgroup"};
    std::vector<std::string> rows = own;
    std::vector<Column> columns;
    size_t first = 0;
    for (const PassStatics& pass : passes)
        for (const ExecutableStatics& e : pass.executables) {
            Column& column = columns.emplace_back();
            column.head = pass.executables.size() > 1 ? pass.node + " " + e.name : pass.node;
            column.cells[own[0]] = std::to_string(pass.group[0] * pass.group[1] * pass.group[2]);
            column.cells[own[1]] = std::to_string(e.subgroup_size);
            for (const Statistic& s : e.statistics) {
                if (std::ranges::find(rows, s.name) == rows.end()) rows.push_back(s.name);
                column.cells[s.name] =
                    std::visit([](auto value) { return fmt::format("{}", value); }, s.value);
            }
        }
    for (const std::string& row : rows) first = std::max(first, row.size());
    const auto print_row = [&](const std::string& name, const auto& cell) {
        fmt::print("{:{}}", name, first);
        for (const Column& column : columns) {
            size_t width = column.head.size();
            for (const auto& [row, text] : column.cells) width = std::max(width, text.size());
            fmt::print("  {:>{}}", cell(column), width);
        }
        fmt::print("\n");
    };
    print_row("", [](const Column& column) { return column.head; });
    for (const std::string& row : rows)
        print_row(row, [&](const Column& column) {
            const auto found = column.cells.find(row);
            return found == column.cells.end() ? std::string("-") : found->second;
        });
}

}  // namespace

int run_statics(const StaticsArguments& arguments) {
    const auto nodes = open_nodes(arguments.node_folders);
    if (!nodes) return exit_wrong;
    const auto facts = parse_facts(arguments.facts, *nodes->domain());
    if (!facts) return exit_wrong;
    std::vector<CheckedPipeline> pipelines;
    for (const std::string& file : arguments.pipelines) {
        auto pipeline = open_pipeline(file, arguments.settings, *nodes);
        if (!pipeline) return exit_wrong;
        pipelines.push_back(std::move(*pipeline));
    }
    std::unique_ptr<Device> device;
    try {
        device = std::make_unique<Device>(DeviceOptions{.name = arguments.device, .statistics = true});
    } catch (const DeviceError& e) {  // one that was asked for by name is the command's mistake
        std::cerr << "penumbra: " << e.what() << "\n"
                  << "Mesa's compiler for a card that is not there answers as well: docs/gpu.md\n";
        return arguments.device.empty() ? exit_failed : exit_wrong;
    }
    // Its class and features choose the shaders; of its memory nothing is asked, since there may be none.
    DeviceTable table = reference_device(device->info().is_cpu);
    table.features = features_of(*device);

    OrderedJson document = {{"device", device->info().name},
                            {"driver", device->info().driver},
                            {"pipelines", OrderedJson::array()}};
    Doing doing;
    for (const CheckedPipeline& pipeline : pipelines) {
        const std::string what = "compiling the shaders of " + pipeline.name;
        doing(what);
        Target target = standalone_target(pipeline, table, {1920, 1080}, *facts, {1024, 1024}, max_cascades);
        target.left_out.clear();  // as facts that are not named: what a host may bring is there
        Diagnostics diagnostics;
        const auto plan = compile(pipeline, target, {}, diagnostics);
        if (!plan) return wrong(diagnostics);
        const std::vector<PassStatics> passes =
            pass_statics(*device, *plan, [&](double share) { doing(what, share); });
        doing.clear();
        if (arguments.format == "json") {
            document["pipelines"].push_back({{"pipeline", plan->pipeline}, {"passes", passes_json(passes)}});
        } else {
            fmt::print("{}{} on {} ({})\n", &pipeline == pipelines.data() ? "" : "\n", plan->pipeline,
                       device->info().name, device->info().driver);
            print_table(passes);
        }
    }
    if (arguments.format == "json") std::cout << document.dump(2) << "\n";
    return exit_good;
}

}  // namespace penumbra
