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
    // Where a scene has translucent triangles, red, green, blue of what arrives of the light.
    std::array<std::vector<float>, 3> transmittance = {};
};

Truth analytic_truth(const Shot& shot, uint32_t frame);

// What the pixels of one frozen frame see of a light. Several threads ask at once, of different pixels.
class PixelTruth {
  public:
    virtual ~PixelTruth() = default;
    enum class Sight { nothing, receiver, lost };
    // To be asked once of each pixel, before its visibility.
    virtual Sight look(uint32_t x, uint32_t y) = 0;
    struct Seen {
        double visibility = 0;
        glm::dvec3 transmittance{0};  // read where coloured()
    };
    // Of a receiver: the mean of side x side rays.
    virtual Seen seen(uint32_t x, uint32_t y, uint32_t side, uint32_t seed) const = 0;
    // Whether anything is translucent.
    virtual bool coloured() const { return false; }
};

// A session of pipelines/reference.json at the shot's size, for counted_truth(). `jitter`: of pixels as
// `render` jitters them, instead of their centres.
std::unique_ptr<Session> open_truth(Device& device, const Shot& shot, Diagnostics& diagnostics,
                                    std::vector<std::string>& warnings, bool jitter = false,
                                    KeptScene* kept = nullptr, const Told& doing = {});

// Of the frame that such a session has just run: the sun (host/truth/counted_visibility.h).
std::unique_ptr<PixelTruth> sun_pixels(const Session& session, uint32_t frame);

// Of every pixel that shows a surface, rays_cast(rays) directions to the sun. `step` is told of rows that are
// done.
Truth counted_truth(Session& session, uint32_t frame, uint32_t rays,
                    const std::function<void(uint32_t)>& step = {});

// Bit by bit. Each round casts side x side rays per pixel in directions of its own; what is known is their
// mean.
class TruthRounds {
  public:
    TruthRounds(std::unique_ptr<PixelTruth> pixels, Extent extent, uint32_t side, uint32_t seed);
    ~TruthRounds();
    // Goes on, on all cores, for about so many milliseconds: at least a row, at most to the round's end.
    void work(double milliseconds);
    uint32_t rounds() const;         // that every pixel has
    uint32_t rows() const;           // of the round that has begun, that are done or under way
    Truth truth() const;             // of all rows so far; rays 0 where there are none yet
    bool knows(uint32_t row) const;  // a round of it is done

  private:
    struct State;
    std::unique_ptr<State> state_;
};

uint32_t rays_cast(uint32_t wanted);  // the next square

}  // namespace penumbra
