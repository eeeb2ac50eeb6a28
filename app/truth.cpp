// SPDX-License-Identifier: MIT
// The node `reference` is repeated on one frame until all rays are cast, in portions so that no submission
// takes long.
#include "app/truth.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "app/reference_pipeline.h"
#include "host/truth/analytic.h"
#include "penumbra/shadow_nodes.h"

namespace penumbra {
namespace {

constexpr uint32_t probe_side = 8;            // 64 rays decide whether a pixel wants more
constexpr uint64_t rays_per_pass = 1u << 23;  // if every pixel wanted them
// Mesa 22's lavapipe ends an invocation's loops, all of them together, after 65 535 rounds, without a word: a
// ray takes up to some hundred steps through the tree.
constexpr uint64_t rays_per_invocation = 128;

uint32_t strata_per_axis(uint32_t rays) {
    return static_cast<uint32_t>(std::ceil(std::sqrt(static_cast<double>(rays))));
}

// One set of side * side rays; `first_stage` is the stage of its first portion (see
// shaders/visibility/reference.comp).
template <class Run>
void cast(Session& session, uint32_t side, uint32_t first_stage, uint32_t portion, Run&& run) {
    const uint32_t rays = side * side;
    session.set_param("side", side);
    for (uint32_t first = 0; first < rays; first += portion) {
        session.set_param("stage", first == 0 ? first_stage : 2u);
        session.set_param("first", first);
        session.set_param("count", std::min(portion, rays - first));
        run();
    }
}

}  // namespace

uint32_t rays_cast(uint32_t wanted) {
    return strata_per_axis(wanted) * strata_per_axis(wanted);
}

Truth analytic_truth(const Shot& shot, uint32_t frame) {
    const std::vector<double> exact = analytic_image(shot, frame);
    const std::vector<uint8_t> receivers = analytic_receivers(shot, frame);
    return {{exact.begin(), exact.end()},
            {receivers.begin(), receivers.end()},
            std::vector<float>(exact.size(), 0.0f)};
}

std::unique_ptr<Session> open_truth(Device& device, const Shot& shot, Diagnostics& diagnostics,
                                    std::vector<std::string>& warnings) {
    static const NodeSet nodes = shadow_nodes();  // plans point into it
    const auto pipeline =
        parse_pipeline(reference_pipeline_text, "pipelines/reference.json", {}, diagnostics);
    const auto checked = pipeline ? check(*pipeline, nodes, diagnostics) : std::nullopt;
    if (!checked) return nullptr;
    SessionOptions options;
    options.size = shot.size;
    options.captures = {"counts"};
    options.light = "sun";
    options.jitter = false;
    options.optimum = false;
    return Session::open(device, nodes, *checked, shot, options, diagnostics, warnings);
}

Truth counted_truth(Session& session, uint32_t frame, uint32_t rays) {
    const Extent extent = session.plan().extent;
    const uint64_t pixels = uint64_t{extent.width} * extent.height;
    const auto portion =
        static_cast<uint32_t>(std::clamp<uint64_t>(rays_per_pass / pixels, 1, rays_per_invocation));
    cast(session, probe_side, 0, probe_side * probe_side, [&] { session.run_frame(frame, false); });
    cast(session, strata_per_axis(rays), 1, portion, [&] { session.repeat_frame(); });

    const std::span<const std::byte> bytes = session.view().captured("counts");
    std::vector<std::array<uint32_t, 4>> counts(pixels);
    if (bytes.size() != pixels * sizeof counts[0])
        throw std::logic_error("counts are not one uvec4 per pixel");
    std::memcpy(counts.data(), bytes.data(), bytes.size());
    Truth truth;
    for (const std::array<uint32_t, 4>& c : counts) {
        truth.visibility.push_back(c[1] ? static_cast<float>(double(c[0]) / double(c[1])) : 1.0f);
        truth.receiver.push_back(c[1] ? 1.0f : 0.0f);
        truth.rays.push_back(static_cast<float>(c[1]));
    }
    return truth;
}

}  // namespace penumbra
