// SPDX-License-Identifier: MIT
// Host slots are found by name; a pipeline that asks for an input the standalone host does not have is an
// error.
#include "app/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <ctime>

#include "app/commands.h"
#include "app/validate.h"
#include "host/materials/environment_lots.h"
#include "host/shots/model_lights.h"

namespace penumbra {
namespace {

double process_cpu_ms() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

double wall_ms() {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

// Slots of a plan; a pipeline names "scene", which stands for those of a trace backend.
const std::vector<std::string> known_slots = {"depth",
                                              "normal",
                                              "motion",
                                              "albedo",
                                              "sun",
                                              "sun_prev",
                                              "cascades",
                                              "cascade_maps",
                                              "cascade_bounds",
                                              "neighbours",
                                              "scene",
                                              "scene.nodes",
                                              "scene.leaves",
                                              "scene.tlas",
                                              "scene.alpha_uv",
                                              "scene.alpha_map",
                                              "light",
                                              "light_prev",
                                              "lights",
                                              "material",
                                              "emissive",
                                              "environment",
                                              "environment_lots",
                                              "surfaces",
                                              "surface_texels",
                                              "translucents",
                                              "translucent_texels",
                                              "scene.nodes_words",
                                              "scene.leaves_words",
                                              "scene.alpha_uv_words",
                                              "scene.alpha_map_words"};

bool reads(const Plan& plan, std::string_view slot) {
    return std::ranges::any_of(plan.slots, [&](const HostSlot& s) { return s.name == slot; });
}

// Optional inputs that are left out until a session has something to bring.
bool brought_if_there(std::string_view name) {
    return name == "lights" || name == "environment_lots";
}

bool needs_input(const CheckedPipeline& pipeline, std::string_view name) {
    const auto input = std::ranges::find(pipeline.inputs, name, &HostInput::name);
    return input != pipeline.inputs.end() && !input->optional;
}

// Of a light whose name a slot's ends in, where a pipeline has nodes for each of them.
std::string slot_of(const std::string& light) {
    return "light_" + light;
}
std::string previous_slot_of(const std::string& light) {
    return "light_prev_" + light;
}

// The shot's lights that the pipeline has inputs of their own for.
std::vector<std::string> lights_with_inputs(const CheckedPipeline& pipeline, const Shot& shot) {
    std::vector<std::string> names;
    for (const auto& [name, light] : shot.lights)
        if (std::ranges::find(pipeline.inputs, slot_of(name), &HostInput::name) != pipeline.inputs.end())
            names.push_back(name);
    return names;
}

void check_slots(const Plan& plan, const std::string& file, const std::vector<std::string>& lights,
                 Diagnostics& diagnostics) {
    std::vector<std::string> known = known_slots;
    for (const std::string& light : lights) {
        known.push_back(slot_of(light));
        known.push_back(previous_slot_of(light));
    }
    for (const HostSlot& slot : plan.slots)
        if (std::find(known.begin(), known.end(), slot.name) == known.end())
            diagnostics.add({file}, "inputs." + slot.name,
                            "the standalone host has no such input" + did_you_mean(slot.name, known));
}

bool takes(const Plan& plan, const PlanPass& pass, std::string_view slot) {
    return std::ranges::any_of(pass.bindings, [&](const PlanBinding& b) {
        return b.source == BindingSource::host && plan.slots[b.index].name == slot;
    });
}

// Who reads the sun reads one of these slots, too: the sun's block is bound, and is not whom the mask is of.
void check_nodes(const Plan& plan, const std::vector<std::string>& slots, const std::string& light,
                 const Place& place, Diagnostics& diagnostics) {
    for (const PlanPass& pass : plan.passes) {
        const auto reads_it = [&](const std::string& slot) { return takes(plan, pass, slot); };
        if (reads_it("sun") && std::ranges::none_of(slots, reads_it))
            diagnostics.add(
                place, "nodes." + pass.node,
                fmt::format("\"{}\" knows the sun alone, and the shot's light is {}", pass.type, light));
    }
}

// A pipeline is for the sun or for lights that are near, and so is every node of it that asks for a light.
void check_light(const Plan& plan, const CheckedPipeline& pipeline, const ChosenLight& chosen,
                 Diagnostics& diagnostics) {
    const bool near = reads(plan, "light");
    const Place place{pipeline.file, 0, 0};
    if (!chosen.light && near)
        diagnostics.add(
            place, "inputs.light",
            fmt::format("\"{}\" takes a light that is near, and masks of this shot are of its sun",
                        pipeline.name));
    if (!chosen.light) return;
    const std::string light = fmt::format("\"{}\", a {}", chosen.name, name_of(chosen.light->kind));
    if (!near && reads(plan, "sun"))
        diagnostics.add(
            place, "inputs",
            fmt::format("\"{}\" knows the sun alone, and the shot's light is {}, which `light` and `lights` "
                        "draw; a variant of another pipeline has \"inputs\": {{ \"light\": {{}} }}",
                        pipeline.name, light));
    if (near) check_nodes(plan, {"light"}, light, place, diagnostics);
}

}  // namespace

bool standalone_has_input(std::string_view name) {
    return name.starts_with(slot_of("")) ||
           std::find(known_slots.begin(), known_slots.end(), name) != known_slots.end();
}

DeviceHandles handles_of(const Device& device) {
    return {device.instance(),     device.physical(),     device.get(),
            device.queue_family(), vkGetInstanceProcAddr, {}};
}

std::set<std::string> features_of(const Device& device) {
    std::set<std::string> features;
    if (device.caps().ray_query) features.insert("ray_query");
    if (device.caps().storage8) features.insert("storage8");
    return features;
}

Target standalone_target(const CheckedPipeline& pipeline, const DeviceTable& device,
                         std::array<uint32_t, 2> size, const Facts& facts, Extent cascade_extent,
                         uint32_t cascades) {
    Target target;
    target.extent = {size[0], size[1]};
    target.facts = facts;
    target.device = device;
    target.inputs = {{"depth", {Format::d32, target.extent}},
                     {"normal", {Format::rgba32f, target.extent}},
                     {"motion", {Format::rgba16f, target.extent}},
                     {"albedo", {Format::rgba8, target.extent}},
                     {"material", {Format::rg8, target.extent}},
                     {"emissive", {Format::rgba16f, target.extent}},
                     {"environment", {Format::rgba32f, {4, 1024}}},
                     {"cascade_maps", {Format::d32, cascade_extent, cascades}},
                     {"cascade_bounds", {Format::rgba32f, cascade_extent, cascades}}};
    std::erase_if(target.inputs, [&](const auto& input) {
        return std::ranges::find(pipeline.inputs, input.first, &HostInput::name) == pipeline.inputs.end();
    });
    for (const HostInput& input : pipeline.inputs)
        if (input.optional && (!standalone_has_input(input.name) || brought_if_there(input.name)))
            target.left_out.insert(input.name);
    return target;
}

std::unique_ptr<Session> Session::open(Device& device, const NodeSet& nodes, const CheckedPipeline& pipeline,
                                       Shot shot, const SessionOptions& options, Diagnostics& diagnostics,
                                       std::vector<std::string>& warnings) {
    shot.size = options.size;  // analytic scenes measure their camera in pixels
    const auto takes_input = [&](const char* name) {
        return std::ranges::find(pipeline.inputs, name, &HostInput::name) != pipeline.inputs.end();
    };
    // A pipeline that can do without lamps is of the sun and of all lamps that there are: of the sun alone,
    // too.
    const bool near = takes_input("light"), needs_lamps = needs_input(pipeline, "lights");
    const bool beside_sun =
        takes_input("lights") && !needs_lamps && !shot.lights.empty() && options.light != "sun";
    const bool several = needs_lamps || beside_sun;
    std::vector<std::string> lights = lights_with_inputs(pipeline, shot);
    const bool each = !lights.empty();
    if (several) lights = choose_lights(shot, near ? "" : options.light, diagnostics);
    if (several && lights.empty()) return nullptr;
    const auto chosen = each || (beside_sun && !near) || (several && !near && !takes_input("sun"))
                            ? ChosenLight{}
                            : choose_light(shot, several && !near ? "" : options.light, diagnostics,
                                           near ? LightsFor::near : LightsFor::sun);
    if (!chosen) return nullptr;
    const auto doing = [&](const char* what, double share = 0) {
        if (options.doing) options.doing(what, share);
    };
    KeptScene own;
    KeptScene& kept = options.kept ? *options.kept : own;
    doing("reading the model");
    auto scene = kept.scene(shot, diagnostics, warnings);
    if (!scene || !place_model_lights(shot, *scene, diagnostics)) return nullptr;
    doing("copying it to the device");
    auto session = std::unique_ptr<Session>(new Session(device));
    session->seed_ = options.seed.value_or(shot.seed);
    session->pass_costs_ = options.pass_costs;
    session->hold_ = options.hold;
    DeviceTable table = device_table(handles_of(device));
    table.cpu = options.cpu.value_or(table.cpu);
    table.features = features_of(device);

    if (std::max(options.size[0], options.size[1]) > table.max_image_extent) {
        diagnostics.add({}, "size",
                        fmt::format("{}x{} exceeds the device's largest image, {} per axis", options.size[0],
                                    options.size[1], table.max_image_extent));
        return nullptr;
    }

    const uint64_t gbuffer = uint64_t{options.size[0]} * options.size[1] * gbuffer_bytes_per_pixel();
    const auto too_much = [&](uint64_t bytes, const char* of_what) {
        diagnostics.add({}, "size",
                        fmt::format("{}x{} takes {} MiB for {}, {} more than the device's {}",
                                    options.size[0], options.size[1], bytes >> 20, of_what,
                                    (bytes - table.memory_bytes) >> 20, table.memory_bytes >> 20));
        return nullptr;
    };
    if (gbuffer > table.memory_bytes) return too_much(gbuffer, "the G-buffer alone");

    // Whether to jitter is known from the plan, and the plan needs the scene's facts: the host is made in
    // between.
    StandaloneOptions host_options{options.size, 1, false, options.cascade_size};
    CompileOptions compile_options;
    compile_options.alias = options.alias;
    compile_options.poison = options.poison.has_value();
    compile_options.captures = options.captures;
    if (options.optimum) compile_options.optimum_search_nodes = render_search_nodes;
    host_options.jitter = options.jitter;
    host_options.light = chosen->name;
    host_options.lights = lights;
    host_options.steered = options.steered;
    host_options.materials = takes_input("material") || takes_input("emissive");
    const bool looks_beyond = takes_input("environment");
    std::optional<EnvironmentMap> environment;
    if (looks_beyond) {
        environment = make_environment(shot, diagnostics);
        if (!environment) return nullptr;
    }
    try {
        session->host_ =
            std::make_unique<StandaloneHost>(device, std::move(shot), std::move(scene), host_options);
    } catch (const VulkanError& error) {  // what a call says of itself does not say that the frame is large
        throw VulkanError(error.result(),
                          fmt::format("at {}x{}: {}", options.size[0], options.size[1], error.what()));
    }
    Facts facts = options.facts;
    if (options.steered)  // what a camera or a sun that somebody steers may come to
        facts.merge(Facts{{"moves", true}, {"sun_moves", true}, {"sun_up", true}});
    facts.merge(session->host_->facts());  // keeps what is there
    Target target =
        standalone_target(pipeline, table, options.largest.value_or(options.size), facts,
                          {options.cascade_size, options.cascade_size}, session->host_->cascade_layers());
    if (several) {
        target.inputs["lights"] = {Format::rgba32ui, {5, static_cast<uint32_t>(lights.size())}};
        target.left_out.erase("lights");
    }
    const auto beyond = std::ranges::find(pipeline.inputs, "environment", &HostInput::name);
    if (environment && beyond->optional && is_black(*environment)) {
        target.left_out.insert("environment");
        environment.reset();
    }
    if (environment) {
        target.inputs["environment"] = {Format::rgba32f, {environment->width, environment->height}};
        if (std::max(environment->width, environment->height) > table.max_image_extent) {
            diagnostics.add({}, "environment",
                            fmt::format("{}x{} exceeds the device's largest image, {} per axis",
                                        environment->width, environment->height, table.max_image_extent));
            return nullptr;
        }
    }
    std::vector<std::array<uint32_t, 4>> lots;
    if (environment && takes_input("environment_lots")) lots = environment_lots(*environment);
    if (!lots.empty() && lots.size() <= table.max_texel_elements) {
        target.inputs["environment_lots"] = {Format::rgba32ui, {static_cast<uint32_t>(lots.size()), 1}};
        target.left_out.erase("environment_lots");
    } else if (needs_input(pipeline, "environment_lots")) {
        const auto& input = *std::ranges::find(pipeline.inputs, "environment_lots", &HostInput::name);
        diagnostics.add(
            input.place, "inputs.environment_lots",
            lots.empty()
                ? "there are none: where no input \"environment\" is taken, or the sky is even, no rays "
                  "are drawn by lots (\"optional\": true)"
                : "the environment has more texels than the device's texel buffers "
                  "(\"optional\": true)");
        return nullptr;
    }
    std::optional<CheckedPipeline> validating;
    if (options.validate) {
        validating = with_validation(pipeline, nodes, diagnostics);
        if (!validating) return nullptr;
    }
    doing("packing memory");
    auto plan = compile(validating ? *validating : pipeline, target, compile_options, diagnostics);
    if (plan) check_slots(*plan, pipeline.file, lights, diagnostics);
    if (plan) {
        const ShotLight* light = session->host_->light();  // the shot has moved
        check_light(*plan, pipeline, {chosen->name, light}, diagnostics);
        std::vector<std::string> slots;
        if (each) std::ranges::transform(lights, std::back_inserter(slots), slot_of);
        if (each) check_nodes(*plan, slots, "one of several", {pipeline.file, 0, 0}, diagnostics);
    }
    if (!plan || !diagnostics.empty()) return nullptr;
    if (const uint64_t all = gbuffer + plan->memory.heap_bytes; all > table.memory_bytes)
        return too_much(all, "the G-buffer and the pipeline");
    session->host_->set_jitter(options.jitter && (plan->jitter || options.always_jitter));

    doing("compiling shaders");
    const double before = wall_ms();
    auto program = std::make_shared<Program>(handles_of(device), std::make_shared<Plan>(std::move(*plan)));
    session->view_ = std::make_unique<View>(program, ViewOptions{1, options.poison});
    session->program_ms_ = wall_ms() - before;
    session->set_param("seed", session->seed_);
    const auto needs = [&](std::string_view slot) { return reads(session->plan(), slot); };
    const bool words = table.max_texel_elements < large_texel_buffer;  // as compile() decided
    const TexelsAs as = words ? TexelsAs::words : TexelsAs::texels;
    const char* const building = "building the tree of triangles";
    doing(building);
    if (needs("scene.nodes") || needs("scene.nodes_words") || needs("neighbours"))
        session->bvh_ =
            kept.tree(device, needs("neighbours"), as, [&](double share) { doing(building, share); });
    if (needs("scene.tlas"))
        session->tlas_ = std::make_unique<SceneTlas>(device, session->host_->scene(), 0, as);
    if (needs("surfaces") || needs("surface_texels")) {
        session->surfaces_ = std::make_unique<HitSurfaces>(device, session->host_->scene());
        session->update_surfaces(0, 0);
    }
    if (needs("translucents") || needs("translucent_texels"))
        session->translucents_ = std::make_unique<TranslucentTree>(device, session->host_->scene(), 0);
    if (needs("environment")) session->environment_ = upload_environment(device, *environment);
    if (needs("environment_lots"))
        session->environment_lots_ =
            upload_texels_as(TexelsAs::texels, device, std::as_bytes(std::span(lots)),
                             VK_FORMAT_R32G32B32A32_UINT, "what rays to the environment are drawn by");
    if (needs("cascade_maps") || needs("cascade_bounds"))
        session->cascade_maps_ =
            std::make_unique<CascadeMaps>(device, session->host_->scene(), options.cascade_size,
                                          session->host_->cascade_layers(), needs("cascade_bounds"));
    session->sun_ =
        make_host_buffer(device, sizeof(blocks::Sun), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, "the sun");
    session->sun_prev_ = make_host_buffer(device, sizeof(blocks::Sun), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                                          "the previous frame's sun");
    session->light_ =
        make_host_buffer(device, sizeof(blocks::Light), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, "the light");
    session->light_prev_ = make_host_buffer(device, sizeof(blocks::Light), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                                            "the previous frame's light");
    for (size_t i = 0; each && i < lights.size(); ++i)
        session->own_lights_.push_back(
            {make_host_buffer(device, sizeof(blocks::Light), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                              lights[i].c_str()),
             make_host_buffer(device, sizeof(blocks::Light), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                              "the previous frame's light")});
    if (several)
        session->lights_ = make_host_texels(device, lights.size() * sizeof(blocks::Light),
                                            VK_FORMAT_R32G32B32A32_UINT, "the lights");
    session->scene_ = make_host_buffer(device, sizeof(blocks::Scene), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT,
                                       "the scene block");
    session->cascades_ = make_host_buffer(device, sizeof(blocks::Cascades),
                                          VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, "the cascades block");
    return session;
}

void Session::write_blocks(const StandaloneFrame& frame) {
    std::memcpy(sun_.mapped, &frame.sun, sizeof frame.sun);
    std::memcpy(sun_prev_.mapped, &frame.sun_prev, sizeof frame.sun_prev);
    std::memcpy(light_.mapped, &frame.light, sizeof frame.light);
    std::memcpy(light_prev_.mapped, &frame.light_prev, sizeof frame.light_prev);
    for (size_t i = 0; i < own_lights_.size(); ++i) {
        std::memcpy(own_lights_[i].now.mapped, &frame.lights[i], sizeof frame.lights[i]);
        std::memcpy(own_lights_[i].before.mapped, &frame.lights_prev[i], sizeof frame.lights_prev[i]);
    }
    if (lights_.buffer.mapped)
        std::memcpy(lights_.buffer.mapped, frame.lights.data(), frame.lights.size() * sizeof(blocks::Light));
    std::memcpy(scene_.mapped, &frame.scene, sizeof frame.scene);
    std::memcpy(cascades_.mapped, &frame.cascades, sizeof frame.cascades);
}

std::vector<SlotBinding> Session::bind_slots() const {
    const GBufferImages& images = host_->images();
    std::vector<SlotBinding> bindings;
    for (const HostSlot& slot : plan().slots) {
        SlotBinding& b = bindings.emplace_back();
        if (slot.name == "depth") b.image = images.depth.view.get();
        if (slot.name == "normal") b.image = images.normal.view.get();
        if (slot.name == "motion") b.image = images.motion.view.get();
        if (slot.name == "albedo") b.image = images.albedo.view.get();
        if (slot.name == "material") b.image = images.material.view.get();
        if (slot.name == "emissive") b.image = images.emissive.view.get();
        if (slot.name == "environment") b.image = environment_.view.get();
        if (slot.name == "environment_lots") b.texels = environment_lots_.view.get();
        if (slot.name == "surfaces") b.texels = surfaces_->surfaces();
        if (slot.name == "surface_texels") b.texels = surfaces_->texels();
        if (slot.name == "translucents") b.texels = translucents_->tree();
        if (slot.name == "translucent_texels") b.texels = translucents_->texels();
        if (slot.name == "sun") b.buffer = sun_.get();
        if (slot.name == "sun_prev") b.buffer = sun_prev_.get();
        if (slot.name == "light") b.buffer = light_.get();
        if (slot.name == "light_prev") b.buffer = light_prev_.get();
        if (slot.name == "lights") b.texels = lights_.view.get();
        for (size_t i = 0; i < own_lights_.size(); ++i) {
            if (slot.name == slot_of(host_->light_names()[i])) b.buffer = own_lights_[i].now.get();
            if (slot.name == previous_slot_of(host_->light_names()[i]))
                b.buffer = own_lights_[i].before.get();
        }
        if (slot.name == "scene") b.buffer = scene_.get();
        const auto bind = [&](std::string_view name, const GpuTexels& texels) {
            if (slot.name == name) b.texels = texels.view.get();
            if (slot.name == std::string(name) + "_words") b.buffer = texels.buffer.get();
        };
        if (bvh_) {
            bind("scene.nodes", bvh_->nodes());
            bind("scene.leaves", bvh_->leaves());
            bind("neighbours", bvh_->neighbours());
        }
        if (bvh_ || tlas_) {
            bind("scene.alpha_uv", bvh_ ? bvh_->alpha_uv() : tlas_->alpha_uv());
            bind("scene.alpha_map", bvh_ ? bvh_->alpha_map() : tlas_->alpha_map());
        }
        if (slot.name == "scene.tlas") b.structure = tlas_->get();
        if (slot.name == "cascades") b.buffer = cascades_.get();
        if (slot.name == "cascade_maps") b.image = cascade_maps_->maps().view.get();
        if (slot.name == "cascade_bounds") b.image = cascade_maps_->bounds().view.get();
    }
    return bindings;
}

void Session::set_param(std::string_view name, const ParamValue& value) {
    for (size_t p = 0; p < plan().passes.size(); ++p)
        for (size_t i = 0; i < plan().passes[p].params.size(); ++i)
            if (plan().passes[p].params[i].param.name == name) view_->set_param(p, i, value);
}

FrameCost Session::repeat_frame() {
    last_.flags &= ~uint32_t{frame_reset | frame_unchanged};
    return run_passes([](VkCommandBuffer) {}, {});
}

void Session::update_surfaces(double moment, double previous) {
    surfaces_->update(moment, previous, bvh_ ? &bvh_->bvh() : nullptr,
                      tlas_ ? tlas_->first_triangles() : std::vector<uint32_t>{});
    surfaces_moments_ = {moment, previous};
    surfaces_builds_ = bvh_ ? bvh_->builds() : 0;
}

void Session::draw_cascades(uint32_t index, FrameCost& cost) {
    const double before = process_cpu_ms();
    device_.run([&](VkCommandBuffer cmd) {
        cost.cascades_drawn = cascade_maps_->record(cmd, host_->cascade_fit(index));
    });
    cost.cascades_cpu_ms = process_cpu_ms() - before;
    blocks::Cascades block{};
    std::memcpy(&block, cascades_.mapped, sizeof block);
    block.flags = blocks::BOUNDS_HOLD_ALL;
    std::memcpy(cascades_.mapped, &block, sizeof block);
}

bool Session::unchanged(const StandaloneFrame& frame, const std::array<double, 2>& moments) const {
    if (!last_frame_) return false;
    const StandaloneFrame& last = *last_frame_;
    const FrameDescription &a = frame.description, &b = last.description;
    const auto same = [](const auto& x, const auto& y) { return std::memcmp(&x, &y, sizeof x) == 0; };
    const auto all_same = [&](const auto& x, const auto& y) { return std::ranges::equal(x, y, same); };
    return !((a.flags | b.flags) & frame_reset) && a.camera == b.camera && a.previous == b.previous &&
           same(frame.sun, last.sun) && same(frame.sun_prev, last.sun_prev) &&
           same(frame.light, last.light) && same(frame.light_prev, last.light_prev) &&
           all_same(frame.lights, last.lights) && all_same(frame.lights_prev, last.lights_prev) &&
           same(frame.scene, last.scene) && !host_->scene().moved(moments[0], last_moments_[0]) &&
           !host_->scene().moved(moments[1], last_moments_[1]);
}

FrameCost Session::run_frame(uint32_t index, bool reset) {
    const double before = process_cpu_ms();
    StandaloneFrame frame = host_->frame(index, reset);
    const std::array<double, 2> moments{
        host_->moment(index), host_->moment(frame.description.flags & frame_reset ? index : index - 1)};
    const bool same = unchanged(frame, moments);
    held_ = hold_ && same && view_->settled();
    if (held_) {
        const size_t passes = plan().passes.size();
        FrameCost check{.passes = std::vector<PassStatistics>(passes),
                        .pass_cpu_ms = std::vector<std::optional<double>>(passes, 0.0)};
        check.cpu_ms = process_cpu_ms() - before;
        if (!pass_costs_ || !plan().cpu) check.record_cpu_ms = check.wall_ms = check.cpu_ms;
        return check;
    }
    last_frame_ = frame;
    last_moments_ = moments;
    if (same) frame.description.flags |= frame_unchanged;
    // Since the frame that was traced last, which need not be the one before: a session may start anywhere.
    const auto [moment, previous] = moments;
    if (bvh_) bvh_->update(moment);
    if (translucents_) translucents_->update(moment);
    if (host_->scene().moved(traced_moment_, moment)) {
        if (tlas_) tlas_->update(moment);
        if (cascade_maps_) cascade_maps_->update(moment);
    }
    traced_moment_ = moment;
    if (surfaces_) {
        const auto moved = [&](double a, double b) { return host_->scene().moved(a, b); };
        if (moved(surfaces_moments_[0], moment) || moved(surfaces_moments_[0], surfaces_moments_[1]) ||
            moved(previous, moment) || (bvh_ && surfaces_builds_ != bvh_->builds()))
            update_surfaces(moment, previous);
    }
    write_blocks(frame);
    last_ = frame.description;
    FrameCost cost;
    if (cascade_maps_) draw_cascades(index, cost);
    return run_passes([&](VkCommandBuffer cmd) { host_->record(cmd, frame); }, std::move(cost));
}

// What is recorded before the passes is no part of their cost.
FrameCost Session::run_passes(const std::function<void(VkCommandBuffer)>& record_before, FrameCost cost) {
    const std::vector<SlotBinding> slots = bind_slots();
    const bool pass_by_pass = plan().cpu && pass_costs_;
    cost.pass_cpu_ms.resize(plan().passes.size());
    device_.run([&](VkCommandBuffer cmd) {
        record_before(cmd);
        if (pass_by_pass) view_->begin(cmd, last_, slots);
    });
    if (pass_by_pass) {
        for (size_t p = 0; p < plan().passes.size(); ++p) {
            const double before = process_cpu_ms();
            device_.run([&](VkCommandBuffer cmd) { view_->record_pass(cmd, p); });
            cost.pass_cpu_ms[p] = process_cpu_ms() - before;
            if (plan().passes[p].kind != PassKind::capture) cost.cpu_ms += *cost.pass_cpu_ms[p];
        }
        device_.run([&](VkCommandBuffer cmd) { view_->end(cmd); });
    } else {
        const double before = process_cpu_ms();
        double wall = 0;
        device_.run([&](VkCommandBuffer cmd) {
            const double start = process_cpu_ms();
            view_->record(cmd, last_, slots);
            cost.record_cpu_ms = process_cpu_ms() - start;
            wall = wall_ms();
        });
        cost.wall_ms = wall_ms() - wall;
        cost.cpu_ms = process_cpu_ms() - before;
    }
    cost.passes = view_->statistics();
    for (size_t p = 0; p < plan().passes.size(); ++p)
        if (plan().passes[p].kind != PassKind::capture && cost.passes[p].ms)
            cost.ms = cost.ms.value_or(0) + *cost.passes[p].ms;
    return cost;
}

}  // namespace penumbra
