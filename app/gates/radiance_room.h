// SPDX-License-Identifier: MIT
// The scenes that radiance is gated in: a white furnace, and a room with stripes on its wall and a lamp.
#pragma once

#include <filesystem>

#include "host/shots/shot.h"

namespace penumbra::gates {

// Of the strips of floor, one in each class of roughness_class(). In whole 255ths: a tie, as of .1, a device
// may round either way, and in motion 26 is worth half as many rays again as 25.
inline constexpr std::array<float, 5> strip_roughness{0.03f, 26.0f / 255, 0.2f, 0.4f, 0.8f};

inline constexpr uint32_t lamp_off_frame = 33, last_off_frame = 96;

// Their models, as files in a temporary folder that goes with the object.
class RadianceScenes {
  public:
    RadianceScenes();
    ~RadianceScenes();
    RadianceScenes(const RadianceScenes&) = delete;
    RadianceScenes& operator=(const RadianceScenes&) = delete;

    // A floor alone in surroundings of radiance 1, seen by a camera that moves.
    Shot furnace(std::array<uint32_t, 2> size, uint32_t frames) const;
    // The room, seen by one that stands, or moves by half a pixel to two a frame.
    Shot room(std::array<uint32_t, 2> size, uint32_t frames, bool moving) const;
    // The room at rest, whose lamp is gone from lamp_off_frame on.
    Shot lamp_off(std::array<uint32_t, 2> size) const;

  private:
    Shot night(const char* model, std::array<uint32_t, 2> size, uint32_t frames, bool moving) const;

    std::filesystem::path folder_;
};

}  // namespace penumbra::gates
