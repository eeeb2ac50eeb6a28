// SPDX-License-Identifier: MIT
// Channel names follow what a resource is: Y for one channel, R,G,B,A for colour, X,Y,Z,W for vectors, Z for
// depth in metres, W for words.
#include "app/outputs.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "graph/fnv1a.h"
#include "graph/read_text.h"
#include "host/images/texels.h"

namespace penumbra {

struct OutputWriter::Texels {
    PlanarImage image;
    uint64_t hash = 0;
};

namespace {

using Texels = OutputWriter::Texels;

// As many as a format can have; those that it has not are not used.
std::vector<std::string> channel_names(const std::string& resource, Format format) {
    if (info(format).kind == FormatClass::uint) return {"W", "W2", "W3", "W4"};
    switch (info(format).channels) {
        case 1:
            return {"Y"};
        case 2:
            return {"X", "Y"};
        default:
            break;
    }
    const bool vectors =
        resource == "motion" || resource == "normal" || resource == "guide_normal" || resource == "moments";
    return vectors ? std::vector<std::string>{"X", "Y", "Z", "W"}
                   : std::vector<std::string>{"R", "G", "B", "A"};
}

// Three channels of floats that are no vectors are radiance; but for what is a share of it, of one light or
// several.
bool is_light(const std::string& resource, Format format) {
    return info(format).kind == FormatClass::real && channel_names(resource, format)[0] == "R" &&
           !resource.starts_with("transmittance");
}

// The image that a buffer of words stands for: tiles of 8x4 or 8x8 pixels where the count says so, else one
// row.
Extent buffer_extent(const Plan& plan, const PlanResource& r, Format format) {
    const uint32_t tiles_x = (plan.extent.width + 7) / 8;
    const uint64_t words = r.count * r.element_bytes / info(format).bytes;
    for (const uint32_t tile_height : {4u, 8u}) {
        const uint32_t tiles_y = (plan.extent.height + tile_height - 1) / tile_height;
        if (words == uint64_t{tiles_x} * tiles_y) return {tiles_x, tiles_y};
    }
    return {static_cast<uint32_t>(words), 1};
}

// Of one texel; elements that are structs are shown word by word.
Format buffer_format(const PlanResource& r) {
    if (r.kind == PortKind::texels) return r.format;
    if (r.element == "uvec2") return Format::rg32ui;
    if (r.element == "uvec4") return Format::rgba32ui;
    if (r.element == "vec4") return Format::rgba32f;
    if (r.element == "f32") return Format::r32f;
    return Format::r32ui;
}

// Null where the graph has captured none of this name.
const PlanResource* captured_resource(const Session& session, const std::string& name) {
    const Plan& plan = session.plan();
    for (const PlanPass& pass : plan.passes)
        if (pass.kind == PassKind::capture && pass.node == name)
            return &plan.resources[pass.bindings.front().index];
    return nullptr;
}

// Of each layer.
std::vector<Texels> captured_texels(const Session& session, const std::string& name) {
    const Plan& plan = session.plan();
    const PlanResource* const resource = captured_resource(session, name);
    if (!resource) throw FileError(fmt::format("\"{}\" was not captured", name));
    const PlanResource& r = *resource;
    const bool image = r.kind == PortKind::image;
    const Format format = image ? r.format : buffer_format(r);
    const Extent extent = image ? r.extent : buffer_extent(plan, r, format);
    const std::span<const std::byte> all = session.view().captured(name);
    std::vector<std::string> names = channel_names(name, format);
    // What a pipeline puts out is a picture, in which a fourth channel would be taken for how opaque it is.
    if (image && std::ranges::find(plan.outputs, name, &PlanOutput::name) != plan.outputs.end())
        names.resize(std::min(names.size(), size_t{3}));
    std::vector<Texels> layers;
    for (uint32_t layer = 0; layer < r.layers; ++layer) {
        const auto bytes = all.subspan(layer * (all.size() / r.layers), all.size() / r.layers);
        layers.push_back({decode_texels(format, extent.width, extent.height, bytes, names), fnv1a(bytes)});
        layers.back().image.light = image && is_light(name, format);
    }
    return layers;
}

// What the files of a layer are called, after their resource: by its light where each is of one, of a
// pipeline that takes them all in one input.
std::string name_of_layer(const Session& session, size_t layer, const PlanResource& resource) {
    if (!resource.layered) return "";
    const std::vector<std::string>& lights = session.host().light_names();
    const bool of_lights =
        std::ranges::find(session.plan().slots, "lights", &HostSlot::name) != session.plan().slots.end();
    if (of_lights && lights.size() == resource.layers) return "." + lights[layer];
    return resource.layers == 1 ? "" : fmt::format(".{}", layer);
}

// Reverse-Z depth to metres along the view axis, 0 = sky. The last element of a projection tells the two
// kinds apart.
float metres_of_depth(const Camera& camera, float depth) {
    if (!(depth > 0)) return 0;
    const auto& m = camera.clip_from_view;
    const bool orthographic = m[15] == 1;
    return static_cast<float>(orthographic ? (m[14] - depth) / m[10] : camera.near_m / depth);
}

Texels host_texels(Device& device, const Session& session, const std::string& name) {
    if (std::ranges::count(host_image_names(), name) == 0)
        throw FileError(fmt::format("\"{}\" was not captured", name));
    const GBufferImages& images = session.host().images();
    const GpuImage& image = name == "depth"    ? images.depth
                            : name == "normal" ? images.normal
                            : name == "motion" ? images.motion
                                               : images.albedo;
    const Format format = name == "depth"    ? Format::r32f
                          : name == "normal" ? Format::rgba32f
                          : name == "motion" ? Format::rgba16f
                                             : Format::rgba8;
    const std::vector<std::byte> bytes =
        read_image(device, image.get(), image.format, image.extent, GBuffer::final_layout);
    std::vector<std::string> names = channel_names(name, format);
    if (names.size() > 3) names.pop_back();  // in which these images hold nothing
    Texels texels{decode_texels(format, image.extent.width, image.extent.height, bytes, names), fnv1a(bytes)};
    if (name == "depth") {
        Plane& plane = texels.image.planes.front();
        plane.name = "Z";
        const Camera camera = camera_at(session.host().shot(), 0, 1);  // the lens is the same in every frame
        for (float& value : plane.values) value = metres_of_depth(camera, value);
    }
    return texels;
}

void write_png(const std::filesystem::path& path, const PlanarImage& image) {
    const Plane& first = image.planes.front();
    if (first.type == PlaneType::uint) {  // the share of set bits: how much of a tile is occluded
        std::vector<float> values;
        for (const uint32_t word : first.words)
            values.push_back(static_cast<float>(std::popcount(word)) / 32.0f);
        return write_png_linear(path, image.width, image.height, values);
    }
    if (image.planes.size() < 3 || first.name != "R") {
        if (first.name != "Z" && first.name != "X")
            return write_png_linear(path, image.width, image.height, first.values);
        std::vector<float> rgb;  // vectors: -1..1 to 0..1; depth: 1 / (1 + metres)
        for (size_t i = 0; i < first.values.size(); ++i)
            for (size_t c = 0; c < 3; ++c) {
                const Plane& plane = image.planes[std::min(c, image.planes.size() - 1)];
                rgb.push_back(first.name == "Z" ? (plane.values[i] > 0 ? 1 / (1 + plane.values[i]) : 0)
                                                : 0.5f + 0.5f * plane.values[i]);
            }
        return write_png_color(path, image.width, image.height, rgb);
    }
    std::vector<float> rgb(3 * first.values.size());
    for (size_t i = 0; i < first.values.size(); ++i)
        for (size_t c = 0; c < 3; ++c) rgb[3 * i + c] = image.planes[c].values[i];
    (image.light ? write_png_light : write_png_color)(path, image.width, image.height, rgb);
}

void summarise(const PlanarImage& image, WrittenOutput& out) {
    out.min = std::numeric_limits<double>::infinity();
    out.max = -out.min;
    const auto see = [&](double value) {
        out.min = std::min(out.min, value);
        out.max = std::max(out.max, value);
    };
    for (const Plane& plane : image.planes) {
        out.channels += (out.channels.empty() ? "" : ",") + plane.name;
        for (const uint32_t word : plane.words) see(word);
        for (const float value : plane.values) {
            out.nonfinite += !std::isfinite(value);
            if (std::isfinite(value)) see(value);
        }
    }
}

}  // namespace

std::span<const std::string> host_image_names() {
    static const std::array<std::string, 4> names{"depth", "normal", "motion", "albedo"};
    return names;
}

bool is_host_image(const CheckedPipeline& pipeline, const std::string& name) {
    const CheckedResource* const made = pipeline.resource(name);
    return std::ranges::count(host_image_names(), name) > 0 && (!made || made->input);
}

bool is_captured(const Session& session, const std::string& name) {
    return captured_resource(session, name) != nullptr;
}

PlanarImage captured_image(const Session& session, const std::string& resource) {
    return captured_texels(session, resource).front().image;
}

PlanarImage host_image(Device& device, const Session& session, const std::string& name) {
    return host_texels(device, session, name).image;
}

WrittenFrames frames_of_report(const std::filesystem::path& folder) {
    namespace fs = std::filesystem;
    WrittenFrames frames;
    std::error_code failure;
    const auto report = nlohmann::json::parse(read_text(folder / "report.json").value_or(""), nullptr, false);
    const auto reported = fs::last_write_time(folder / "report.json", failure);
    if (failure || !report.is_object() || !report.contains("penumbra") || !report.contains("outputs"))
        return frames;
    for (const auto& output : report["outputs"]) {
        if (!output.is_object() || !output.contains("file") || !output["file"].is_string()) continue;
        const fs::path name(output["file"].get<std::string>());
        if (name != name.filename() || name.extension() != ".exr") continue;
        for (const char* ending : {".exr", ".png"}) {
            const fs::path file = folder / fs::path(name).replace_extension(ending);
            if (!fs::is_regular_file(fs::symlink_status(file, failure))) continue;
            const auto time = fs::last_write_time(file, failure);
            if (!failure && time <= reported) frames.emplace(file, time);
        }
    }
    return frames;
}

void OutputWriter::write(const Session& session, const std::string& resource, uint32_t frame) {
    const std::vector<Texels> layers = is_captured(session, resource)
                                           ? captured_texels(session, resource)
                                           : std::vector{host_texels(device_, session, resource)};
    const std::vector<std::string> files = names(session, resource, frame);
    for (size_t i = 0; i < layers.size(); ++i) write(layers[i], resource, files[i], frame);
}

std::vector<std::string> OutputWriter::names(const Session& session, const std::string& resource,
                                             uint32_t frame) {
    const PlanResource* const captured = captured_resource(session, resource);
    std::vector<std::string> out;
    for (size_t i = 0; i < (captured ? captured->layers : 1); ++i)
        out.push_back(
            fmt::format("{}{}.{:04}", resource, captured ? name_of_layer(session, i, *captured) : "", frame));
    return out;
}

void OutputWriter::write(const Texels& texels, const std::string& resource, const std::string& name,
                         uint32_t frame) {
    WrittenOutput out;
    out.resource = resource;
    out.frame = frame;
    out.hash = texels.hash;
    summarise(texels.image, out);
    out.file = name + ".exr";
    write_exr(folder_ / out.file, texels.image);
    write_png(folder_ / (name + ".png"), texels.image);
    written_.push_back(std::move(out));
}

}  // namespace penumbra
