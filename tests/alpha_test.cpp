// SPDX-License-Identifier: MIT
// Alpha-tested materials from the file to the shadow: what glTF's MASK means to the bit, that a scene without
// holes pays nothing, and that holes are seen and cast by the same texels.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <glm/gtc/packing.hpp>
#include <random>

#include "app/session.h"
#include "host/generated/leaf_card.h"
#include "host/models/glb_writer.h"
#include "host/models/gltf.h"
#include "host/scene/scene_alpha.h"
#include "penumbra/dump.h"
#include "tests/alpha_oracle.h"
#include "tests/gpu_test.h"
#include "tests/ray_maker.h"
#include "tests/scene_file.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"

namespace penumbra::test {
namespace {

namespace fs = std::filesystem;

Texture plain_texture(uint32_t size, uint8_t alpha) {
    Texture texture{size, size, {}};
    for (uint32_t i = 0; i < size * size; ++i)
        texture.rgba.insert(texture.rgba.end(), {200, 200, 200, alpha});
    return texture;
}

// A horizontal card of 2 m at height 1, over `x`.
Shape card_above(double x) {
    Shape shape;
    add_leaf_card(shape, {x, 1, 1}, {0, 0, -1}, {1, 0, 0}, 2);
    return shape;
}

Shot shot_of(const fs::path& model, std::array<uint32_t, 2> size) {
    Shot shot;
    shot.name = "cards";
    shot.model = model;
    shot.size = size;
    shot.frames = 4;
    shot.camera = {{0, {0, 9, 0.01}, {0, 0, 0}, {0, 1, 0}}};
    shot.sun_angular_radius_deg = 0.3;
    shot.sun = {{0, {0.05, 1, 0}}};
    return shot;
}

std::unique_ptr<Session> open(const char* pipeline, const Shot& shot, std::vector<std::string> captures) {
    SessionOptions options;
    options.size = shot.size;
    options.jitter = false;
    options.captures = std::move(captures);
    return open_session(shipped_pipeline(pipeline), shot, options);
}

// 51 / 255 is 0.2 exactly, and the float next to 0.2 lies above it: a cutoff kept in single precision would
// lose the texel.
TEST(AlphaCutoff, IsMetByAnAlphaThatEqualsIt) {
    static_assert(51 / 255.0 == 0.2 && double(0.2f) > 0.2);
    const auto least = [](double cutoff, float factor) {
        return least_opaque_alpha({{1, 1, 1, factor}, -1, cutoff});
    };
    EXPECT_EQ(least(0.2, 1), 51u);
    EXPECT_EQ(least(0.5, 1), 128u);
    EXPECT_EQ(least(1, 1), 255u);
    EXPECT_EQ(least(0, 1), 0u);
    EXPECT_EQ(least(1.5, 1), 256u);  // legal, and never met
    EXPECT_EQ(least(0.3, 0.6f), 128u);
    EXPECT_EQ(least(0.12, 0.6f), 51u);  // 0.6f * 51 / 255 misses 0.12 by the factor's rounding alone
    for (uint32_t alpha = 0; alpha < 256; ++alpha) EXPECT_EQ(least(alpha / 255.0, 1), alpha);
    EXPECT_EQ(least_opaque_alpha({}), 0u);
}

TEST(AlphaCutoff, TestsOnlyWhatItRemovesSomethingFrom) {
    Model model;
    model.textures = {plain_texture(4, 51), leaf_card_texture()};
    model.materials = {{},
                       {{1, 1, 1, 1}, 0, 0.2},
                       {{1, 1, 1, 1}, 0, 0.21},
                       {{1, 1, 1, 1}, 1, 0.5},
                       {{1, 1, 1, 0.4f}, -1, 0.5},
                       {{1, 1, 1, 0.6f}, -1, 0.5}};
    const std::vector<bool> expected{false, false, true, true, true, false};
    for (size_t i = 0; i < expected.size(); ++i)
        EXPECT_EQ(is_alpha_tested(model, static_cast<int>(i)), expected[i]) << i;
    EXPECT_FALSE(is_alpha_tested(model, -1));
}

TEST(AlphaGltf, ComesBackAsItWasWritten) {
    Model model;
    model.textures = {leaf_card_texture()};
    model.materials = {{{0.5f, 0.5f, 0.5f, 0.25f}, 0, 0.125}, {{1, 1, 1, 1}}};
    add(model, "card", card_above(0), 0);
    add(model, "floor", ground(2, 2, 1, 1), 1);
    const SceneFile file("written.glb", to_glb(model));
    Diagnostics diagnostics;
    const auto read = load_gltf(file.path(), diagnostics);
    ASSERT_TRUE(read) << diagnostics.text();
    EXPECT_TRUE(read->warnings.empty()) << read->warnings.front();
    ASSERT_EQ(read->textures.size(), 1u);
    EXPECT_EQ(read->textures[0].rgba, model.textures[0].rgba);
    EXPECT_EQ(read->materials[0].alpha_cutoff, 0.125);
    EXPECT_EQ(read->materials[0].texture, 0);
    EXPECT_EQ(read->materials[1].alpha_cutoff, std::nullopt);
    EXPECT_EQ(read->meshes[0].parts[0].uv, model.meshes[0].parts[0].uv);
}

// The binary chunk stays; only the mode's name changes, to one of the same length or shorter.
std::vector<std::byte> with_mode(const std::string& mode) {
    Model model;
    model.materials = {{{1, 1, 1, 0.5f}, -1, 0.75}};
    add(model, "card", card_above(0), 0);
    std::vector<std::byte> glb = to_glb(model);
    std::string text(reinterpret_cast<const char*>(glb.data()), glb.size());
    const std::string was = R"("alphaMode":"MASK","alphaCutoff":0.75)";
    std::string now = fmt::format(R"("alphaMode":"{}")", mode);
    now.resize(was.size(), ' ');
    text.replace(text.find(was), was.size(), now);
    std::memcpy(glb.data(), text.data(), glb.size());
    return glb;
}

TEST(AlphaGltf, BlendHasNoCutoff) {
    const SceneFile file("blend.glb", with_mode("BLEND"));
    Diagnostics diagnostics;
    const auto model = load_gltf(file.path(), diagnostics);
    ASSERT_TRUE(model) << diagnostics.text();
    EXPECT_EQ(model->materials[0].alpha_cutoff, std::nullopt);
    EXPECT_TRUE(model->materials[0].alpha_blend);
    EXPECT_TRUE(model->warnings.empty());
}

TEST(AlphaGltf, UnknownModesAreErrors) {
    const SceneFile file("odd.glb", with_mode("MIXED"));
    Diagnostics diagnostics;
    EXPECT_FALSE(load_gltf(file.path(), diagnostics));
    EXPECT_NE(diagnostics.text().find("MIXED"), std::string::npos) << diagnostics.text();
}

// The fact's price: two slots of the passes that trace. Without it nothing is left of alpha, in the plan or
// in a shader.
TEST(AlphaFact, CostsNothingWhereItDoesNotHold) {
    // Those that walk the tree: `trace`, and in one_ray `transmit` beside it.
    for (const auto& [name, tracing] : {std::pair{"raw", 1u}, std::pair{"one_ray", 2u}}) {
        SCOPED_TRACE(name);
        const auto plan_with = [&](bool alpha) {
            Target target;
            target.extent = {640, 360};
            target.device = reference_device();
            target.facts["alpha"] = alpha;
            Diagnostics diagnostics;
            auto plan = compile(shipped_pipeline(name), target, {}, diagnostics);
            if (!plan) throw std::runtime_error(diagnostics.text());
            return std::move(*plan);
        };
        const Plan with = plan_with(true), without = plan_with(false);
        EXPECT_EQ(to_text(without).find("alpha"), std::string::npos);
        std::vector<std::string> extra;
        for (const HostSlot& slot : with.slots)
            if (std::ranges::none_of(without.slots, [&](const HostSlot& s) { return s.name == slot.name; }))
                extra.push_back(slot.name);
        EXPECT_EQ(extra, (std::vector<std::string>{"scene.alpha_uv", "scene.alpha_map"}));
        EXPECT_EQ(with.slots.size(), without.slots.size() + 2);
        ASSERT_EQ(with.passes.size(), without.passes.size());
        EXPECT_EQ(with.memory.heap_bytes, without.memory.heap_bytes);
        // The same module, in which a constant says whether the masks are there.
        size_t masked = 0;
        for (size_t p = 0; p < with.passes.size(); ++p) {
            EXPECT_EQ(with.passes[p].variant, without.passes[p].variant);
            const auto absent = [](const PlanPass& pass) {
                return std::ranges::count(pass.bindings, BindingSource::nothing, &PlanBinding::source);
            };
            const auto masks = absent(without.passes[p]) - absent(with.passes[p]);
            EXPECT_TRUE(masks == 0 || masks == 2);
            EXPECT_EQ(with.passes[p].constants != without.passes[p].constants, masks == 2);
            masked += masks == 2;
        }
        EXPECT_EQ(masked, tracing);
    }
}

class Alpha : public GpuTest {};

// Three cards of one alpha each, cutoff 0.2: at the cutoff, one step below, and above it by a factor; and a
// wholly opaque mask beside them. What is not there is neither seen nor casts.
TEST_F(Alpha, AtTheCutoffCastsAndBelowItDoesNot) {
    Model model;
    model.textures = {plain_texture(8, 51), plain_texture(8, 50)};
    model.materials = {{{0.8f, 0.8f, 0.8f, 1}}, {{1, 1, 1, 1}, 0, 0.2}, {{1, 1, 1, 1}, 1, 0.2}};
    add(model, "floor", ground(6, 6, 2, 2), 0);
    add(model, "at", card_above(-2.5), 1);
    add(model, "below", card_above(2.5), 2);
    const SceneFile file("cutoff.glb", to_glb(model));
    const Shot shot = shot_of(file.path(), {128, 72});
    const auto session = open("raw", shot, {"visibility", "view_depth"});
    EXPECT_TRUE(session->plan().facts.at("alpha"));
    session->run_frame(0, true);
    const auto depth = captured_values<float>(*session, "view_depth");
    const auto visibility = session->view().captured("visibility");
    const size_t bytes = visibility.size() / depth.size();
    size_t high[2] = {}, dark[2] = {};
    for (size_t i = 0; i < depth.size(); ++i) {
        const size_t side = i % 128 >= 64;
        bool lit = false;
        for (size_t b = 0; b < bytes; ++b) lit = lit || visibility[bytes * i + b] != std::byte{0};
        high[side] += depth[i] > 7.5f && depth[i] < 8.5f;
        dark[side] += depth[i] > 8.5f && !lit;
    }
    EXPECT_GT(high[0], 100u);
    EXPECT_EQ(high[1], 0u);
    EXPECT_GT(dark[0], 4u);  // what of its shadow the card leaves in view
    EXPECT_EQ(dark[1], 0u);
}

// Every leaf word maps weights to the same texture coordinates as the scene's own corners, whatever the
// rotation and the winding of a pair: rays of the CPU's traversal against every triangle in double precision.
TEST(AlphaLayout, KeepsCornersThroughPairs) {
    Model model;
    model.textures = {leaf_card_texture()};
    model.materials = {{}, {{1, 1, 1, 1}, 0, 0.5}};
    std::mt19937 random(5);
    std::uniform_real_distribution<double> in(-1, 1);
    Shape cards, opaque;
    for (int i = 0; i < 400; ++i) {
        const glm::dvec3 along = glm::normalize(glm::dvec3(in(random), in(random), in(random))),
                         side = glm::normalize(glm::cross(along, glm::dvec3(in(random), in(random), 1.5)));
        Shape card;
        add_leaf_card(card, {4 * in(random), 4 * in(random), 4 * in(random)}, along, side, 1);
        // Any rotation of either triangle, and some turned over.
        for (size_t t = 0; t < 2; ++t) {
            std::rotate(&card.indices[3 * t], &card.indices[3 * t] + random() % 3, &card.indices[3 * t] + 3);
            if (random() % 2) std::swap(card.indices[3 * t], card.indices[3 * t + 1]);
        }
        if (i % 4 == 0) {  // one half opaque: a pair of both kinds
            Shape half = card;
            half.indices.resize(3);
            card.indices.erase(card.indices.begin(), card.indices.begin() + 3);
            half.uv.clear();
            opaque.append(half);
        }
        cards.append(card);
    }
    Mesh& mesh = model.meshes.emplace_back();
    mesh.parts = {to_part(opaque, 0), to_part(cards, 1)};
    model.nodes.emplace_back().mesh = 0;
    const Scene scene(std::move(model), Shot{});
    ASSERT_TRUE(has_alpha(scene));

    const std::vector<Triangle> triangles = scene.triangles(0);
    const Bvh bvh = build_bvh(triangles, scene.triangle_objects());
    const SceneAlpha alpha = make_scene_alpha(scene);
    const auto words = alpha_leaf_words(alpha, bvh, triangles);
    size_t mixed = 0;
    for (size_t leaf = 0; leaf < words.size(); ++leaf)
        mixed +=
            bvh.corners[leaf][2] != bvh.corners[leaf][3] && (words[leaf][0] == 0) != (words[leaf][1] == 0);
    EXPECT_GT(mixed, 50u);

    const AlphaTest test = alpha_test(alpha, words);
    const AlphaOracle oracle(scene);
    size_t blocked = 0, solid = 0, wrong = 0;
    for (int i = 0; i < 20000; ++i) {
        Ray ray{};
        for (int a = 0; a < 3; ++a) {
            ray.origin[a] = static_cast<float>(5 * in(random));
            ray.direction[a] = static_cast<float>(in(random));
        }
        ray.t_max = std::numeric_limits<float>::infinity();
        const bool hit = occluded(bvh, ray, nullptr, test);
        blocked += hit;
        solid += occluded(bvh, ray);
        wrong += oracle.truth(triangles, ray, 1e-6) == (hit ? Truth::clear : Truth::blocked);
    }
    EXPECT_EQ(wrong, 0u);
    EXPECT_GT(blocked, 2000u);
    EXPECT_GT(solid, blocked + 2000);  // the masks do remove something
}

}  // namespace
}  // namespace penumbra::test
