// SPDX-License-Identifier: MIT
#include "app/reference_pages.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <sstream>

#include "app/node_text.h"

namespace penumbra {
namespace {

// For a cell of a table: a bar would end it.
std::string cell(const std::string& text) {
    std::string out;
    for (const char c : text) out += c == '|' ? std::string("\\|") : std::string(1, c);
    return out;
}

// A paragraph in lines of at most 120 columns.
std::string paragraph(const std::string& text) {
    constexpr size_t columns = 120;
    std::istringstream words(text);
    std::string out;
    size_t column = 0;
    for (std::string word; words >> word; out += word, column += word.size()) {
        if (column + 1 + word.size() > columns) {
            out += '\n';
            column = 0;
        } else if (column > 0) {
            out += ' ';
            ++column;
        }
    }
    return out;
}

// A float in as few digits as tell it from others.
std::string text_of(const ParamValue& value) {
    const auto json = json_of(value);
    return json.is_number_float() ? fmt::format("{}", json.get<float>()) : json.dump();
}

std::string settings_of(const BoundNode& node) {
    std::vector<std::string> settings;
    for (size_t i = 0; i < node.params.size(); ++i) {
        const Param& param = node.type().params[i];
        if (!node.set[i] || node.params[i] == param.default_value) continue;
        settings.push_back(fmt::format("{} = {}", param.name, text_of(node.params[i])));
    }
    return joined(settings, ", ");
}

}  // namespace

std::string node_section(const NodeType& type) {
    std::string out = fmt::format("### {}\n\n{}\n\n", type.name, paragraph(type.doc));
    std::vector<std::string> of_device, of_host;
    for (const std::string& need : type.needs)
        (need == "jitter" || need == "camera" ? of_host : of_device).push_back(need);
    if (!of_device.empty()) out += fmt::format("Runs where the device has {}.\n\n", joined(of_device, ", "));
    if (!of_host.empty()) out += fmt::format("Asks its host for {}.\n\n", joined(of_host, ", "));
    if (!type.jittered.empty())
        out += fmt::format("Where the host jitters, a plan with this node takes `{}` for true.\n\n",
                           joined(type.jittered, "`, `"));
    out += "| | name | what | |\n|---|---|---|---|\n";
    for (const Port& port : type.ports)
        out += fmt::format("| {} | `{}` | {} | {} |\n", port.output ? "out" : "in", port.name,
                           cell(describe(port)), cell(port.doc));
    for (const Param& param : type.params)
        out += fmt::format("| {} | `{}` | {} | {} |\n", param.constant ? "constant" : "parameter", param.name,
                           cell(describe(param)), cell(param.doc));
    for (const std::string& counter : type.counters) out += fmt::format("| counts | `{}` | | |\n", counter);
    return out + "\n";
}

std::string pipeline_section(const CheckedPipeline& pipeline) {
    std::vector<std::string> inputs, outputs;
    for (const HostInput& input : pipeline.inputs)
        inputs.push_back(fmt::format("`{}`{}", input.name, input.optional ? " (optional)" : ""));
    for (const std::string& name : pipeline.output_names()) outputs.push_back("`" + name + "`");
    std::string out = fmt::format(
        "### {}\n\n{}\n\n{}\n\n| node | type | runs if | sets |\n"
        "|---|---|---|---|\n",
        pipeline.name, paragraph(pipeline.doc),
        paragraph(fmt::format("Takes {}. Gives {}.", joined(inputs, ", "), joined(outputs, ", "))));
    for (const BoundNode& node : pipeline.nodes)
        if (!node.added)
            out += fmt::format("| {} | [{}](nodes.md#{}) | {} | {} |\n", node.id, node.type().name,
                               node.type().name, cell(node.condition), cell(settings_of(node)));
    return out + "\n";
}

std::string nodes_page(const NodeSet& nodes) {
    std::string out =
        "# Node types\nWhat a pipeline can be made of: ports, parameters and counters as their declarations "
        "say. Written\n"
        "by `penumbra nodes --format page >docs/nodes.md`; `penumbra nodes TYPE` shows one.\n\n";
    for (const std::string& name : nodes.names()) out += node_section(nodes.find(name)->type);
    return out;
}

std::string pipelines_page(const std::vector<CheckedPipeline>& pipelines) {
    std::string out =
        "# Shipped pipelines, node by node\nEach as it is after what it extends. Written by\n"
        "`penumbra check --page pipelines/*.json >docs/pipeline_list.md`; `penumbra plan NAME --size WxH` "
        "shows what\n"
        "becomes of one. Which to take: [choosing.md](choosing.md).\n\n";
    for (const CheckedPipeline& pipeline : pipelines) out += pipeline_section(pipeline);
    return out;
}

}  // namespace penumbra
