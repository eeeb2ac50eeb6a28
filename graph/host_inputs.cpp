// SPDX-License-Identifier: MIT
// The host's word comes first, then the pipeline's, then the readers': what the host brings must be what the
// others accept.
#include "graph/host_inputs.h"

#include <fmt/format.h>

#include <algorithm>

namespace penumbra {
namespace {

struct Reader {
    const BoundNode* node;
    const BoundPort* bound;

    bool accepts(Format format) const {
        return std::ranges::find(bound->port->formats, format) != bound->port->formats.end();
    }
};

std::vector<Reader> readers_of(const CheckedPipeline& pipeline, const Selection& selection, size_t input) {
    std::vector<Reader> readers;
    for (const SelectedNode& selected : selection.nodes)
        for (size_t p = 0; p < selected.sources.size(); ++p) {
            const BoundPort& bound = selected.node->ports[p];
            if (selected.sources[p] == Source::host && pipeline.resources[bound.resource].input == input)
                readers.push_back({selected.node, &bound});
        }
    return readers;
}

// An output that has a layer for each row of an input; null: there is none.
const std::string* layered_by(const CheckedPipeline& pipeline, const Selection& selection, size_t input) {
    for (const SelectedNode& selected : selection.nodes)
        for (size_t p = 0; p < selected.sources.size(); ++p) {
            const BoundPort& bound = selected.node->ports[p];
            const std::optional<uint32_t> rows = bound.port->layers_of.port;
            if (rows && selected.sources[p] != Source::none &&
                pipeline.resources[selected.node->ports[*rows].resource].input == input)
                return &pipeline.resources[bound.resource].name;
        }
    return nullptr;
}

// check() has found that all readers of the pipeline have one in common.
Format common_format(const std::vector<Reader>& readers) {
    const std::vector<Format>& formats = readers.front().bound->port->formats;
    return *std::ranges::find_if(formats, [&](Format format) {
        return std::ranges::all_of(readers, [&](const Reader& r) { return r.accepts(format); });
    });
}

}  // namespace

std::vector<bool> inputs_left_out(const CheckedPipeline& pipeline, const Target& target,
                                  Diagnostics& diagnostics) {
    std::vector<std::string> names;
    for (const HostInput& input : pipeline.inputs) names.push_back(input.name);
    const auto known = [&](const std::string& name) {
        const bool found = std::ranges::find(names, name) != names.end();
        if (!found)
            diagnostics.add({pipeline.file}, "inputs",
                            fmt::format("the host speaks of \"{}\", which is no input{}", name,
                                        did_you_mean(name, names)));
        return found;
    };
    for (const auto& [name, resource] : target.inputs) known(name);
    std::vector<bool> left_out(pipeline.inputs.size());
    for (const std::string& name : target.left_out) {
        if (!known(name)) continue;
        const auto i = static_cast<size_t>(std::ranges::find(names, name) - names.begin());
        left_out[i] = true;
        if (!pipeline.inputs[i].optional)
            diagnostics.add(pipeline.inputs[i].place, fmt::format("inputs.{}.optional", name),
                            "the host leaves it out, and it is not optional");
    }
    return left_out;
}

std::vector<HostResource> resolve_inputs(const CheckedPipeline& pipeline, const Selection& selection,
                                         const Target& target, Diagnostics& diagnostics) {
    std::vector<HostResource> resources(pipeline.inputs.size());
    for (size_t i = 0; i < resources.size(); ++i) {
        const HostInput& input = pipeline.inputs[i];
        const auto error = [&](const char* key, std::string message) {
            diagnostics.add(input.place, fmt::format("inputs.{}.{}", input.name, key), std::move(message));
        };
        const std::vector<Reader> readers = readers_of(pipeline, selection, i);
        if (readers.empty() || (input.kind != PortKind::image && input.kind != PortKind::texels)) continue;
        const bool list = input.kind == PortKind::texels && input.extent == HostInput::Extent::any;
        uint32_t row = 1;
        for (const Reader& reader : readers) row = std::max(row, reader.bound->port->row);
        const Extent wanted = input.extent == HostInput::Extent::fixed ? Extent{input.size[0], input.size[1]}
                              : list                                   ? Extent{row, 1}
                                                                       : target.extent;
        const auto brought = target.inputs.find(input.name);
        HostResource& r = resources[i];
        if (brought != target.inputs.end())
            r = brought->second;
        else
            r = {input.format ? *input.format : common_format(readers), wanted};
        if (input.kind == PortKind::image && (r.extent.width == 0 || r.extent.height == 0 || r.layers == 0))
            error("extent", fmt::format("the host brings an image of {}x{} and {} layers", r.extent.width,
                                        r.extent.height, r.layers));
        const std::string* layered = list ? layered_by(pipeline, selection, i) : nullptr;
        if (layered && (brought == target.inputs.end() || r.extent.height == 0))
            error("extent", fmt::format("\"{}\" has a layer for each of its rows: say how many, as in "
                                        "Target::inputs[\"{}\"] = {{Format::{}, {{{}, ROWS}}}}",
                                        *layered, input.name, info(r.format).name, row));
        if (input.format && *input.format != r.format)
            error("format", fmt::format("the host brings {}", info(r.format).name));
        for (const Reader& reader : readers) {
            const Port& port = *reader.bound->port;
            const auto refuse = [&](const std::string& why) {
                diagnostics.add(reader.bound->place,
                                fmt::format("nodes.{}.in.{}", reader.node->id, port.name),
                                fmt::format("the host brings \"{}\" {}", input.name, why));
            };
            if (!reader.accepts(r.format))
                refuse(fmt::format("as {}, which this port does not accept", info(r.format).name));
            if (r.layers != 1 && !port.layers)
                refuse(fmt::format("with {} layers, and this port takes no array", r.layers));
            if (port.row && r.extent.width != port.row)
                refuse(fmt::format("in rows of {} texels, which are of {} here", r.extent.width, port.row));
        }
        if (input.extent != HostInput::Extent::any && r.extent != wanted)
            error("extent", fmt::format("the host brings {}x{}, the pipeline asks for {}x{}{}",
                                        r.extent.width, r.extent.height, wanted.width, wanted.height,
                                        input.extent == HostInput::Extent::frame
                                            ? ", the frame's own size; what is bound to it may be larger"
                                            : ""));
    }
    return resources;
}

}  // namespace penumbra
