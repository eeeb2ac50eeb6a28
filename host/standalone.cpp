// SPDX-License-Identifier: MIT
// Frames of a shot, and the facts about it.
#include "host/standalone.h"

#include <algorithm>
#include <cstring>
#include <glm/gtc/type_ptr.hpp>

#include "host/shots/shot_facts.h"

namespace penumbra {
namespace {

blocks::Sun sun_block(const SunState& sun) {
    blocks::Sun block{};
    for (int i = 0; i < 3; ++i) block.to_sun.v[i] = static_cast<float>(sun.to_sun[i]);
    block.angular_radius = static_cast<float>(sun.angular_radius);
    return block;
}

}  // namespace

StandaloneHost::StandaloneHost(Device& device, Shot shot, Scene scene, const StandaloneOptions& options)
    : StandaloneHost(device, std::move(shot), std::make_shared<const Scene>(std::move(scene)), options) {}

StandaloneHost::StandaloneHost(Device& device, Shot shot, std::shared_ptr<const Scene> scene,
                               const StandaloneOptions& options)
    : shot_(std::move(shot)),
      scene_(std::move(scene)),
      emitters_(options.emitters ? Emitters(*scene_) : Emitters()),
      options_(options),
      sub_pixel_bits_(shot_.analytic ? 24 : device.limits().subPixelPrecisionBits),
      gbuffer_(device, *scene_, {options.size[0], options.size[1]}, options.frames_in_flight,
               options.materials) {}

bool alike(const StandaloneFrame& a, const StandaloneFrame& b) {
    const FrameDescription &x = a.description, &y = b.description;
    const auto same = [](const auto& of_a, const auto& of_b) {
        return std::memcmp(&of_a, &of_b, sizeof of_a) == 0;
    };
    return !((x.flags | y.flags) & frame_reset) && x.flags == y.flags && x.camera == y.camera &&
           x.previous == y.previous && x.size == y.size && x.dt_s == y.dt_s &&
           x.sub_pixel_bits == y.sub_pixel_bits && same(a.sun, b.sun) && same(a.sun_prev, b.sun_prev) &&
           same(a.light, b.light) && same(a.light_prev, b.light_prev) && same(a.scene, b.scene) &&
           std::ranges::equal(a.lights, b.lights, same) &&
           std::ranges::equal(a.lights_prev, b.lights_prev, same);
}

void StandaloneHost::steer(uint32_t index, const Stance& stance) {
    Stance now = stance, before = stances_.empty() ? stance : stances_.back();
    now.camera.frame = now.sun.frame = index;
    before.camera.frame = before.sun.frame = index - 1.0;
    stances_ = {before, now};
    shot_.camera = {before.camera, now.camera};
    shot_.sun = {before.sun, now.sun};
    shot_.cuts.clear();
}

double StandaloneHost::moment(uint32_t index) const {
    if (stances_.empty()) return index;
    return (index < stances_.back().camera.frame ? stances_.front() : stances_.back()).moment;
}

CascadeFit StandaloneHost::cascade_fit(uint32_t index) const {
    CascadeRequest request;
    request.camera = camera_at(shot_, index, double(options_.size[0]) / options_.size[1]);
    for (int i = 0; i < 3; ++i) request.camera.position[static_cast<size_t>(i)] -= shot_.origin[i];
    request.orthographic = shot_.analytic.has_value();
    const SunState sun = sun_at(shot_, index);
    request.to_sun = sun.to_sun;
    request.angular_radius = sun.angular_radius;
    const auto [low, high] = scene_->box(moment(index));
    request.low = low;
    request.high = high;
    request.size = options_.cascade_size;
    return fit_cascades(request);
}

uint32_t StandaloneHost::cascade_layers() const {
    if (options_.steered) return max_cascades;
    uint32_t layers = 1;
    for (uint32_t index = 0; index < shot_.frames; ++index)
        layers = std::max(layers, cascade_fit(index).count);
    return layers;
}

bool StandaloneHost::cut(uint32_t index) const {
    return std::ranges::binary_search(shot_.cuts, index);
}

StandaloneFrame StandaloneHost::frame(uint32_t index, bool reset) const {
    const double aspect = double(options_.size[0]) / options_.size[1];
    const bool has_previous = !reset && index > 0 && !cut(index);
    const uint32_t previous = has_previous ? index - 1 : index;
    StandaloneFrame out;
    FrameDescription& description = out.description;
    description.camera = camera_at(shot_, index, aspect);
    description.previous = camera_at(shot_, previous, aspect);
    description.jitter = jitter(index);
    description.prev_jitter = jitter(previous);
    description.size = description.prev_size = options_.size;
    description.index = index;
    description.dt_s = static_cast<float>(1 / shot_.fps);
    description.flags = frame_depth_at_centres | (has_previous ? 0u : uint32_t(frame_reset));
    if (shot_.analytic) description.flags |= frame_orthographic;
    description.sub_pixel_bits = sub_pixel_bits_;

    out.sun = sun_block(sun_at(shot_, index));
    out.sun_prev = sun_block(sun_at(shot_, previous));
    const glm::dvec3 camera = glm::make_vec3(description.camera.position.data());
    if (light()) {
        out.light = light_block(*light(), moment(index), camera - shot_.origin);
        out.light_prev = light_block(*light(), moment(previous), camera - shot_.origin);
    }
    for (const std::string& name : options_.lights) {
        const ShotLight& one = shot_.lights.at(name);
        out.lights.push_back(light_block(one, moment(index), camera - shot_.origin));
        out.lights_prev.push_back(light_block(one, moment(previous), camera - shot_.origin));
    }
    out.emitters = emitters_.texels(moment(index), camera - shot_.origin);
    const glm::dvec3 camera_from_origin = camera - (shot_.origin + scene_->bvh_origin());
    for (int i = 0; i < 3; ++i) out.scene.camera_from_origin.v[i] = static_cast<float>(camera_from_origin[i]);
    return out;
}

void StandaloneHost::record(VkCommandBuffer commands, const StandaloneFrame& frame) {
    const FrameDescription& description = frame.description;
    const uint32_t previous = (description.flags & frame_reset) ? description.index : description.index - 1;
    gbuffer_.record(commands, description, moment(description.index), moment(previous), shot_.origin);
}

std::map<std::string, bool> StandaloneHost::facts() const {
    return shot_facts(shot_, *scene_, light());
}

}  // namespace penumbra
