// SPDX-License-Identifier: MIT
// The plan's frames are simulated on the two-frame circle until they repeat. Each instance (resource, parity)
// remembers its last write, the reads since, and what earlier dependencies have already ordered. Read after
// write and write after write need memory dependencies, write after read needs execution only (Vulkan
// specification, "Synchronization"). Dependencies are global memory barriers; image barriers only activate
// images in reused memory, and since their access scope covers that image alone, the previous occupants'
// writes go into the memory barrier of the same dependency; those that nobody has read, which the transition
// itself overwrites, into both. What is kept is activated once, by a reset.
#include "graph/barriers.h"

#include <algorithm>
#include <map>
#include <set>
#include <tuple>

namespace penumbra {
namespace {

// What has been done to one instance.
struct State {
    VkPipelineStageFlags2 write_stages = 0;
    VkAccessFlags2 write_access = 0;
    VkPipelineStageFlags2 read_stages = 0;   // reads since the write
    uint32_t write_time = 0, read_time = 0;  // how many dependencies were recorded before
};

bool contains(uint64_t set, uint64_t subset) {
    return (set & subset) == subset;
}

class Simulation {
  public:
    explicit Simulation(const Plan& plan) : plan_(plan), states_(plan.resources.size()) { find_neighbours(); }

    // Adds to `dependency` what `use` of an instance needs after its own and, on activation, its memory's
    // past.
    void require(Dependency& dependency, uint32_t resource, uint32_t parity, const Use& use, bool activates) {
        if (activates) return activate(dependency, resource, parity, use);
        require_after(dependency, state(resource, parity), use);
    }

    // The dependency is recorded: everything its source scope covers is ordered before its destination. A
    // plan of ten thousand passes has a handful of different ones, so that the last time of each says what
    // has been ordered since any other time.
    void apply(const Dependency& d) {
        if (d.src_stages == 0) return;
        ++time_;
        for (Recorded& r : recorded_)
            if (r.src_stages == d.src_stages && r.src_access == d.src_access &&
                r.dst_stages == d.dst_stages && r.dst_access == d.dst_access) {
                r.last = time_;
                return;
            }
        recorded_.push_back({d.src_stages, d.dst_stages, d.src_access, d.dst_access, time_});
    }

    void done(uint32_t resource, uint32_t parity, const Use& use) {
        State& s = state(resource, parity);
        Place& place = places_[place_of_[resource][plan_.resources[resource].kept ? 0 : parity]];
        place.remove(s);
        if (use.write) {
            s = {
                .write_stages = use.stages, .write_access = use.access & write_accesses, .write_time = time_};
        } else {
            s.read_stages |= use.stages;
            s.read_time = time_;
        }
        place.add(s);
    }

  private:
    struct Recorded {
        VkPipelineStageFlags2 src_stages, dst_stages;
        VkAccessFlags2 src_access, dst_access;
        uint32_t last;
    };

    // Bytes that instances take turns in. Of what is done to them alike, the latest is the least ordered:
    // where it is ordered, so are the others.
    struct Place {
        std::map<std::pair<VkPipelineStageFlags2, VkAccessFlags2>, std::multiset<uint32_t>> writes;
        std::map<VkPipelineStageFlags2, std::multiset<uint32_t>> reads;
        std::map<VkAccessFlags2, uint32_t> unread;  // writes that nobody has read
        std::vector<uint32_t> neighbours;  // places that share bytes with this one, itself among them

        void add(const State& s) {
            if (s.write_stages) writes[{s.write_stages, s.write_access}].insert(s.write_time);
            if (s.read_stages) reads[s.read_stages].insert(s.read_time);
            if (s.write_stages && !s.read_stages) ++unread[s.write_access];
        }
        void remove(const State& s) {
            if (s.write_stages) drop(writes, std::pair(s.write_stages, s.write_access), s.write_time);
            if (s.read_stages) drop(reads, s.read_stages, s.read_time);
            if (s.write_stages && !s.read_stages && --unread[s.write_access] == 0)
                unread.erase(s.write_access);
        }
        template <class Map>
        static void drop(Map& map, const typename Map::key_type& key, uint32_t time) {
            const auto at = map.find(key);
            at->second.erase(at->second.find(time));
            if (at->second.empty()) map.erase(at);
        }
    };

    // What is kept has one instance.
    State& state(uint32_t resource, uint32_t parity) {
        return states_[resource][plan_.resources[resource].kept ? 0 : parity];
    }

    void require_after(Dependency& d, const State& s, const Use& use) const {
        if (s.write_stages) after_write(d, s.write_stages, s.write_access, s.write_time, use);
        if (s.read_stages) after_read(d, s.read_stages, s.read_time, use);
    }

    void after_write(Dependency& d, VkPipelineStageFlags2 stages, VkAccessFlags2 access, uint32_t time,
                     const Use& use) const {
        VkPipelineStageFlags2 visible_stages = 0;
        VkAccessFlags2 visible_access = 0;
        for (const Recorded& r : recorded_)
            if (r.last > time && contains(r.src_stages, stages) && contains(r.src_access, access)) {
                visible_stages |= r.dst_stages;
                visible_access |= r.dst_access;
            }
        if (contains(visible_stages, use.stages) && contains(visible_access, use.access)) return;
        d.src_stages |= stages;
        d.src_access |= access;
        d.dst_stages |= use.stages;
        d.dst_access |= use.access;
    }

    void after_read(Dependency& d, VkPipelineStageFlags2 stages, uint32_t time, const Use& use) const {
        if (!use.write) return;
        VkPipelineStageFlags2 ordered = 0;
        for (const Recorded& r : recorded_)
            if (r.last > time && contains(r.src_stages, stages)) ordered |= r.dst_stages;
        if (contains(ordered, use.stages)) return;
        d.src_stages |= stages;
        d.dst_stages |= use.stages;
    }

