// SPDX-License-Identifier: MIT
// The device draws what each pixel shows; the rest is the processor's, row by row on all its cores.
#include "app/truth.h"

#include <atomic>
#include <chrono>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>
#include <limits>
#include <thread>

#include "app/captured_values.h"
#include "app/reference_pipeline.h"
#include "app/reference_session.h"
#include "app/view_rays.h"
#include "host/generated/noise.h"
#include "host/truth/analytic.h"
#include "host/truth/counted_visibility.h"
#include "host/truth/octahedral.h"

namespace penumbra {
namespace {

uint32_t strata_per_axis(uint32_t rays) {
    return static_cast<uint32_t>(std::ceil(std::sqrt(static_cast<double>(rays))));
}

}  // namespace

uint32_t rays_cast(uint32_t wanted) {
    return strata_per_axis(wanted) * strata_per_axis(wanted);
}

Truth analytic_truth(const Shot& shot, uint32_t frame) {
    const std::vector<double> exact = analytic_image(shot, frame);
    const std::vector<uint8_t> receivers = analytic_receivers(shot, frame);
    return {{exact.begin(), exact.end()},
            {receivers.begin(), receivers.end()},
            std::vector<float>(exact.size(), 0.0f)};
}

std::unique_ptr<Session> open_truth(Device& device, const Shot& shot, Diagnostics& diagnostics,
                                    std::vector<std::string>& warnings, bool jitter, KeptScene* kept,
                                    const Told& doing) {
    SessionOptions options;
    options.jitter = jitter;
    options.light = "sun";
    options.kept = kept;
    options.doing = doing;
    return open_own(device, shot, {reference_pipeline_text, "pipelines/reference.json"}, std::move(options),
                    diagnostics, warnings);
}

namespace {

class SunPixels : public PixelTruth {
  public:
    SunPixels(const Session& session, uint32_t index)
        : width_(session.plan().extent.width),
          counted_(session.host().scene(), session.host().moment(index)),
          rays_(session.frame_description(),
                session.host().shot().origin + session.host().scene().bvh_origin()),
          sun_(sun_at(session.host().shot(), index)),
          points_(size_t{width_} * session.plan().extent.height),
          depth_(captured_values<float>(session, "view_depth")),
          normal_(captured_values<float>(session, "receiver_normal")) {}

    Sight look(uint32_t x, uint32_t y) override {
        const size_t p = size_t{y} * width_ + x;
        if (!(depth_[p] > 0)) return Sight::nothing;
        points_[p] = counted_.shown(rays_.at(x, y), depth_[p],
                                    octahedral_normal({normal_[2 * p], normal_[2 * p + 1]}));
        return points_[p] ? Sight::receiver : Sight::lost;
    }
    Seen seen(uint32_t x, uint32_t y, uint32_t side, uint32_t seed) const override {
        const SunStrata strata{sun_.to_sun, sun_.angular_radius, side, seed};
        const auto seen = counted_.seen(*points_[size_t{y} * width_ + x], strata);
        return {seen.visibility, seen.transmittance};
    }
    bool coloured() const override { return counted_.has_translucent(); }

  private:
    uint32_t width_;
    CountedVisibility counted_;
    ViewRays rays_;
    SunState sun_;
    std::vector<std::optional<SurfacePoint>> points_;
    std::vector<float> depth_, normal_;
};

}  // namespace

std::unique_ptr<PixelTruth> sun_pixels(const Session& session, uint32_t frame) {
    return std::make_unique<SunPixels>(session, frame);
}

struct TruthRounds::State {
    State(std::unique_ptr<PixelTruth> of, Extent size, uint32_t strata, uint32_t first_seed)
        : pixels(std::move(of)),
          extent(size),
          side(strata),
          seed(first_seed),
          receiver(size_t{size.width} * size.height),
          sums(receiver.size()),
          colors(pixels->coloured() ? receiver.size() : 0),
          row_rounds(extent.height) {}

