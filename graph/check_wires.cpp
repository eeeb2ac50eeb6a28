// SPDX-License-Identifier: MIT
// The third part of check(): both ends of every wire must agree on kind, format, element, layers and levels.
// A written resource takes its shape from its writer (an updater's from the name it updates), a host input
// from its readers.
#include <fmt/format.h>

#include <algorithm>

#include "graph/check_dataflow.h"
#include "graph/json_reader.h"

namespace penumbra {

namespace {

std::string phrase(PortKind kind, const Bundle* bundle = nullptr) {
    if (bundle) return "a " + bundle->kind;
    const char* article = kind == PortKind::image ? "an " : kind == PortKind::texels ? "" : "a ";
    return std::string(article) + kind_name(kind);
}

bool has_texels(PortKind kind) {
    return kind == PortKind::image || kind == PortKind::texels;
}
bool has_element(PortKind kind) {
    return kind == PortKind::buffer || kind == PortKind::block;
}

std::string format_list(std::span<const Format> formats) {
    std::string text;
    for (const Format format : formats)
        text += fmt::format("{}{}", text.empty() ? "" : ", ", info(format).name);
    return text;
}

bool lists(std::span<const Format> formats, Format format) {
    return std::ranges::find(formats, format) != formats.end();
}

// What a written resource is made of, and the port that says so.
struct Shape {
    PortKind kind = PortKind::image;
    std::optional<Format>
        format;  // of images and texels; none where the settings are wrong (reported elsewhere)
    bool layers = false, levels = false;
    std::string element;
    std::string from;
};

class WireChecker {
  public:
    WireChecker(const Dataflow& flow, Diagnostics& diagnostics) : flow_(flow), diagnostics_(diagnostics) {
        for (const ResourceSetting& setting : flow.source.resources)
            settings_.try_emplace(setting.name, &setting);
    }

    void run(std::vector<HostInput>& inputs, std::vector<CheckedResource>& resources) {
        for (const uint32_t id : flow_.by_name)
            if (flow_.resources[id].host)
                check_host_input(inputs[*resources[id].input], flow_.resources[id].readers);
        for (const uint32_t id : flow_.by_name)
            if (!flow_.resources[id].host) check_written(id, resources[id]);
        for (const ResourceSetting& setting : flow_.source.resources) check_setting(setting);
    }

  private:
    void check_host_input(HostInput& input, const std::vector<PortUse>& readers) {
        const std::string path = "inputs." + input.name;
        std::vector<Format> accepted;
        const PortUse* first = nullptr;
        for (const PortUse& reader : readers) {
            const Port& port = *reader.bound->port;
            const std::string other = first ? first->path : path;
            if (input.kind && (*input.kind != port.kind || input.bundle != port.bundle)) {
                error(reader,
                      fmt::format("\"{}\" is {} ({}), but the port takes {}", input.name,
                                  phrase(*input.kind, input.bundle), other, phrase(port.kind, port.bundle)));
                continue;
            }
            input.kind = port.kind;
            input.bundle = port.bundle;
            check_struct(reader);
            if (port.kind == PortKind::image && port.storage)
                error(reader,
                      fmt::format("\"{}\" is a host input, and host images are only sampled", input.name));
            if (has_texels(port.kind)) check_host_format(input, reader, other, accepted);
            if (first && port.element != first->bound->port->element)
                error(reader, fmt::format("takes \"{}\" as {}, but {} takes it as {}", input.name,
                                          port.element, first->path, first->bound->port->element));
            if (first && port.layers != first->bound->port->layers)
                error(reader, fmt::format("takes \"{}\" {} layers, unlike {}", input.name,
                                          port.layers ? "with" : "without", first->path));
            if (!first) first = &reader;
        }
        if (input.history && (input.kind == PortKind::block || input.kind == PortKind::bundle))
            error(input.place, path, fmt::format("{} has no history", phrase(*input.kind, input.bundle)));
        if (input.format && input.kind && !has_texels(*input.kind) && input.kind_word.empty())
            error(input.place, path, fmt::format("{} has no format", phrase(*input.kind, input.bundle)));
    }

    // A host image with a format must suit every reader; without one, some format must suit all of them.
    void check_host_format(const HostInput& input, const PortUse& reader, const std::string& other,
                           std::vector<Format>& accepted) {
        const std::vector<Format>& formats = reader.bound->port->formats;
        if (input.format) {
            if (!lists(formats, *input.format))
                error(reader, fmt::format("\"{}\" is {}, but the port accepts {}", input.name,
                                          info(*input.format).name, format_list(formats)));
            return;
        }
        if (accepted.empty()) accepted = formats;
        std::vector<Format> both;
        for (const Format format : accepted)
            if (lists(formats, format)) both.push_back(format);
        if (both.empty())
            error(reader, fmt::format("accepts {} for \"{}\", but the readers before it (from {}) accept {}",
                                      format_list(formats), input.name, other, format_list(accepted)));
        else
            accepted = both;
    }

    void error(const PortUse& use, std::string message) {
        error(use.bound->place, use.path, std::move(message));
    }
    void error(const Place& place, std::string path, std::string message) {
        diagnostics_.add(place, std::move(path), std::move(message));
    }

    void check_struct(const PortUse& use) {
        const std::string& element = use.bound->port->element;
        const bool is_struct = !element.empty() && element[0] >= 'A' && element[0] <= 'Z';
        const std::map<std::string, uint32_t>& structs = flow_.pipeline.domain->structs;
        if (!is_struct || structs.contains(element)) return;
        std::vector<std::string> names;
        for (const auto& [name, bytes] : structs) names.push_back(name);
        error(use, fmt::format("the node set has no struct \"{}\"{}", element, did_you_mean(element, names)));
    }

