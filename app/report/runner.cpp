// SPDX-License-Identifier: MIT
#include "app/report/runner.h"

#include <algorithm>
#include <set>
#include <stdexcept>

#include "app/outputs.h"

namespace penumbra::report {
namespace {

std::string without_previous(std::string name) {
    if (name.ends_with("@-1")) name.resize(name.size() - 3);
    return name;
}

// Passes that visibility depends on, in this frame or through history.
std::vector<bool> passes_of_mask(const Plan& plan) {
    std::vector<bool> needed(plan.passes.size());
    std::set<std::string> names{"visibility"};
    for (bool grown = true; grown;) {
        grown = false;
        for (size_t p = 0; p < plan.passes.size(); ++p) {
            const PlanPass& pass = plan.passes[p];
            if (needed[p] || pass.kind == PassKind::capture ||
                std::none_of(pass.writes.begin(), pass.writes.end(),
                             [&](const std::string& name) { return names.contains(name); }))
                continue;
            needed[p] = grown = true;
            for (const std::string& name : pass.reads) names.insert(without_previous(name));
        }
    }
    return needed;
}

uint64_t counted_rays(const Plan& plan, const FrameCost& cost) {
    uint64_t rays = 0;
    for (size_t p = 0; p < plan.passes.size(); ++p) {
        if (!plan.passes[p].entry) continue;
        const std::vector<std::string>& names = plan.passes[p].entry->type.counters;
        for (size_t i = 0; i < names.size(); ++i)
            if (names[i] == "rays") rays += cost.passes[p].counters[i];
    }
    return rays;
}

void add(std::optional<double>& sum, const std::optional<double>& value) {
    if (sum && value) *sum += *value;
}

std::unique_ptr<Session> open_session(Device& device, const NodeSet& nodes, const Contender& contender,
                                      const Shot& shot, std::array<uint32_t, 2> size,
                                      Diagnostics& diagnostics, std::vector<std::string>& warnings) {
    SessionOptions options;
    options.size = size;
    options.captures = {"visibility"};
    options.jitter = false;  // the truth is that of pixel centres
    options.optimum = false;
    return Session::open(device, nodes, contender.pipeline, shot, options, diagnostics, warnings);
}

}  // namespace

std::unique_ptr<Runner> Runner::open(Device& device, const NodeSet& nodes, const std::vector<Contender>& list,
                                     std::vector<size_t> contenders, const Shot& shot,
                                     std::array<uint32_t, 2> size, Diagnostics& diagnostics,
                                     std::vector<std::string>& warnings) {
    auto runner = std::unique_ptr<Runner>(new Runner);
    runner->session_ =
        open_session(device, nodes, list[contenders.front()], shot, size, diagnostics, warnings);
    if (!runner->session_) return nullptr;
    for (const size_t contender : contenders)
        if (list[contender].brute_force) runner->rays_.push_back(*list[contender].brute_force);
    runner->contenders_ = std::move(contenders);
    const Plan& plan = runner->session_->plan();
    const std::vector<bool> mask = passes_of_mask(plan);
    for (size_t p = 0; p < plan.passes.size(); ++p) {
        if (plan.passes[p].kind == PassKind::capture) continue;
        const PlanPass& pass = plan.passes[p];
        runner->passes_.push_back({pass.node, pass.entry->type.name, mask[p]});
        runner->plan_pass_.push_back(p);
    }
    return runner;
}

void Runner::set_seed(uint32_t seed) {
    session_->set_param("seed", seed);
}

Sample Runner::sample(size_t contender, const FrameCost& cost) const {
    Sample sample{contender, {}, {}, counted_rays(session_->plan(), cost)};
    for (const size_t p : plan_pass_) sample.passes.push_back({cost.passes[p].ms, cost.pass_cpu_ms[p]});
    return sample;
}

std::vector<Sample> Runner::run(uint32_t frame, bool reset, bool judged) {
    if (!rays_.empty() && !judged) return {};
    const FrameCost cost = session_->run_frame(frame, reset);
    std::vector<Sample> samples{sample(contenders_.front(), cost)};
    samples[0].visibility = captured_image(*session_, "visibility").planes.front().values;
    if (rays_.empty()) return samples;

    // The frame above stands at noise index `frame`: trace again from frame * rays on, where no other judged
    // frame's rays are.
    std::vector<double> sum(samples[0].visibility.size());
    Sample total;
    samples.clear();
    const uint32_t most = rays_.back();
    for (uint32_t ray = 0; ray < most; ++ray) {
        const Sample one = sample(0, session_->repeat_frame(frame * most + ray));
        const std::vector<float> mask = captured_image(*session_, "visibility").planes.front().values;
        for (size_t i = 0; i < sum.size(); ++i) sum[i] += static_cast<double>(mask[i]);
        if (ray == 0) total = one;
        total.rays += ray == 0 ? 0 : one.rays;
        for (size_t p = 0; ray > 0 && p < passes_.size(); ++p) {
            if (passes_[p].type != "trace") continue;  // the rest is needed once
            add(total.passes[p].ms, one.passes[p].ms);
            add(total.passes[p].cpu_ms, one.passes[p].cpu_ms);
        }
        const auto found = std::find(rays_.begin(), rays_.end(), ray + 1);
        if (found == rays_.end()) continue;
        Sample done = total;
        done.contender = contenders_[static_cast<size_t>(found - rays_.begin())];
        for (const double s : sum) done.visibility.push_back(static_cast<float>(s / (ray + 1)));
        samples.push_back(std::move(done));
    }
    return samples;
}

std::vector<std::unique_ptr<Runner>> open_runners(Device& device, const NodeSet& nodes,
                                                  const std::vector<Contender>& list, const Shot& shot,
                                                  std::array<uint32_t, 2> size, Diagnostics& diagnostics,
                                                  std::vector<std::string>& warnings) {
    std::vector<std::unique_ptr<Runner>> runners;
    std::vector<size_t> brute_force;
    const auto open = [&](std::vector<size_t> contenders) {
        runners.push_back(
            Runner::open(device, nodes, list, std::move(contenders), shot, size, diagnostics, warnings));
        return runners.back() != nullptr;
    };
    for (size_t c = 0; c < list.size(); ++c) {
        if (list[c].brute_force)
            brute_force.push_back(c);
        else if (!open({c}))
            return {};
    }
    if (!brute_force.empty() && !open(brute_force)) return {};
    return runners;
}

}  // namespace penumbra::report
