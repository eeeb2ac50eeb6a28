// SPDX-License-Identifier: MIT
#include "app/report/truth_source.h"

#include "app/light_truth.h"
#include "app/outputs.h"

namespace penumbra::report {
namespace {

std::vector<glm::vec3> triples(const PlanarImage& image) {
    std::vector<glm::vec3> out;
    for (size_t p = 0; p < image.planes[0].values.size(); ++p)
        out.emplace_back(image.planes[0].values[p], image.planes[1].values[p], image.planes[2].values[p]);
    return out;
}

}  // namespace

TruthSource::TruthSource(Device& device, Shot shot, std::array<uint32_t, 2> size, uint32_t rays,
                         uint32_t analytic_border_px, Diagnostics& diagnostics,
                         std::vector<std::string>& warnings)
    : device_(device), shot_(std::move(shot)), rays_(rays) {
    shot_.size = size;
    border_ = exact() ? analytic_border_px : 0;
    session_ =
        of_lamp() ? open_light_truth(device, shot_, shot_.lights.begin()->first, diagnostics, warnings, false)
                  : open_truth(device, shot_, diagnostics, warnings);
}

bool TruthSource::of_lamp() const {
    return !shot_.has_sun && shot_.lights.size() == 1;
}

bool TruthSource::exact() const {
    return shot_.analytic.has_value();
}

TruthSource::Frame TruthSource::at(uint32_t frame) {
    Frame out{exact()     ? analytic_truth(shot_, frame)
              : of_lamp() ? counted_light_truth(*session_, frame, rays_)
                          : counted_truth(*session_, frame, rays_),
              {},
              exact()};
    const auto [width, height] = shot_.size;
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x)
            out.counted.push_back(out.truth.receiver[size_t{y} * width + x] > 0.5f && x >= border_ &&
                                  y >= border_ && x + border_ < width && y + border_ < height);
    return out;
}

LitSurfaces TruthSource::surfaces(uint32_t frame) {
    session_->run_frame(frame, false);  // its host images are what is wanted
    LitSurfaces out{triples(host_image(device_, *session_, "albedo")),
                    triples(host_image(device_, *session_, "normal")), sun_at(shot_, frame).to_sun};
    for (glm::vec3& normal : out.normal)
        if (const float length = glm::length(normal); length > 0) normal /= length;
    return out;
}

}  // namespace penumbra::report
