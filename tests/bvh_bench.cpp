// SPDX-License-Identifier: MIT
// Rays per second of one core: bvh.glsl on the first Vulkan device (a CPU device is meant), the reference
// traversal, and Embree's rtcOccluded1, on the same coherent sun rays and in turns, so that a busy machine
// slows all of them alike. CPU time of the process, not wall time. Usage: bvh_bench [shader.spv]...
// (docs/bvh.md). Texels are fetched or loaded as plans do on this device; of a shader that is named, fetched.
#include <embree3/rtcore.h>
#include <fmt/core.h>

#include <algorithm>
#include <cstring>
#include <ctime>
#include <functional>
#include <limits>
#include <memory>

#include "app/session.h"
#include "tests/bvh_scenes.h"
#include "tests/vulkan_compute.h"

using namespace penumbra;
using namespace penumbra::test;

namespace {

double cpu_seconds() {
    timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
}

struct GpuRay {
    float origin[3], t_min, direction[3], t_max;
};

// A 1024 x 512 picture of the scene, from above at a slant, in blocks of 4x2 pixels (8 lanes); every hit
// sends one ray into the sun's cone.
std::vector<Ray> sun_rays(RTCScene scene, Vec eye, Vec target, float angular_radius) {
    Random random(7);
    const Vec sun = normalised({0.35f, 0.45f, 0.25f}), forward = normalised(target - eye);
    const Vec right = normalised({-forward.z, 0, forward.x});
    const Vec up = {right.y * forward.z - right.z * forward.y, right.z * forward.x - right.x * forward.z,
                    right.x * forward.y - right.y * forward.x};
    std::vector<Ray> rays;
    for (int by = 0; by < 256; ++by)
        for (int bx = 0; bx < 256; ++bx)
            for (int lane = 0; lane < 8; ++lane) {
                const float x = (float(bx * 4 + lane % 4) + 0.5f) / 512 - 1,
                            y = 0.5f - (float(by * 2 + lane / 4) + 0.5f) / 512;
                const Vec d = normalised(forward + right * (0.8f * x) + up * (0.8f * y));
                RTCRayHit hit{};
                hit.ray = {eye.x, eye.y, eye.z, 0, d.x, d.y, d.z, 0, 1e30f, ~0u, 0, 0};
                hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
                RTCIntersectContext context;
                rtcInitIntersectContext(&context);
                rtcIntersect1(scene, &context, &hit);
                const Vec jitter = random_direction(random) * (angular_radius * std::sqrt(random.unit()));
                if (hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) continue;
                const Vec n = normalised({hit.hit.Ng_x, hit.hit.Ng_y, hit.hit.Ng_z});
                const float side = n.x * d.x + n.y * d.y + n.z * d.z > 0 ? -1e-4f : 1e-4f;
                const Vec p = eye + d * hit.ray.tfar + n * side, s = normalised(sun + jitter);
                if ((n.x * s.x + n.y * s.y + n.z * s.z) * side <= 0)
                    continue;  // decided shadowed without a ray
                rays.push_back({{p.x, p.y, p.z}, {s.x, s.y, s.z}, 0, std::numeric_limits<float>::infinity()});
            }
    return rays;
}

RTCScene embree_scene(RTCDevice device, const std::vector<Triangle>& triangles) {
    RTCScene scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12,
                                        triangles.size() * 3),
                triangles.data(), triangles.size() * sizeof(Triangle));
    auto* indices = static_cast<uint32_t*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, triangles.size()));
    for (uint32_t i = 0; i < triangles.size() * 3; ++i) indices[i] = i;
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    rtcCommitScene(scene);
    return scene;
}

uint64_t embree_hits(RTCScene scene, const std::vector<Ray>& rays) {
    uint64_t hits = 0;
    for (const Ray& r : rays) {
        RTCRay ray{
            r.origin[0], r.origin[1], r.origin[2], r.t_min, r.direction[0], r.direction[1], r.direction[2], 0,
            r.t_max,     ~0u,         0,           0};
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcOccluded1(scene, &context, &ray);
        hits += ray.tfar < 0;
    }
    return hits;
}

// One way to answer all rays, and the best of its times.
struct Tracer {
    std::string name;
    std::function<uint64_t()> trace;  // returns the hits
    double seconds = std::numeric_limits<double>::infinity();
    uint64_t hits = 0;
};

