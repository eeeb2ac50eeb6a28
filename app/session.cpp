// SPDX-License-Identifier: MIT
// Host slots are found by name; a pipeline that asks for an input the standalone host does not have is an
// error.
#include "app/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <ctime>

#include "app/commands.h"

namespace penumbra {
namespace {

double process_cpu_ms() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

// Slots of a plan; a pipeline names "scene", which stands for those of a trace backend.
const std::vector<std::string> known_slots = {
    "depth",        "normal",     "motion",         "albedo",         "sun", "scene", "scene.nodes",
    "scene.leaves", "scene.tlas", "scene.alpha_uv", "scene.alpha_map"};

void check_slots(const Plan& plan, const std::string& file, Diagnostics& diagnostics) {
    for (const HostSlot& slot : plan.slots)
        if (std::find(known_slots.begin(), known_slots.end(), slot.name) == known_slots.end())
            diagnostics.add({file}, "inputs." + slot.name,
                            "the standalone host has no such input" + did_you_mean(slot.name, known_slots));
}

}  // namespace

DeviceHandles handles_of(const Device& device) {
    return {device.instance(), device.physical(), device.get(), device.queue_family()};
}

Target standalone_target(const DeviceTable& device, std::array<uint32_t, 2> size, const Facts& facts) {
    Target target;
    target.extent = {size[0], size[1]};
    target.facts = facts;
    target.device = device;
    target.inputs = {{"depth", {Format::d32, target.extent}},
                     {"normal", {Format::rgba16f, target.extent}},
                     {"motion", {Format::rgba16f, target.extent}},
                     {"albedo", {Format::rgba8, target.extent}}};
    return target;
}

std::unique_ptr<Session> Session::open(Device& device, const NodeSet& nodes, const CheckedPipeline& pipeline,
                                       Shot shot, const SessionOptions& options, Diagnostics& diagnostics,
                                       std::vector<std::string>& warnings) {
    shot.size = options.size;  // analytic scenes measure their camera in pixels
    auto scene = load_scene(shot, diagnostics, warnings);
    if (!scene) return nullptr;
    auto session = std::unique_ptr<Session>(new Session(device));
    session->seed_ = options.seed.value_or(shot.seed);
    DeviceTable table = device_table(handles_of(device));
    table.ray_query = device.caps().ray_query;
    table.storage8 = device.caps().storage8;

    if (std::max(options.size[0], options.size[1]) > table.max_image_extent) {
        diagnostics.add({}, "size",
                        fmt::format("{}x{} exceeds the device's largest image, {} per axis", options.size[0],
                                    options.size[1], table.max_image_extent));
        return nullptr;
    }

    // Whether to jitter is known from the plan, and the plan needs the scene's facts: the host is made in
    // between.
    StandaloneOptions host_options{options.size, 1, false};
    CompileOptions compile_options;
    compile_options.alias = options.alias;
    compile_options.poison = options.poison.has_value();
    compile_options.captures = options.captures;
    if (options.optimum) compile_options.optimum_search_nodes = report_search_nodes;
    host_options.jitter = options.jitter;
    session->host_ =
        std::make_unique<StandaloneHost>(device, std::move(shot), std::move(*scene), host_options);
    Facts facts = options.facts;
    facts.merge(session->host_->facts());  // keeps what is there
    Target target = standalone_target(table, options.size, facts);
    for (const HostInput& input : pipeline.inputs)
        if (input.optional &&
            std::find(known_slots.begin(), known_slots.end(), input.name) == known_slots.end())
            target.left_out.insert(input.name);
    auto plan = compile(pipeline, nodes, target, compile_options, diagnostics);
    if (plan) check_slots(*plan, pipeline.file, diagnostics);
    if (!plan || !diagnostics.empty()) return nullptr;
    session->host_->set_jitter(options.jitter && plan->jitter);

    auto program = std::make_shared<Program>(handles_of(device), std::make_shared<Plan>(std::move(*plan)));
    session->view_ = std::make_unique<View>(program, ViewOptions{1, options.poison});
    session->set_param("seed", session->seed_);
    for (const HostSlot& slot : session->plan().slots) {
        if (slot.name == "scene.nodes")
            session->bvh_ = std::make_unique<SceneBvh>(device, session->host_->scene(), 0);
        if (slot.name == "scene.tlas")
            session->tlas_ = std::make_unique<SceneTlas>(device, session->host_->scene(), 0);
    }
    session->sun_ =
        MappedBuffer(handles_of(device), sizeof(blocks::Sun), VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, "the sun");
    session->scene_ = MappedBuffer(handles_of(device), sizeof(blocks::Scene),
                                   VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT, "the scene block");
    return session;
}

void Session::write_blocks(const StandaloneFrame& frame) {
    std::memcpy(sun_.data(), &frame.sun, sizeof frame.sun);
    std::memcpy(scene_.data(), &frame.scene, sizeof frame.scene);
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
        if (slot.name == "sun") b.buffer = sun_.get();
        if (slot.name == "scene") b.buffer = scene_.get();
        if (slot.name == "scene.nodes") b.texels = bvh_->nodes();
        if (slot.name == "scene.leaves") b.texels = bvh_->leaves();
        if (slot.name == "scene.tlas") b.tlas = tlas_->get();
        if (slot.name == "scene.alpha_uv") b.texels = bvh_ ? bvh_->alpha_uv() : tlas_->alpha_uv();
        if (slot.name == "scene.alpha_map") b.texels = bvh_ ? bvh_->alpha_map() : tlas_->alpha_map();
    }
    return bindings;
}

void Session::set_param(std::string_view name, const ParamValue& value) {
    for (const PlanPass& pass : plan().passes)
        if (pass.entry && pass.entry->type.param(name)) view_->set_param(pass.node, name, value);
}

void Session::repeat_frame() {
    last_.flags &= ~uint32_t{frame_reset};
    const std::vector<SlotBinding> slots = bind_slots();
    device_.run([&](VkCommandBuffer cmd) { view_->record(cmd, last_, slots); });
}

FrameCost Session::run_frame(uint32_t index, bool reset) {
    const StandaloneFrame frame = host_->frame(index, reset);
    // Since the frame that was traced last, which need not be the one before: a session may start anywhere.
    if (host_->scene().moved(traced_frame_, index)) {
        if (bvh_) bvh_->update(index);
        if (tlas_) tlas_->update(index);
    }
    traced_frame_ = index;
    write_blocks(frame);
    last_ = frame.description;
    const std::vector<SlotBinding> slots = bind_slots();
    const bool pass_by_pass = plan().cpu;
    FrameCost cost;
    cost.pass_cpu_ms.resize(plan().passes.size());
    device_.run([&](VkCommandBuffer cmd) {
        host_->record(cmd, frame);
        if (pass_by_pass) view_->begin(cmd, frame.description, slots);
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
        device_.run([&](VkCommandBuffer cmd) { view_->record(cmd, frame.description, slots); });
        cost.cpu_ms = process_cpu_ms() - before;
    }
    cost.passes = view_->statistics();
    for (size_t p = 0; p < plan().passes.size(); ++p)
        if (plan().passes[p].kind != PassKind::capture && cost.passes[p].ms)
            cost.ms = cost.ms.value_or(0) + *cost.passes[p].ms;
    return cost;
}

}  // namespace penumbra
