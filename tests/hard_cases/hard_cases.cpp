// SPDX-License-Identifier: MIT
#include "tests/hard_cases/hard_cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <glm/gtc/type_ptr.hpp>

#include "host/models/glb_writer.h"
#include "tests/scene_file.h"
#include "tests/shipped.h"

namespace penumbra::test {
namespace {

// Written once per process, and removed with it.
std::filesystem::path file_of(const std::string& key, const std::vector<Placed>& shapes) {
    static const TestFolder folder;
    const std::filesystem::path path = folder / (key + ".glb");
    if (std::filesystem::exists(path)) return path;
    Model model;
    model.materials = {{{0.8f, 0.8f, 0.75f, 1}, -1}};
    for (const Placed& placed : shapes) add(model, placed.name, placed.shape, 0);
    write_file(path, to_glb(model));
    return path;
}

struct Projected {
    glm::dvec2 uv{0};
    double view_depth = 0;
};

Projected project(const Camera& camera, const glm::dvec3& world) {
    const glm::dmat3 world_from_view = glm::make_mat3(camera.world_from_view.data());
    const glm::dvec3 view =
        glm::transpose(world_from_view) * (world - glm::make_vec3(camera.position.data()));
    const glm::dvec4 clip = glm::make_mat4(camera.clip_from_view.data()) * glm::dvec4(view, 1);
    return {0.5 + 0.5 * glm::dvec2(clip) / clip.w, -view.z};
}

}  // namespace

void figure(const char* what, double naive, double ours) {
    fmt::print("[  figure  ] {}: naive {:.4g}, ours {:.4g}\n", what, naive, ours);
}

Shot scene_shot(const std::string& key, const std::vector<Placed>& shapes, std::array<uint32_t, 2> size) {
    Shot shot;
    shot.name = key;
    shot.model = file_of(key, shapes);
    shot.size = size;
    shot.frames = 64;
    shot.camera = {{0, {0, 4, 4}, {0, 0, 0}, {0, 1, 0}}};
    shot.sun = {{0, {0.4, 0.8, 0.2}}};
    shot.sun_angular_radius_deg = 1.5;
    return shot;
}

double share(size_t part, size_t whole) {
    return static_cast<double>(part) / static_cast<double>(whole);
}

Camera looking(glm::dvec3 eye, glm::dvec3 target, double fov_rad, Extent extent, double near) {
    Camera camera;
    const glm::dvec3 back = glm::normalize(eye - target), right = glm::normalize(glm::cross({0, 1, 0}, back));
    const glm::dmat3 axes(right, glm::cross(back, right), back);
    std::copy_n(glm::value_ptr(axes), 9, camera.world_from_view.begin());
    camera.position = {eye.x, eye.y, eye.z};
    camera.clip_from_view = perspective(fov_rad, double(extent.width) / extent.height, near);
    camera.near_m = near;
    return camera;
}

PlaneImages see_plane(const ViewedPlane& plane, const Camera& previous, const Camera& camera, Extent extent) {
    const size_t n = size_t{extent.width} * extent.height;
    PlaneImages images{std::vector<float>(n), std::vector<std::array<uint16_t, 4>>(n),
                       std::vector<std::array<float, 2>>(n), std::vector<float>(n)};
    const glm::dmat3 world_from_view = glm::make_mat3(camera.world_from_view.data());
    const glm::dvec3 eye = glm::make_vec3(camera.position.data());
    for (size_t i = 0; i < n; ++i) {
        const glm::dvec2 uv((static_cast<double>(i % extent.width) + 0.5) / extent.width,
                            (static_cast<double>(i / extent.width) + 0.5) / extent.height);
        const glm::dvec3 ray = world_from_view * glm::dvec3((2 * uv.x - 1) / camera.clip_from_view[0],
                                                            (2 * uv.y - 1) / camera.clip_from_view[5], -1);
        const double z = glm::dot(plane.point - eye, plane.normal) / glm::dot(ray, plane.normal);
        if (!(z > 0 && z < 1e9)) continue;
        const Projected before = project(previous, eye + z * ray);
        const glm::dvec2 motion = before.view_depth > 0 ? before.uv - uv : glm::dvec2(4);
        images.view_depth[i] = static_cast<float>(z);
        images.depth[i] = static_cast<float>(camera.near_m / z);
        images.normal[i] = to_half4({plane.normal.x, plane.normal.y, plane.normal.z, 0});
        images.motion[i] = {static_cast<float>(motion.x), static_cast<float>(motion.y)};
    }
    return images;
}

std::vector<uint32_t> hit_words(Extent extent, const std::function<bool(uint32_t, uint32_t)>& lit) {
    const uint32_t columns = (extent.width + 7) / 8;
    std::vector<uint32_t> words(size_t{columns} * ((extent.height + 3) / 4), 0);
    for (uint32_t y = 0; y < extent.height; ++y)
        for (uint32_t x = 0; x < extent.width; ++x)
            if (!lit(x, y)) words[size_t{y / 4} * columns + x / 8] |= 1u << (y % 4 * 8 + x % 8);
    return words;
}

namespace {

ViewRunOptions denoise_options(std::vector<std::string> captures) {
    ViewRunOptions options;
    options.formats = {{"depth", Format::r32f}, {"normal", Format::rgba16f}, {"motion", Format::rg32f}};
    options.captures = std::move(captures);
    options.facts = {{"sun_moves", false}};
    return options;
}

}  // namespace

CheckedPipeline denoiser() {
    return shipped_pipeline("denoise", {"nodes.gather.params.distance_m=1000"});
}

DenoiseRun::DenoiseRun(const CheckedPipeline& pipeline, Extent extent, std::vector<std::string> captures)
    : run_(pipeline, extent, denoise_options(std::move(captures))) {}

void DenoiseRun::frame(const PlaneImages& images, const std::vector<uint32_t>& hits,
                       FrameDescription description) {
    run_.set("depth", images.depth);
    run_.set("normal", images.normal);
    run_.set("motion", images.motion);
    run_.set("hits", hits);
    const blocks::Sun sun{{{0.14f, 0.7f, 0.7f}}, 0.00465f};
    run_.set("sun", std::vector<blocks::Sun>{sun});
    run_.frame(description);
}

std::vector<float> DenoiseRun::kept_visibility() {
    std::vector<float> v;
    for (const uint32_t word : captured<uint32_t>(run_.view(), "state"))
        v.push_back(float(word & 0x3ff) / 1023);
    return v;
}

std::vector<float> DenoiseRun::kept_frames() {
    std::vector<float> frames;
    for (const uint32_t word : captured<uint32_t>(run_.view(), "state")) {
        const float c = float(word >> 10 & 63) - 1;
        frames.push_back(c < 0 ? 0 : 1 + c * c / 63);
    }
    return frames;
}

std::vector<float> DenoiseRun::plane(const std::string& name, size_t channel) {
    return captured_planes(run_.view(), name).at(channel);
}

CheckedPipeline published_denoiser(const std::string& tileclass_params) {
    return shadow_pipeline(R"({
      "penumbra": 1, "name": "published", "inputs": { "depth": {}, "normal": {}, "motion": {}, "sun": {}, "hits": {} },
      "outputs": ["visibility"], "resources": { "visibility": { "format": "r16f" } },
      "nodes": {
        "guides": { "type": "guides" }, "classify": { "type": "classify" }, "prepare": { "type": "prepare" },
        "tileclass": { "type": "tileclass", "in": { "history": "filtered0@-1", "moments_prev": "moments@-1",
                       "view_depth_prev": "view_depth@-1" }, "params": )" +
                           tileclass_params + R"( },
        "filter0": { "type": "filter", "in": { "signal": "reprojected" }, "out": { "filtered": "filtered0" }, "params": { "step": 1 } },
        "filter1": { "type": "filter", "in": { "signal": "filtered0" }, "out": { "filtered": "filtered1" }, "params": { "step": 2 } },
        "filter2": { "type": "filter", "in": { "signal": "filtered1" }, "out": { "filtered": "visibility" }, "params": { "step": 4 } } } })");
}

Shot edge_shot(double width_px, double edge_deg, std::array<uint32_t, 2> size, uint32_t frames) {
    Shot shot;
    shot.analytic = AnalyticScene{.penumbra_px = width_px, .edge_deg = edge_deg};
    shot.size = size;
    shot.frames = frames;
    shot.sun = {{0, {0.3, 0.2, 1}}};
    return shot;
}

}  // namespace penumbra::test
