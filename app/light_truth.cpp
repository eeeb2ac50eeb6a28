// SPDX-License-Identifier: MIT
#include "app/light_truth.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <functional>
#include <glm/gtc/type_ptr.hpp>
#include <numeric>
#include <optional>
#include <thread>
#include <utility>

#include "app/captured_values.h"
#include "app/reference_pipeline.h"
#include "app/reference_session.h"
#include "app/view_rays.h"
#include "host/generated/noise.h"
#include "host/scene/scene_alpha.h"
#include "host/scene/scene_translucents.h"
#include "host/truth/counted_visibility.h"
#include "host/truth/coverage.h"
#include "host/truth/light_visibility.h"
#include "host/truth/octahedral.h"

namespace penumbra {
namespace {

constexpr uint32_t probe_side = 8;  // 64 rays decide whether a pixel wants more
constexpr int probe_reach = 2;      // pixels around it that have to agree
constexpr double housing = 1e-4;    // LIGHT_HOUSING of light.glsl

// The point that a pixel shows, on the triangle that it shows, whose rays start a little off that.
struct Receiver {
    glm::dvec3 start{0}, normal{0};
    bool reached = false, lost = false;
    std::vector<uint32_t> seen_through;  // SurfacePoint's
};

// Of a receiver's rays.
struct Rays {
    uint32_t all = 0, lit = 0;
    glm::dvec3 light{0};           // the sum of what each brings, of 1
    glm::dvec3 least{1}, most{0};  // of one of them

    void add(const glm::dvec3& brought) {
        ++all;
        light += brought;
        least = glm::min(least, brought);
        most = glm::max(most, brought);
    }
};

// Triangles that let a part of the light through, in a tree.
class TranslucentTriangles {
  public:
    TranslucentTriangles(const Scene& scene, double frame)
        : translucents_(make_scene_translucents(scene)),
          triangles_(scene.translucent_triangles(frame)),
          bvh_(build_bvh(triangles_)) {
        std::vector<uint32_t> record_of(triangles_.size());
        std::iota(record_of.begin(), record_of.end(), 1u);
        leaf_words_ = record_leaf_words(record_of, bvh_, triangles_);
    }

    // The product over all that the ray meets: none of them ends it.
    glm::dvec3 transmittance(const Ray& ray) const {
        glm::dvec3 product(1);
        occluded(bvh_, ray, nullptr, [&](uint32_t leaf, uint32_t which, const std::array<float, 3>& areas) {
            const uint32_t word = leaf_words_[leaf][which], i0 = word & 3, i1 = word >> 2 & 3;
            const double sum = double(areas[0]) + double(areas[1]) + double(areas[2]);
            product *= translucents_.transmittance(
                (word >> 4) - 1, {areas[i0] / sum, areas[i1] / sum, areas[3 - i0 - i1] / sum});
            return false;
        });
        return product;
    }

  private:
    SceneTranslucents translucents_;
    std::vector<Triangle> triangles_;
    Bvh bvh_;
    std::vector<std::array<uint32_t, 2>> leaf_words_;
};

// The scene and the light of one frame, in the frame of the tree.
class Frame {
  public:
    Frame(const Session& session, uint32_t frame)
        : standalone_(session.host().frame(frame, false)),
          light_(moved(standalone_)),
          view_rays_(session.frame_description(),
                     session.host().shot().origin + session.host().scene().bvh_origin()),
          shown_(session.host().scene(), session.host().moment(frame)),
          triangles_(session.host().scene().triangles(session.host().moment(frame))),
          bvh_(build_bvh(triangles_)),
          alpha_(make_scene_alpha(session.host().scene())),
          leaf_words_(alpha_leaf_words(alpha_, bvh_, triangles_)),
          has_alpha_(has_alpha(session.host().scene())) {
        if (session.host().scene().has_translucent())
            translucents_.emplace(session.host().scene(), session.host().moment(frame));
    }

    bool has_translucent() const { return translucents_.has_value(); }

