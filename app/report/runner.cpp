// SPDX-License-Identifier: MIT
#include "app/report/runner.h"

#include <algorithm>

#include "app/mask_passes.h"
#include "app/outputs.h"

namespace penumbra::report {
namespace {

uint64_t counted_rays(const Plan& plan, const FrameCost& cost) {
    uint64_t rays = 0;
    for (size_t p = 0; p < plan.passes.size(); ++p) {
        const std::vector<std::string>& names = plan.passes[p].counters;
        for (size_t i = 0; i < names.size(); ++i)
            if (names[i] == "rays") rays += cost.passes[p].counters[i];
    }
    return rays;
}

// A memo carries over too, but its declaration says that the mask does not depend on it.
CostMemory cost_memory(const Session& session) {
    const std::vector<PlanResource>& resources = session.plan().resources;
    if (std::ranges::any_of(resources, [](const PlanResource& r) { return r.history && r.memo; }))
        return CostMemory::all;
    const bool kept = std::ranges::any_of(resources, &PlanResource::kept);
    return session.cascade_maps() || kept ? CostMemory::frame_before : CostMemory::none;
}

}  // namespace

std::unique_ptr<Runner> Runner::open(Device& device, const NodeSet& nodes, const Contender& contender,
                                     const Shot& shot, std::array<uint32_t, 2> size, bool costs,
                                     KeptScene& scene, Diagnostics& diagnostics,
                                     std::vector<std::string>& warnings) {
    SessionOptions options;
    options.kept = &scene;
    options.size = size;
    options.captures = {"visibility"};
    options.jitter = false;  // the truth is that of pixel centres
    options.pass_costs = costs;
    auto runner = std::unique_ptr<Runner>(new Runner);
    runner->session_ = Session::open(device, nodes, contender.pipeline, shot, options, diagnostics, warnings);
    if (!runner->session_) return nullptr;
    const Plan& plan = runner->session_->plan();
    runner->has_history_ = penumbra::has_history(plan);
    runner->cost_memory_ = report::cost_memory(*runner->session_);
    const std::vector<bool> mask = passes_of_mask(plan);
    for (size_t p = 0; p < plan.passes.size(); ++p) {
        if (plan.passes[p].kind == PassKind::capture) continue;
        const PlanPass& pass = plan.passes[p];
        runner->passes_.push_back({pass.node, pass.type, mask[p]});
        runner->plan_pass_.push_back(p);
    }
    return runner;
}

void Runner::set_seed(uint32_t seed) {
    session_->set_param("seed", seed);
}

Sample Runner::run(uint32_t frame, bool reset, bool judged) {
    const FrameCost cost = session_->run_frame(frame, reset);
    Sample sample;
    if (judged) sample.visibility = captured_image(*session_, "visibility").planes.front().values;
    for (const size_t p : plan_pass_) sample.passes.push_back({cost.passes[p].ms, cost.pass_cpu_ms[p]});
    sample.maps_cpu_ms = cost.cascades_cpu_ms;
    sample.rays = counted_rays(session_->plan(), cost);
    const bool after_last = last_ && frame == *last_ + 1;
    unbroken_ = reset || (unbroken_ && after_last);
    sample.true_cost = cost_memory_ == CostMemory::none ||
                       (cost_memory_ == CostMemory::frame_before ? after_last : unbroken_);
    last_ = frame;
    return sample;
}

std::vector<std::unique_ptr<Runner>> open_runners(Device& device, const NodeSet& nodes,
                                                  const std::vector<Contender>& list, const Shot& shot,
                                                  std::array<uint32_t, 2> size, bool costs,
                                                  Diagnostics& diagnostics,
                                                  std::vector<std::string>& warnings) {
    KeptScene scene;  // one for all: they take turns
    std::vector<std::unique_ptr<Runner>> runners;
    for (const Contender& contender : list) {
        runners.push_back(
            Runner::open(device, nodes, contender, shot, size, costs, scene, diagnostics, warnings));
        if (!runners.back()) return {};
    }
    return runners;
}

}  // namespace penumbra::report
