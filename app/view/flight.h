// SPDX-License-Identifier: MIT
// Where somebody stands who flies through a shot: along the shot's own course until he takes the camera or
// the sun into his hands, from there on as his keys and his mouse say.
#pragma once

#include <optional>

#include "host/standalone.h"

namespace penumbra::viewer {

// What hands have done since the last frame.
struct FlightInput {
    glm::dvec3 move{0};  // right, up and forward, each -1 .. 1
    glm::dvec2 look{0};  // radians: to the right, upwards
    glm::dvec2 sun{0};   // radians: azimuth, elevation
    double faster = 1;   // factor of the speed that is kept (the wheel)
    bool hurry = false;  // five times as fast while it holds
    double seconds = 0;  // since the last frame
    bool any() const { return move != glm::dvec3(0) || look != glm::dvec2(0) || sun != glm::dvec2(0); }
};

class Flight {
  public:
    // `shot` has a camera of its own, which an analytic scene's does not.
    explicit Flight(const Shot& shot);

    void steer(const FlightInput& input);
    // Goes on in the shot's time, where it plays, and begins again at its end.
    void tick();
    void play(bool on) { plays_ = on; }
    bool plays() const { return plays_; }
    // Back to the shot's own course, at its first frame.
    void start_over();

    Stance stance() const;
    double speed_m_per_s() const { return speed_; }

  private:
    struct Hands {
        glm::dvec3 position{0};
        double yaw = 0, pitch = 0;  // radians; 0, 0 looks along -z
    };
    Hands taken() const;  // where the shot's course is

    const Shot shot_;
    bool plays_ = false;
    double moment_ = 0, speed_ = 1;
    std::optional<Hands> hands_;
    std::optional<glm::dvec3> to_sun_;
};

}  // namespace penumbra::viewer
