// SPDX-License-Identifier: MIT
// Lifetimes from uses, then one packing per heap with both parities' instances of every resource.
#include "graph/lifetimes.h"

#include <algorithm>

#include "graph/pack.h"

namespace penumbra {
namespace {

Interval interval_of(const PlanResource& r, uint32_t parity, uint32_t passes) {
    return {r.first_pass + parity * passes, r.length, r.bytes, r.alignment};
}

struct Instance {
    uint32_t resource, parity;
};

// Without aliasing each resource has memory of its own: a pair for history, else one placement for both
// parities.
uint64_t place_apart(Plan& plan, uint32_t heap) {
    uint64_t end = 0;
    for (PlanResource& r : plan.resources) {
        if (r.heap != heap || r.slot) continue;
        for (uint32_t parity = 0; parity < 2; ++parity) {
            if (parity == 1 && !r.history) {
                r.offset[1] = r.offset[0];
                continue;
            }
            end = align_up(end, r.alignment);
            r.offset[parity] = end;
            end += r.bytes;
        }
    }
    return end;
}

}  // namespace

void place_lifetimes(Plan& plan) {
    const auto passes = static_cast<uint32_t>(plan.passes.size());
    std::vector<uint32_t> end(plan.resources.size(),
                              0);  // one past the last use, counted from the frame's first pass
    for (uint32_t p = 0; p < passes; ++p)
        for (const PassUse& use : plan.passes[p].uses)
            end[use.resource] = std::max(end[use.resource], (use.previous ? passes : 0) + p + 1);
    for (size_t i = 0; i < plan.resources.size(); ++i) {
        PlanResource& r = plan.resources[i];
        if (r.output) end[i] = std::max(end[i], passes);
        r.length = r.kept ? 2 * passes : end[i] - r.first_pass;
    }
}

MemoryNeed need_of(const DeviceTable& device, const PlanResource& r) {
    if (r.kind != PortKind::image) return device.buffer_memory(r.buffer_bytes(), r.buffer_usage);
    const MemoryNeed image =
        device.image_memory({r.format, r.extent, r.layers, r.levels, r.image_usage, r.row_bytes != 0});
    if (r.row_bytes == 0) return image;
    const MemoryNeed rows = device.buffer_memory(r.buffer_bytes(), rows_usage);
    return {std::max(image.size, rows.size), std::max(image.alignment, rows.alignment),  // powers of two
            image.type_bits & rows.type_bits};
}

void place_memory(Plan& plan, const DeviceTable& device, bool share_transients, uint64_t optimum_search_nodes,
                  const std::function<void(double share)>& optimum_progress) {
    SearchProgress progress;
    if (optimum_progress)
        progress = [&](uint64_t nodes) {
            optimum_progress(static_cast<double>(nodes) / static_cast<double>(optimum_search_nodes));
        };
    const auto passes = static_cast<uint32_t>(plan.passes.size());
    for (PlanResource& r : plan.resources) {
        const MemoryNeed need = need_of(device, r);
        r.bytes = need.size;
        r.alignment = need.alignment;
        if (r.slot) continue;  // the host's memory
        const std::string type = r.kind == PortKind::image ? "images" : "buffers";
        const bool shared = share_transients && r.transient();
        const auto heap = std::find_if(plan.heaps.begin(), plan.heaps.end(), [&](const Heap& h) {
            return h.type == type && h.memory_type_bits == need.type_bits && h.shared == shared;
        });
        r.heap = static_cast<uint32_t>(heap - plan.heaps.begin());
        if (heap == plan.heaps.end()) plan.heaps.push_back({type, 0, need.type_bits, 1, shared});
        plan.heaps[r.heap].alignment = std::max(plan.heaps[r.heap].alignment, need.alignment);
    }

    MemoryReport& report = plan.memory;
    report.optimum_bytes = 0;
    for (uint32_t h = 0; h < plan.heaps.size(); ++h) {
        std::vector<Interval> intervals;
        std::vector<Instance> instances;
        for (uint32_t i = 0; i < plan.resources.size(); ++i) {
            const PlanResource& r = plan.resources[i];
            if (r.heap != h || r.slot) continue;
            for (uint32_t parity = 0; parity < (r.kept ? 1u : 2u); ++parity) {
                intervals.push_back(interval_of(r, parity, passes));
                instances.push_back({i, parity});
            }
            report.unaliased_bytes += r.history ? 2 * r.bytes : r.bytes;
            if (r.history) report.dedicated_history_bytes += 2 * r.bytes;
            if (r.first_pass + r.length > passes) report.persistent_bytes += r.bytes;
        }
        report.live_bound_bytes += live_bound(intervals, plan.period());
        if (plan.aliased) {
            const Packing packing = pack(intervals, plan.period());
            for (size_t k = 0; k < instances.size(); ++k) {
                PlanResource& r = plan.resources[instances[k].resource];
                r.offset[instances[k].parity] = packing.offsets[k];
                if (r.kept) r.offset[1] = r.offset[0];
            }
            plan.heaps[h].bytes = packing.heap;
        } else {
            plan.heaps[h].bytes = place_apart(plan, h);
        }
        report.heap_bytes += plan.heaps[h].bytes;
        if (plan.heaps[h].shared) report.shared_bytes += plan.heaps[h].bytes;
        const auto best = optimum_search_nodes
                              ? optimum(intervals, plan.period(), optimum_search_nodes, progress)
                              : std::nullopt;
        if (best && report.optimum_bytes)
            *report.optimum_bytes += *best;
        else
            report.optimum_bytes.reset();
    }
}

}  // namespace penumbra
