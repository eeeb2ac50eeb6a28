// SPDX-License-Identifier: MIT
// The tree is built anew whenever a translucent triangle has moved, and never refitted: such triangles are
// few.
#include "host/scene/scene_translucents.h"

#include <algorithm>
#include <map>
#include <numeric>
#include <stdexcept>

#include "host/models/translucency.h"
#include "host/scene/scene_alpha.h"

namespace penumbra {
namespace {

RecordMap append_map(const Model& model, const Material& material, std::vector<uint32_t>& words) {
    const TransmittanceMap map = transmittance_map(model, material);
    if (std::max(map.width, map.height) > largest_record_map)
        throw std::runtime_error("a translucent texture has more than 65536 texels along an axis");
    const RecordMap place{static_cast<uint32_t>(words.size()), map.width, map.height};
    if (words.size() + map.texels.size() > size_t{1} << 31)
        throw std::runtime_error("translucent textures have more than 2^31 texels");
    words.insert(words.end(), map.texels.begin(), map.texels.end());
    return place;
}

std::vector<Texel> tree_texels(const Bvh& bvh, const SceneTranslucents& translucents,
                               std::span<const Triangle> triangles) {
    std::vector<uint32_t> record_of(triangles.size());
    std::iota(record_of.begin(), record_of.end(), 1u);
    std::vector<Texel> out{{}};
    const auto place = [&] { return static_cast<uint32_t>(out.size()); };
    out.insert(out.end(), bvh.nodes.begin(), bvh.nodes.end());
    out[0][0] = place();
    out.insert(out.end(), bvh.leaves.begin(), bvh.leaves.end());
    out[0][1] = place();
    const auto words = record_leaf_words(record_of, bvh, triangles);
    for (size_t leaf = 0; leaf < words.size(); leaf += 2) {
        const auto second = leaf + 1 < words.size() ? words[leaf + 1] : std::array<uint32_t, 2>{};
        out.push_back({words[leaf][0], words[leaf][1], second[0], second[1]});
    }
    out[0][2] = place();
    out.insert(out.end(), translucents.records.begin(), translucents.records.end());
    return out;
}

}  // namespace

glm::dvec3 SceneTranslucents::transmittance(size_t triangle, const std::array<double, 3>& weights) const {
    const Texel &r0 = records[2 * triangle], &r1 = records[2 * triangle + 1];
    return unpack_transmittance(map[r1[2] + record_texel(r0, r1, weights)]);
}

SceneTranslucents make_scene_translucents(const Scene& scene) {
    SceneTranslucents out;
    std::map<int, RecordMap> maps;  // by material
    for (const Instance& instance : scene.instances())
        for (const Part& part : scene.model().meshes[static_cast<size_t>(instance.mesh)].parts) {
            if (!scene.translucent(part)) continue;
            const auto [found, fresh] = maps.try_emplace(part.material, RecordMap{});
            if (fresh)
                found->second = append_map(
                    scene.model(), scene.model().materials[static_cast<size_t>(part.material)], out.map);
            for (size_t i = 0; i < part.indices.size(); i += 3)
                append_record(out.records, part, i, found->second);
        }
    return out;
}

TranslucentTree::TranslucentTree(Device& device, const Scene& scene, double frame)
    : device_(device),
      scene_(scene),
      frame_(frame),
      triangles_(scene.translucent_triangles(frame)),
      translucents_(make_scene_translucents(scene)) {
    std::vector<uint32_t> words = translucents_.map;
    if (words.empty()) words.push_back(0);  // a view is of something
    texels_ = upload_texels(device, std::as_bytes(std::span(words)), VK_FORMAT_R32_UINT,
                            "the textures of translucent triangles");
    build();
}

void TranslucentTree::update(double frame) {
    if (!scene_.moved(frame_, frame)) return;
    frame_ = frame;
    std::vector<Triangle> now = scene_.translucent_triangles(frame);
    const auto bytes = [](const std::vector<Triangle>& of) { return std::as_bytes(std::span(of)); };
    if (std::ranges::equal(bytes(now), bytes(triangles_))) return;  // something opaque has moved
    triangles_ = std::move(now);
    build();
}

void TranslucentTree::build() {
    const std::vector<Texel> texels = tree_texels(build_bvh(triangles_), translucents_, triangles_);
    tree_ = upload_texels(device_, std::as_bytes(std::span(texels)), VK_FORMAT_R32G32B32A32_UINT,
                          "the tree of translucent triangles");
}

}  // namespace penumbra