    void activate(Dependency& d, uint32_t resource, uint32_t parity, const Use& use) {
        VkPipelineStageFlags2 past = 0;
        VkAccessFlags2 unread = 0;
        for (const uint32_t neighbour : places_[place_of_[resource][parity]].neighbours) {
            const Place& place = places_[neighbour];
            for (const auto& [how, times] : place.writes) {
                after_write(d, how.first, how.second, *times.rbegin(), use);
                past |= how.first;
            }
            for (const auto& [stages, times] : place.reads) {
                after_read(d, stages, *times.rbegin(), use);
                past |= stages;
            }
            for (const auto& [access, instances] : place.unread) unread |= access;
        }
        if (plan_.resources[resource].kind != PortKind::image) return;
        // The transition writes the image: it waits for every past access and precedes the first use.
        d.activations.push_back(
            {resource, past ? past : VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT, unread, use.stages, use.access});
    }

    // The place of every instance, and the places that share bytes: by offset, since ten thousand of them are
    // not compared pair by pair.
    void find_neighbours() {
        std::map<std::tuple<uint32_t, uint64_t, uint64_t>, uint32_t> known;  // heap, offset, bytes
        place_of_.resize(plan_.resources.size());
        for (uint32_t i = 0; i < plan_.resources.size(); ++i) {
            const PlanResource& r = plan_.resources[i];
            for (uint32_t parity = 0; parity < 2; ++parity) {
                const auto next = static_cast<uint32_t>(places_.size());
                uint32_t& place = place_of_[i][parity];
                if (r.slot) {  // the host may bring the same image every frame
                    place = parity == 0 ? next : place_of_[i][0];
                    if (parity == 0) places_.emplace_back().neighbours = {next};
                    continue;
                }
                const auto [at, added] = known.try_emplace({r.heap, r.offset[parity], r.bytes}, next);
                place = at->second;
                if (added) places_.emplace_back();
            }
        }
        struct Bytes {
            uint64_t end;
            uint32_t place;
        };
        std::vector<Bytes> open;  // those that reach where we are
        uint32_t open_heap = 0;
        for (const auto& [at, place] : known) {  // by heap, then by offset
            const auto [heap, offset, bytes] = at;
            if (heap != open_heap) open.clear();
            open_heap = heap;
            std::erase_if(open, [&, from = offset](const Bytes& other) { return other.end <= from; });
            places_[place].neighbours.push_back(place);
            for (const Bytes& other : open) {
                places_[place].neighbours.push_back(other.place);
                places_[other.place].neighbours.push_back(place);
            }
            open.push_back({offset + bytes, place});
        }
    }

    const Plan& plan_;
    std::vector<std::array<State, 2>> states_;
    std::vector<Recorded> recorded_;
    uint32_t time_ = 0;
    std::vector<Place> places_;
    std::vector<std::array<uint32_t, 2>> place_of_;  // by resource and parity
};

// vkCmdFillBuffer counts as a clear in the specification and as a copy in some validation layers: ask for
// both.
constexpr Use clear_use{VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT, true};

// One pass may use a resource through several ports: their scopes are joined.
std::vector<PassUse> joined(const std::vector<PassUse>& uses) {
    std::vector<PassUse> result;
    for (const PassUse& use : uses) {
        const auto same = std::find_if(result.begin(), result.end(), [&](const PassUse& other) {
            return other.resource == use.resource && other.previous == use.previous;
        });
        if (same == result.end()) {
            result.push_back(use);
        } else {
            same->use.stages |= use.use.stages;
            same->use.access |= use.use.access;
            same->use.write |= use.use.write;
        }
    }
    return result;
}

void run_frame(Plan& plan, Simulation& simulation, uint32_t parity) {
    for (uint32_t p = 0; p < plan.passes.size(); ++p) {
        PlanPass& pass = plan.passes[p];
        Dependency before, after_clears;
        const std::vector<PassUse> uses = joined(pass.uses);
        const auto cleared = [&](const PassUse& use) {
            return !use.previous &&
                   std::find(pass.clears.begin(), pass.clears.end(), use.resource) != pass.clears.end();
        };
        for (const PassUse& use : uses) {
            const PlanResource& r = plan.resources[use.resource];
            const bool activates = !use.previous && r.first_pass == p && !r.kept;
            simulation.require(before, use.resource, use.previous ? 1 - parity : parity,
                               cleared(use) ? clear_use : use.use, activates);
        }
        simulation.apply(before);
        for (const PassUse& use : uses)
            if (cleared(use)) simulation.done(use.resource, parity, clear_use);
        for (const PassUse& use : uses)
            if (cleared(use)) simulation.require(after_clears, use.resource, parity, use.use, false);
        simulation.apply(after_clears);
        for (const PassUse& use : uses)
            simulation.done(use.resource, use.previous ? 1 - parity : parity, use.use);
        pass.before[parity] = std::move(before);
        pass.after_clears[parity] = std::move(after_clears);
    }
    Dependency end;
    for (const PlanOutput& output : plan.outputs)
        simulation.require(end, output.resource, parity, output.use, false);
    simulation.apply(end);
    for (const PlanOutput& output : plan.outputs) simulation.done(output.resource, parity, output.use);
    plan.end[parity] = std::move(end);
}

}  // namespace

void place_barriers(Plan& plan) {
    Simulation simulation(plan);
    // The first circle starts from nothing; by the third every frame repeats what it did two frames before.
    for (uint32_t frame = 0; frame < 6; ++frame) run_frame(plan, simulation, frame & 1);
}

}  // namespace penumbra
