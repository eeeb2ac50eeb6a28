// SPDX-License-Identifier: MIT
// The node taa on images that a test fills itself, sample by sample.
#pragma once

#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "host/shots/shot.h"
#include "shaders/common/blocks.h"
#include "tests/gpu_test.h"
#include "tests/view_run.h"

namespace penumbra::test {

// The colours reach the node as an albedo under white ambient light: `lit` is what the test chose.
inline std::string taa_pipeline(const std::string& taa) {
    return R"({
  "penumbra": 1, "name": "taa", "inputs": { "depth": {}, "normal": {}, "motion": {}, "albedo": {}, "visibility": {}, "sun": {} },
  "outputs": ["color"],
  "nodes": {
    "guides": { "type": "guides" },
    "shade": { "type": "shade", "params": { "sun_color": [0, 0, 0], "ambient": [1, 1, 1] } },
    "taa": )" +
           taa + " } }";
}
inline const std::string robust =
    R"({ "type": "taa", "in": { "history": "color@-1", "view_depth_prev": "view_depth@-1" } })";
inline const std::string robust_linear =
    R"({ "type": "taa", "in": { "history": "color@-1", "view_depth_prev": "view_depth@-1" }, "params": { "weighting": "linear" } })";
inline const std::string published =
    R"({ "type": "taa", "in": { "history": "color@-1" }, "params": { "form": "published", "box": "rgb" } })";

// One sample of the picture: a surface that faces the camera, `z` metres in front of it. 0: sky.
struct Sample {
    glm::dvec3 color{0};
    double z = 10;
    glm::dvec3 motion{0};  // px, px, metres
};
using Picture = std::function<Sample(glm::dvec2 point)>;  // of a point of the image plane, in pixels

class Taa {
  public:
    Taa(Extent extent, bool cpu, const std::string& node)
        : extent_(extent), run_(shadow_pipeline(taa_pipeline(node)), extent, options(cpu)) {
        run_.set("normal", std::vector<std::array<uint16_t, 4>>(pixels(), to_half4({0, 0, 1, 0})));
        run_.set("visibility", std::vector<uint8_t>(pixels(), 255));
        run_.set("sun", std::vector<blocks::Sun>{{{{0, 1, 0}}, 0.01f}});
    }

    size_t pixels() const { return size_t{extent_.width} * extent_.height; }
    glm::dvec2 centre(size_t i) const { return glm::dvec2(i % extent_.width, i / extent_.width) + 0.5; }

    // Pixel p sees the picture at its centre minus the jitter, as a raster moved by it does.
    std::vector<glm::dvec3> frame(const Picture& picture, bool reset, bool jittered = true) {
        FrameDescription description;
        description.camera = description.previous = camera_at({0, 0, 0}, 0, extent_);
        description.size = description.prev_size = {extent_.width, extent_.height};
        description.index = index_;
        description.flags = reset ? uint32_t{frame_reset} : 0u;
        if (jittered) description.jitter = halton_jitter(index_, description.size);
        description.prev_jitter = reset ? description.jitter : jitter_;
        jitter_ = description.jitter;
        ++index_;
        const glm::dvec2 shift(jitter_[0] * extent_.width, jitter_[1] * extent_.height);
        return frame(picture, description, shift);
    }

    std::vector<glm::dvec3> frame(const Picture& picture, const FrameDescription& description,
                                  glm::dvec2 shift) {
        std::vector<glm::dvec3> color, motion;
        std::vector<float> depth;
        for (size_t i = 0; i < pixels(); ++i) {
            const Sample s = picture(centre(i) - shift);
            color.push_back(s.color);
            motion.emplace_back(s.motion.x / extent_.width, s.motion.y / extent_.height, s.motion.z);
            depth.push_back(static_cast<float>(s.z == 0 ? 0 : 0.05 / s.z));
        }
        return frame(color, motion, depth, description);
    }

    // Of images as they are: motion in uv and metres, depth as reverse Z with the near plane at 5 cm.
    std::vector<glm::dvec3> frame(const std::vector<glm::dvec3>& color, const std::vector<glm::dvec3>& motion,
                                  const std::vector<float>& depth, const FrameDescription& description) {
        std::vector<std::array<uint16_t, 4>> albedo, motion_texels;
        for (const glm::dvec3& c : color) albedo.push_back(to_half4({c.x, c.y, c.z, 1}));
        for (const glm::dvec3& m : motion) motion_texels.push_back(to_half4({m.x, m.y, m.z, 0}));
        run_.set("albedo", albedo);
        run_.set("motion", motion_texels);
        run_.set("depth", depth);
        run_.frame(description);
        return image("color");
    }
    std::vector<glm::dvec3> lit() { return image("lit"); }
    std::vector<float> view_depth() { return captured<float>(run_.view(), "view_depth"); }
    std::vector<float> frames_held() {
        std::vector<float> alpha = captured_planes(run_.view(), "color")[3];
        for (float& a : alpha) a = std::round(a * 32);  // what is left is below half a frame
        return alpha;
    }
    void set_normal(const glm::dvec3& n) {
        run_.set("normal", std::vector<std::array<uint16_t, 4>>(pixels(), to_half4({n.x, n.y, n.z, 0})));
    }

  private:
    static ViewRunOptions options(bool cpu) {
        ViewRunOptions o;
        o.cpu = cpu;
        o.formats = {{"depth", Format::r32f},
                     {"normal", Format::rgba16f},
                     {"motion", Format::rgba16f},
                     {"albedo", Format::rgba16f},
                     {"visibility", Format::r8}};
        o.captures = {"lit", "view_depth"};
        return o;
    }
    std::vector<glm::dvec3> image(const char* name) {
        const auto planes = captured_planes(run_.view(), name);
        std::vector<glm::dvec3> colors(planes[0].size());
        for (size_t i = 0; i < colors.size(); ++i) colors[i] = {planes[0][i], planes[1][i], planes[2][i]};
        return colors;
    }

    Extent extent_;
    ViewRun run_;
    uint32_t index_ = 0;
    std::array<double, 2> jitter_{0, 0};
};

class TaaOurs : public GpuTest, public ::testing::WithParamInterface<bool> {};

inline double compress(double c) {
    return c / (1 + c);
}

}  // namespace penumbra::test
