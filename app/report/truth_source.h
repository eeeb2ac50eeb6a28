// SPDX-License-Identifier: MIT
// The truth of any frame of a shot, and what the sun shines on there.
#pragma once

#include <glm/glm.hpp>

#include "app/truth.h"

namespace penumbra::report {

struct LitSurfaces {
    std::vector<glm::vec3> albedo, normal;
    glm::dvec3 to_sun{0, 1, 0};
};

class TruthSource {
  public:
    // `analytic_border_px` is not counted along the border of analytic scenes.
    TruthSource(Device& device, Shot shot, std::array<uint32_t, 2> size, uint32_t rays,
                uint32_t analytic_border_px, Diagnostics& diagnostics, std::vector<std::string>& warnings);

    bool exact() const;                        // a closed form
    bool of_lamp() const;                      // of a shot that has nothing but one light that is near
    bool ready() const { return !!session_; }  // false after an error

    struct Frame {
        Truth truth;
        std::vector<uint8_t> counted;
        bool exact = false;
    };
    Frame at(uint32_t frame);
    LitSurfaces surfaces(uint32_t frame);

  private:
    Device& device_;
    Shot shot_;
    uint32_t rays_, border_ = 0;
    std::unique_ptr<Session> session_;
};

}  // namespace penumbra::report
