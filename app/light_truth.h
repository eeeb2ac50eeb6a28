// SPDX-License-Identifier: MIT
// The true visibility of a light that is near, of one frozen frame, by many rays, and its colour behind what
// is translucent.
#pragma once

#include "app/truth.h"

namespace penumbra {

// A session that draws what the pixels show, for counted_light_truth(); `light`: a name of the shot's, not
// its sun's.
std::unique_ptr<Session> open_light_truth(Device& device, const Shot& shot, const std::string& light,
                                          Diagnostics& diagnostics, std::vector<std::string>& warnings,
                                          bool jitter, KeptScene* kept = nullptr, const Told& doing = {});

// Of the frame that such a session has just run.
std::unique_ptr<PixelTruth> light_pixels(const Session& session, uint32_t frame);

// Rays in double precision, stratified over the light, against the tree on the processor; pixels around which
// 64 agree keep those, the others get rays_cast(rays). Who the light cannot reach is no receiver and has 1.
// `step` is told of rows that are done.
Truth counted_light_truth(Session& session, uint32_t frame, uint32_t rays,
                          const std::function<void(uint32_t)>& step = {});

}  // namespace penumbra
