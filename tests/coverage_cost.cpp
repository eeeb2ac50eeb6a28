// SPDX-License-Identifier: MIT
// What coverage costs by the number of triangles that a cone meets, and where hybrid_shadows leaves off and
// casts rays: one wavy sheet over a floor, of 10^2 to 10^6 triangles, under suns of .1 to 10 degrees. Per row
// the CPU time of a pixel that no beam decides, for covered.json, for the rays that hybrid_shadows would cast
// instead in every such pixel, and for hybrid_shadows itself, with the share of pixels that it leaves to
// rays. A Markdown table: build/release/tests/coverage_cost
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>

#include "app/session.h"
#include "host/images/image_file.h"
#include "host/models/glb_writer.h"
#include "host/models/model_builder.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/test_folder.h"

namespace penumbra {
namespace {

constexpr uint32_t frames = 12, first_counted = 4;

Shape wavy_sheet(uint32_t cells) {
    Shape sheet;
    const double half = 1.5;
    for (uint32_t i = 0; i <= cells; ++i)
        for (uint32_t k = 0; k <= cells; ++k) {
            const double x = half * (2.0 * i / cells - 1), z = half * (2.0 * k / cells - 1);
            sheet.positions.emplace_back(x, 1.5 + 0.1 * std::sin(5 * x + 1) * std::cos(4 * z), z);
        }
    for (uint32_t i = 0; i < cells; ++i)
        for (uint32_t k = 0; k < cells; ++k) {
            const uint32_t a = i * (cells + 1) + k, b = a + cells + 1;
            for (const uint32_t v : {a, a + 1, b, b, a + 1, b + 1}) sheet.indices.push_back(v);
        }
    return sheet;
}

Shot shot_under(const std::filesystem::path& model, double radius_deg) {
    Shot shot;
    shot.name = "sheet";
    shot.model = model;
    shot.size = {320, 180};
    shot.frames = frames;
    shot.camera = {{0, {0.2, 3, 4}, {0.4, 0, 0.3}, {0, 1, 0}},
                   {frames, {0.4, 3, 4}, {0.4, 0, 0.3}, {0, 1, 0}}};
    shot.sun_angular_radius_deg = radius_deg;
    shot.sun = {{0, {-0.3, 0.8, -0.2}}};
    return shot;
}

struct Cost {
    double us = 0;     // of a pixel that beams left, in beams, cover and trace
    double steps = 0;  // per pixel that asked
    double left = 0;   // share of pixels that went to rays
};

Cost cost_of(Device& device, const std::string& name, const std::vector<std::string>& settings,
             const Shot& shot) {
    SessionOptions options;
    options.size = shot.size;
    options.jitter = false;
    const auto session = test::open_session(test::shipped_pipeline(name, settings), shot, options,
                                            test::shipped_nodes(), device);
    std::vector<Cost> costs;
    for (uint32_t frame = 0; frame < frames; ++frame) {
        const FrameCost cost = session->run_frame(frame, frame == 0);
        if (frame < first_counted) continue;
        double ms = 0, asked = 0, undecided = 0, left = 0, steps = 0;
        for (size_t p = 0; p < cost.passes.size(); ++p) {
            const PlanPass& pass = session->plan().passes[p];
            const std::string& type = pass.type;
            if (type == "cover" || type == "trace") ms += cost.pass_cpu_ms[p].value_or(0);
            const auto count = [&](const char* counter) {
                const std::vector<std::string>& names = pass.counters;
                return double(
                    cost.passes[p].counters.at(size_t(std::ranges::find(names, counter) - names.begin())));
            };
            if (type == "beams") undecided = count("unknown");
            if (type == "cover") asked = count("pixels"), left = count("left"), steps = count("steps");
        }
        costs.push_back({1e3 * ms / undecided, steps / std::max(asked, 1.0), left / undecided});
    }
    const auto middle = costs.begin() + costs.size() / 2;
    std::nth_element(costs.begin(), middle, costs.end(),
                     [](const Cost& a, const Cost& b) { return a.us < b.us; });
    return *middle;
}

void run() {
    Device device(DeviceOptions{});
    const test::TestFolder folder;
    const std::filesystem::path file = folder / "sheet.glb";
    fmt::print(
        "| triangles | sun, degrees | coverage, us per pixel | steps | 32 rays | hybrid_shadows | left to "
        "rays | over the better |\n"
        "|---|---|---|---|---|---|---|---|\n");
    for (const uint32_t cells : {7u, 22u, 71u, 224u, 707u}) {
        ModelBuilder builder({{{0.8f, 0.8f, 0.75f, 1}, -1}});
        builder.solid("floor", ground(20, 20, 8, 8), 0);
        builder.solid("sheet", wavy_sheet(cells), 0);
        write_file(file, to_glb(builder.take()));
        for (const double radius : {0.1, 0.2665, 1.0, 3.0, 10.0}) {
            const Shot shot = shot_under(file, radius);
            const Cost covered = cost_of(device, "covered", {}, shot);
            const Cost rays = cost_of(device, "hybrid_shadows", {"nodes.cover.params.budget=1"}, shot);
            const Cost hybrid = cost_of(device, "hybrid_shadows", {}, shot);
            fmt::print("| {} | {} | {:.2f} | {:.0f} | {:.2f} | {:.2f} | {:.0f} % | {:.2f} |\n",
                       2 * cells * cells, radius, covered.us, covered.steps, rays.us, hybrid.us,
                       100 * hybrid.left, hybrid.us / std::min(covered.us, rays.us));
            std::cout.flush();
        }
    }
}

}  // namespace
}  // namespace penumbra

int main() {
    try {
        penumbra::run();
    } catch (const std::exception& error) {
        std::cerr << "coverage_cost: " << error.what() << "\n";
        return 1;
    }
}
