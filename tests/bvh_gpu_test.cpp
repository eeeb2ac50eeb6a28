// SPDX-License-Identifier: MIT
// bvh.glsl on the first Vulkan device against the reference traversal in C++: the same arithmetic, so the
// same answers, ray for ray; and rays_together.glsl against it, where eight lanes are a vector of one thread.
// A compiler that fuses multiply-add, or a driver that loses a value set inside a divergent loop, shows here.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <cmath>

#include "host/bvh/bvh.h"
#include "tests/bvh_large_planes.h"
#include "tests/bvh_oracle.h"
#include "tests/bvh_scenes.h"
#include "tests/bvh_shipped_scenes.h"
#include "tests/gpu_test.h"
#include "tests/vulkan_compute.h"

namespace penumbra {
namespace {

using namespace test;

struct GpuRay {
    float origin[3], t_min, direction[3], t_max;
};

std::vector<uint32_t> answers(Compute& compute, const Bvh& bvh, const std::vector<Ray>& rays) {
    std::vector<GpuRay> in;
    for (const Ray& r : rays)
        in.push_back({{r.origin[0], r.origin[1], r.origin[2]},
                      r.t_min,
                      {r.direction[0], r.direction[1], r.direction[2]},
                      r.t_max});
    const std::vector<uint32_t> unanswered(rays.size(), 0xDEADBEEFu);
    const std::span<const std::byte> contents[] = {
        std::as_bytes(std::span(bvh.nodes)), std::as_bytes(std::span(bvh.leaves)),
        std::as_bytes(std::span(in)), std::as_bytes(std::span(unanswered))};
    compute.bind(contents);
    compute.run(uint32_t((rays.size() + 63) / 64), uint32_t(rays.size()));
    const auto* out = static_cast<const uint32_t*>(compute.mapped(3));
    return {out, out + rays.size()};
}

class BvhGpu : public GpuTest {
  protected:
    void SetUp() override {
        GpuTest::SetUp();
        const VkDescriptorType bindings[] = {
            VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER, VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER,
            VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER};
        compute.load(BVH_RAYS_SPV, bindings);
        cpu_device = gpu().info().is_cpu;
        VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
        VkPhysicalDeviceSubgroupProperties lanes{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES,
                                                 &driver};
        VkPhysicalDeviceProperties2 all{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &lanes};
        vkGetPhysicalDeviceProperties2(gpu().physical(), &all);
        walks_together = cpu_device && lanes.subgroupSize == 8;
        if (walks_together) together.load(BVH_RAYS_TOGETHER_SPV, bindings);
        keeps_denormals = driver.driverID == VK_DRIVER_ID_MESA_LLVMPIPE;  // which does not promise it
        std::printf("device: %s\n", gpu().info().name.c_str());
    }

    // A CPU device divides with correct rounding and must agree bit for bit. Vulkan allows others 2.5 ulp in
    // the ray's slopes; then the oracle has the last word, and at most this share of rays is open to it.
    // Trees that the device's texel buffers cannot hold, which are what this shader reads, are not asked.
    void expect_equal(const std::string& name, const std::vector<Triangle>& triangles,
                      const std::vector<Ray>& rays, double most_differ = 1e-4) {
        const Bvh bvh = build_bvh(triangles);
        const size_t most = test::gpu().limits().maxTexelBufferElements;
        if (std::max(bvh.nodes.size(), bvh.leaves.size()) > most) {
            std::printf("%s: more than the %zu texels of a buffer here\n", name.c_str(), most);
            return;
        }
        ++asked;
        const std::vector<uint32_t> gpu = answers(compute, bvh, rays);
        EXPECT_TRUE(!walks_together || answers(together, bvh, rays) == gpu) << name;
        size_t differ = 0, hits = 0;
        for (size_t i = 0; i < rays.size(); ++i) {
            ASSERT_LE(gpu[i], 1u) << "ray " << i << " was not answered";
            const bool cpu = occluded(bvh, rays[i]);
            hits += cpu;
            if (gpu[i] == uint32_t(cpu)) continue;
            ++differ;
            EXPECT_NE(truth(triangles, rays[i]), cpu ? Truth::blocked : Truth::clear)
                << name << ", ray " << i;
        }
        std::printf("%s: %zu of %zu rays blocked, %zu differ from the reference\n", name.c_str(), hits,
                    rays.size(), differ);
        EXPECT_LE(double(differ), cpu_device ? 0 : std::ceil(most_differ * double(rays.size()))) << name;
        EXPECT_GT(hits, 0u) << name;
    }

