// SPDX-License-Identifier: MIT
// The node `cover` in a pipeline on a shot: what it said of each pixel, and each pixel's start and noise
// made anew in double precision.
#pragma once

#include "tests/cover_model.h"
#include "tests/coverage_oracle.h"
#include "tests/hard_cases/hard_cases.h"
#include "tests/ray_maker.h"
#include "tests/shot_run.h"

namespace penumbra::test {

// Mesa 22 ends all loops of a workgroup after 65 535 turns (docs/coverage.md).
inline bool ends_long_loops() {
    return gpu().info().driver.find("Mesa 22") != std::string::npos;
}

// Every pixel that faces the sun is the node's to decide.
inline std::vector<std::string> without_beams() {
    return {
        "nodes.beams=null",
        "nodes.beams_alone=null",
        "nodes.trace=null",
        "nodes.trace_queries=null",
        "nodes.cover.if=casters",
        "nodes.resolve_still=null",
        "nodes.average=null",
        "resources.fresh=null",
        "nodes.resolve.if=sun_up & casters",
        R"(nodes.classify.out={ "tile_list": "candidates", "trace_args": "candidate_args", "preloaded_hits": "candidate_hits" })"};
}

inline Shot shipped_shot(const std::string& name, std::array<uint32_t, 2> size) {
    Shot shot = shot_named(name);
    shot.size = size;
    return shot;
}

struct CoverOptions {
    std::vector<std::string> settings;
    std::string pipeline = "covered";
    uint32_t samples = 128, seed = 0;
    bool beams = false;
};

class CoverRun {
  public:
    explicit CoverRun(const Shot& shot, const CoverOptions& options = {})
        : size_(shot.size), samples_(options.samples), run_(options.pipeline, shot, run_options(options)) {}

    void frame(uint32_t index, bool reset = true) {
        visibility = run_.frame(index, reset);
        standalone_ = run_.session().host().frame(index, reset);
        const Scene& scene = run_.session().host().scene();
        triangles = scene.triangles(index);
        mates.assign(triangles.size(), Mate{});
        for (const auto& c : build_bvh(triangles, scene.triangle_objects()).corners) {
            if (c[3] == c[2]) continue;
            mates[c[0] / 3] = {c[3] / 3, int(c[0] % 3), int(c[3] % 3)};
            mates[c[3] / 3] = {c[0] / 3, int(c[3] % 3), int(c[0] % 3)};
        }
        depth_ = captured_values<float>(run_.session(), "view_depth");
        normals_ = captured_values<NormalTexel>(run_.session(), "receiver_normal");
        words_ = captured_values<uint32_t>(run_.session(), "receiver_words");
        maker_ = std::make_unique<RayMaker>(run_.session(), shipped_nodes(), standalone_);
        const glm::dvec3 s = glm::make_vec3(standalone_.sun.to_sun.v);
        // sun_frame(), in double precision.
        const double sign = s.z >= 0 ? 1 : -1, a = -1 / (sign + s.z), b = s.x * s.y * a;
        axes_ = {glm::dvec3(1 + sign * s.x * s.x * a, sign * b, -sign * s.x),
                 glm::dvec3(b, sign + s.y * s.y * a, -s.y), s};
    }

