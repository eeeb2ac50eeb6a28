// SPDX-License-Identifier: MIT
// The node `radiance_reference` is repeated on one frame until all rays are cast.
#include "app/radiance_truth.h"

#include <algorithm>
#include <cmath>

#include "app/captured_values.h"
#include "app/outputs.h"
#include "app/reference_pipeline.h"
#include "app/reference_session.h"
#include "host/images/texels.h"
#include "host/images/triples.h"

namespace penumbra {
namespace {

constexpr uint64_t rays_per_pass = 1u << 21;
// Mesa 22's lavapipe ends an invocation's loops, all of them together, after 65 535 rounds, without a word. A
// ray is followed by a second one, to the sun; lamps add a third, and the environment's lots as many again.
uint64_t rays_per_invocation(const Plan& plan) {
    return uint64_t{64} >> (plan.slot("lights") ? 1 : 0) >> (plan.slot("environment_lots") ? 1 : 0);
}

std::vector<float> roughness_of(Device& device, const Session& session, size_t pixels) {
    const GpuImage& material = session.host().images().material;
    if (std::ranges::find(session.plan().slots, "material", &HostSlot::name) == session.plan().slots.end())
        return std::vector<float>(pixels, 1.0f);
    const std::vector<std::byte> bytes =
        read_image(device, material.get(), material.format, material.extent, GBuffer::final_layout);
    return decode_texels(Format::rg8, material.extent.width, material.extent.height, bytes,
                         {"metallic", "roughness"})
        .planes[1]
        .values;
}

Picture captured_picture(const Session& session, const char* name) {
    const PlanarImage image = captured_image(session, name);
    return {image.width, image.height, triples(image, {"R", "G", "B"})};
}

std::unique_ptr<Session> open(Device& device, const Shot& shot, const OwnPipeline& own,
                              std::vector<std::string> captures, Diagnostics& diagnostics,
                              std::vector<std::string>& warnings, const Told& doing) {
    SessionOptions options;
    options.captures = std::move(captures);
    options.jitter = false;
    options.doing = doing;
    return open_own(device, shot, own, std::move(options), diagnostics, warnings);
}

// All rays of a frozen frame.
void cast(Session& session, uint32_t frame, uint32_t rays, const std::function<void(uint32_t)>& step) {
    const Extent extent = session.plan().extent;
    const uint64_t pixels = uint64_t{extent.width} * extent.height;
    const auto portion = static_cast<uint32_t>(
        std::clamp<uint64_t>(rays_per_pass / pixels, 1, rays_per_invocation(session.plan())));
    for (uint32_t first = 0; first < rays; first += portion) {
        session.set_param("first", first);
        session.set_param("count", std::min(portion, rays - first));
        if (first == 0)
            session.run_frame(frame, false);
        else
            session.repeat_frame();
        if (step) step(std::min(portion, rays - first));
    }
}

}  // namespace

RadiancePlanes radiance_planes(const PlanarImage& image) {
    return {{image.find("R")->values, image.find("G")->values, image.find("B")->values}};
}

RadianceTruth known_of(const PlanarImage& truth) {
    return {truth.width,
            radiance_planes(truth),
            truth.find("receiver")->values,
            truth.find("roughness")->values,
            truth.find("ray_error")->values,
            truth.find("noise")->values};
}

std::unique_ptr<Session> open_lit_truth(Device& device, const Shot& shot, Diagnostics& diagnostics,
                                        std::vector<std::string>& warnings, const Told& doing) {
    return open(device, shot, {reference_lit_pipeline_text, "pipelines/reference_lit.json"},
                {"lit", "specular", "diffuse", "specular_share", "diffuse_share"}, diagnostics, warnings,
                doing);
}

LitTruth lit_truth(Session& session, uint32_t frame, uint32_t rays,
                   const std::function<void(uint32_t)>& step) {
    cast(session, frame, rays, step);
    return {captured_picture(session, "lit"), captured_picture(session, "specular"),
            captured_picture(session, "diffuse"), captured_picture(session, "specular_share"),
            captured_picture(session, "diffuse_share")};
}

std::unique_ptr<Session> open_radiance_truth(Device& device, const Shot& shot, const std::string& signal,
                                             Diagnostics& diagnostics, std::vector<std::string>& warnings,
                                             const Told& doing) {
    return open(device, shot,
                {reference_radiance_pipeline_text,
                 "pipelines/reference_radiance.json",
                 {"nodes.reference.params.lobe=" + signal}},
                {"weighted_sum", "plain_sum"}, diagnostics, warnings, doing);
}

PlanarImage radiance_truth(Device& device, Session& session, uint32_t frame, uint32_t rays,
                           const std::function<void(uint32_t)>& step) {
    cast(session, frame, rays, step);
    const Extent extent = session.plan().extent;
    const uint64_t pixels = uint64_t{extent.width} * extent.height;
    const auto weighted = captured_values<std::array<float, 4>>(session, "weighted_sum"),
               plain = captured_values<std::array<float, 4>>(session, "plain_sum");
    PlanarImage out{extent.width, extent.height, {}};
    for (const char* name : {"R", "G", "B", "receiver", "roughness", "ray_error", "noise"})
        out.planes.push_back({name, PlaneType::real, std::vector<float>(pixels, 0.0f), {}});
    out.planes[4].values = roughness_of(device, session, pixels);
    for (size_t i = 0; i < pixels; ++i) {
        const double weight = weighted[i][3];
        if (!(weight > 0)) continue;
        // E|L - S|^2 = E|L|^2 - 2 S.E L + |S|^2. Of a mirror it is the rounding of sums in single precision:
        // nothing.
        double error = plain[i][3] / double(rays);
        const double rounding = 1e-5 * error;
        for (size_t c = 0; c < 3; ++c) {
            const double signal = weighted[i][c] / weight;
            out.planes[c].values[i] = static_cast<float>(signal);
            error += signal * (signal - 2 * plain[i][c] / double(rays));
        }
        if (error < rounding) error = 0;
        out.planes[3].values[i] = 1;
        out.planes[5].values[i] = static_cast<float>(error);
        out.planes[6].values[i] = static_cast<float>(error / rays);
    }
    return out;
}

}  // namespace penumbra