    const ResourceSetting* setting_of(const std::string& name) const {
        const auto found = settings_.find(name);
        return found == settings_.end() ? nullptr : found->second;
    }

    // The shape that one writer gives; an updater's comes from the name whose memory it takes over.
    std::optional<Shape> shape_from(const std::string& name, const PortUse& writer, size_t depth = 0) const {
        const Port& port = *writer.bound->port;
        if (const BoundPort* updated = flow_.updated(writer)) {
            const bool endless =
                depth > flow_.resources.size();  // names that update each other: reported as a cycle
            if (endless || updated->resource == no_resource) return std::nullopt;
            const ResourceUse& origin = flow_.resources[updated->resource];
            if (origin.writers.empty()) return std::nullopt;
            return shape_from(origin.name, origin.writers.front(), depth + 1);
        }
        Shape shape{port.kind, std::nullopt, port.layers, port.levels, port.element, writer.path};
        if (has_texels(port.kind)) {
            const ResourceSetting* setting = setting_of(name);
            const std::optional<Format> format = setting ? setting->format : std::nullopt;
            if (!format)
                shape.format = port.formats.front();
            else if (lists(port.formats, *format))
                shape.format = format;
        }
        return shape;
    }

    void check_written(uint32_t id, CheckedResource& resource) {
        const ResourceUse& use = flow_.resources[id];
        if (use.writers.empty()) return;
        for (const PortUse& writer : use.writers) check_struct(writer);
        const std::optional<Shape> shape = shape_from(use.name, use.writers.front());
        if (!shape) return;
        resource.format = shape->format.value_or(resource.format);
        for (size_t i = 1; i < use.writers.size(); ++i)
            if (const auto other = shape_from(use.name, use.writers[i]))
                compare_writers(use.name, use.writers[i], *other, *shape);
        for (const PortUse& reader : use.readers) {
            check_struct(reader);
            check_reader(use.name, reader, *shape);
        }
    }

    void compare_writers(const std::string& name, const PortUse& writer, const Shape& shape,
                         const Shape& first) {
        const bool alike = shape.kind == first.kind && shape.element == first.element &&
                           shape.layers == first.layers && shape.levels == first.levels;
        if (!alike)
            error(writer, fmt::format("makes \"{}\" {}, but {} makes it {}", name, describe(shape),
                                      first.from, describe(first)));
        else if (shape.format && first.format && shape.format != first.format)
            error(writer,
                  fmt::format("makes \"{}\" {}, but {} makes it {}; choose one in resources.{}.format", name,
                              info(*shape.format).name, first.from, info(*first.format).name, name));
    }

    static std::string describe(const Shape& shape) {
        std::string text = phrase(shape.kind);
        if (!shape.element.empty()) text += " of " + shape.element;
        if (shape.layers) text += " with layers";
        if (shape.levels) text += " with levels";
        return text;
    }

    void check_reader(const std::string& name, const PortUse& reader, const Shape& shape) {
        const Port& port = *reader.bound->port;
        if (port.kind != shape.kind)
            error(reader, fmt::format("\"{}\" is {} ({}), but the port takes {}", name, phrase(shape.kind),
                                      shape.from, phrase(port.kind, port.bundle)));
        else if (has_element(port.kind) && port.element != shape.element)
            error(reader, fmt::format("\"{}\" has elements {} ({}), but the port takes {}", name,
                                      shape.element, shape.from, port.element));
        else if (shape.format && !lists(port.formats, *shape.format))
            error(reader, fmt::format("\"{}\" is {} ({}), but the port accepts {}", name,
                                      info(*shape.format).name, shape.from, format_list(port.formats)));
        else if (port.layers != shape.layers)
            error(reader, fmt::format("\"{}\" has {} ({}), but the port takes {}", name,
                                      shape.layers ? "layers" : "one layer", shape.from,
                                      port.layers ? "layers" : "one layer"));
        else if (port.levels && !shape.levels)
            error(reader,
                  fmt::format("\"{}\" has one level ({}), but the port takes a mip chain", name, shape.from));
    }

    // A format that the pipeline chooses must be one that every writer offers.
    void check_setting(const ResourceSetting& setting) {
        const ResourceUse* found = flow_.find(setting.name);
        if (!setting.format || !found || found->host) return;
        const std::string path = fmt::format("resources.{}.format", setting.name);
        for (const PortUse& writer : found->writers) {
            const Port& port = *writer.bound->port;
            if (!has_texels(port.kind))
                error(setting.format_place, path, fmt::format("{} is {}", writer.path, phrase(port.kind)));
            else if (const BoundPort* updated = flow_.updated(writer);
                     updated && updated->resource != no_resource)
                error(setting.format_place, path,
                      fmt::format("{} takes over the memory of \"{}\", and its format", writer.path,
                                  flow_.resources[updated->resource].name));
            else if (!lists(port.formats, *setting.format))
                error(setting.format_place, path,
                      fmt::format("{} writes {}, not {}", writer.path, format_list(port.formats),
                                  info(*setting.format).name));
        }
    }

    const Dataflow& flow_;
    Diagnostics& diagnostics_;
    std::map<std::string_view, const ResourceSetting*> settings_;
};

}  // namespace

void check_wires(const Dataflow& dataflow, std::vector<HostInput>& inputs,
                 std::vector<CheckedResource>& resources, Diagnostics& diagnostics) {
    WireChecker(dataflow, diagnostics).run(inputs, resources);
}

}  // namespace penumbra
