// SPDX-License-Identifier: MIT
// Small scenes of known radiance, and pipelines and truth run on them.
#pragma once

#include <array>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "app/session.h"
#include "host/images/image_file.h"
#include "host/models/model.h"
#include "tests/view_run.h"

namespace penumbra::test {

// A night shot (nothing but the environment and what shines) of a model, which is written to a temporary
// folder; the camera at (0, 1.5, 3) looks at the origin.
Shot night_shot(const Model& model, std::array<uint32_t, 2> size, uint32_t frames = 1);

// An environment that is linear in a direction's height.
EnvironmentSky linear_sky(double down, double up);

// Strips of floor from x = -4 to 4 at height 0, one per roughness; they mirror and are black elsewise.
Model striped_floor(const std::vector<float>& roughness);

// Material of a surface that shines and reflects nothing.
Material shining(std::array<float, 3> radiance);

// Where the camera ray through the middle of a pixel goes on after the plane y = 0, from `origin` on it; NaN
// where it misses the plane.
glm::dvec3 mirrored(const Camera& camera, std::array<uint32_t, 2> size, size_t pixel, glm::dvec3& origin);

// `also`: resources that are captured besides the outputs; `facts`: instead of what the scene says.
std::unique_ptr<Session> open_shipped(const std::string& pipeline, const Shot& shot,
                                      const std::vector<std::string>& settings = {},
                                      const std::vector<std::string>& also = {}, const Facts& facts = {},
                                      bool jitter = true);

// For a host that brings denoise_radiance.json what it traced, of a scene that moves.
ViewRunOptions radiance_host_options();
void hand_over_guides(ViewRun& host, const Session& session);  // of the session's frame

// The mean over all pixels and channels of radiance that is kept in words
// (shaders/reflections/radiance_word.glsl, past_texel.glsl): of `accumulated`, which has a tenth bit per
// mantissa in `frames`, or of `gathered`. Both captured.
double mean_accumulated(const Session& session);
double mean_gathered(const Session& session);
std::vector<double> gathered(const Session& session);  // each pixel's, over its channels

// The colour planes of the pipeline's only output.
std::array<std::vector<float>, 3> colors(const Session& session);
PlanarImage truth_of(const Shot& shot, const std::string& signal, uint32_t rays, uint32_t frame = 0);

}  // namespace penumbra::test
