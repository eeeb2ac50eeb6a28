// SPDX-License-Identifier: MIT
// The table of docs/scenes.md: penumbra_scene_facts SHOT... writes it as Markdown, measured at 320 pixels'
// width.
#include <fmt/core.h>

#include <cmath>
#include <cstdio>

#include "host/scene/scene_facts.h"

using namespace penumbra;

namespace {

constexpr uint32_t width = 320;

bool measure(Device& device, const char* path) {
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    std::optional<Shot> shot = read_shot(path, diagnostics);
    std::optional<Scene> scene = shot ? load_scene(*shot, diagnostics, warnings) : std::nullopt;
    if (!scene) {
        fmt::print(stderr, "{}", diagnostics.text());
        return false;
    }
    const auto height = static_cast<uint32_t>(std::lround(double(width) * shot->size[1] / shot->size[0]));
    const double sun = shot->sun_angular_radius_deg;
    StandaloneHost host(device, std::move(*shot), std::move(*scene), {{width, height}, 1, false});
    const SceneFacts facts = scene_facts(device, host);
    fmt::print("| {} | {} | {:.4g} | {:.1f} % | {:.1f} % | {} of {} ({:.3g} m) | {:.2f} % |\n",
               host.shot().name, facts.triangles, sun, 100 * facts.receivers, 100 * facts.penumbra,
               facts.sub_texel, facts.casters, facts.texel_m, 100 * facts.disoccluded);
    std::fflush(stdout);
    return true;
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2) {
        fmt::print(stderr, "usage: penumbra_scene_facts SHOT...\n");
        return 2;
    }
    try {
        Device device(DeviceOptions{});
        fmt::print(
            "| shot | triangles | sun, degrees | receivers | in penumbra | casters below a texel | "
            "disoccluded |\n"
            "|---|---|---|---|---|---|---|\n");
        bool good = true;
        for (int i = 1; i < argc; ++i) good = measure(device, argv[i]) && good;
        return good ? 0 : 2;
    } catch (const std::exception& error) {
        fmt::print(stderr, "{}\n", error.what());
        return 1;
    }
}
