// SPDX-License-Identifier: MIT
#include "host/materials/environment.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "host/images/image_file.h"
#include "host/images/input_limit.h"

namespace penumbra {
namespace {

// Four floats, and what environment_lots() makes of them: three doubles, an index, four words.
constexpr uint64_t bytes_per_texel = 60;

// Bilinear in the polar angle, a sky of this height is off by (pi / 1024)^2 / 8 of its curvature: 1e-6.
constexpr uint32_t sky_width = 4, sky_height = 1024;

EnvironmentMap sky(const EnvironmentSky& sky) {
    EnvironmentMap map{sky_width, sky_height, {}};
    for (uint32_t y = 0; y < sky_height; ++y) {
        const double height = std::cos((y + 0.5) / sky_height * std::numbers::pi);
        const double up = sky.linear ? 0.5 + 0.5 * height : std::sqrt(std::max(height, 0.0));
        for (uint32_t x = 0; x < sky_width; ++x) {
            for (int c = 0; c < 3; ++c)
                map.rgba.push_back(static_cast<float>(sky.low[c] + up * (sky.high[c] - sky.low[c])));
            map.rgba.push_back(1);
        }
    }
    return map;
}

std::optional<EnvironmentMap> from_file(const EnvironmentFile& file, Diagnostics& diagnostics) {
    const auto image = read_exr(file.path, diagnostics);
    if (!image) return std::nullopt;
    EnvironmentMap map{image->width, image->height, {}};
    const size_t texels = size_t{image->width} * image->height;
    if (texels * bytes_per_texel > input_limit()) {
        diagnostics.add(
            {file.path.string()}, "",
            fmt::format("an environment of {}x{} takes {}", image->width, image->height, over_input_limit()));
        return std::nullopt;
    }
    map.rgba.assign(4 * texels, 1);
    size_t c = 0;
    for (const char* name : {"R", "G", "B"}) {
        const Plane* plane = image->find(name);
        if (!plane || plane->type == PlaneType::uint) {
            diagnostics.add({file.path.string()}, name, "an environment needs this channel, in floats");
            return std::nullopt;
        }
        for (size_t i = 0; i < plane->values.size(); ++i) {
            const double value = plane->values[i] * file.scale;
            if (!(value >= 0 && value <= 1e30)) {
                diagnostics.add({file.path.string()}, name,
                                fmt::format("{} at {}, {} is no radiance: finite numbers from 0 on are",
                                            value, i % image->width, i / image->width));
                return std::nullopt;
            }
            map.rgba[4 * i + c] = static_cast<float>(value);
        }
        ++c;
    }
    return map;
}

}  // namespace

std::optional<EnvironmentMap> make_environment(const Shot& shot, Diagnostics& diagnostics) {
    if (const auto* file = std::get_if<EnvironmentFile>(&shot.environment))
        return from_file(*file, diagnostics);
    return sky(std::get<EnvironmentSky>(shot.environment));
}

bool is_black(const EnvironmentMap& map) {
    for (size_t i = 0; i < map.rgba.size(); ++i)
        if (i % 4 != 3 && map.rgba[i] != 0) return false;
    return true;
}

GpuImage upload_environment(Device& device, const EnvironmentMap& map) {
    GpuImage image = make_image(device, VK_FORMAT_R32G32B32A32_SFLOAT, {map.width, map.height}, 1,
                                VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT, "environment");
    upload_image(device, image, std::as_bytes(std::span(map.rgba)));
    return image;
}

}  // namespace penumbra