    Receiver receiver(uint32_t x, uint32_t y, float depth, std::array<float, 2> normal) const {
        const auto point = shown_.shown(view_rays_.at(x, y), depth, octahedral_normal(normal));
        if (!point) return {.lost = true};
        const double offset_m = start_offset_m(standalone_, {{x, y}, depth, normal});
        const glm::dvec3 start = glm::vec3(point->at + point->normal * offset_m);  // floats, as a ray's
        return {start, point->normal, light_.reaches(start), false, point->seen_through};
    }

    Rays rays(const Receiver& r, uint32_t side, uint32_t seed) const {
        const AlphaTest alpha = has_alpha_ ? alpha_test(alpha_, leaf_words_) : AlphaTest{};
        AlphaTest test = alpha;
        if (!r.seen_through.empty())
            test = [&](uint32_t leaf, uint32_t which, const std::array<float, 3>& areas) {
                const uint32_t index = bvh_.corners[leaf][which == 0 ? 0 : 3] / 3;
                return std::ranges::find(r.seen_through, index) == r.seen_through.end() &&
                       (!alpha || alpha(leaf, which, areas));
            };
        Rays out;
        for (uint32_t i = 0; i < side * side; ++i) {
            const uint32_t a = pcg(i + pcg(seed)), b = pcg(a);
            const glm::dvec2 u((i % side + a * 0x1p-32) / side, (i / side + b * 0x1p-32) / side);
            const glm::dvec3 way = light_.target(r.start, u) - r.start;
            Ray ray{};
            for (int c = 0; c < 3; ++c) {
                ray.origin[c] = static_cast<float>(r.start[c]);
                ray.direction[c] = static_cast<float>(way[c]);
            }
            ray.t_max = static_cast<float>(1 - housing);
            const bool lit = glm::dot(way, r.normal) > 0 && !occluded(bvh_, ray, nullptr, test);
            out.lit += lit;
            out.add(!lit ? glm::dvec3(0) : translucents_ ? translucents_->transmittance(ray) : glm::dvec3(1));
        }
        return out;
    }

  private:
    static NearLight moved(const StandaloneFrame& frame) {
        blocks::Light block = frame.light;
        for (int c = 0; c < 3; ++c) block.centre.v[c] += frame.scene.camera_from_origin.v[c];
        return NearLight(block);
    }

    StandaloneFrame standalone_;
    NearLight light_;
    ViewRays view_rays_;
    CountedVisibility shown_;  // with a tree of its own, whose triangles need no leaves' words
    std::vector<Triangle> triangles_;
    Bvh bvh_;
    SceneAlpha alpha_;
    std::vector<std::array<uint32_t, 2>> leaf_words_;
    bool has_alpha_;
    std::optional<TranslucentTriangles> translucents_;
};

// `step`: on this thread, of rows that are done or under way.
void on_all_cores(uint32_t rows, const std::function<void(uint32_t)>& work,
                  const std::function<void(uint32_t)>& step = {}) {
    std::atomic<uint32_t> next{0};
    uint32_t told = 0;
    const auto loop = [&](bool tells) {
        for (uint32_t row; (row = next++) < rows;) {
            work(row);
            if (tells) step(row + 1 - std::exchange(told, row + 1));
        }
    };
    {
        std::vector<std::jthread> others(std::max(std::thread::hardware_concurrency(), 1u) - 1);
        for (std::jthread& thread : others) thread = std::jthread(loop, false);
        loop(bool(step));
    }
    if (step) step(rows - told);
}

class LightPixels : public PixelTruth {
  public:
    LightPixels(const Session& session, uint32_t index)
        : width_(session.plan().extent.width),
          frame_(session, index),
          depth_(captured_values<float>(session, "view_depth")),
          normal_(captured_values<float>(session, "receiver_normal")),
          receivers_(depth_.size()) {}

    Sight look(uint32_t x, uint32_t y) override {
        const size_t p = size_t{y} * width_ + x;
        if (!(depth_[p] > 0)) return Sight::nothing;
        receivers_[p] = frame_.receiver(x, y, depth_[p], {normal_[2 * p], normal_[2 * p + 1]});
        if (receivers_[p].lost) return Sight::lost;
        return receivers_[p].reached ? Sight::receiver : Sight::nothing;
    }
    Seen seen(uint32_t x, uint32_t y, uint32_t side, uint32_t seed) const override {
        const Rays rays = frame_.rays(receivers_[size_t{y} * width_ + x], side, seed);
        return {double(rays.lit) / rays.all, rays.light / double(rays.all)};
    }
    bool coloured() const override { return frame_.has_translucent(); }

