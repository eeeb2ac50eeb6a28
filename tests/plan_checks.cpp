// SPDX-License-Identifier: MIT
// Hazards: for every access of six consecutive frames, every earlier access to overlapping bytes (of the same
// instance, or of another instance whose memory it shares) must be followed by a barrier whose source scope
// covers it and whose destination scope covers the later one, directly or through a chain of execution
// dependencies. Quadratic and plain.
#include "tests/plan_checks.h"

#include <fmt/format.h>

#include <algorithm>

namespace penumbra::test {
namespace {

// The data of an instance is needed from its first write to its last read.
struct Held {
    uint32_t resource = 0;
    uint32_t frame = 0;            // that wrote it
    uint64_t first = 0, last = 0;  // absolute pass numbers
};

std::vector<Held> holdings(const Plan& plan, uint32_t frames) {
    const uint64_t passes = plan.passes.size();
    std::vector<Held> result;
    for (uint32_t frame = 0; frame < frames; ++frame)
        for (uint32_t r = 0; r < plan.resources.size(); ++r) {
            Held held{r, frame, ~0ull, 0};
            for (uint64_t p = 0; p < passes; ++p)
                for (const PassUse& use : plan.passes[p].uses)
                    if (use.resource == r) {
                        const uint64_t at = (frame + (use.previous ? 1 : 0)) * passes + p;
                        held.first = std::min(held.first, at);
                        held.last = std::max(held.last, at);
                    }
            if (plan.resources[r].output) held.last = std::max(held.last, (frame + 1) * passes - 1);
            if (plan.resources[r].kept) held = {r, frame, frame == 0 ? 0 : ~0ull, ~0ull - 1};  // one for all
            if (held.first != ~0ull) result.push_back(held);
        }
    return result;
}

bool share_bytes(const Plan& plan, uint32_t a, uint32_t pa, uint32_t b, uint32_t pb) {
    const PlanResource &x = plan.resources[a], &y = plan.resources[b];
    if (x.heap != y.heap) return false;
    const uint64_t begin = std::max(x.offset[pa], y.offset[pb]);
    const uint64_t end = std::min(x.offset[pa] + x.bytes, y.offset[pb] + y.bytes);
    return begin < end;
}

struct Event {
    bool barrier = false;
    Dependency dependency;  // barrier
    PassUse use;            // access
    uint32_t parity = 0;    // of the instance accessed; barriers: of the frame
    std::string label;
};

// Which of the two instances a frame's use is of; what is kept has one.
uint32_t instance_of(const Plan& plan, const PassUse& use, uint32_t parity) {
    if (plan.resources[use.resource].kept) return 0;
    return use.previous ? 1 - parity : parity;
}

std::vector<Event> events(const Plan& plan, uint32_t frames) {
    std::vector<Event> list;
    for (uint32_t frame = 0; frame < frames; ++frame) {
        const uint32_t parity = frame & 1;
        for (const PlanPass& pass : plan.passes) {
            const std::string label = fmt::format("{} of frame {}", pass.node, frame);
            list.push_back({true, pass.before[parity], {}, parity, label});
            for (const uint32_t r : pass.clears)
                list.push_back(
                    {false,
                     {},
                     {r, false, {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, true}},
                     parity,
                     label + " (clear)"});
            list.push_back({true, pass.after_clears[parity], {}, parity, label});
            for (const PassUse& use : pass.uses)
                list.push_back({false, {}, use, instance_of(plan, use, parity), label});
        }
        list.push_back({true, plan.end[parity], {}, parity, "end"});
        // Between this frame and the next the host reads the outputs.
        for (const PlanOutput& output : plan.outputs)
            list.push_back({false,
                            {},
                            {output.resource, false, output.use},
                            instance_of(plan, {output.resource, false, {}}, parity),
                            fmt::format("the host after frame {}", frame)});
    }
    return list;
}

bool covers(uint64_t set, uint64_t subset) {
    return (set & subset) == subset;
}

constexpr VkAccessFlags2 write_access =
    VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;

// The stages that wait for an access, and what its write is visible to.
struct Reach {
    VkPipelineStageFlags2 stages = 0;
    bool available = false;
    VkPipelineStageFlags2 visible_stages = 0;
    VkAccessFlags2 visible_access = 0;
};

bool flushes(const Dependency& d, const Use& use) {
    return covers(d.src_stages, use.stages) && covers(d.src_access, use.access & write_access);
}

// How far the barriers between two events carry the first, for the second's use of one instance. Follows
// chains: a barrier's destination stages become the source of the next; a transition is part of the order for
// its own image.
Reach reach(const std::vector<Event>& list, size_t from, size_t to, uint32_t resource, uint32_t parity) {
    const Use& first = list[from].use.use;
    Reach r;
    for (size_t i = from + 1; i < to; ++i) {
        if (!list[i].barrier) continue;
        const Dependency& d = list[i].dependency;
        if (covers(d.src_stages, first.stages) || (d.src_stages & r.stages)) {
            r.stages |= d.dst_stages;
            r.available |= flushes(d, first);
            if (r.available) {
                r.visible_stages |= d.dst_stages;
                r.visible_access |= d.dst_access;
            }
        }
        for (const Activation& a : d.activations)
            if (a.resource == resource && list[i].parity == parity &&
                (covers(a.src_stages, first.stages) || (a.src_stages & r.stages)))
                r.stages |= a.dst_stages;
    }
    return r;
}

// `from` happens before `to`, and is visible to it if it wrote.
bool ordered(const std::vector<Event>& list, size_t from, size_t to) {
    const Use& second = list[to].use.use;
    const Reach r = reach(list, from, to, list[to].use.resource, list[to].parity);
    if (!covers(r.stages, second.stages)) return false;
    return !list[from].use.use.write ||
           (covers(r.visible_stages, second.stages) && covers(r.visible_access, second.access));
}

// A transition writes the image's memory: every earlier access to those bytes happens before it, and what it
// wrote is available.
bool transition_ordered(const std::vector<Event>& list, size_t from, size_t to, const Activation& a) {
    const Use& first = list[from].use.use;
    const Reach r = reach(list, from, to, a.resource, list[to].parity);
    if (!covers(a.src_stages, first.stages) && !(a.src_stages & r.stages)) return false;
    return !first.write || r.available || flushes(list[to].dependency, first);
}

// How an image is used first: by the pass's clear, else by its ports together.
Use first_use(const Plan& plan, uint32_t resource) {
    const PlanPass& pass = plan.passes[plan.resources[resource].first_pass];
    if (std::find(pass.clears.begin(), pass.clears.end(), resource) != pass.clears.end())
        return {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, true};
    Use all;
    for (const PassUse& use : pass.uses)
        if (use.resource == resource && !use.previous)
            all = {all.stages | use.use.stages, all.access | use.use.access, all.write || use.use.write};
    return all;
}

// Images come to life undefined, every frame, unless they are kept (a reset gives those a layout). The
// transition writes the image's memory, which has to be visible to the first use.
std::vector<std::string> missing_activations(const Plan& plan) {
    std::vector<std::string> errors;
    for (uint32_t r = 0; r < plan.resources.size(); ++r)
        for (const Dependency& d : plan.passes[plan.resources[r].first_pass].before) {
            if (plan.resources[r].kind != PortKind::image || plan.resources[r].kept) continue;
            const auto activation = std::find_if(d.activations.begin(), d.activations.end(),
                                                 [&](const Activation& a) { return a.resource == r; });
            const Use use = first_use(plan, r);
            if (activation == d.activations.end())
                errors.push_back(plan.resources[r].names.front() + " is used without a layout");
            else if (!covers(activation->dst_stages, use.stages) ||
                     !covers(activation->dst_access, use.access))
                errors.push_back(plan.resources[r].names.front() +
                                 " is given a layout that its first use does not see");
        }
    return errors;
}

// Every use lies in the passes that the resource's bytes are its own for, counted from the frame that writes
// it.
std::vector<std::string> lifetime_errors(const Plan& plan) {
    std::vector<std::string> errors;
    const auto passes = static_cast<uint32_t>(plan.passes.size());
    const auto expect_live = [&](uint32_t resource, uint32_t pass, const std::string& who) {
        const PlanResource& r = plan.resources[resource];
        if (!r.kept && (pass < r.first_pass || pass >= r.first_pass + r.length))
            errors.push_back(fmt::format("{} uses {} in pass {}, which lives in {} to {}", who,
                                         r.names.front(), pass, r.first_pass, r.first_pass + r.length - 1));
        if (r.kept && r.length < 2 * passes)
            errors.push_back(r.names.front() + " is not kept for both frames");
    };
    for (uint32_t p = 0; p < passes; ++p)
        for (const PassUse& use : plan.passes[p].uses)
            expect_live(use.resource, p + (use.previous ? passes : 0), plan.passes[p].node);
    for (const PlanOutput& output : plan.outputs) expect_live(output.resource, passes - 1, "the host");
    return errors;
}

}  // namespace

std::vector<std::string> overlap_errors(const Plan& plan) {
    std::vector<std::string> errors = lifetime_errors(plan);
    const std::vector<Held> held = holdings(plan, 4);
    for (size_t i = 0; i < held.size(); ++i)
        for (size_t j = i + 1; j < held.size(); ++j) {
            const Held &a = held[i], &b = held[j];
            const bool same_time = a.first <= b.last && b.first <= a.last;
            if (same_time && share_bytes(plan, a.resource, a.frame & 1, b.resource, b.frame & 1))
                errors.push_back(fmt::format("{} of frame {} and {} of frame {} share bytes and time",
                                             plan.resources[a.resource].names.front(), a.frame,
                                             plan.resources[b.resource].names.front(), b.frame));
        }
    for (const PlanResource& r : plan.resources)
        for (const uint64_t offset : r.offset) {
            if (offset % r.alignment != 0) errors.push_back(r.names.front() + " is not aligned");
            if (offset + r.bytes > plan.heaps[r.heap].bytes)
                errors.push_back(r.names.front() + " lies outside its heap");
        }
    return errors;
}

std::vector<std::string> hazard_errors(const Plan& plan, size_t most) {
    std::vector<std::string> errors = missing_activations(plan);
    const std::vector<Event> list = events(plan, 6);
    const size_t settled =
        list.size() / 2;  // later accesses are those of frames 3 to 5: every pair of parities
    for (size_t to = settled; to < list.size() && errors.size() < most; ++to) {
        for (const Activation& a : list[to].dependency.activations)
            for (size_t from = to - settled; from < to; ++from) {
                const Event& first = list[from];
                if (first.barrier ||
                    !share_bytes(plan, a.resource, list[to].parity, first.use.resource, first.parity))
                    continue;
                if (!transition_ordered(list, from, to, a))
                    errors.push_back(fmt::format("the transition of {} in {} is not ordered after {} by {}",
                                                 plan.resources[a.resource].names.front(), list[to].label,
                                                 plan.resources[first.use.resource].names.front(),
                                                 first.label));
            }
        if (list[to].barrier) continue;
        const Event& second = list[to];
        for (size_t from = to - 1; from > to - settled; --from) {
            const Event& first = list[from];
            if (first.barrier) continue;
            const bool same = first.use.resource == second.use.resource && first.parity == second.parity;
            if (same && first.label == second.label) continue;
            if (!same &&
                !share_bytes(plan, first.use.resource, first.parity, second.use.resource, second.parity))
                continue;
            const bool conflict = first.use.use.write || second.use.use.write;
            // The same data is written once per frame: only the latest write before a read counts, but all
            // must be ordered.
            if (conflict && !ordered(list, from, to))
                errors.push_back(fmt::format("{} by {} is not ordered after {} by {}",
                                             plan.resources[second.use.resource].names.front(), second.label,
                                             plan.resources[first.use.resource].names.front(), first.label));
        }
    }
    return errors;
}

}  // namespace penumbra::test
