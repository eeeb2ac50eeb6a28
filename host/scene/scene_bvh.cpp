// SPDX-License-Identifier: MIT
// Objects keep their triangles' order, so that a refit needs positions alone: texture coordinates stay with
// their leaves.
#include "host/scene/scene_bvh.h"

#include <algorithm>

namespace penumbra {

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
    if (!follow(triangles)) build(triangles);
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
    return refit(bvh_, triangles);
}

void SceneBvh::upload_tree() {
    nodes_ = upload_texels_as(as_, device_, std::as_bytes(std::span(bvh_.nodes)), VK_FORMAT_R32G32B32A32_UINT,
                              "the BVH's nodes");
    leaves_ = upload_texels_as(as_, device_, std::as_bytes(std::span(bvh_.leaves)),
                               VK_FORMAT_R32G32B32A32_UINT, "the BVH's leaves");
    if (!with_neighbours_) return;
    const std::vector<Texel> neighbours = leaf_neighbours(bvh_);
    neighbours_ = upload_texels(device_, std::as_bytes(std::span(neighbours)), VK_FORMAT_R32G32B32A32_UINT,
                                "the BVH's neighbours");
}

}  // namespace penumbra
