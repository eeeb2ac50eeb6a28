// SPDX-License-Identifier: MIT
#include "host/materials/hit_surfaces.h"

#include <algorithm>
#include <bit>
#include <map>
#include <stdexcept>

namespace penumbra {
namespace {

constexpr uint32_t no_texture = ~0u, moves_bit = 1u << 31;
constexpr const char* what = "the surfaces that rays hit";

uint32_t bits(float value) {
    return std::bit_cast<uint32_t>(value);
}

// Material and texture coordinates of a triangle that never changes.
struct Corners {
    uint32_t material = 0;  // the first is that of triangles without one
    std::array<glm::vec2, 3> uv{};
};

// In the order of Scene::triangles().
std::vector<Corners> triangle_corners(const Scene& scene) {
    std::vector<Corners> out;
    for (const Instance& instance : scene.instances())
        for (const Part& part : scene.model().meshes[static_cast<size_t>(instance.mesh)].parts)
            for (size_t i = 0; i < part.indices.size(); i += 3) {
                Corners& corners = out.emplace_back();
                corners.material = static_cast<uint32_t>(1 + part.material);
                if (part.uv.empty()) continue;
                for (size_t k = 0; k < 3; ++k) corners.uv[k] = part.uv[part.indices[i + k]];
            }
    return out;
}

// The textures that hits read, one after the other.
class TextureWords {
  public:
    explicit TextureWords(const Model& model) : model_(model) {}

    std::array<uint32_t, 2> place(int texture, std::vector<uint32_t>& words) {
        if (texture < 0) return {no_texture, 0};
        const Texture& from = model_.textures[static_cast<size_t>(texture)];
        if (from.width == 0) return {no_texture, 0};
        if (from.width > 65536 || from.height > 65536)
            throw std::runtime_error("a texture has more than 65536 texels along an axis");
        const auto [known, fresh] = first_.try_emplace(texture, static_cast<uint32_t>(words.size()));
        if (fresh) {
            if (words.size() + from.rgba.size() / 4 > size_t{1} << 31)
                throw std::runtime_error("the textures that reflections see have more than 2^31 texels");
            for (size_t i = 0; i < from.rgba.size(); i += 4)
                words.push_back(from.rgba[i] | uint32_t{from.rgba[i + 1]} << 8 |
                                uint32_t{from.rgba[i + 2]} << 16 | uint32_t{from.rgba[i + 3]} << 24);
        }
        return {known->second, (from.width - 1) | (from.height - 1) << 16};
    }

  private:
    const Model& model_;
    std::map<int, uint32_t> first_;
};

void append_words(std::vector<Texel>& out, std::span<const uint32_t> words) {
    for (size_t i = 0; i < words.size(); i += 4) {
        Texel& texel = out.emplace_back();
        for (size_t k = 0; k < 4; ++k) texel[k] = i + k < words.size() ? words[i + k] : 0;
    }
}

std::vector<uint32_t> leaf_words(const Bvh& bvh) {
    std::vector<uint32_t> words;
    for (const auto& corners : bvh.corners) words.insert(words.end(), {corners[0] / 3, corners[3] / 3});
    return words;
}

}  // namespace

SurfaceTexels make_surface_texels(const Scene& scene, double frame, double previous, const Bvh* bvh,
                                  std::span<const uint32_t> first_triangles) {
    SurfaceTexels out;
    out.surfaces.push_back({});
    for (const Corners& corners : triangle_corners(scene)) {
        uint32_t words[16]{};
        for (size_t k = 0; k < 3; ++k) {
            words[9 + 2 * k] = bits(corners.uv[k].x);
            words[10 + 2 * k] = bits(corners.uv[k].y);
        }
        words[15] = corners.material;
        append_words(out.surfaces, words);
    }
    move_surface_texels(scene, frame, previous, out.surfaces);
    const auto place = [&] { return static_cast<uint32_t>(out.surfaces.size()); };
    out.surfaces[0][0] = place();
    if (bvh) append_words(out.surfaces, leaf_words(*bvh));
    out.surfaces[0][1] = place();
    append_words(out.surfaces, first_triangles);
    out.surfaces[0][2] = place();
    TextureWords textures(scene.model());
    const auto append = [&](const Material& material) {
        const auto base = textures.place(material.texture, out.texels);
        const auto emissive = textures.place(material.emissive_texture, out.texels);
        append_words(out.surfaces, std::array{bits(material.base_color[0]), bits(material.base_color[1]),
                                              bits(material.base_color[2]), 0u, bits(material.emissive[0]),
                                              bits(material.emissive[1]), bits(material.emissive[2]), 0u,
                                              base[0], base[1], emissive[0], emissive[1]});
    };
    append(Material{});
    for (const Material& material : scene.model().materials) append(material);
    return out;
}

std::vector<uint32_t> move_surface_texels(const Scene& scene, double frame, double previous,
                                          std::span<Texel> surfaces) {
    const std::vector<Triangle> triangles = scene.triangles(frame);
    const std::vector<glm::dmat4> here = scene.transforms(frame), before = scene.transforms(previous);
    const bool moved = scene.moved(previous, frame);
    std::vector<bool> moves;
    for (const Instance& instance : scene.instances()) {
        const auto node = static_cast<size_t>(instance.node);
        for (const Part& part : scene.model().meshes[static_cast<size_t>(instance.mesh)].parts)
            moves.insert(moves.end(), part.indices.size() / 3,
                         here[node] != before[node] || (moved && scene.deforms(instance, part)));
    }

    std::vector<uint32_t> written;
    for (size_t t = 0; t < triangles.size(); ++t) {
        const size_t first = 1 + 4 * t;
        std::array<Texel, 4> now;
        std::copy_n(&surfaces[first], 4, now.begin());
        for (size_t i = 0; i < 9; ++i) now[i / 4][i % 4] = bits(triangles[t].v[i / 3][i % 3]);
        now[3][3] = (now[3][3] & ~moves_bit) | (moves[t] ? moves_bit : 0);
        for (size_t k = 0; k < 4; ++k) {
            if (surfaces[first + k] == now[k]) continue;
            surfaces[first + k] = now[k];
            written.push_back(static_cast<uint32_t>(first + k));
        }
    }
    return written;
}

void HitSurfaces::make(double frame, double previous, const Bvh* bvh,
                       std::span<const uint32_t> first_triangles) {
    SurfaceTexels made = make_surface_texels(scene_, frame, previous, bvh, first_triangles);
    made_ = std::move(made.surfaces);
    surfaces_ = upload_texels(device_, std::as_bytes(std::span(made_)), VK_FORMAT_R32G32B32A32_UINT, what);
    if (made.texels.empty()) made.texels.push_back(0);  // a view is of something
    if (!texels_.view.get())
        texels_ = upload_texels(device_, std::as_bytes(std::span(made.texels)), VK_FORMAT_R32_UINT,
                                "the textures that rays hit");
}

void HitSurfaces::move(double frame, double previous) {
    const std::vector<uint32_t> written = move_surface_texels(scene_, frame, previous, made_);
    update_buffer(device_, surfaces_.buffer, std::as_bytes(std::span(made_)), sizeof(Texel), written, what);
}

}  // namespace penumbra
