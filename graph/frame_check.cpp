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

void check_camera(const Camera& camera, const std::string& place) {
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
    if (!std::isfinite(camera.near_m)) wrong("near_m", "is not finite");
}

// In pixels, which is the usual mistake, it would be some of the image's.
void check_jitter(const FrameDescription& frame) {
    for (size_t i = 0; i < 2; ++i)
        if (!(std::abs(frame.jitter[i]) * frame.size[i] <= 2))
            fail(ErrorCode::usage, "FrameDescription::jitter",
                 fmt::format("is ({}, {}): in units of the image a part of a pixel", frame.jitter[0],
                             frame.jitter[1]));
    if (!std::ranges::all_of(frame.prev_jitter, [](double x) { return std::abs(x) <= 1; }))
        fail(ErrorCode::usage, "FrameDescription::prev_jitter",
             "is more than the image, in whose units it is");
}

}  // namespace

void check_frame(const FrameDescription& frame, bool reads_previous) {
    // All zeros: there is none, for a pipeline that asks for no camera.
    const bool has_camera = std::ranges::any_of(frame.camera.clip_from_view, [](double x) { return x != 0; });
    if (has_camera) check_camera(frame.camera, "camera");
    if (has_camera && reads_previous) check_camera(frame.previous, "previous");
    check_jitter(frame);
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