  private:
    uint32_t width_;
    Frame frame_;
    std::vector<float> depth_, normal_;
    std::vector<Receiver> receivers_;
};

}  // namespace

std::unique_ptr<PixelTruth> light_pixels(const Session& session, uint32_t frame) {
    return std::make_unique<LightPixels>(session, frame);
}

std::unique_ptr<Session> open_light_truth(Device& device, const Shot& shot, const std::string& light,
                                          Diagnostics& diagnostics, std::vector<std::string>& warnings,
                                          bool jitter, KeptScene* kept, const Told& doing) {
    SessionOptions options;
    options.captures = {"view_depth", "receiver_normal"};
    options.jitter = jitter;
    options.light = light;
    options.kept = kept;
    options.doing = doing;
    options.facts = {{"sun_up", true}, {"casters", true}};  // so that both are made in any case
    return open_own(device, shot, {raw_pipeline_text, "pipelines/raw.json", {"inputs.light={}"}},
                    std::move(options), diagnostics, warnings);
}

Truth counted_light_truth(Session& session, uint32_t index, uint32_t rays,
                          const std::function<void(uint32_t)>& step) {
    session.run_frame(index, true);
    const uint32_t width = session.plan().extent.width, height = session.plan().extent.height;
    const size_t pixels = size_t{width} * height;
    const std::vector<float> depth = captured_values<float>(session, "view_depth"),
                             normal = captured_values<float>(session, "receiver_normal");
    const Frame frame(session, index);
    const uint32_t seed = pcg(session.seed());

    Truth truth{std::vector<float>(pixels, 1), std::vector<float>(pixels), std::vector<float>(pixels)};
    std::vector<Receiver> receivers(pixels);
    std::vector<Rays> probed(pixels);
    on_all_cores(height, [&](uint32_t y) {
        for (uint32_t x = 0; x < width; ++x) {
            const size_t p = size_t{y} * width + x;
            if (!(depth[p] > 0)) continue;
            receivers[p] = frame.receiver(x, y, depth[p], {normal[2 * p], normal[2 * p + 1]});
            if (receivers[p].reached)
                probed[p] = frame.rays(receivers[p], probe_side, pcg(uint32_t(p) + seed));
        }
    });
    truth.lost = static_cast<size_t>(std::ranges::count_if(receivers, &Receiver::lost));
    const auto agree_around = [&](uint32_t x, uint32_t y) {
        glm::dvec3 least(1), most(0);
        for (int dy = -probe_reach; dy <= probe_reach; ++dy)
            for (int dx = -probe_reach; dx <= probe_reach; ++dx) {
                const int64_t qx = int64_t{x} + dx, qy = int64_t{y} + dy;
                if (qx < 0 || qy < 0 || qx >= width || qy >= height) continue;
                const size_t q = size_t(qy) * width + size_t(qx);
                if (!receivers[q].reached) continue;
                least = glm::min(least, probed[q].least);
                most = glm::max(most, probed[q].most);
            }
        return least == most;
    };

    if (frame.has_translucent()) truth.transmittance.fill(std::vector<float>(pixels, 1));
    const auto side = static_cast<uint32_t>(std::lround(std::sqrt(rays_cast(rays))));
    on_all_cores(
        height,
        [&](uint32_t y) {
            for (uint32_t x = 0; x < width; ++x) {
                const size_t p = size_t{y} * width + x;
                if (!receivers[p].reached) continue;
                const Rays cast = agree_around(x, y)
                                      ? probed[p]
                                      : frame.rays(receivers[p], side, pcg(uint32_t(p) + seed + 1));
                truth.visibility[p] = static_cast<float>(double(cast.lit) / cast.all);
                truth.receiver[p] = 1;
                truth.rays[p] = static_cast<float>(cast.all);
                for (size_t c = 0; c < 3 && frame.has_translucent(); ++c)
                    truth.transmittance[c][p] =
                        static_cast<float>(cast.light[static_cast<glm::length_t>(c)] / cast.all);
            }
        },
        step);
    return truth;
}

}  // namespace penumbra