    void trace_row(uint32_t y) {
        for (uint32_t x = 0; x < extent.width; ++x) {
            const size_t p = size_t{y} * extent.width + x;
            if (round == 0) {
                const PixelTruth::Sight sight = pixels->look(x, y);
                receiver[p] = sight == PixelTruth::Sight::receiver;
                if (sight == PixelTruth::Sight::lost) ++lost;
            }
            if (!receiver[p]) continue;
            const PixelTruth::Seen seen = pixels->seen(x, y, side, pcg(uint32_t(p) + pcg(seed + round)));
            sums[p] += seen.visibility;
            if (!colors.empty()) colors[p] += seen.transmittance;
        }
        row_rounds[y] = round + 1;
    }

    std::unique_ptr<PixelTruth> pixels;
    Extent extent;
    uint32_t side, seed;
    std::vector<uint8_t> receiver;
    std::vector<double> sums;        // over rounds
    std::vector<glm::dvec3> colors;  // as well; none where nothing is coloured
    std::vector<uint32_t> row_rounds;
    uint32_t round = 0;
    std::atomic<uint32_t> next_row{0};
    std::atomic<size_t> lost{0};
};

TruthRounds::TruthRounds(std::unique_ptr<PixelTruth> pixels, Extent extent, uint32_t side, uint32_t seed)
    : state_(std::make_unique<State>(std::move(pixels), extent, side, seed)) {}
TruthRounds::~TruthRounds() = default;

void TruthRounds::work(double milliseconds) {
    using Clock = std::chrono::steady_clock;
    State& s = *state_;
    const auto start = Clock::now();
    const auto some = [&] {
        for (uint32_t y; (y = s.next_row++) < s.extent.height;) {
            s.trace_row(y);
            if (std::chrono::duration<double, std::milli>(Clock::now() - start).count() >= milliseconds)
                return;
        }
    };
    {
        std::vector<std::jthread> others(std::max(std::thread::hardware_concurrency(), 1u) - 1);
        for (std::jthread& thread : others) thread = std::jthread(some);
        some();
    }
    if (s.next_row < s.extent.height) return;
    s.next_row = 0;
    ++s.round;
}

uint32_t TruthRounds::rounds() const {
    return state_->round;
}

uint32_t TruthRounds::rows() const {
    return state_->next_row;
}

bool TruthRounds::knows(uint32_t row) const {
    return state_->row_rounds.at(row) > 0;
}

Truth TruthRounds::truth() const {
    const State& s = *state_;
    const size_t pixels = s.receiver.size();
    Truth truth{std::vector<float>(pixels, 1), std::vector<float>(pixels), std::vector<float>(pixels)};
    if (!s.colors.empty()) truth.transmittance.fill(std::vector<float>(pixels, 1));
    for (size_t p = 0; p < pixels; ++p) {
        const uint32_t rounds = s.row_rounds[p / s.extent.width];
        if (!s.receiver[p] || rounds == 0) continue;
        truth.visibility[p] = static_cast<float>(s.sums[p] / rounds);
        truth.receiver[p] = 1;
        truth.rays[p] = static_cast<float>(s.side * s.side * rounds);
        for (size_t channel = 0; channel < 3 && !s.colors.empty(); ++channel)
            truth.transmittance[channel][p] =
                static_cast<float>(s.colors[p][static_cast<glm::length_t>(channel)] / rounds);
    }
    truth.lost = s.lost;
    return truth;
}

Truth counted_truth(Session& session, uint32_t frame, uint32_t rays,
                    const std::function<void(uint32_t)>& step) {
    constexpr double between_steps_ms = 250;
    session.run_frame(frame, false);
    const Extent extent = session.plan().extent;
    TruthRounds rounds(sun_pixels(session, frame), extent, strata_per_axis(rays), session.seed());
    for (uint32_t told = 0; rounds.rounds() == 0;) {
        rounds.work(step ? between_steps_ms : std::numeric_limits<double>::infinity());
        const uint32_t rows = rounds.rounds() > 0 ? extent.height : rounds.rows();
        if (step) step(rows - std::exchange(told, rows));
    }
    return rounds.truth();
}

}  // namespace penumbra