struct View {
    const char* name;
    std::vector<Triangle> triangles;
    Vec eye, target;
};

void bench(RTCDevice device, const View& view, std::vector<std::string> shaders) {
    const RTCScene scene = embree_scene(device, view.triangles);
    const double before = cpu_seconds();
    const Bvh bvh = build_bvh(view.triangles);
    const double build_s = cpu_seconds() - before;
    const std::vector<Ray> rays = sun_rays(scene, view.eye, view.target, 0.0047f);

    TraversalCounts counts;
    for (const Ray& ray : rays) occluded(bvh, ray, &counts);
    const double n = double(rays.size());
    fmt::print(
        "{}: {} triangles, {} leaves, {} nodes, built in {:.2f} s; {} rays, {:.1f} nodes and {:.1f} leaves "
        "per ray\n",
        view.name, view.triangles.size(), bvh.corners.size(), bvh.nodes.size() / 3, build_s, rays.size(),
        double(counts.nodes) / n, double(counts.leaves) / n);

    std::vector<GpuRay> gpu_rays;
    for (const Ray& r : rays)
        gpu_rays.push_back({{r.origin[0], r.origin[1], r.origin[2]},
                            r.t_min,
                            {r.direction[0], r.direction[1], r.direction[2]},
                            r.t_max});
    const std::vector<uint32_t> zeros(rays.size());
    const std::span<const std::byte> contents[] = {
        std::as_bytes(std::span(bvh.nodes)), std::as_bytes(std::span(bvh.leaves)),
        std::as_bytes(std::span(gpu_rays)), std::as_bytes(std::span(zeros))};
    std::vector<Tracer> tracers{{"Embree rtcOccluded1", [&] { return embree_hits(scene, rays); }},
                                {"bvh.cpp, the reference", [&] {
                                     uint64_t hits = 0;
                                     for (const Ray& r : rays) hits += occluded(bvh, r);
                                     return hits;
                                 }}};
    Device vulkan({});
    std::vector<std::unique_ptr<Compute>> devices;
    const bool loaded = shaders.empty() && device_table(handles_of(vulkan)).loads_texels;
    if (shaders.empty()) shaders = {loaded ? BVH_RAYS_LOADED_SPV : BVH_RAYS_SPV};
    const VkDescriptorType texels =
        loaded ? VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER : VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER;
    const VkDescriptorType bindings[] = {texels, texels, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                                         VK_DESCRIPTOR_TYPE_STORAGE_BUFFER};
    for (const std::string& shader : shaders) {
        devices.push_back(std::make_unique<Compute>(vulkan));
        Compute* gpu = devices.back().get();
        gpu->load(shader, bindings);
        gpu->bind(contents);
        tracers.push_back({shader + " on " + vulkan.info().name, [gpu, &rays] {
                               gpu->run(uint32_t((rays.size() + 63) / 64), uint32_t(rays.size()));
                               const auto* answers = static_cast<const uint32_t*>(gpu->mapped(3));
                               return uint64_t(std::count(answers, answers + rays.size(), 1u));
                           }});
    }
    for (int round = 0; round < 40; ++round)  // the first compiles and warms up
        for (Tracer& t : tracers) {
            const double start = cpu_seconds();
            t.hits = t.trace();
            if (round > 0) t.seconds = std::min(t.seconds, cpu_seconds() - start);
        }
    for (const Tracer& t : tracers)
        fmt::print("  {:6.2f} Mrays/s = {:3.0f} % of Embree, {} hits: {}\n", n * 1e-6 / t.seconds,
                   100 * tracers[0].seconds / t.seconds, t.hits, t.name);
    rtcReleaseScene(scene);
}

}  // namespace

int main(int argc, char** argv) {
    const std::vector<std::string> shaders(argv + 1, argv + argc);
    RTCDevice device = rtcNewDevice("threads=1");
    bench(device, {"terrain", terrain(354), {-9, 9, -9}, {0, 0, 0}}, shaders);
    bench(device, {"colonnade", colonnade(64, 60, 32), {-13, 4.5f, -15}, {0, 0, 0}}, shaders);
    bench(device, {"terrain, 1 M", terrain(707), {-9, 9, -9}, {0, 0, 0}}, shaders);
    rtcReleaseDevice(device);
}
