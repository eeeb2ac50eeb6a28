// SPDX-License-Identifier: MIT
// A flight that was recorded, as a shot: the shot that was flown through, with the camera and the sun as they
// were held. It lasts as long as the flight did, at the shot's frames per second, however many the view had.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "host/shots/shot.h"
#include "host/standalone.h"

namespace penumbra::viewer {

class FlightRecord {
  public:
    // `seconds` since the recording began; they rise.
    void add(const Stance& stance, double seconds) { held_.push_back({stance, seconds}); }
    bool empty() const { return held_.empty(); }
    double seconds() const { return held_.empty() ? 0 : held_.back().seconds; }
    static constexpr uint32_t most_frames = 100'000;  // of any shot
    // Whether it lasts longer than a shot of so many frames per second can: its shot ends before it does.
    bool has_more(double fps) const { return lasting(fps) >= most_frames; }

    // The text of a shot file that will stand in `folder`. `base`: the flown shot's own text, as it stands in
    // the folder of `shot`. The camera and the sun get a key wherever a straight course between two keys
    // would miss what was recorded by more than a thousandth of how far the target is, at the shot's first
    // key or then, whichever is nearer, or a direction by as much. What moves by itself (objects, an
    // animation) plays from the shot's first frame. Not of an empty record.
    std::string shot_text(const std::string& base, const Shot& shot,
                          const std::filesystem::path& folder) const;

  private:
    struct Held {
        Stance stance;
        double seconds = 0;
    };
    double lasting(double fps) const;  // frames, but the first
    std::vector<Stance> frames(double fps) const;

    std::vector<Held> held_;
};

}  // namespace penumbra::viewer
