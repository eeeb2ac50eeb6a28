// SPDX-License-Identifier: MIT
#include "app/lit_picture.h"

#include <fmt/format.h>

#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

#include "host/images/triples.h"

namespace penumbra {
namespace {

constexpr uint32_t gap_px = 4;
const glm::dvec3 luminance_of(0.2126, 0.7152, 0.0722);  // ITU-R BT.709

std::vector<glm::vec3> displayed(const std::vector<glm::vec3>& rgb) {
    std::vector<glm::vec3> out;
    out.reserve(rgb.size());
    for (const glm::vec3& v : rgb) out.push_back(glm::clamp(v, 0.0f, 1.0f));
    return out;
}

bool is_finite(const glm::vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

std::optional<Picture> read_picture(const std::filesystem::path& file, Diagnostics& diagnostics) {
    const auto image = read_exr(file, diagnostics);
    if (!image) return std::nullopt;
    for (const char* name : {"R", "G", "B"}) {
        const Plane* plane = image->find(name);
        if (plane && plane->type != PlaneType::uint) continue;
        diagnostics.add({file.string(), 0, 0}, name, "there is no such channel of radiance");
        return std::nullopt;
    }
    return Picture{image->width, image->height, triples(*image, {"R", "G", "B"})};
}

bool is_finite(const Picture& truth, const std::filesystem::path& file, Diagnostics& diagnostics) {
    for (size_t i = 0; i < truth.rgb.size(); ++i) {
        if (is_finite(truth.rgb[i])) continue;
        diagnostics.add({file.string(), 0, 0}, "",
                        fmt::format("is a reference, and pixel {},{} of it is not finite", i % truth.width,
                                    i / truth.width));
        return false;
    }
    return true;
}

PictureError picture_error(const Picture& image, const Picture& truth) {
    PictureError out;
    std::vector<glm::vec3> shown = image.rgb;
    double is_sum = 0, should_sum = 0;
    for (size_t i = 0; i < shown.size(); ++i) {
        if (!is_finite(shown[i])) {
            ++out.nonfinite;
            shown[i] = glm::vec3(0);
        }
        const glm::dvec3 is(shown[i]), should(truth.rgb[i]);
        const double luminance = glm::dot(luminance_of, should);
        out.relmse += glm::dot(is - should, is - should) / (luminance * luminance + 0.01);
        is_sum += glm::dot(luminance_of, is);
        should_sum += luminance;
    }
    out.relmse /= static_cast<double>(shown.size());
    if (should_sum > 0) out.bias = is_sum / should_sum - 1;
    out.flip = *pool_flip(flip_map(truth.width, truth.height, displayed(truth.rgb), displayed(shown)));
    return out;
}

PlanarImage planar(const Picture& picture) {
    PlanarImage out{picture.width, picture.height, {}};
    const char* names[] = {"R", "G", "B"};
    for (int c = 0; c < 3; ++c) {
        std::vector<float> values;
        for (const glm::vec3& v : picture.rgb) values.push_back(v[c]);
        out.planes.push_back({names[c], PlaneType::real, std::move(values), {}});
    }
    return out;
}

void write_beside(const std::filesystem::path& file, const Picture& left, const Picture& right) {
    const uint32_t width = left.width + gap_px + right.width;
    std::vector<float> rgb(size_t{3} * width * left.height, 1.0f);
    for (const auto& [picture, at] : {std::pair{&left, 0u}, std::pair{&right, left.width + gap_px}})
        for (uint32_t y = 0; y < picture->height; ++y)
            for (uint32_t x = 0; x < picture->width; ++x)
                for (int c = 0; c < 3; ++c)
                    rgb[3 * (size_t{y} * width + at + x) + size_t(c)] =
                        exposed(picture->rgb[size_t{y} * picture->width + x][c]);
    write_png_color(file, width, left.height, rgb);
}

}  // namespace penumbra
