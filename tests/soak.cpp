// SPDX-License-Identifier: MIT
#include "tests/soak.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "host/truth/analytic.h"
#include "tests/process_size.h"
#include "tests/shot_run.h"

namespace penumbra::test {
namespace {

constexpr uint32_t window = 256, settled = 192;  // frames; settled: six histories of 32
constexpr uint32_t after_jump = 3;
constexpr size_t windows_between = 8;

Shot still_shot(const SoakOptions& options) {
    Shot shot;
    shot.analytic = AnalyticScene{.penumbra_px = options.width_px, .edge_deg = 17};
    shot.size = options.size;
    shot.frames = options.frames + after_jump;
    shot.sun = {{0, {0.3, 0.2, 1}}};
    return shot;
}

double jump_px(const Shot& shot) {
    return shot.size[0] / 3.0;
}

// The caster stays where it is up to the last frame of the run and is elsewhere in the next one.
Shot jumping_shot(const SoakOptions& options) {
    Shot shot = still_shot(options);
    const glm::dvec2 way = jump_px(shot) * analytic_pixel_m * analytic_geometry(shot, 0).normal;
    shot.objects["caster"].keys = {{double(options.frames - 1), glm::dvec3(0), glm::dvec3(0)},
                                   {double(options.frames), glm::dvec3(way, 0), glm::dvec3(0)}};
    return shot;
}

class Run {
  public:
    Run(Device& device, const SoakOptions& options)
        : run_(options.pipeline, jumping_shot(options), {}, device) {}
    std::vector<float> frame(uint32_t index) { return run_.frame(index, !std::exchange(begun_, true)); }

    // Where the run goes on after its last frame, and the caster has jumped: the mean distance from the truth
    // over that of the picture before.
    double left_after_jump(const SoakOptions& options) {
        Shot there = still_shot(options);
        const std::vector<float> before = analytic_truth(there, 0).visibility;
        there.analytic->offset_px = jump_px(there);
        const std::vector<float> after = analytic_truth(there, 0).visibility;
        std::vector<float> now;
        for (uint32_t i = 0; i < after_jump; ++i) now = frame(options.frames + i);
        double left = 0, whole = 0;
        for (size_t i = 0; i < now.size(); ++i) {
            left += std::abs(now[i] - after[i]);
            whole += std::abs(before[i] - after[i]);
        }
        return left / whole;
    }

  private:
    ShotRun run_;
    bool begun_ = false;
};

}  // namespace

double Soak::drift() const {
    const size_t third = windows.size() / 3;
    double sum = 0;
    for (size_t i = 0; i < third; ++i) sum += windows[windows.size() - 1 - i].mean - windows[i].mean;
    return std::abs(sum) / static_cast<double>(third);
}

double Soak::n_eff_kept() const {
    const size_t third = windows.size() / 3;
    double first = 0, last = 0;
    for (size_t i = 0; i < third; ++i) {
        first += windows[i].n_eff;
        last += windows[windows.size() - 1 - i].n_eff;
    }
    return last / first;
}

double Soak::kept_noise() const {
    double squares = 0, sum = windows.front().n_eff;
    for (size_t i = 1; i < windows.size(); ++i) {
        squares += std::pow(windows[i].n_eff - windows[i - 1].n_eff, 2);
        sum += windows[i].n_eff;
    }
    const auto n = static_cast<double>(windows.size()), third = std::floor(n / 3);
    // What is lost steadily is the mean of the differences, and no noise.
    squares -= std::pow(windows.back().n_eff - windows.front().n_eff, 2) / (n - 1);
    const double of_a_window = std::sqrt(squares / (n - 2) / 2) / (sum / n);
    return of_a_window * std::sqrt(2 / third);
}

long Soak::grown_kib() const {
    return windows.back().resident_kib - windows.front().resident_kib;
}

long Soak::more_files() const {
    return windows.back().open_files - windows.front().open_files;
}

bool soak_holds(const Soak& result) {
    return result.drift() <= 1e-4 && result.n_eff_kept() >= 0.95 - 2 * result.kept_noise() &&
           result.left <= result.left_of_young + 0.01 && result.nonfinite == 0 &&
           result.grown_kib() < 8 * 1024 && result.more_files() == 0;
}

Soak soak(Device& device, const SoakOptions& options) {
    if (options.frames < settled + 4 * window) throw std::invalid_argument("too few frames for a soak");
    const std::vector<float> truth = analytic_truth(still_shot(options), 0).visibility;
    double signal = 0;
    for (const double v : truth)
        if (v >= 1.0 / 256 && v <= 255.0 / 256) signal += v * (1 - v);

    // Evenly from the first to the last, without overlaps where the run is short.
    Soak result;
    const uint32_t last = options.frames - window;
    const size_t count = std::min<size_t>(windows_between, (last - settled) / window) + 1;
    for (size_t i = 0; i < count; ++i)
        result.windows.push_back({settled + static_cast<uint32_t>(i * (last - settled) / (count - 1))});

    Run run(device, options);
    uint32_t next = 0;
    for (SoakWindow& w : result.windows) {
        double error = 0, sum = 0;
        for (; next < w.first + window; ++next) {
            const std::vector<float> v = run.frame(next);
            if (next < w.first) continue;
            for (size_t i = 0; i < v.size(); ++i) {
                result.nonfinite += !std::isfinite(v[i]);
                error += (double(v[i]) - truth[i]) * (double(v[i]) - truth[i]);
                sum += v[i];
            }
        }
        w.n_eff = signal * window / error;
        w.mean = sum / static_cast<double>(truth.size() * window);
        w.resident_kib = resident_kib();
        w.open_files = open_files();
    }
    result.left = run.left_after_jump(options);

    Run young(device, options);
    for (uint32_t index = options.frames - window; index < options.frames; ++index) young.frame(index);
    result.left_of_young = young.left_after_jump(options);
    return result;
}

}  // namespace penumbra::test
