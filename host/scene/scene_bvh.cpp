// SPDX-License-Identifier: MIT
// Objects keep their triangles' order, so that a refit needs positions alone: texture coordinates stay with
// their leaves.
#include "host/scene/scene_bvh.h"

#include <algorithm>

namespace penumbra {

namespace {

constexpr const char *nodes_name = "the BVH's nodes", *leaves_name = "the BVH's leaves";

}  // namespace

SceneBvh::SceneBvh(Device& device, const Scene& scene, double frame, bool neighbours, TexelsAs as,
                   const std::function<void(double)>& progress)
    : device_(device), scene_(scene), frame_(frame), with_neighbours_(neighbours), as_(as) {
    if (has_alpha(scene)) {
        alpha_ = make_scene_alpha(scene);
        alpha_map_ = upload_texels_as(as_, device, std::as_bytes(std::span(alpha_->map)), VK_FORMAT_R32_UINT,
                                      "the alpha masks");
    }
    build(scene.triangles(frame), progress);
    upload_tree();
}

void SceneBvh::update(double frame) {
    if (!scene_.moved(frame_, frame)) return;
    frame_ = frame;
    const std::vector<Triangle> triangles = scene_.triangles(frame);
    if (follow(triangles)) return;
    build(triangles);
    upload_tree();
}

void SceneBvh::build(const std::vector<Triangle>& triangles, const std::function<void(double)>& progress) {
    bvh_ = build_bvh(triangles, scene_.triangle_objects(), progress);
    ++builds_;
    if (!alpha_) return;
    const std::vector<Texel> texels = alpha_uv_texels(*alpha_, alpha_leaf_words(*alpha_, bvh_, triangles));
    alpha_uv_ = upload_texels_as(as_, device_, std::as_bytes(std::span(texels)), VK_FORMAT_R32G32B32A32_UINT,
                                 "the texture coordinates of alpha-tested triangles");
}

// A refit moves the second triangle of a pair into the place of a first that has become unusable, which the
// alpha words know nothing of.
bool SceneBvh::follow(const std::vector<Triangle>& triangles) {
    if (alpha_ && std::ranges::count_if(triangles, [](const Triangle& t) { return !usable(t); }) !=
                      std::ssize(bvh_.skipped))
        return false;
    Refitted written;
    if (!refit(bvh_, triangles, &written)) return false;
    constexpr size_t bytes = 3 * sizeof(Texel);
    update_buffer(device_, nodes_.buffer, std::as_bytes(std::span(bvh_.nodes)), bytes, written.nodes,
                  nodes_name);
    update_buffer(device_, leaves_.buffer, std::as_bytes(std::span(bvh_.leaves)), bytes, written.leaves,
                  leaves_name);
    if (with_neighbours_ && refit_neighbours(bvh_, written.leaves, built_neighbours_, neighbour_words_))
        upload_neighbours();
    return true;
}

void SceneBvh::upload_tree() {
    nodes_ = upload_texels_as(as_, device_, std::as_bytes(std::span(bvh_.nodes)), VK_FORMAT_R32G32B32A32_UINT,
                              nodes_name);
    leaves_ = upload_texels_as(as_, device_, std::as_bytes(std::span(bvh_.leaves)),
                               VK_FORMAT_R32G32B32A32_UINT, leaves_name);
    if (!with_neighbours_) return;
    neighbour_words_ = built_neighbours_ = leaf_neighbours(bvh_);
    upload_neighbours();
}

void SceneBvh::upload_neighbours() {
    neighbours_ = upload_buffer(device_, std::as_bytes(std::span(neighbour_words_)),
                                VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, "the BVH's neighbours");
}

}  // namespace penumbra
