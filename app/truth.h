// SPDX-License-Identifier: MIT
// The true visibility of a frozen frame: the closed form of an analytic scene, or many rays per pixel.
#pragma once

#include "app/session.h"

namespace penumbra {

// Rows from the top. `receiver`: 1 where a surface is, by geometry; `rays`: how many the visibility stands
// for.
struct Truth {
    std::vector<float> visibility, receiver, rays;
};

Truth analytic_truth(const Shot& shot, uint32_t frame);

// A session of pipelines/reference.json at the shot's size, for counted_truth().
std::unique_ptr<Session> open_truth(Device& device, const Shot& shot, Diagnostics& diagnostics,
                                    std::vector<std::string>& warnings);

// Pixels around which a few rays agree keep those; the others get rays_cast(rays).
Truth counted_truth(Session& session, uint32_t frame, uint32_t rays);

uint32_t rays_cast(uint32_t wanted);  // the next square

}  // namespace penumbra