    bool is_receiver(uint32_t x, uint32_t y) const {
        return (words_[y / 4 * ((size_[0] + 7) / 8) + x / 8] >> (y % 4 * 8 + x % 8) & 1) != 0;
    }
    size_t at(uint32_t x, uint32_t y) const { return size_t{y} * size_[0] + x; }
    glm::dvec3 normal(uint32_t x, uint32_t y) const { return RayMaker::normal(normals_[at(x, y)]); }
    glm::dvec3 start(uint32_t x, uint32_t y) const {
        return maker_->start(x, y, depth_[at(x, y)], normals_[at(x, y)]);
    }
    glm::dvec3 to_camera(const glm::dvec3& from) const {
        return glm::dvec3(glm::make_vec3(standalone_.scene.camera_from_origin.v)) - from;
    }
    // What the rasteriser's grid moves outlines by, metres at a view depth of a metre.
    double grid_angle() const {
        const FrameDescription& frame = standalone_.description;
        return 2 / (size_[1] * std::abs(frame.camera.clip_from_view[5])) *
               std::ldexp(0.5, -int(frame.sub_pixel_bits));
    }
    double view_depth(uint32_t x, uint32_t y) const { return double(depth_[at(x, y)]); }
    // The second of the pixel's numbers rounds; the first turns the light's axes.
    double dither(uint32_t x, uint32_t y) const { return 0.002 + 0.996 * maker_->sample(x, y).y; }
    glm::dmat3 turned_axes(uint32_t x, uint32_t y) const {
        const double angle = 2 * M_PI * maker_->sample(x, y).x, c = std::cos(angle), s = std::sin(angle);
        return {c * axes_[0] + s * axes_[1], c * axes_[1] - s * axes_[0], axes_[2]};
    }
    // Whether the surface blocks the ray to the point of the disc that u stands for is the slope's to say.
    Ray ray(uint32_t x, uint32_t y, const glm::dvec2& u) const {
        return maker_->ray(x, y, depth_[at(x, y)], normals_[at(x, y)], u);
    }
    Ray ray_from_ahead(uint32_t x, uint32_t y, const glm::dvec2& u) const {
        return maker_->from_ahead(ray(x, y, u), x, y, depth_[at(x, y)], normals_[at(x, y)]);
    }
    double slope(uint32_t x, uint32_t y, const Ray& ray) const {
        return RayMaker::slope(ray, normals_[at(x, y)]);
    }
    double angular_radius() const { return double(standalone_.sun.angular_radius); }
    glm::dvec3 to_sun() const { return axes_[2]; }
    ShotRun& run() { return run_; }
    const ShotRun& run() const { return run_; }
    // Pixels that the node did not finish.
    uint32_t left() const { return counters_of(run_.session().view(), "cover").at("left"); }
    std::array<uint32_t, 2> size() const { return size_; }
    uint32_t samples() const { return samples_; }

    std::vector<float> visibility;
    std::vector<Triangle> triangles;
    // The other triangle of a leaf, and the corners that the two do not share; apart < 0: there is none.
    struct Mate {
        uint32_t triangle = 0;
        int apart = -1, its_apart = -1;
    };
    std::vector<Mate> mates;  // parallel to triangles

  private:
    static RunOptions run_options(const CoverOptions& options) {
        RunOptions out;
        out.settings = options.beams ? std::vector<std::string>{} : without_beams();
        out.settings.push_back("nodes.cover.params.samples=" + std::to_string(options.samples));
        out.settings.insert(out.settings.end(), options.settings.begin(), options.settings.end());
        out.captures = {"view_depth", "receiver_normal", "receiver_words"};
        out.seed = options.seed;
        return out;
    }

    std::array<uint32_t, 2> size_;
    uint32_t samples_;
    ShotRun run_;
    StandaloneFrame standalone_;
    glm::dmat3 axes_{1};
    std::vector<float> depth_;
    std::vector<NormalTexel> normals_;
    std::vector<uint32_t> words_;
    std::unique_ptr<RayMaker> maker_;
};

inline glm::dvec3 corner(const Triangle& t, int k) {
    return {t.v[k][0], t.v[k][1], t.v[k][2]};
}

// What the triangles hide of the sun at a pixel, exactly.
inline double exact_visibility(const CoverRun& run, uint32_t x, uint32_t y) {
    const SeenLight light = seen_light(run.to_sun(), run.angular_radius());
    const glm::dvec3 start = run.start(x, y);
    std::vector<ConvexPart> parts = {below_plane(light, run.normal(x, y))};
    for (const Triangle& t : run.triangles)
        parts.push_back(hidden_by(light, start, {corner(t, 0), corner(t, 1), corner(t, 2)}));
    return 1 - hidden_share(parts, run.angular_radius());
}

}  // namespace penumbra::test
