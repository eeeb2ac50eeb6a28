// SPDX-License-Identifier: MIT
// The G-buffer against double-precision ray casting: depth, normals and motion of boxes that move, turn and
// are mirrored, near the origin and a thousand kilometres away from it. Needs a Vulkan device.
#include "host/gbuffer/gbuffer.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/gtc/packing.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <memory>

#include "host/models/shapes.h"
#include "host/standalone.h"
#include "tests/gbuffer_oracle.h"

namespace penumbra::test {
namespace {

class GBufferTest : public ::testing::Test {
  protected:
    static void SetUpTestSuite() {
        device_ = std::make_unique<Device>(DeviceOptions{.name = {}, .validation = true});
    }
    static void TearDownTestSuite() { device_.reset(); }
    void TearDown() override {
        for (const std::string& message : device_->messages()) ADD_FAILURE() << message;
    }
    static std::unique_ptr<Device> device_;
};

std::unique_ptr<Device> GBufferTest::device_;

Model boxes() {
    Model model;
    model.materials = {{{0.5f, 0.25f, 1, 1}}};
    model.meshes.push_back({{to_part(ground(20, 20, 4, 4), -1)}});
    model.meshes.push_back({{to_part(box({-0.5, 0, -0.5}, {0.5, 2, 0.5}), 0)}});
    model.nodes = {
        Node{.name = "floor", .mesh = 0},
        Node{.name = "mover", .mesh = 1, .translation = {-1.5, 0.1, 0}},
        Node{.name = "mirrored", .mesh = 1, .translation = {1.5, 0, -1}, .scale = {-1, 0.4, 2}},
        Node{.name = "far", .mesh = 1, .translation = {-4, 0, -60}, .scale = {8, 8, 8}},
    };
    return model;
}

Shot boxes_shot() {
    Shot shot;
    shot.frames = 8;
    shot.vertical_fov_deg = 50;
    shot.near = 0.05;
    shot.camera = {{.frame = 0, .position = {0.3, 1.7, 6}, .target = {0, 0.8, 0}},
                   {.frame = 4, .position = {0.5, 1.9, 5.7}, .target = {0.1, 0.8, 0}, .up = {0.05, 1, 0}}};
    shot.sun = {{.frame = 0, .to_sun = {0, 1, 0}}};
    shot.objects["mover"].keys = {{.frame = 0},
                                  {.frame = 4, .translation = {0.3, 0.2, 0.1}, .rotation_deg = {0, 40, 5}}};
    return shot;
}

struct Rendered {
    StandaloneFrame frame;
    std::vector<float> depth;
    std::vector<glm::vec4> normal, motion;
    std::vector<glm::u8vec4> albedo;
};

template <class T>
std::vector<T> texels(Device& device, const GpuImage& image) {
    const std::vector<std::byte> bytes =
        read_image(device, image.get(), image.format, image.extent, GBuffer::final_layout);
    std::vector<T> out(bytes.size() / sizeof(T));
    std::memcpy(out.data(), bytes.data(), bytes.size());
    return out;
}

std::vector<glm::vec4> from_half(const std::vector<uint64_t>& packed) {
    std::vector<glm::vec4> out(packed.size());
    std::ranges::transform(packed, out.begin(), [](uint64_t p) { return glm::unpackHalf4x16(p); });
    return out;
}

// `held`: somebody stands where the shot begins, and looks at this moment of it.
Rendered render(Device& device, const Shot& shot, Model model, uint32_t index, bool reset = false,
                std::optional<double> held = {}) {
    StandaloneHost host(device, shot, Scene(std::move(model), shot), {.size = {width, height}});
    if (held) host.steer(index, {shot.camera[0], shot.sun[0], *held});
    Rendered out;
    out.frame = host.frame(index, reset);
    device.run([&](VkCommandBuffer commands) { host.record(commands, out.frame); });
    out.depth = texels<float>(device, host.images().depth);
    out.normal = texels<glm::vec4>(device, host.images().normal);
    out.motion = from_half(texels<uint64_t>(device, host.images().motion));
    out.albedo = texels<glm::u8vec4>(device, host.images().albedo);
    return out;
}

TEST_F(GBufferTest, MatchesDoublePrecision) {
    const Shot shot = boxes_shot();
    const Scene scene(boxes(), shot);
    const Rendered image = render(*device_, shot, boxes(), 3);
    const FrameDescription& frame = image.frame.description;
    ASSERT_NE(frame.jitter[0], 0);
    const auto triangles = reference_triangles(scene, 3, 2);
    const auto hits = reference_hits(triangles, frame);
    const glm::dvec3 eye = glm::make_vec3(frame.camera.position.data());

    double depth_error = 0, normal_error = 0, motion_error_px = 0, change_error = 0, moved = 0;
    size_t surface = 0, sky = 0;
    for (uint32_t y = 0; y < height; ++y) {
        for (uint32_t x = 0; x < width; ++x) {
            if (!is_interior(hits, x, y)) continue;
            const size_t i = y * width + x;
            const Hit& hit = hits[i];
            if (hit.triangle < 0) {
                EXPECT_EQ(image.depth[i], 0);
                EXPECT_EQ(image.normal[i], glm::vec4(0));
                EXPECT_EQ(image.motion[i], glm::vec4(0));
                ++sky;
                continue;
            }
            ++surface;
            const Reference& triangle = triangles[static_cast<size_t>(hit.triangle)];
            const auto at = [&](const glm::dvec3* c) {
                return hit.weights.x * c[0] + hit.weights.y * c[1] + hit.weights.z * c[2];
            };
            const glm::dvec3 point = at(triangle.corner), before = at(triangle.before);
            ASSERT_GT(image.depth[i], 0) << x << ", " << y;
            // A centre may lie half a step of the grid past what it shows, along both axes.
            const double slope = 0.5 * (std::abs(hits[i + 1].t - hits[i - 1].t) +
                                        std::abs(hits[i + width].t - hits[i - width].t));
            const uint32_t bits = device_->limits().subPixelPrecisionBits;
            const double claimed = 0.5 * slope * std::exp2(-double(bits));
            const double view_depth = double(float(shot.near)) / image.depth[i];
            depth_error = std::max(depth_error, (std::abs(view_depth - hit.t) - claimed) / hit.t);

            glm::dvec3 normal = glm::normalize(
                glm::cross(triangle.corner[1] - triangle.corner[0], triangle.corner[2] - triangle.corner[0]));
            if (glm::dot(normal, point - eye) > 0) normal = -normal;
            normal_error = std::max(normal_error, glm::length(glm::dvec3(image.normal[i]) - normal));

            const glm::dvec3 expected =
                uv_and_depth(frame.previous, before) - uv_and_depth(frame.camera, point);
            const glm::dvec3 error = glm::dvec3(image.motion[i]) - expected;
            // rgba16f keeps 11 bits, and a device may round either way.
            const glm::dvec3 rounding = glm::abs(expected) / 1024.0;
            motion_error_px = std::max(motion_error_px, std::max((std::abs(error.x) - rounding.x) * width,
                                                                 (std::abs(error.y) - rounding.y) * height));
            change_error = std::max(change_error, (std::abs(error.z) - rounding.z) / hit.t);
            moved = std::max(moved, std::abs(expected.x) * width);
        }
    }
    EXPECT_GT(surface, 30000u);
    EXPECT_GT(sky, 3000u);
    EXPECT_GT(moved, 2);
    EXPECT_LT(depth_error, 2e-6);
    EXPECT_LT(normal_error, 1e-6);
    const double by_device = device_->info().is_cpu ? 1 : 2;  // which interpolates as finely as it likes
    EXPECT_LT(motion_error_px, by_device * 5e-4);
    EXPECT_LT(change_error, by_device * 1e-6);
    for (const auto& [name, value] : {std::pair("depth_error_1e9", depth_error),
                                      {"normal_error_1e9", normal_error},
                                      {"motion_error_px_1e9", motion_error_px},
                                      {"change_error_1e9", change_error}}) {
        RecordProperty(name, static_cast<int>(value * 1e9));  // seen with --gtest_output=json
    }
}

// A floor in triangles of a few pixels, each of which the rasteriser tilts as it moves its corners to its
// grid: interpolated, depth is off by up to 8 mm per metre on SwiftShader, which test.sh runs this on.
// lavapipe interpolates over the corners as they were.
TEST_F(GBufferTest, DepthIsThatOfThePixelsCentreHoweverFineTheTriangles) {
    Model model;
    model.materials = {{{1, 1, 1, 1}}};
    model.meshes.push_back({{to_part(ground(20, 20, 200, 200), 0)}});
    model.nodes = {Node{.name = "floor", .mesh = 0}};
    Shot shot = boxes_shot();
    shot.objects.clear();
    shot.camera = {{.frame = 0, .position = {0.3, 0.4, 6}, .target = {0, 0.2, 0}}};
    const Rendered image = render(*device_, shot, model, 3);
    const FrameDescription& frame = image.frame.description;
    const glm::dvec3 eye = glm::make_vec3(frame.camera.position.data());
    const auto depth_at = [&](double x, double y) {
        const glm::dvec2 uv((x + 0.5) / width - frame.jitter[0], (y + 0.5) / height - frame.jitter[1]);
        return -eye.y / ray_through(frame.camera, uv).y;
    };
    double worst = -INFINITY;
    size_t surface = 0;
    for (uint32_t y = 1; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            const float depth = image.depth[y * width + x];
            if (depth == 0) continue;
            ++surface;
            const double t = depth_at(x, y);
            worst = std::max(worst, std::abs(double(float(shot.near)) / depth - t) / t);
        }
    EXPECT_GT(surface, 15'000u);
    EXPECT_LT(worst, 1e-6);
}

// Absolute fp32 matrices are wrong by pixels already at 1e5 m.
TEST_F(GBufferTest, OriginChangesNothingBeyondRounding) {
    Shot shot = boxes_shot();
    const Rendered here = render(*device_, shot, boxes(), 3);
    shot.origin = {1e6, -2e6, 3e6};
    const Rendered there = render(*device_, shot, boxes(), 3);
    size_t differing_coverage = 0;
    for (size_t i = 0; i < here.depth.size(); ++i) {
        if (here.normal[i] != there.normal[i]) {
            ++differing_coverage;
            continue;
        }
        EXPECT_NEAR(there.depth[i], here.depth[i], here.depth[i] * 2e-6);
        // One step of the half's 11 bits, and what the camera's own position keeps at 1e6 m in double (2e-10
        // m).
        EXPECT_NEAR(there.motion[i].x, here.motion[i].x, std::abs(here.motion[i].x) / 1024 + 1e-6);
        EXPECT_NEAR(there.motion[i].y, here.motion[i].y, std::abs(here.motion[i].y) / 1024 + 1e-6);
    }
    EXPECT_LE(differing_coverage, here.depth.size() / 10000);
}

TEST_F(GBufferTest, StandingStillIsExactlyStill) {
    Shot shot = boxes_shot();
    shot.camera.pop_back();
    shot.objects.clear();
    const Rendered image = render(*device_, shot, boxes(), 3);
    for (const glm::vec4& motion : image.motion) ASSERT_EQ(motion, glm::vec4(0));
}

TEST_F(GBufferTest, ResetFrameHasNoMotion) {
    const Rendered image = render(*device_, boxes_shot(), boxes(), 3, true);
    EXPECT_EQ(image.frame.description.flags & frame_reset, uint32_t(frame_reset));
    for (const glm::vec4& motion : image.motion) ASSERT_EQ(motion, glm::vec4(0));
}

// A half turn: what was behind the camera has no previous place in the image, and must not get a mirrored
// one.
TEST_F(GBufferTest, PointsBehindThePreviousCameraGoOffScreen) {
    Shot shot = boxes_shot();
    shot.camera = {{.frame = 0, .position = {0, 1, 6}, .target = {0, 1, 20}},
                   {.frame = 1, .position = {0, 1, 6}, .target = {0, 1, -8}}};
    const Rendered image = render(*device_, shot, boxes(), 1);
    size_t seen = 0;
    for (uint32_t y = 0; y < height; ++y) {
        for (uint32_t x = 0; x < width; ++x) {
            const size_t i = y * width + x;
            if (image.depth[i] == 0) continue;
            ++seen;
            const glm::vec2 uv((float(x) + 0.5f) / width + image.motion[i].x,
                               (float(y) + 0.5f) / height + image.motion[i].y);
            ASSERT_FALSE(uv.x >= 0 && uv.x < 1 && uv.y >= 0 && uv.y < 1) << x << ", " << y;
            ASSERT_TRUE(std::isfinite(image.motion[i].x) && std::isfinite(image.motion[i].z));
        }
    }
    EXPECT_GT(seen, 1000u);
}

TEST_F(GBufferTest, AlbedoIsFactorTimesTextureInLinearLight) {
    Model model;
    Part part = to_part(ground(2, 2, 1, 1), 0);
    part.uv.assign(part.positions.size(), glm::vec2(0.5f));
    model.meshes.push_back({{part}});
    model.nodes = {Node{.name = "floor", .mesh = 0}};
    model.textures = {Texture{1, 1, {188, 255, 0, 255}}};  // sRGB 188 is 0.503 in linear light
    model.materials = {{{1, 0.5f, 1, 1}, 0}};
    Shot shot = boxes_shot();
    shot.objects.clear();
    const Rendered image = render(*device_, shot, model, 0);
    const size_t centre = (height / 2 + 20) * width + width / 2;
    ASSERT_GT(image.depth[centre], 0);
    EXPECT_NEAR(image.albedo[centre].r, 128, 1);
    EXPECT_NEAR(image.albedo[centre].g, 128, 1);
    EXPECT_EQ(image.albedo[centre].b, 0);
}

// A wall before the camera, the right half of which lets light through.
TEST_F(GBufferTest, OfWhatIsBlendedOpaqueTexelsAreDrawn) {
    const auto drawn = [&](uint8_t right, float transmission) {
        Model model;
        model.textures = {{2, 1, {255, 255, 255, 250, 255, 255, 255, right}}};
        Material& material = model.materials.emplace_back();
        material.texture = 0;
        material.alpha_blend = true;
        material.transmission = transmission;
        Shape wall;
        for (const glm::vec2 at : {glm::vec2(0, 1), glm::vec2(1, 1), glm::vec2(1, 0), glm::vec2(0, 0)}) {
            wall.positions.emplace_back(20 * at.x - 10, 11 - 20 * at.y, 0);
            wall.uv.push_back(at);
        }
        wall.indices = {0, 1, 2, 0, 2, 3};
        model.meshes.push_back({{to_part(wall, 0)}});
        model.nodes = {Node{.name = "wall", .mesh = 0}};
        Shot shot;
        shot.camera = {{.frame = 0, .position = {0, 1, 5}, .target = {0, 1, 0}}};
        shot.sun = {{.frame = 0, .to_sun = {0, 1, 0}}};
        const Rendered image = render(*device_, shot, model, 0);
        const size_t middle = height / 2 * width;
        return std::array{image.depth[middle + width / 4] > 0, image.depth[middle + 3 * width / 4] > 0};
    };
    EXPECT_EQ(drawn(255, 0), (std::array{true, true}));
    EXPECT_EQ(drawn(99, 0), (std::array{true, false}));
    EXPECT_EQ(drawn(255, 0.5f), (std::array{false, false}));
}

TEST_F(GBufferTest, EmptySceneIsSky) {
    Shot shot = boxes_shot();
    shot.objects.clear();
    const Rendered image = render(*device_, shot, Model{}, 0);
    EXPECT_TRUE(std::ranges::all_of(image.depth, [](float d) { return d == 0; }));
}

// glTF's doubleSided, by the side of the plane that the camera is on. A rasteriser's own front and back are
// those of corners on its grid, and on a far ridge show the undersides of what is steep.
TEST_F(GBufferTest, WhatHasOneSideShowsThatAlone) {
    Shot shot = boxes_shot();
    const auto with = [](Model model, bool single_sided, bool reversed) {
        for (Mesh& mesh : model.meshes)
            for (Part& part : mesh.parts) {
                part.single_sided = single_sided;
                for (size_t i = 0; reversed && i < part.indices.size(); i += 3)
                    std::swap(part.indices[i + 1], part.indices[i + 2]);
            }
        return model;
    };
    const Rendered both = render(*device_, shot, boxes(), 3);
    const Rendered closed = render(*device_, shot, with(boxes(), true, false), 3);
    EXPECT_EQ(closed.depth, both.depth) << "the camera is outside of everything, the mirrored box included";
    const Rendered inside_out = render(*device_, shot, with(boxes(), true, true), 3);
    size_t deeper = 0;
    for (size_t i = 0; i < both.depth.size(); ++i) {
        EXPECT_LE(inside_out.depth[i], both.depth[i]);
        deeper += inside_out.depth[i] < both.depth[i];
    }
    EXPECT_GT(deeper, 10'000u) << "floor and near walls are gone";

    Model hills;
    Shape grid = ground(40, 40, 300, 300);
    for (glm::vec3& p : grid.positions)
        p.y = 0.6f * std::sin(7 * p.x + 3 * std::sin(5 * p.z)) * std::cos(6 * p.z + 2 * std::sin(4 * p.x));
    hills.meshes.push_back({{to_part(std::move(grid), -1)}});
    hills.nodes = {Node{.name = "hills", .mesh = 0}};
    shot.objects.clear();
    const auto undersides = [](const Rendered& image) {
        return std::ranges::count_if(image.normal, [](const glm::vec4& n) { return n.y < 0; });
    };
    EXPECT_GT(undersides(render(*device_, shot, hills, 0)), 0);
    EXPECT_EQ(undersides(render(*device_, shot, with(hills, true, false), 0)), 0);
}

// A mesh that a joint or a morph target moves, and the same one moved by its node: nothing tells them apart.
TEST_F(GBufferTest, WhatDeformsIsWhereItIsAndComesFromWhereItWas) {
    Shot shot = boxes_shot();
    shot.objects.clear();
    shot.animation = "0";
    shot.fps = 1;
    const auto moving = [](AnimationChannel::Path path, int node, std::vector<float> values) {
        Animation animation;
        animation.duration_s = 4;
        animation.channels = {
            {node, path, AnimationChannel::Interpolation::linear, {0, 4}, std::move(values)}};
        return animation;
    };
    const glm::vec3 way(0.6f, 0.3f, 0.2f), start(-1.5f, 0.1f, 0);
    Model by_node = boxes(), by_joint = boxes(), by_target = boxes();
    by_node.animations = {
        moving(AnimationChannel::Path::translation, 1,
               {start.x, start.y, start.z, start.x + way.x, start.y + way.y, start.z + way.z})};

    by_joint.nodes[1].translation = {7, 7, 7};  // of no consequence
    by_joint.nodes[1].skin = 0;
    by_joint.nodes.push_back({.name = "joint", .translation = glm::dvec3(start)});
    by_joint.skins = {{{4}, {glm::dmat4(1)}}};
    by_joint.meshes.push_back(by_joint.meshes[1]);
    by_joint.nodes[1].mesh = 2;
    Part& bound = by_joint.meshes[2].parts[0];
    bound.joints.assign(bound.positions.size(), {0, 0, 0, 0});
    bound.weights.assign(bound.positions.size(), {1, 0, 0, 0});
    by_joint.animations = {
        moving(AnimationChannel::Path::translation, 4,
               {start.x, start.y, start.z, start.x + way.x, start.y + way.y, start.z + way.z})};

    by_target.meshes.push_back(by_target.meshes[1]);
    by_target.nodes[1].mesh = 2;
    Part& morphed = by_target.meshes[2].parts[0];
    morphed.targets = {std::vector<glm::vec3>(morphed.positions.size(), way)};
    by_target.animations = {moving(AnimationChannel::Path::weights, 1, {0, 1})};

    const Rendered expected = render(*device_, shot, by_node, 3);
    size_t moved = 0;
    for (const auto& [name, model] : {std::pair{"joint", &by_joint}, {"target", &by_target}}) {
        const Rendered seen = render(*device_, shot, *model, 3);
        size_t off = 0;
        for (size_t p = 0; p < expected.depth.size(); ++p) {
            if (std::abs(seen.depth[p] - expected.depth[p]) > 1e-5f * expected.depth[p]) {
                ++off;  // a pixel of an outline
                continue;
            }
            EXPECT_LE(glm::length(seen.normal[p] - expected.normal[p]), 1e-4f) << name;
            EXPECT_LE(glm::length(glm::vec3(seen.motion[p] - expected.motion[p])), 2e-3f) << name;
            moved += glm::length(glm::vec2(expected.motion[p])) > 0.02f;
        }
        EXPECT_LE(off, 40u) << name;

        const Rendered held = render(*device_, shot, by_node, 3, false, 1.0),
                       held_too = render(*device_, shot, *model, 3, false, 1.0);
        off = 0;
        for (size_t p = 0; p < held.depth.size(); ++p)
            off += std::abs(held_too.depth[p] - held.depth[p]) > 1e-5f * held.depth[p] ||
                   glm::length(glm::vec2(held_too.motion[p])) > 2e-3f;
        EXPECT_LE(off, 40u) << name << ": frames go on, the animation does not";
    }
    EXPECT_GT(moved, 500u) << "the mover is in the picture and moves";
    // Its triangles for rays stand there, too.
    const Scene a(by_node, shot), b(by_joint, shot), c(by_target, shot);
    const auto box_a = a.box(3), box_b = b.box(3), box_c = c.box(3);
    for (int k = 0; k < 2; ++k) {
        EXPECT_NEAR(glm::length(box_a[k] - box_b[k]), 0, 1e-5);
        EXPECT_NEAR(glm::length(box_a[k] - box_c[k]), 0, 1e-5);
    }
}

}  // namespace
}  // namespace penumbra::test
