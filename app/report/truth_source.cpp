// SPDX-License-Identifier: MIT
#include "app/report/truth_source.h"

#include "app/light_truth.h"
#include "app/outputs.h"
#include "host/images/triples.h"

namespace penumbra::report {
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
    LitSurfaces out{triples(host_image(device_, *session_, "albedo"), {"R", "G", "B"}),
                    triples(host_image(device_, *session_, "normal"), {"X", "Y", "Z"}),
                    sun_at(shot_, frame).to_sun};
    for (glm::vec3& normal : out.normal)
        if (const float length = glm::length(normal); length > 0) normal /= length;
    return out;
}

}  // namespace penumbra::report
