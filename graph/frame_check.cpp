// SPDX-License-Identifier: MIT
#include "graph/frame_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "graph/device.h"

namespace penumbra {
namespace {

bool all_finite(const auto& numbers) {
    return std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); });
}

bool is_given(const Camera& camera) {
    return std::ranges::any_of(camera.clip_from_view, [](double x) { return x != 0; });
}

// What shaders take for granted of a projection (shaders/common/camera.glsl): x and y each make their own
// coordinate, off-centre by a share of w, and what w is. Of floats that were multiplied it is off by less.
bool is_upright(const glm::dmat4& m, bool orthographic) {
    const int scales = orthographic ? 3 : 2, other = orthographic ? 2 : 3;  // the column that makes w
    return std::ranges::all_of(
        std::array{m[0][1], m[0][2], m[0][3], m[1][0], m[1][2], m[1][3], m[other][0], m[other][1],
                   m[other][3], std::abs(m[scales][3] - (orthographic ? 1 : -1))},
        [](double x) { return std::abs(x) < 1e-4; });
}

void check_camera(const Camera& camera, bool orthographic, const std::string& place) {
    const auto wrong = [&](const char* member, const char* text) {
        fail(ErrorCode::usage, fmt::format("FrameDescription::{}.{}", place, member), text);
    };
    if (!all_finite(camera.position)) wrong("position", "has a coordinate that is not finite");
    // Of floats, or of rotations that were multiplied for long, it is off by less.
    const glm::dmat3 axes = glm::make_mat3(camera.world_from_view.data());
    const glm::dmat3 off = glm::transpose(axes) * axes - glm::dmat3(1);
    const auto is_off = [](double x) { return !(std::abs(x) < 1e-2); };
    if (std::any_of(glm::value_ptr(off), glm::value_ptr(off) + 9, is_off))
        wrong("world_from_view", "is no rotation: its columns are the unit vectors right, up and back");
    if (!all_finite(camera.clip_from_view)) wrong("clip_from_view", "has a number that is not finite");
    const glm::dmat4 inverse = glm::inverse(glm::make_mat4(camera.clip_from_view.data()));
    if (std::any_of(glm::value_ptr(inverse), glm::value_ptr(inverse) + 16,
                    [](double x) { return !std::isfinite(x); }))
        wrong("clip_from_view", "has no inverse: it is the unjittered projection, as perspective() makes it");
    if (!is_upright(glm::make_mat4(camera.clip_from_view.data()), orthographic))
        wrong("clip_from_view",
              orthographic
                  ? "is none of an orthographic camera (frame_orthographic): w is 1, and the image neither "
                    "turned nor sheared; a change between the two needs frame_reset"
                  : "is no plain perspective: w is -z (else: frame_orthographic, and frame_reset where that "
                    "changes), the eye is at Camera::position, the near plane is straight, and the image "
                    "neither turned nor sheared");
    if (!std::isfinite(camera.near_m)) wrong("near_m", "is not finite");
}

// In pixels, which is the usual mistake, it would be some of the image's.
void check_jitter(const FrameDescription& frame, const Plan& plan) {
    for (size_t i = 0; i < 2; ++i)
        if (!(std::abs(frame.jitter[i]) * frame.size[i] <= 2))
            fail(ErrorCode::usage, "FrameDescription::jitter",
                 fmt::format("is ({}, {}): in units of the image a part of a pixel", frame.jitter[0],
                             frame.jitter[1]));
    if (!std::ranges::all_of(frame.prev_jitter, [](double x) { return std::abs(x) <= 1; }))
        fail(ErrorCode::usage, "FrameDescription::prev_jitter",
             "is more than the image, in whose units it is");
    if (!plan.jitter && (frame.jitter[0] != 0 || frame.jitter[1] != 0))
        fail(ErrorCode::usage, "FrameDescription::jitter",
             "is not 0, and the plan was made for images that nobody jitters: say that you do "
             "(Target::jitters)");
}

}  // namespace

void check_frame(const FrameDescription& frame, const Plan& plan, bool has_past) {
    const bool orthographic = (frame.flags & frame_orthographic) != 0;
    if (plan.camera && !is_given(frame.camera))
        fail(ErrorCode::usage, "FrameDescription::camera.clip_from_view",
             fmt::format("is all zeros, and \"{}\" asks for a camera", plan.pipeline));
    if (is_given(frame.camera)) {
        check_camera(frame.camera, orthographic, "camera");
        const bool has_history = !plan.reset.empty() || std::ranges::any_of(plan.slots, &HostSlot::previous);
        if (has_past && !(frame.flags & frame_reset) && has_history)
            check_camera(frame.previous, orthographic, "previous");
    }
    if ((frame.flags & frame_unchanged) && !(frame.flags & frame_reset) && has_past &&
        frame.camera != frame.previous)
        fail(ErrorCode::usage, "FrameDescription::flags",
             "promise that nothing has changed (frame_unchanged), and camera is not previous");
    check_jitter(frame, plan);
    if (!std::isfinite(frame.dt_s)) fail(ErrorCode::usage, "FrameDescription::dt_s", "is not finite");
    constexpr uint32_t flags = frame_reset | frame_orthographic | frame_depth_at_centres | frame_unchanged;
    if (frame.flags & ~flags)
        fail(ErrorCode::usage, "FrameDescription::flags",
             fmt::format("has unknown bits: {:#x}", frame.flags & ~flags));
    if (frame.sub_pixel_bits > 24)
        fail(ErrorCode::usage, "FrameDescription::sub_pixel_bits",
             fmt::format("is {}, and no rasteriser has so many", frame.sub_pixel_bits));
}

}  // namespace penumbra
