// SPDX-License-Identifier: MIT
#include "tests/shot_run.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

#include "tests/view_run.h"

namespace penumbra::test {

Shot shot_named(const std::string& name, std::optional<std::array<uint32_t, 2>> size) {
    Diagnostics diagnostics;
    auto shot =
        read_shot(std::filesystem::path(PENUMBRA_SOURCE_DIR) / "scenes" / (name + ".shot.json"), diagnostics);
    if (!shot) throw std::runtime_error(diagnostics.text());
    if (size) shot->size = *size;
    return std::move(*shot);
}

std::unique_ptr<Session> open_session(const CheckedPipeline& pipeline, Shot shot,
                                      const SessionOptions& options, const NodeSet& nodes, Device& device) {
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    auto session = Session::open(device, nodes, pipeline, std::move(shot), options, diagnostics, warnings);
    if (!session) throw std::runtime_error(diagnostics.text());
    return session;
}

ShotRun::ShotRun(const std::string& pipeline, Shot shot, const RunOptions& options, Device& device) {
    SessionOptions session_options;
    session_options.size = shot.size;
    session_options.captures = options.captures;
    session_options.captures.emplace_back("visibility");
    session_options.seed = options.seed;
    if (!options.jitter) session_options.jitter = false;
    session_options.facts = options.facts;
    session_options.cascade_size = options.cascade_size;
    session_options.alias = options.alias;
    session_options.poison = options.poison;
    session_options.pass_costs = false;
    session_ = open_session(shipped_pipeline(pipeline, options.settings, test_nodes()), std::move(shot),
                            session_options, test_nodes(), device);
}

std::vector<float> ShotRun::frame(uint32_t index, bool reset) {
    session_->run_frame(index, reset);
    return plane("visibility");
}

std::vector<float> ShotRun::up_to(uint32_t last) {
    for (uint32_t index = 0; index < last; ++index) session_->run_frame(index, index == 0);
    return frame(last, last == 0);
}

std::vector<float> ShotRun::plane(const std::string& capture, size_t channel) const {
    return captured_planes(session_->view(), capture).at(channel);
}

std::vector<uint32_t> ShotRun::words(const std::string& capture) const {
    return captured<uint32_t>(session_->view(), capture);
}

std::vector<float> ShotRun::mean(uint32_t frames) {
    std::vector<double> sum;
    for (uint32_t index = 0; index < frames; ++index) {
        const std::vector<float> v = frame(index, index == 0);
        sum.resize(v.size());
        for (size_t i = 0; i < v.size(); ++i) sum[i] += v[i];
    }
    std::vector<float> mean(sum.size());
    std::ranges::transform(sum, mean.begin(), [&](double s) { return static_cast<float>(s / frames); });
    return mean;
}

Truth truth_of(const Shot& shot, uint32_t frame, uint32_t rays) {
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto session = open_truth(gpu(), shot, diagnostics, warnings);
    if (!session) throw std::runtime_error(diagnostics.text());
    return counted_truth(*session, frame, rays);
}

double rms(const std::vector<float>& a, const std::vector<float>& b) {
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) sum += (double(a[i]) - b[i]) * (double(a[i]) - b[i]);
    return std::sqrt(sum / static_cast<double>(a.size()));
}

size_t count_if(const std::vector<float>& values, const std::function<bool(float)>& test) {
    return static_cast<size_t>(std::ranges::count_if(values, test));
}

size_t nonfinite(const std::vector<float>& values) {
    return count_if(values, [](float v) { return !std::isfinite(v); });
}

double n_eff(const std::vector<float>& image, const std::vector<float>& truth,
             const std::function<bool(size_t)>& counted) {
    double signal = 0, error = 0;
    for (size_t i = 0; i < truth.size(); ++i) {
        if (counted && !counted(i)) continue;
        const double v = truth[i];
        if (v >= 1.0 / 256 && v <= 255.0 / 256) signal += v * (1 - v);
        error += (image[i] - v) * (image[i] - v);
    }
    return signal / error;
}

double n_eff_of_receivers(const std::vector<float>& image, const Truth& truth) {
    return n_eff(image, truth.visibility, [&](size_t i) { return truth.receiver[i] > 0; });
}

}  // namespace penumbra::test
