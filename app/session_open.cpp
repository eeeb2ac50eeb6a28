// SPDX-License-Identifier: MIT
// How a session is opened: what the pipeline asks for is found in the shot, and what is missing, or more than
// the device has, is said before anything of the pipeline is allocated.
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <iterator>

#include "app/commands.h"
#include "app/fact_list.h"
#include "app/session.h"
#include "app/sleeping_lights.h"
#include "app/validate.h"
#include "host/materials/environment.h"
#include "host/materials/environment_lots.h"
#include "host/shots/model_lights.h"
#include "penumbra/requirements.h"

namespace penumbra {

struct EnvironmentInput {
    std::optional<EnvironmentMap> map;          // none: nobody looks at one, or there is nothing to be seen
    std::vector<std::array<uint32_t, 4>> lots;  // that rays are drawn by
};

namespace {

constexpr uint64_t kept_bytes_per_tile = 512;  // kept_masks of nodes/budget/retain.json

DeviceTable table_for(const Device& device, const SessionOptions& options) {
    DeviceTable table = device_table(handles_of(device));
    table.cpu = options.cpu.value_or(table.cpu);
    table.features = features_of(device);
    return table;
}

bool fits_axis(std::array<uint32_t, 2> size, const DeviceTable& table, const char* path,
               Diagnostics& diagnostics) {
    if (std::max(size[0], size[1]) <= table.max_image_extent) return true;
    diagnostics.add({}, path,
                    fmt::format("{}x{} exceeds the device's largest image, {} per axis", size[0], size[1],
                                table.max_image_extent));
    return false;
}

// The G-buffer and `more` bytes.
bool fits_memory(std::array<uint32_t, 2> size, uint64_t more, const char* what, const DeviceTable& table,
                 Diagnostics& diagnostics) {
    const uint64_t bytes = uint64_t{size[0]} * size[1] * gbuffer_bytes_per_pixel() + more;
    if (bytes <= table.memory_bytes) return true;
    diagnostics.add(
        {}, "size",
        fmt::format("{}x{} takes {} MiB for {}, {} more than the device's {}", size[0], size[1], bytes >> 20,
                    what, (bytes - table.memory_bytes) >> 20, table.memory_bytes >> 20));
    return false;
}

// Whether the G-buffer has them.
bool has_surfaces(const CheckedPipeline& pipeline) {
    return pipeline.input("material") || pipeline.input("emissive");
}

std::unique_ptr<StandaloneHost> make_host(Device& device, const CheckedPipeline& pipeline, Shot shot,
                                          std::shared_ptr<const Scene> scene, const SessionLights& lights,
                                          const SessionOptions& options) {
    StandaloneOptions host{options.size, 1, false, options.cascade_size};
    host.light = lights.chosen.name;
    host.lights = lights.names;
    host.steered = options.steered;
    host.emitters = pipeline.input("emitters");
    host.materials = has_surfaces(pipeline);
    try {
        return std::make_unique<StandaloneHost>(device, std::move(shot), std::move(scene), host);
    } catch (const VulkanError& error) {  // what a call says of itself does not say that the frame is large
        throw VulkanError(error.result(),
                          fmt::format("at {}x{}: {}", options.size[0], options.size[1], error.what()));
    }
}

// Facts that were given are kept, whatever the scene says.
Facts facts_of(const StandaloneHost& host, const SessionOptions& options) {
    Facts facts = options.facts;
    if (options.steered)  // what a camera or a sun that somebody steers may come to
        facts.merge(Facts{{"moves", true}, {"sun_moves", true}, {"sun_up", true}});
    facts.merge(host.facts());
    return facts;
}

// Brings what there is of the environment to the target; false after an error.
bool bring_environment(const CheckedPipeline& pipeline, EnvironmentInput& environment, Target& target,
                       std::vector<std::string>& warnings, Diagnostics& diagnostics) {
    const HostInput* taken = pipeline.input("environment");
    if (environment.map && taken->optional && is_black(*environment.map)) {
        target.left_out.insert("environment");
        environment.map.reset();
    }
    if (environment.map) {
        const std::array<uint32_t, 2> size{environment.map->width, environment.map->height};
        target.inputs["environment"] = {Format::rgba32f, {size[0], size[1]}};
        if (!fits_axis(size, target.device, "environment", diagnostics)) return false;
    }
    const HostInput* by_lots = pipeline.input("environment_lots");
    if (!by_lots) return true;
    if (environment.map) environment.lots = environment_lots(*environment.map);
    if (!environment.lots.empty() && environment.lots.size() <= target.device.max_texel_elements) {
        target.inputs["environment_lots"] = {Format::rgba32ui,
                                             {static_cast<uint32_t>(environment.lots.size()), 1}};
        target.left_out.erase("environment_lots");
        return true;
    }
    const std::string too_many =
        fmt::format("the environment has {} bright texels, more than the device's texel buffers of {}",
                    environment.lots.size(), target.device.max_texel_elements);
    if (by_lots->optional) {
        if (!environment.lots.empty()) warnings.push_back(too_many + ": rays are not drawn by them");
        return true;
    }
    diagnostics.add(by_lots->place, "inputs.environment_lots",
                    (!pipeline.input("environment") ? "there are none without an input \"environment\""
                     : environment.lots.empty()     ? "there are none: the sky is even"
                                                    : too_many) +
                        std::string(" (\"optional\": true)"));
    return false;
}

// To a pipeline that can do without: where the camera stands still, or somebody steers it, who may let it.
// Masks are kept in a buffer that not every device can have of a large image.
void bring_moved_boxes(const CheckedPipeline& pipeline, const Shot& shot, const SessionOptions& options,
                       Target& target) {
    const HostInput* taken = pipeline.input("moved_boxes");
    if (!taken) return;
    const uint64_t tiles = uint64_t{(target.extent.width + 7) / 8} * ((target.extent.height + 3) / 4);
    const bool fits = tiles * kept_bytes_per_tile <= target.device.max_storage_bytes;
    if (!taken->optional || (fits && (options.steered || !camera_moves(shot))))
        target.left_out.erase("moved_boxes");
}

// Nothing after an error.
std::optional<Plan> make_plan(const CheckedPipeline& pipeline, const NodeSet& nodes, const Target& target,
                              const SessionOptions& options, Diagnostics& diagnostics) {
    CompileOptions how;
    how.alias = options.alias;
    how.poison = options.poison.has_value();
    how.captures = options.captures;
    if (options.optimum) how.optimum_search_nodes = render_search_nodes;
    if (!options.validate) return compile(pipeline, target, how, diagnostics);
    const std::optional<CheckedPipeline> validating = with_validation(pipeline, nodes, diagnostics);
    return validating ? compile(*validating, target, how, diagnostics) : std::nullopt;
}

// What the device lacks of what the plan's shaders need.
void check_device_has(const Plan& plan, const Device& device, Diagnostics& diagnostics) {
    for (const Requirement& r : unmet(plan, handles_of(device)))
        diagnostics.add(
            {}, r.why,
            fmt::format("{} lacks what this needs: {} {}", device.info().name, kind_name(r.kind), r.name));
}

}  // namespace

DeviceHandles handles_of(const Device& device) {
    return {device.instance(),     device.physical(),     device.get(),
            device.queue_family(), vkGetInstanceProcAddr, {},
            device.names_objects()};
}

std::set<std::string> features_of(const Device& device) {
    std::set<std::string> features;
    if (device.caps().ray_query) features.insert("ray_query");
    if (device.caps().storage8) features.insert("storage8");
    return features;
}

void Session::make_view(Plan plan, const SessionOptions& options) {
    const auto before = std::chrono::steady_clock::now();
    auto program = std::make_shared<Program>(handles_of(device_), std::make_shared<Plan>(std::move(plan)));
    view_ = std::make_unique<View>(program, ViewOptions{1, options.poison, options.timestamps});
    program_ms_ =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - before).count();
    set_param("seed", seed_);
}

