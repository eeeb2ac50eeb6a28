// SPDX-License-Identifier: MIT
// The true visibility of a frozen frame: the closed form of an analytic scene, or many rays per pixel.
#pragma once

#include "app/session.h"

namespace penumbra {

// Rows from the top. `receiver`: 1 where a surface is, by geometry; `rays`: how many the visibility stands
// for.
struct Truth {
    std::vector<float> visibility, receiver, rays;
    // Pixels that show a surface of which no triangle was found where it was drawn: no receivers.
    size_t lost = 0;
};

Truth analytic_truth(const Shot& shot, uint32_t frame);

// A session of pipelines/reference.json at the shot's size, for counted_truth(). `jitter`: of pixels as
// `render` jitters them, instead of their centres.
std::unique_ptr<Session> open_truth(Device& device, const Shot& shot, Diagnostics& diagnostics,
                                    std::vector<std::string>& warnings, bool jitter = false);

// Of every pixel that shows a surface, rays_cast(rays) directions to the sun
// (host/truth/counted_visibility.h).
Truth counted_truth(Session& session, uint32_t frame, uint32_t rays);

// The same bit by bit, of the frame that the session has just run. Each round casts side x side rays per
// pixel in directions of its own; what is known is their mean.
class TruthRounds {
  public:
    TruthRounds(const Session& session, uint32_t frame, uint32_t side);
    ~TruthRounds();
    // Goes on, on all cores, for about so many milliseconds: at least a row, at most to the round's end.
    void work(double milliseconds);
    uint32_t rounds() const;         // that every pixel has
    Truth truth() const;             // of all rows so far; rays 0 where there are none yet
    bool knows(uint32_t row) const;  // a round of it is done

  private:
    struct State;
    std::unique_ptr<State> state_;
};

uint32_t rays_cast(uint32_t wanted);  // the next square

}  // namespace penumbra
