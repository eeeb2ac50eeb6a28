// SPDX-License-Identifier: MIT
// What a standalone host brings to a sun's pipeline, as bytes: a test may change them before it hands them to
// a view of its own.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "host/bvh/bvh.h"
#include "host/standalone.h"
#include "tests/gpu_test.h"
#include "tests/view_run.h"

namespace penumbra::test {

// As GBuffer has them, for ViewRunOptions::formats.
inline const std::map<std::string, Format> host_image_formats{{"depth", Format::r32f},
                                                              {"normal", Format::rgba32f},
                                                              {"motion", Format::rgba16f},
                                                              {"albedo", Format::rgba8}};

inline std::map<std::string, std::vector<std::byte>> draw(StandaloneHost& host,
                                                          const StandaloneFrame& frame) {
    gpu().run([&](VkCommandBuffer commands) { host.record(commands, frame); });
    const GBufferImages& images = host.images();
    const auto read = [](const GpuImage& image) {
        return read_image(gpu(), image.get(), image.format, image.extent, GBuffer::final_layout);
    };
    return {{"depth", read(images.depth)},
            {"normal", read(images.normal)},
            {"motion", read(images.motion)},
            {"albedo", read(images.albedo)}};
}

// Everything but images.
inline void set_scene(ViewRun& run, const StandaloneHost& host, const StandaloneFrame& frame) {
    const auto bytes_of = [](const auto& value) { return std::as_bytes(std::span(&value, 1)); };
    const Bvh bvh =
        build_bvh(host.scene().triangles(frame.description.index), host.scene().triangle_objects());
    run.set("scene.nodes", std::as_bytes(std::span(bvh.nodes)));
    run.set("scene.leaves", std::as_bytes(std::span(bvh.leaves)));
    run.set("scene", bytes_of(frame.scene));
    run.set("sun", bytes_of(frame.sun));
    run.set("sun_prev", bytes_of(frame.sun_prev));
}

}  // namespace penumbra::test
