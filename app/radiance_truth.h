// SPDX-License-Identifier: MIT
// The true demodulated radiance of a frozen frame, by many rays per pixel.
#pragma once

#include "app/lit_picture.h"
#include "app/session.h"
#include "host/images/image_file.h"
#include "host/metrics/radiance_error.h"

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

// Views of such an image, which must outlive them; the colours of any image that has R, G and B.
RadiancePlanes radiance_planes(const PlanarImage& image);
RadianceTruth known_of(const PlanarImage& truth);

// A session of pipelines/reference_lit.json at the shot's size.
std::unique_ptr<Session> open_lit_truth(Device& device, const Shot& shot, Diagnostics& diagnostics,
                                        std::vector<std::string>& warnings, const Told& doing = {});

// The whole picture with both signals converged, and what the surfaces reflect of white in either lobe: with
// another signal it is lit + share (signal - truth).
struct LitTruth {
    Picture lit, specular, diffuse, specular_share, diffuse_share;
};
LitTruth lit_truth(Session& session, uint32_t frame, uint32_t rays,
                   const std::function<void(uint32_t)>& step = {});

}  // namespace penumbra
