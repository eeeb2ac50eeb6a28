// SPDX-License-Identifier: MIT
// A session's frames; how one is opened is session_open.cpp's part.
#include "app/session.h"

#include <chrono>
#include <ctime>
#include <glm/gtc/type_ptr.hpp>
#include <tuple>

#include "host/scene/moved_boxes.h"
#include "host/shots/light_in_view.h"

namespace penumbra {
namespace {

double process_cpu_ms() {
    timespec t{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

double wall_ms() {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

}  // namespace

void Session::set_param(std::string_view name, const ParamValue& value) {
    for (size_t p = 0; p < plan().passes.size(); ++p)
        for (size_t i = 0; i < plan().passes[p].params.size(); ++i)
            if (plan().passes[p].params[i].param.name == name)
                std::ignore = view_->set_param(p, i, value);  // one of another type is not meant
}

FrameCost Session::repeat_frame() {
    last_.flags &= ~uint32_t{frame_reset | frame_unchanged};
    return run_passes([](VkCommandBuffer) {}, {});
}

void Session::update_surfaces(double moment, double previous) {
    const uint32_t builds = resources_.bvh ? resources_.bvh->builds() : 0;
    if (surfaces_builds_ == builds)
        resources_.surfaces->move(moment, previous);
    else
        resources_.surfaces->make(
            moment, previous, resources_.bvh ? &resources_.bvh->bvh() : nullptr,
            resources_.tlas ? resources_.tlas->first_triangles() : std::vector<uint32_t>{});
    surfaces_moments_ = {moment, previous};
    surfaces_builds_ = builds;
}

void Session::bring_cascades(uint32_t index, FrameCost& cost) {
    const double before = process_cpu_ms();
    const CascadeFit fit = host_->cascade_fit(index);
    blocks::Cascades block =
        cascade_block(fit, glm::make_vec3(last_.camera.position.data()) - host_->shot().origin);
    if (resources_.cascade_maps) {
        device_.run(
            [&](VkCommandBuffer cmd) { cost.cascades_drawn = resources_.cascade_maps->record(cmd, fit); });
        cost.cascades_cpu_ms = process_cpu_ms() - before;
        block.flags = blocks::BOUNDS_HOLD_ALL;
    }
    resources_.blocks->write_cascades(block);
}

// (A frame in motion that is run again is like the last one, and still not like the one before it.)
bool Session::unchanged(const StandaloneFrame& frame, const std::array<double, 2>& moments) const {
    return last_frame_ && alike(frame, *last_frame_) &&
           frame.description.camera == frame.description.previous &&
           !host_->scene().moved(moments[0], last_moments_[0]) &&
           !host_->scene().moved(moments[1], last_moments_[1]);
}

// Shaped like the cost of a frame that was run.
FrameCost Session::held_frame(double cpu_before, double wall_before) const {
    FrameCost cost{.held = true};
    for (const PlanPass& pass : plan().passes) {
        cost.passes.emplace_back().counters.resize(pass.counters.size());
        cost.pass_cpu_ms.emplace_back(0.0);
    }
    cost.cpu_ms = process_cpu_ms() - cpu_before;
    if (pass_by_pass()) return cost;
    cost.record_cpu_ms = cost.cpu_ms;
    cost.wall_ms = wall_ms() - wall_before;
    return cost;
}

FrameCost Session::run_frame(uint32_t index, bool reset) {
    const double cpu_before = process_cpu_ms(), wall_before = wall_ms();
    StandaloneFrame frame = host_->frame(index, reset);
    const std::array<double, 2> moments{
        host_->moment(index), host_->moment(frame.description.flags & frame_reset ? index : index - 1)};
    const bool same = unchanged(frame, moments);
    if (hold_ && same && view_->settled()) return held_frame(cpu_before, wall_before);
    last_frame_ = frame;
    last_moments_ = moments;
    if (same) frame.description.flags |= frame_unchanged;
    // Since the frame that was traced last, which need not be the one before: a session may start anywhere.
    const auto [moment, previous] = moments;
    if (reads(plan(), "moved_boxes"))
        resources_.blocks->write_moved(
            moved_block(host_->scene().moved_boxes(traced_moment_, moment),
                        glm::make_vec3(frame.description.camera.position.data()) - host_->shot().origin));
    if (resources_.bvh) resources_.bvh->update(moment);
    if (resources_.translucents) resources_.translucents->update(moment);
    if (host_->scene().moved(traced_moment_, moment)) {
        if (resources_.tlas) resources_.tlas->update(moment);
        if (resources_.cascade_maps) resources_.cascade_maps->update(moment);
    }
    traced_moment_ = moment;
    if (resources_.surfaces) {
        const auto moved = [&](double a, double b) { return host_->scene().moved(a, b); };
        if (moved(surfaces_moments_[0], moment) || moved(surfaces_moments_[0], surfaces_moments_[1]) ||
            moved(previous, moment) || (resources_.bvh && surfaces_builds_ != resources_.bvh->builds()))
            update_surfaces(moment, previous);
    }
    resources_.blocks->write(frame);
    for (const size_t i : sleepers_)
        std::ignore =
            view_->set_awake(host_->light_names()[i], may_show(frame.lights[i], frame.description.camera));
    last_ = frame.description;
    FrameCost cost;
    if (resources_.cascade_maps || reads(plan(), "cascades")) bring_cascades(index, cost);
    return run_passes([&](VkCommandBuffer cmd) { host_->record(cmd, frame); }, std::move(cost));
}

// What is recorded before the passes is no part of their cost.
FrameCost Session::run_passes(const std::function<void(VkCommandBuffer)>& record_before, FrameCost cost) {
    const std::vector<SlotBinding> slots = bind_slots();
    cost.pass_cpu_ms.resize(plan().passes.size());
    device_.run([&](VkCommandBuffer cmd) {
        if (before_) before_(cmd);
        record_before(cmd);
        if (pass_by_pass()) view_->begin(cmd, last_, slots);
    });
    if (pass_by_pass()) {
        for (size_t p = 0; p < plan().passes.size(); ++p) {
            const double before = process_cpu_ms();
            device_.run([&](VkCommandBuffer cmd) { view_->record_pass(cmd, p); });
            cost.pass_cpu_ms[p] = process_cpu_ms() - before;
            if (plan().passes[p].kind != PassKind::capture) cost.cpu_ms += *cost.pass_cpu_ms[p];
        }
        device_.run([&](VkCommandBuffer cmd) { view_->end(cmd); });
    } else {
        const double before = process_cpu_ms();
        double wall = 0;
        device_.run([&](VkCommandBuffer cmd) {
            const double start = process_cpu_ms();
            view_->record(cmd, last_, slots);
            cost.record_cpu_ms = process_cpu_ms() - start;
            wall = wall_ms();
        });
        cost.wall_ms = wall_ms() - wall;
        cost.cpu_ms = process_cpu_ms() - before;
    }
    cost.passes = view_->statistics();
    for (size_t p = 0; p < plan().passes.size(); ++p)
        if (plan().passes[p].kind != PassKind::capture && cost.passes[p].ms)
            cost.ms = cost.ms.value_or(0) + *cost.passes[p].ms;
    return cost;
}

}  // namespace penumbra
