// SPDX-License-Identifier: MIT
// Masks are shared by the parts that use the same texture with the same cutoff.
#include "host/scene/scene_alpha.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <stdexcept>

namespace penumbra {

namespace {

constexpr uint32_t largest_record = (1u << 28) - 2;

RecordMap append_mask(const Model& model, const Material& material, std::vector<uint32_t>& words) {
    const Texture white{1, 1, {255, 255, 255, 255}};
    const Texture& texture =
        material.texture < 0 ? white : model.textures[static_cast<size_t>(material.texture)];
    if (std::max(texture.width, texture.height) > largest_record_map)
        throw std::runtime_error("an alpha mask has more than 65536 texels on an axis");
    const RecordMap mask{static_cast<uint32_t>(words.size()), texture.width, texture.height};
    const size_t texels = size_t{mask.width} * mask.height;
    words.resize(words.size() + (texels + 31) / 32);
    const uint32_t least = least_opaque_alpha(material);
    for (size_t i = 0; i < texels; ++i)
        if (texture.rgba[4 * i + 3] >= least) words[mask.first_word + i / 32] |= 1u << (i % 32);
    return mask;
}

uint32_t corner_bits(uint32_t i0, uint32_t i1) {
    return i1 << 2 | i0;
}

}  // namespace

void append_record(std::vector<Texel>& records, const Part& part, size_t first_index, const RecordMap& map) {
    uint32_t uv[6] = {};
    for (size_t k = 0; k < 3 && !part.uv.empty(); ++k) {
        uv[2 * k] = std::bit_cast<uint32_t>(part.uv[part.indices[first_index + k]].x);
        uv[2 * k + 1] = std::bit_cast<uint32_t>(part.uv[part.indices[first_index + k]].y);
    }
    records.push_back({uv[0], uv[1], uv[2], uv[3]});
    records.push_back({uv[4], uv[5], map.first_word, (map.width - 1) | (map.height - 1) << 16});
}

bool has_alpha(const Scene& scene) {
    const Model& model = scene.model();
    return std::ranges::any_of(scene.instances(), [&](const Instance& instance) {
        return std::ranges::any_of(model.meshes[static_cast<size_t>(instance.mesh)].parts,
                                   [&](const Part& part) { return scene.alpha_tested(part); });
    });
}

uint64_t record_texel(const Texel& r0, const Texel& r1, const std::array<double, 3>& weights) {
    const uint32_t width = (r1[3] & 0xffff) + 1, height = (r1[3] >> 16) + 1;
    const auto texel = [&](uint32_t word0, uint32_t word1, uint32_t word2, uint32_t size) {
        const double at = weights[0] * double(std::bit_cast<float>(word0)) +
                          weights[1] * double(std::bit_cast<float>(word1)) +
                          weights[2] * double(std::bit_cast<float>(word2));
        return std::min(static_cast<uint32_t>((at - std::floor(at)) * size), size - 1);
    };
    return uint64_t{texel(r0[1], r0[3], r1[1], height)} * width + texel(r0[0], r0[2], r1[0], width);
}

bool SceneAlpha::blocks(uint32_t record, const std::array<double, 3>& weights) const {
    const Texel &r0 = records[2 * size_t{record}], &r1 = records[2 * size_t{record} + 1];
    const uint64_t bit = record_texel(r0, r1, weights);
    return map[r1[2] + bit / 32] >> (bit % 32) & 1;
}

SceneAlpha make_scene_alpha(const Scene& scene) {
    const Model& model = scene.model();
    SceneAlpha out;
    std::map<std::pair<int, uint32_t>, RecordMap> masks;  // by texture and least alpha
    for (const Instance& instance : scene.instances())
        for (const Part& part : model.meshes[static_cast<size_t>(instance.mesh)].parts) {
            if (!scene.alpha_tested(part)) {
                out.record_of.insert(out.record_of.end(), part.indices.size() / 3, 0);
                continue;
            }
            const Material& material = model.materials[static_cast<size_t>(part.material)];
            const auto [found, fresh] =
                masks.try_emplace({material.texture, least_opaque_alpha(material)}, RecordMap{});
            if (fresh) found->second = append_mask(model, material, out.map);
            const RecordMap& mask = found->second;
            for (size_t i = 0; i < part.indices.size(); i += 3) {
                append_record(out.records, part, i, mask);
                if (out.records.size() / 2 > largest_record)
                    throw std::runtime_error("there are more than 2^28 alpha-tested triangles");
                out.record_of.push_back(static_cast<uint32_t>(out.records.size() / 2));
            }
        }
    return out;
}

std::vector<std::array<uint32_t, 2>> record_leaf_words(std::span<const uint32_t> record_of, const Bvh& bvh,
                                                       std::span<const Triangle> triangles) {
    std::vector<std::array<uint32_t, 2>> out(bvh.corners.size());
    const auto position = [&](uint32_t corner) { return triangles[corner / 3].v[corner % 3]; };
    for (size_t leaf = 0; leaf < out.size(); ++leaf) {
        const std::array<uint32_t, 4>& c = bvh.corners[leaf];
        // v0, v1, v2 are the first triangle's corners in the scene's cyclic order.
        const uint32_t turn = c[0] % 3;
        if (const uint32_t record = record_of[c[0] / 3])
            out[leaf][0] = record << 4 | corner_bits((3 - turn) % 3, (4 - turn) % 3);
        if (c[3] == c[2]) continue;
        const uint32_t record = record_of[c[3] / 3];
        if (record == 0) continue;
        // Of the second only v3 is named; which of its other corners lies at v2 is found by position.
        const uint32_t opposite = c[3] % 3, next = (opposite + 1) % 3;
        const float *at_v2 = position(c[2]), *at_next = position(c[3] / 3 * 3 + next);
        const bool next_is_v2 = std::equal(at_v2, at_v2 + 3, at_next);
        uint32_t place[3];  // by the scene's corner: which of v2, v1, v3
        place[opposite] = 2;
        place[next] = next_is_v2 ? 0 : 1;
        place[(opposite + 2) % 3] = next_is_v2 ? 1 : 0;
        out[leaf][1] = record << 4 | corner_bits(place[0], place[1]);
    }
    return out;
}

std::vector<Texel> alpha_uv_texels(const SceneAlpha& alpha,
                                   std::span<const std::array<uint32_t, 2>> leaf_words) {
    std::vector<Texel> out{{static_cast<uint32_t>(1 + alpha.records.size()), 0, 0, 0}};
    out.insert(out.end(), alpha.records.begin(), alpha.records.end());
    for (size_t leaf = 0; leaf < leaf_words.size(); leaf += 2) {
        const auto second = leaf + 1 < leaf_words.size() ? leaf_words[leaf + 1] : std::array<uint32_t, 2>{};
        out.push_back({leaf_words[leaf][0], leaf_words[leaf][1], second[0], second[1]});
    }
    return out;
}

AlphaTest alpha_test(const SceneAlpha& alpha, std::span<const std::array<uint32_t, 2>> leaf_words) {
    return [&alpha, leaf_words](uint32_t leaf, uint32_t which, const std::array<float, 3>& areas) {
        const uint32_t word = leaf_words[leaf][which];
        if (word == 0) return true;
        const uint32_t i0 = word & 3, i1 = word >> 2 & 3, i2 = 3 - i0 - i1;
        const double sum = double(areas[0]) + double(areas[1]) + double(areas[2]);
        return alpha.blocks((word >> 4) - 1, {areas[i0] / sum, areas[i1] / sum, areas[i2] / sum});
    };
}

}  // namespace penumbra