void Session::make_resources(const SessionOptions& options, KeptScene& kept, const SessionLights& lights,
                             TexelsAs as, const EnvironmentInput& environment) {
    const auto needs = [&](std::string_view slot) { return reads(plan(), slot); };
    const Scene& scene = host_->scene();
    HostResources& r = resources_;
    const auto told = [&](double share) {
        if (options.doing) options.doing("building the tree of triangles", share);
    };
    told(0);
    if (needs("scene.nodes") || needs("scene.nodes_words") || needs("neighbours"))
        r.bvh = kept.tree(device_, needs("neighbours"), as, told);
    if (needs("scene.tlas")) r.tlas = std::make_unique<SceneTlas>(device_, scene, 0, as);
    if (needs("surfaces") || needs("surface_texels")) {
        r.surfaces = std::make_unique<HitSurfaces>(device_, scene);
        update_surfaces(0, 0);
    }
    if (needs("translucents") || needs("translucent_texels"))
        r.translucents = std::make_unique<TranslucentTree>(device_, scene, 0);
    if (needs("environment")) r.environment = upload_environment(device_, *environment.map);
    if (needs("environment_lots"))
        r.environment_lots =
            upload_texels_as(TexelsAs::texels, device_, std::as_bytes(std::span(environment.lots)),
                             VK_FORMAT_R32G32B32A32_UINT, "what rays to the environment are drawn by");
    if (const auto maps = plan().slot(needs("cascade_maps") ? "cascade_maps" : "cascade_bounds"))
        r.cascade_maps = std::make_unique<CascadeMaps>(device_, scene, options.cascade_size,
                                                       plan().slots[*maps].layers, needs("cascade_bounds"));
    r.blocks = std::make_unique<HostBlocks>(device_, lights.each ? lights.names : std::vector<std::string>{},
                                            lights.together ? lights.names.size() : 0,
                                            reads(plan(), "emitters") ? host_->emitters().size() : 0);
}