    Compute compute{gpu()}, together{gpu()};
    bool cpu_device = false, keeps_denormals = false, walks_together = false;
    size_t asked = 0;  // scenes
};

TEST_F(BvhGpu, AnswersLikeTheReference) {
    for (const TriangleScene& s : all_scenes())
        expect_equal(s.name, s.triangles, shadow_rays(s.triangles, 250'000, 21));
    EXPECT_GT(asked, all_scenes().size() / 2);
}

// Rays towards the small end of a tree as deep as they get: what they pass waits until they are down, and a
// walk that forgot what waits longest would miss it.
TEST_F(BvhGpu, DeepTreesAnswerLikeTheReference) {
    // A triangle's distance has products of three lengths, and Vulkan lets a device take what is below 2^-126
    // for 0. Of a small ray the largest triangles' planes lie within rounding of its start.
    const int smallest = keeps_denormals ? -59 : -24;
    for (const int copies : {6, 24}) {
        Random random(27);
        std::vector<Ray> rays;
        for (int i = 0; i < 10'000; ++i) {
            const float size = std::ldexp(1.0f, int(random.in(float(smallest), 38)));
            const Vec from{size * random.in(0.5f, 3), size * random.in(0.5f, 3), size * random.in(0.5f, 3)};
            rays.push_back({{from.x, from.y, from.z}, {-from.x, -from.y, -from.z}, 0, 2});
        }
        expect_equal(fmt::format("series of {}", copies), geometric_series(copies), rays, 0.1);
    }
}

TEST_F(BvhGpu, LargePlanesAnswerLikeTheReference) {
    for (const double half : {1e3, 1e4})
        for (const glm::dvec3& normal : plane_normals) {
            LargePlane plane = large_plane(half, 3, normal, 100'000, 24);
            // Half of the origins within the bound around the plane, where the last bit decides.
            Random random(25);
            for (size_t i = 0; i < plane.rays.size(); i += 2)
                for (int axis = 0; axis < 3; ++axis)
                    plane.rays[i].origin[axis] -= float(normal[axis] * half) * random.in(0, 4e-6f);
            expect_equal(fmt::format("plane +-{} m, normal {} {} {}", half, normal.x, normal.y, normal.z),
                         plane.quad, plane.rays);
        }
}

// Needles of 10^5 : 1, each a millimetre ahead of a ray's start: one float cannot say on which side.
TEST_F(BvhGpu, NeedlesAtTheStartAnswerLikeTheReference) {
    Random random(26);
    std::vector<Triangle> needles;
    std::vector<Ray> rays;
    const auto vec = [](const glm::vec3& p) { return Vec{p.x, p.y, p.z}; };
    for (int i = 0; i < 8000; ++i) {
        const glm::vec3 place = 0.5f * glm::vec3(i % 20, i / 20 % 20, i / 400);  // out of each other's way
        const auto direction = [&] {
            const Vec d = random_direction(random);
            return glm::vec3(d.x, d.y, d.z);
        };
        const glm::vec3 along = direction(), across = glm::normalize(glm::cross(along, direction()));
        const glm::vec3 a = place - 5e-7f * across, b = place + 5e-7f * across, c = place + 0.1f * along;
        needles.push_back(triangle(vec(a), vec(b), vec(c)));
        const glm::vec3 target = 0.45f * (a + b) + 0.1f * c, d = 1e-3f * glm::cross(along, across),
                        o = target - d;
        rays.push_back({{o.x, o.y, o.z}, {d.x, d.y, d.z}, 0, 2});
    }
    expect_equal("needles", needles, rays);
}

TEST_F(BvhGpu, EmptySceneBlocksNothing) {
    const std::vector<Triangle> one{triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0})};
    for (uint32_t a : answers(compute, build_bvh({}), shadow_rays(one, 1000, 22))) ASSERT_EQ(a, 0u);
}

TEST_F(BvhGpu, ClosedMeshesDoNotLeakAtEdgesAndVertices) {
    const Vec centre{1.5f, -2.25f, 30};
    const std::vector<Triangle> ball = closed_ball(5, centre, 5);
    Random random(23);
    std::vector<Ray> rays;
    for (int i = 0; i < 1'000'000; ++i) {
        const auto& t = ball[random.bits() % ball.size()].v;
        const auto &a = t[i % 3], &b = t[(i + 1) % 3];
        const float along = i % 2 ? 0.0f : random.unit();
        const Vec origin = centre + random_direction(random) * random.in(0, 4);
        rays.push_back({{origin.x, origin.y, origin.z},
                        {a[0] + (b[0] - a[0]) * along - origin.x, a[1] + (b[1] - a[1]) * along - origin.y,
                         a[2] + (b[2] - a[2]) * along - origin.z},
                        0,
                        std::numeric_limits<float>::infinity()});
    }
    const std::vector<uint32_t> gpu = answers(compute, build_bvh(ball), rays);
    EXPECT_EQ(std::count(gpu.begin(), gpu.end(), 1u), std::ssize(gpu));
}

TEST_F(BvhGpu, AxisParallelRaysAnswerLikeTheReference) {
    std::vector<Triangle> flat;
    for (int i = 0; i < 5; ++i) {
        const float o = float(i) * 2;
        add_quad(flat, {o, 0, 0}, {o, 1, 0}, {o, 1, 1}, {o, 0, 1});
        add_quad(flat, {0, o, 3}, {1, o, 3}, {1, o, 4}, {0, o, 4});
        add_quad(flat, {3, 3, o}, {4, 3, o}, {4, 4, o}, {3, 4, o});
    }
    std::vector<Ray> rays;
    const float values[] = {-1, -0.0f, 0, 1}, places[] = {-1, 0, 0.25f, 1, 2, 3, 3.5f, 5};
    for (float dx : values)
        for (float dy : values)
            for (float dz : values)
                for (float ox : places)
                    for (float oy : places)
                        for (float oz : places)
                            if (dx != 0 || dy != 0 || dz != 0)
                                rays.push_back(
                                    {{ox, oy, oz}, {dx, dy, dz}, 0, std::numeric_limits<float>::infinity()});
    expect_equal("flat", flat, rays);
}

}  // namespace
}  // namespace penumbra
