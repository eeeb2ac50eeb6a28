// SPDX-License-Identifier: MIT
// The true demodulated radiance of a frozen frame, by many rays per pixel.
#pragma once

#include "app/session.h"
#include "host/images/image_file.h"

namespace penumbra {

// A session of pipelines/reference_radiance.json at the shot's size. `signal`: specular or diffuse.
std::unique_ptr<Session> open_radiance_truth(Device& device, const Shot& shot, const std::string& signal,
                                             Diagnostics& diagnostics, std::vector<std::string>& warnings,
                                             const Told& doing = {});

// Channels R, G, B: the signal; receiver: 1 where a surface is; roughness: perceptual, 1 of a diffuse signal;
// ray_error: the expected squared error of one ray, summed over the channels; noise: the same of this truth.
// `step` is told of rays that every pixel has cast.
PlanarImage radiance_truth(Device& device, Session& session, uint32_t frame, uint32_t rays,
                           const std::function<void(uint32_t)>& step = {});

}  // namespace penumbra
