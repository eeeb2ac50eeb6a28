// SPDX-License-Identifier: MIT
// The host's word comes first, then the pipeline's, then the readers': what the host brings must be what the
// others accept. A copy needs a format that can be stored and holds every value of the original: its own, or
// 32-bit floats.
#include "graph/host_inputs.h"

#include <fmt/format.h>

#include <algorithm>

namespace penumbra {
namespace {

struct Reader {
    const SelectedNode* node;
    const BoundPort* bound;
};

bool lists(const std::vector<Format>& formats, Format format) {
    return std::find(formats.begin(), formats.end(), format) != formats.end();
}

class Resolver {
  public:
    Resolver(const CheckedPipeline& pipeline, const Selection& selection, const Target& target,
             Diagnostics& diagnostics)
        : pipeline_(pipeline), selection_(selection), target_(target), diagnostics_(diagnostics) {}

    ResolvedInputs run() {
        check_left_out();
        for (const HostInput& input : pipeline_.inputs) {
            const std::vector<Reader> readers = readers_of(input.name, Source::host);
            const bool texels = input.kind == PortKind::image || input.kind == PortKind::texels;
            if (readers.empty() || !texels) {
                if (!readers_of(kept_copy(input.name), Source::internal).empty())
                    error(input, "history", fmt::format("a {} cannot be copied", kind_name(*input.kind)));
                continue;
            }
            const HostResource resource = resolve(input, readers);
            resolve_copy(input, resource.format);
            result_.brought.emplace(input.name, resource);
        }
        return std::move(result_);
    }

  private:
    void error(const HostInput& input, const char* key, const std::string& message) {
        diagnostics_.add(input.place, fmt::format("inputs.{}.{}", input.name, key), message);
    }

    void check_left_out() {
        for (const std::string& name : target_.left_out) {
            const auto input = std::find_if(pipeline_.inputs.begin(), pipeline_.inputs.end(),
                                            [&](const HostInput& i) { return i.name == name; });
            if (input != pipeline_.inputs.end() && !input->optional)
                error(*input, "optional", "the host leaves it out, and it is not optional");
        }
    }

    std::vector<Reader> readers_of(const std::string& name, Source source) const {
        std::vector<Reader> readers;
        for (const SelectedNode& node : selection_.nodes)
            for (const Connection& c : node.ports) {
                if (!c.bound || c.bound->port->output || c.source != source) continue;
                if ((source == Source::host ? c.bound->resource : c.resource) == name)
                    readers.push_back({&node, c.bound});
            }
        return readers;
    }

    HostResource resolve(const HostInput& input, const std::vector<Reader>& readers) {
        HostResource r;
        const auto brought = target_.inputs.find(input.name);
        const bool known = brought != target_.inputs.end();
        if (known)
            r = brought->second;
        else
            r.extent = input.extent == HostInput::Extent::fixed ? Extent{input.size[0], input.size[1]}
                                                                : target_.extent;
        if (!known) r.format = input.format.value_or(common_format(readers));
        if (input.format && *input.format != r.format)
            error(input, "format", fmt::format("the host brings {}", info(r.format).name));
        for (const Reader& reader : readers)
            if (!lists(reader.bound->port->formats, r.format)) refuse(input, reader, r.format);
        const Extent wanted =
            input.extent == HostInput::Extent::fixed ? Extent{input.size[0], input.size[1]} : target_.extent;
        if (input.extent != HostInput::Extent::any && r.extent != wanted)
            error(input, "extent",
                  fmt::format("the host brings {}x{}, the pipeline asks for {}x{}", r.extent.width,
                              r.extent.height, wanted.width, wanted.height));
        return r;
    }

    // check() has found that all readers of the pipeline have one in common.
    static Format common_format(const std::vector<Reader>& readers) {
        for (const Format format : readers.front().bound->port->formats)
            if (std::all_of(readers.begin(), readers.end(),
                            [&](const Reader& r) { return lists(r.bound->port->formats, format); }))
                return format;
        return readers.front().bound->port->formats.front();
    }

    void refuse(const HostInput& input, const Reader& reader, Format format) {
        const std::string& id = reader.node->node->id;
        if (id == kept_copy(input.name))
            return error(input, "history", fmt::format("{} cannot be copied", info(format).name));
        diagnostics_.add(reader.bound->place, fmt::format("nodes.{}.in.{}", id, reader.bound->port->name),
                         fmt::format("the host brings \"{}\" as {}, which this port does not accept",
                                     input.name, info(format).name));
    }

    void resolve_copy(const HostInput& input, Format format) {
        const std::vector<Reader> readers = readers_of(kept_copy(input.name), Source::internal);
        if (readers.empty()) return;
        const BoundPort* copied = nullptr;
        for (const SelectedNode& node : selection_.nodes)
            for (const Connection& c : node.ports)
                if (c.bound && c.bound->port->output && c.resource == kept_copy(input.name)) copied = c.bound;
        const FormatInfo& of = info(format);
        Format kept = format;
        if (!lists(copied->port->formats, format) && of.channels <= 2)
            kept = of.channels == 1 ? Format::r32f : Format::rg32f;
        if (input.kind != PortKind::image || of.kind == FormatClass::uint ||
            !lists(copied->port->formats, kept))
            return error(input, "history",
                         fmt::format("{} {} cannot be copied", of.name, kind_name(*input.kind)));
        for (const Reader& reader : readers) {
            if (reader.bound->port->layers)
                return error(input, "history", "an image with layers cannot be copied");
            if (lists(reader.bound->port->formats, kept)) continue;
            diagnostics_.add(reader.bound->place,
                             fmt::format("nodes.{}.in.{}", reader.node->node->id, reader.bound->port->name),
                             fmt::format("the copy that keeps \"{}\" is {}, which this port does not accept",
                                         input.name, info(kept).name));
        }
        result_.kept[kept_copy(input.name)] = kept;
    }

    const CheckedPipeline& pipeline_;
    const Selection& selection_;
    const Target& target_;
    Diagnostics& diagnostics_;
    ResolvedInputs result_;
};

}  // namespace

ResolvedInputs resolve_inputs(const CheckedPipeline& pipeline, const Selection& selection,
                              const Target& target, Diagnostics& diagnostics) {
    return Resolver(pipeline, selection, target, diagnostics).run();
}

}  // namespace penumbra
