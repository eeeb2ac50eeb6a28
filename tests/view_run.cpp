// SPDX-License-Identifier: MIT
#include "tests/view_run.h"

#include <cmath>
#include <filesystem>
#include <glm/gtc/packing.hpp>
#include <stdexcept>

#include "app/session.h"
#include "penumbra/shadow_nodes.h"
#include "penumbra/user_nodes.h"
#include "tests/gpu_test.h"

namespace penumbra::test {
namespace {

CheckedPipeline checked(const std::optional<Pipeline>& pipeline, Diagnostics& diagnostics) {
    auto result = pipeline ? check(*pipeline, test_nodes(), diagnostics) : std::nullopt;
    if (!result) throw std::runtime_error(diagnostics.text());
    return std::move(*result);
}

Plan plan_for(const CheckedPipeline& pipeline, Extent extent, const ViewRunOptions& options) {
    Target target;
    target.extent = extent;
    target.device = device_table(handles_of(gpu()));
    target.device.cpu = options.cpu;
    target.facts = options.facts;
    if (options.jitters) target.jitters = true;
    for (const auto& [name, format] : options.formats) target.inputs[name] = {format, extent};
    for (const auto& [name, size] : options.arrays) target.inputs[name] = {options.formats.at(name), size, 1};
    CompileOptions compile_options;
    compile_options.alias = options.alias;
    compile_options.poison = options.poison.has_value();
    compile_options.optimum_search_nodes = 0;
    compile_options.captures = options.captures;
    for (const std::string& name : pipeline.output_names())
        if (std::find(options.captures.begin(), options.captures.end(), name) == options.captures.end())
            compile_options.captures.push_back(name);
    Diagnostics diagnostics;
    auto plan = compile(pipeline, target, compile_options, diagnostics);
    if (!plan) throw std::runtime_error(diagnostics.text());
    return std::move(*plan);
}

const HostSlot& slot_named(const Plan& plan, const std::string& name) {
    for (const HostSlot& slot : plan.slots)
        if (slot.name == name) return slot;
    throw std::invalid_argument("the plan has no host slot " + name);
}

const PlanResource& resource_named(const Plan& plan, const std::string& name) {
    for (const PlanResource& r : plan.resources)
        if (std::find(r.names.begin(), r.names.end(), name) != r.names.end()) return r;
    throw std::invalid_argument("the plan has no resource " + name);
}

}  // namespace

const NodeSet& test_nodes() {
    static const NodeSet set = [] {
        NodeSet all = shadow_nodes();
        Diagnostics diagnostics;
        if (!add_user_nodes(all, std::filesystem::path(PENUMBRA_SOURCE_DIR) / "tests/nodes", diagnostics,
                            open_shader_cache("")))
            throw std::runtime_error(diagnostics.text());
        return all;
    }();
    return set;
}

CheckedPipeline shadow_pipeline(std::string_view text) {
    Diagnostics diagnostics;
    return checked(parse_pipeline(text, "test.json", {}, diagnostics), diagnostics);
}

ViewRun::ViewRun(const CheckedPipeline& pipeline, Extent extent, const ViewRunOptions& options)
    : arrays_(options.arrays) {
    auto plan = std::make_shared<Plan>(plan_for(pipeline, extent, options));
    view_ = std::make_unique<View>(std::make_shared<Program>(handles_of(gpu()), plan),
                                   ViewOptions{1, options.poison});
}

void ViewRun::set(const std::string& name, std::span<const std::byte> bytes) {
    const HostSlot& slot = slot_named(view_->plan(), name);
    Input input;
    if (slot.kind == PortKind::image) {
        const VkFormat format = info(slot.format).vk;
        const VkExtent2D size{slot.extent.width, slot.extent.height};
        constexpr VkImageUsageFlags usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
        input.image =
            (arrays_.contains(name) ? make_layered_image : make_image)(gpu(), format, size, 1, usage, name);
        upload_image(gpu(), input.image, bytes);
    } else if (slot.kind == PortKind::texels) {
        input.texels = upload_texels(gpu(), bytes, info(slot.format).vk, name);
    } else {
        const bool block = slot.kind == PortKind::block;
        input.buffer = upload_buffer(
            gpu(), bytes, block ? VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT : VK_BUFFER_USAGE_STORAGE_BUFFER_BIT,
            name);
    }
    inputs_[name] = std::move(input);  // no frame is in flight: frame() waits
}

void ViewRun::frame(const FrameDescription& frame) {
    std::vector<SlotBinding> slots;
    for (const HostSlot& slot : view_->plan().slots) {
        const Input& input = inputs_.at(slot.name);
        SlotBinding& binding = slots.emplace_back();
        binding.image = input.image.view.get();
        binding.buffer = input.buffer.get();
        binding.texels = input.texels.view.get();
    }
    gpu().run([&](VkCommandBuffer cmd) { view_->record(cmd, frame, slots); });
}

Camera camera_at(std::array<double, 3> position, double yaw_rad, Extent extent) {
    Camera camera;
    camera.position = position;
    const double c = std::cos(yaw_rad), s = std::sin(yaw_rad);
    camera.world_from_view = {c, 0, -s, 0, 1, 0, s, 0, c};
    camera.clip_from_view =
        perspective(1.0, static_cast<double>(extent.width) / extent.height, camera.near_m);
    return camera;
}

FrameDescription frame_between(const Camera& previous, const Camera& current, Extent extent, uint32_t index,
                               bool reset) {
    FrameDescription frame;
    frame.camera = current;
    frame.previous = reset ? current : previous;
    frame.size = frame.prev_size = {extent.width, extent.height};
    frame.index = index;
    frame.flags = reset ? uint32_t{frame_reset} : 0u;
    return frame;
}

std::vector<std::vector<float>> captured_planes(const View& view, const std::string& name) {
    const PlanResource& r = resource_named(view.plan(), name);
    PlanarImage image =
        decode_texels(r.format, r.extent.width, r.extent.height, view.captured(name), {"x", "y", "z", "w"});
    std::vector<std::vector<float>> planes;
    for (Plane& plane : image.planes) planes.push_back(std::move(plane.values));
    return planes;
}

std::map<std::string, uint32_t> counters_of(const View& view, const std::string& node) {
    const auto statistics = view.statistics();
    std::map<std::string, uint32_t> counters;
    for (size_t p = 0; p < statistics.size(); ++p) {
        const PlanPass& pass = view.plan().passes[p];
        if (pass.kind != PassKind::compute || pass.node != node) continue;
        for (size_t i = 0; i < statistics[p].counters.size(); ++i)
            counters[pass.counters[i]] = statistics[p].counters[i];
    }
    return counters;
}

double sampler_error_px() {
    return gpu().info().is_cpu ? 1e-4
                               : std::ldexp(1.0, -static_cast<int>(gpu().limits().subTexelPrecisionBits));
}

std::array<uint16_t, 4> to_half4(const std::array<double, 4>& v) {
    std::array<uint16_t, 4> texel;
    for (size_t i = 0; i < 4; ++i) texel[i] = glm::packHalf1x16(static_cast<float>(v[i]));
    return texel;
}

float from_half(uint16_t bits) {
    return glm::unpackHalf1x16(bits);
}

double half_ulp(double x) {
    return std::ldexp(1.0, (std::abs(x) > 0x1p-14 ? std::ilogb(x) : -14) - 10);
}

}  // namespace penumbra::test
