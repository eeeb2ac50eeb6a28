// SPDX-License-Identifier: MIT
#include "app/report/contenders.h"

#include <fmt/format.h>

#include <algorithm>
#include <span>

#include "app/reference_pipeline.h"
#include "app/report/study.h"
#include "app/session.h"

namespace penumbra::report {
namespace {

namespace fs = std::filesystem;

// Why a pipeline cannot be judged on a shot; nothing where it can.
std::optional<std::string> obstacle(const CheckedPipeline& pipeline, bool of_lamp) {
    for (const HostInput& input : pipeline.inputs)
        if (!input.optional && !standalone_has_input(input.name))
            return fmt::format("takes \"{}\", which only an engine can bring", input.name);
    const bool takes_lamp = pipeline.input("light");
    if (takes_lamp && !of_lamp) return "takes a light that is near, and the report is of the sun";
    if (of_lamp && !takes_lamp) return "takes no light that is near, and the report is of one";
    const std::vector<std::string> outputs = pipeline.output_names();
    if (std::ranges::find(outputs, "visibility") == outputs.end()) return "puts out no \"visibility\"";
    return std::nullopt;
}

std::optional<CheckedPipeline> checked(const std::optional<Pipeline>& pipeline, const NodeSet& nodes,
                                       Diagnostics& diagnostics) {
    return pipeline ? check(*pipeline, nodes, diagnostics) : std::nullopt;
}

bool reads_maps(const CheckedPipeline& pipeline) {
    return std::ranges::any_of(pipeline.inputs, [](const HostInput& input) {
        return input.name == "cascade_maps" || input.name == "cascade_bounds";
    });
}

// A pipeline with other numbers of rays, but those that a contender of its kind has already.
void add_plain_rays(Contenders& contenders, std::span<const uint32_t> numbers, bool proofs, bool from_text,
                    const std::string& file, const NodeSet& nodes, Diagnostics& diagnostics) {
    for (const uint32_t rays : numbers) {
        const auto is_same = [&](const Contender& c) {
            return c.plain && c.plain->proofs == proofs && c.plain->per_pixel == rays;
        };
        if (std::ranges::any_of(contenders.list, is_same)) continue;
        const std::vector<std::string> settings{fmt::format("nodes.trace.params.rays_per_pixel={}", rays)};
        auto pipeline = checked(from_text ? parse_pipeline(raw_pipeline_text, file, settings, diagnostics)
                                          : load_pipeline(file, settings, diagnostics),
                                nodes, diagnostics);
        if (!pipeline) return;
        const std::string doc =
            fmt::format("{} per pixel, not denoised: {} --set {}.",
                        rays == 1 ? "One ray" : fmt::format("{} rays", rays), file, settings.front());
        contenders.list.push_back({fmt::format("{}rays_{}", proofs ? "many_" : "", rays), file, doc,
                                   PlainRays{rays, proofs}, settings, std::move(*pipeline)});
    }
}

// The rays per pixel of the nodes that trace; nothing where there is none, or they differ.
std::optional<uint32_t> rays_per_pixel(const CheckedPipeline& pipeline) {
    std::optional<uint32_t> rays;
    for (const BoundNode& node : pipeline.nodes)
        for (size_t i = 0; i < node.params.size(); ++i)
            if (node.type().params[i].name == "rays_per_pixel") {
                std::optional<uint32_t> here;
                if (const auto* value = std::get_if<uint32_t>(&node.params[i])) here = *value;
                if (const auto* value = std::get_if<int32_t>(&node.params[i]))
                    here = static_cast<uint32_t>(*value);
                if (rays && rays != here) return std::nullopt;
                rays = here;
            }
    return rays;
}

// Whether a given file is one of the two whose rays are plain.
std::optional<PlainRays> plain_rays(const fs::path& file, const fs::path& root,
                                    const CheckedPipeline& pipeline) {
    std::error_code none;
    for (const char* plain : {"raw.json", "light_raw.json", "many_rays.json"})
        if (fs::equivalent(file, root / "pipelines" / plain, none))
            if (const auto rays = rays_per_pixel(pipeline)) return PlainRays{*rays, plain[0] == 'm'};
    return std::nullopt;
}

}  // namespace

std::optional<Contenders> open_contenders(const std::vector<std::string>& wanted, const fs::path& root,
                                          const NodeSet& nodes, Diagnostics& diagnostics, bool without_maps,
                                          bool of_lamp) {
    Contenders contenders;
    std::vector<fs::path> files;
    for (const std::string& name : wanted)
        if (const auto file = shipped_file(name, root, shipped_pipelines, diagnostics))
            files.push_back(*file);
    if (wanted.empty()) files = shipped_files(root, shipped_pipelines);
    if (files.empty() && diagnostics.empty())
        diagnostics.add({}, "--pipelines", "none given, and no folder of shipped ones is near the program");
    for (const fs::path& file : files) {
        auto pipeline = checked(load_pipeline(file, {}, diagnostics), nodes, diagnostics);
        if (!pipeline) continue;
        auto why = obstacle(*pipeline, of_lamp);
        if (!why && wanted.empty() && without_maps && reads_maps(*pipeline))
            why = "reads shadow maps, whose drawing is in no pass";
        if (why && wanted.empty()) {
            contenders.left_out.push_back({file.generic_string(), *why});
            continue;
        }
        if (why) diagnostics.add({file.string(), 0, 0}, "", *why);
        for (const Contender& other : contenders.list)
            if (other.id == pipeline->name)
                diagnostics.add({file.string(), 0, 0}, "name",
                                fmt::format("\"{}\" is the name of {} too", pipeline->name, other.file));
        contenders.list.push_back({pipeline->name,
                                   file.generic_string(),
                                   pipeline->doc,
                                   plain_rays(file, root, *pipeline),
                                   {},
                                   *pipeline});
    }
    const auto beside = [&](const char* name) {
        const fs::path path = fs::path("pipelines") / name;
        return (root == "." ? path : root / path).generic_string();
    };
    if (root.empty()) contenders.left_out.push_back({"pipelines/many_rays.json", "is not near the program"});
    if (of_lamp && !root.empty() && diagnostics.empty())  // to which there are no beams
        add_plain_rays(contenders, brute_force_rays, false, false, beside("light_raw.json"), nodes,
                       diagnostics);
    if (!of_lamp && diagnostics.empty())
        add_plain_rays(contenders, brute_force_rays, false, true, "pipelines/raw.json", nodes, diagnostics);
    if (!of_lamp && !root.empty() && diagnostics.empty())
        add_plain_rays(contenders, proved_rays, true, false, beside("many_rays.json"), nodes, diagnostics);
    if (!diagnostics.empty()) return std::nullopt;
    return contenders;
}

}  // namespace penumbra::report
