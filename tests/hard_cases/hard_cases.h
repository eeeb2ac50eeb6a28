// SPDX-License-Identifier: MIT
// What the tests of hard cases share (docs/hard_cases.md): scenes from a few shapes run through whole
// pipelines, an analytic plane seen by any camera as a host's images, and the figures that a case gives,
// printed for the table.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/models/shapes.h"
#include "tests/gpu_test.h"
#include "tests/shot_run.h"
#include "tests/view_run.h"

namespace penumbra::test {

class HardCase : public GpuTest {};

// Prints "case 13: naive 0.5, ours 0" for docs/hard_cases.md.
void figure(const char* what, double naive, double ours);

struct Placed {
    const char* name;
    Shape shape;
};

// A still shot of the shapes from above; the file is gone when the process ends. Shots of one `key` share it.
Shot scene_shot(const std::string& key, const std::vector<Placed>& shapes, std::array<uint32_t, 2> size);

double share(size_t part, size_t whole);

Camera looking(glm::dvec3 eye, glm::dvec3 target, double fov_rad, Extent extent, double near = 0.05);

// An infinite plane as a G-buffer that a host hands to the denoiser alone, with shadow samples of the test's
// choosing. Everything is computed per pixel in double precision.
struct ViewedPlane {
    glm::dvec3 point{0, 0, 0}, normal{0, 1, 0};
};

struct PlaneImages {
    std::vector<float> depth;                     // near / view depth, 0 = sky
    std::vector<std::array<uint16_t, 4>> normal;  // fp16
    std::vector<std::array<float, 2>> motion;
    std::vector<float> view_depth;
};
PlaneImages see_plane(const ViewedPlane& plane, const Camera& previous, const Camera& camera, Extent extent);

// Ray-hit words from a predicate "lit at pixel x, y".
std::vector<uint32_t> hit_words(Extent extent, const std::function<bool(uint32_t, uint32_t)>& lit);

// denoise.json told that penumbrae are wide, so that noise is what it may be.
CheckedPipeline denoiser();

// A denoiser on such images.
class DenoiseRun {
  public:
    DenoiseRun(const CheckedPipeline& pipeline, Extent extent, std::vector<std::string> captures);
    void frame(const PlaneImages& images, const std::vector<uint32_t>& hits, FrameDescription description);
    std::vector<float> plane(const std::string& name, size_t channel = 0);
    // Of the state that denoise.json keeps (shadow_state.glsl): the visibility, and the frames that it stands
    // for.
    std::vector<float> kept_visibility();
    std::vector<float> kept_frames();
    View& view() { return run_.view(); }

  private:
    ViewRun run_;
};

// The published temporal pass (tileclass and one filter) on the same inputs, without the constant-time parts
// around it.
CheckedPipeline published_denoiser(const std::string& tileclass_params = "{}");

// A straight edge seen face on; sun (.3, .2, 1).
Shot edge_shot(double width_px, double edge_deg, std::array<uint32_t, 2> size, uint32_t frames = 64);

}  // namespace penumbra::test