std::unique_ptr<Session> Session::open(Device& device, const NodeSet& nodes, const CheckedPipeline& pipeline,
                                       Shot shot, const SessionOptions& options, Diagnostics& diagnostics,
                                       std::vector<std::string>& warnings) {
    shot.size = options.size;  // analytic scenes measure their camera in pixels
    const auto lights = choose_session_lights(pipeline, shot, options.light, diagnostics);
    if (!lights) return nullptr;
    const auto doing = [&](const char* what) {
        if (options.doing) options.doing(what, 0);
    };
    KeptScene own;
    KeptScene& kept = options.kept ? *options.kept : own;
    doing("reading the model");
    auto scene = kept.scene(shot, diagnostics, warnings);
    if (!scene || !place_model_lights(shot, *scene, diagnostics)) return nullptr;

    doing("copying it to the device");
    const DeviceTable table = table_for(device, options);
    if (!fits_axis(options.size, table, "size", diagnostics) ||
        !fits_memory(options.size, 0, "the G-buffer alone", table, diagnostics))
        return nullptr;
    EnvironmentInput environment;
    if (pipeline.input("environment") && !(environment.map = make_environment(shot, diagnostics)))
        return nullptr;
    std::ranges::move(texture_warnings(scene->model().materials, scene->model().textures,
                                       has_surfaces(pipeline), device.limits().maxImageDimension2D),
                      std::back_inserter(warnings));
    auto session = std::unique_ptr<Session>(new Session(device, options, options.seed.value_or(shot.seed)));
    // Whether to jitter is known from the plan, and the plan needs the scene's facts: the host is made in
    // between.
    session->host_ = make_host(device, pipeline, std::move(shot), std::move(scene), *lights, options);
    StandaloneHost& host = *session->host_;
    const bool maps = pipeline.input("cascade_maps") || pipeline.input("cascade_bounds");
    Target target =
        standalone_target(pipeline, table, options.largest.value_or(options.size), facts_of(host, options),
                          {options.cascade_size, options.cascade_size}, maps ? host.cascade_layers() : 1);
    if (lights->together) {
        target.inputs["lights"] = {Format::rgba32ui, {5, static_cast<uint32_t>(lights->names.size())}};
        target.left_out.erase("lights");
    }
    if (pipeline.input("emitters") && host.emitters().size() > 0) {
        target.inputs["emitters"] = {Format::rgba32ui,
                                     {2 * static_cast<uint32_t>(host.emitters().size()), 1}};
        target.left_out.erase("emitters");
    }
    target.jitters = options.jitter;
    bring_moved_boxes(pipeline, host.shot(), options, target);
    std::ranges::move(unknown_inputs_left_out(pipeline), std::back_inserter(warnings));
    if (!bring_environment(pipeline, environment, target, warnings, diagnostics)) return nullptr;

    doing("packing memory");
    std::optional<Plan> plan = make_plan(pipeline, nodes, target, options, diagnostics);
    if (plan) std::ranges::move(facts_not_taken(*plan, options.facts), std::back_inserter(warnings));
    if (plan) check_slots(*plan, pipeline.file, lights->names, host.scene(), diagnostics);
    if (plan) check_lights(*plan, pipeline, *lights, host.light(), diagnostics);
    if (plan) check_device_has(*plan, device, diagnostics);
    if (!plan || !diagnostics.empty()) return nullptr;
    if (!fits_memory(options.size, plan->memory.heap_bytes, "the G-buffer and the pipeline", table,
                     diagnostics))
        return nullptr;
    host.set_jitter(plan->jitter);

    doing("compiling shaders");
    session->make_view(std::move(*plan), options);
    session->sleepers_ = lights_that_may_sleep(session->plan(), host.light_names());
    const bool words = table.max_texel_elements < large_texel_buffer;  // as compile() decided
    session->make_resources(options, kept, *lights, words ? TexelsAs::words : TexelsAs::texels, environment);
    return session;
}

}  // namespace penumbra
