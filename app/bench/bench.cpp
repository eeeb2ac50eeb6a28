// SPDX-License-Identifier: MIT
#include "app/bench/bench.h"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <set>

#include "app/bench/native_pass.h"
#include "app/bench/wake.h"
#include "app/mask_passes.h"
#include "app/report/statistics.h"
#include "app/session.h"

namespace penumbra::bench {
namespace {

double thread_cpu_ms() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

double since_ms(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

double median_of(const std::vector<double>& values) {
    return report::median_of(values)->median;
}

uint64_t bytes_of(const Plan& plan, const PlanBinding& binding) {
    const auto image = [](Extent e, uint32_t layers, Format format) {
        return uint64_t{e.width} * e.height * layers * info(format).bytes;
    };
    switch (binding.source) {
        case BindingSource::resource: {
            const PlanResource& r = plan.resources[binding.index];
            return r.kind == PortKind::image ? image(r.extent, r.layers, r.format) : r.buffer_bytes();
        }
        case BindingSource::host: {
            const HostSlot& s = plan.slots[binding.index];
            return s.kind == PortKind::image ? image(s.extent, s.layers, s.format) : s.bytes;
        }
        case BindingSource::table:
            return plan.tables[binding.index].texels->size();
        default:
            return 0;
    }
}

uint64_t bound_bytes(const Plan& plan, const PlanPass& pass) {
    std::set<std::array<uint32_t, 3>> seen;
    uint64_t bytes = 0;
    for (const PlanBinding& b : pass.bindings)
        if (seen.insert({static_cast<uint32_t>(b.source), b.index, b.previous}).second)
            bytes += bytes_of(plan, b);
    return bytes;
}

// What the timed frames of one round gave.
class Round {
  public:
    explicit Round(size_t passes) : cpu_(passes), ms_(passes) {}

    void add(const FrameCost& cost) {
        if (cost.wall_ms) {  // one submission
            frame_cpu_.push_back(cost.cpu_ms);
            wall_.push_back(*cost.wall_ms);
            record_us_.push_back(1e3 * *cost.record_cpu_ms / static_cast<double>(cpu_.size()));
            if (cost.ms) sum_ms_.push_back(*cost.ms);
            for (size_t p = 0; p < ms_.size(); ++p)
                if (cost.passes[p].ms) ms_[p].push_back(*cost.passes[p].ms);
        } else {
            sum_.push_back(cost.cpu_ms);
            for (size_t p = 0; p < cpu_.size(); ++p)
                if (cost.pass_cpu_ms[p]) cpu_[p].push_back(*cost.pass_cpu_ms[p]);
        }
    }

    void close(Figures& figures, bool cpu_device) const {
        const auto put = [](Rounds& rounds, const std::vector<double>& samples) {
            if (!samples.empty()) rounds.values.push_back(median_of(samples));
        };
        put(figures.pass_cpu_ms, sum_);
        put(figures.pass_ms, sum_ms_);
        if (cpu_device) put(figures.frame_cpu_ms, frame_cpu_);
        put(figures.wall_ms, wall_);
        put(figures.record_us, record_us_);
        for (size_t p = 0; p < cpu_.size(); ++p) {
            put(figures.passes[p].cpu_ms, cpu_[p]);
            put(figures.passes[p].ms, ms_[p]);
        }
    }

  private:
    std::vector<std::vector<double>> cpu_, ms_;
    std::vector<double> sum_, sum_ms_, frame_cpu_, wall_, record_us_;
};

// One contender on one scene.
class Runner {
  public:
    Runner(std::unique_ptr<Session> session, const CheckedPipeline& pipeline, size_t index)
        : session_(std::move(session)), pipeline_(pipeline) {
        const Plan& plan = session_->plan();
        figures_.contender = index;
        figures_.program_ms = session_->program_ms();
        figures_.memory = plan.memory;
        figures_.settles = plan.settles;
        const std::vector<bool> mask = passes_of_mask(plan);
        for (size_t p = 0; p < plan.passes.size(); ++p)
            figures_.passes.push_back({plan.passes[p].node,
                                       plan.passes[p].type,
                                       mask[p],
                                       {},
                                       {},
                                       bound_bytes(plan, plan.passes[p])});
    }

    void time_compile(const Target& target, Diagnostics& diagnostics) {
        const auto start = std::chrono::steady_clock::now();
        compile(pipeline_, target, {}, diagnostics);
        figures_.compile_ms.values.push_back(since_ms(start));
    }

    // `without`: the plan of a shot that lacks one of the lights.
    void compare_lights(const Plan& without) {
        figures_.last_light_bytes = static_cast<int64_t>(figures_.memory.heap_bytes) -
                                    static_cast<int64_t>(without.memory.heap_bytes);
    }

    void run(uint32_t round, const Options& options, const std::function<void()>& step) {
        const bool cpu = session_->on_cpu();
        Round figures(figures_.passes.size());
        figures_.timed = figures_.held = 0;
        for (uint32_t frame = 0; frame <= options.frames[1]; ++frame) {
            // Pass by pass and whole in turn, the other way round in the next round.
            session_->set_pass_costs((frame + round) % 2 == 0);
            const bool first = frame == 0;
            const auto start = std::chrono::steady_clock::now();
            const FrameCost cost = session_->run_frame(frame, first);
            if (first) add_first(since_ms(start), round);
            if (frame >= options.frames[0]) {
                figures.add(cost);
                ++figures_.timed;
                figures_.held += cost.held;
            }
            step();
        }
        figures.close(figures_, cpu);
    }

    const Session& session() const { return *session_; }
    void keep_awake(const Wake& wake) {
        session_->set_before([&wake](VkCommandBuffer commands) { wake.record(commands); });
    }
    Figures take() { return std::move(figures_); }

  private:
    void add_first(double ms, uint32_t round) {
        if (round == 0)
            figures_.first_frame_ms = ms;
        else
            figures_.frame_0_ms = std::min(figures_.frame_0_ms.value_or(ms), ms);
    }

    std::unique_ptr<Session> session_;
    const CheckedPipeline& pipeline_;
    Figures figures_;
};

double native_ms(const NativeImages& images, std::vector<uint32_t>& out) {
    constexpr int runs = 5;
    double least = 1e30;
    for (int i = 0; i < runs; ++i) {
        const double before = thread_cpu_ms();
        native_pass(images, out);
        least = std::min(least, thread_cpu_ms() - before);
    }
    return least;
}

void keep_first(auto& keys) {
    if (keys.size() > 1) keys.erase(keys.begin() + 1, keys.end());
}

}  // namespace

std::optional<double> Rounds::least() const {
    return values.empty() ? std::nullopt : std::optional(*std::ranges::min_element(values));
}

std::optional<double> Rounds::median() const {
    return values.empty() ? std::nullopt : std::optional(median_of(values));
}

std::optional<double> PassFigures::gb_per_s() const {
    const auto least = ms.least();
    return least && *least > 0 ? std::optional(static_cast<double>(bytes) / *least * 1e-6) : std::nullopt;
}

Shot standing_still(Shot shot) {
    shot = with_still_camera(std::move(shot));
    keep_first(shot.sun);
    for (auto& [name, motion] : shot.objects) keep_first(motion.keys);
    for (auto& [name, light] : shot.lights) keep_first(light.keys);
    shot.animation.clear();
    if (shot.analytic) shot.analytic->speed_px = shot.analytic->offset_px = 0;
    return shot;
}

Shot with_still_camera(Shot shot) {
    keep_first(shot.camera);
    shot.cuts.clear();
    return shot;
}

std::optional<Scene> measure(Device& device, const NodeSet& nodes, const Subject& subject,
                             std::array<uint32_t, 2> size, const Options& options,
                             const std::function<void()>& step, Diagnostics& diagnostics,
                             std::vector<std::string>& warnings) {
    SessionOptions session_options;
    session_options.size = size;
    session_options.optimum = true;
    session_options.hold = options.still;
    session_options.light = options.light;
    // On a processor they are wall times, and what waits for them is a part of the frame's cost.
    session_options.timestamps = !device.info().is_cpu;
    const auto open = [&](const CheckedPipeline& pipeline, const Shot& shot) {
        return Session::open(device, nodes, pipeline, shot, session_options, diagnostics, warnings);
    };
    const std::vector<CheckedPipeline>& pipelines = subject.pipelines;
    std::optional<Wake> wake;
    if (!device.info().is_cpu) wake.emplace(device);
    std::vector<Runner> runners;
    for (size_t c = 0; c < pipelines.size(); ++c) {
        auto session = open(pipelines[c], subject.shot);
        if (!session) return std::nullopt;
        runners.emplace_back(std::move(session), pipelines[c], c);
        if (wake) runners.back().keep_awake(*wake);
        if (!subject.fewer) continue;
        session = open(subject.for_fewer[c], *subject.fewer);
        if (!session) return std::nullopt;
        runners.back().compare_lights(session->plan());
    }
    DeviceTable table = device_table(handles_of(device));
    table.features = features_of(device);
    const NativeImages images = native_images((size[0] + 7) / 8 * 8, size[1]);
    std::vector<uint32_t> out(images.signal.size());
    Scene scene{subject.shot.name, size, {}, {}};
    for (uint32_t round = 0; round < options.rounds; ++round) {
        double native = 1e30;
        for (size_t turn = 0; turn < runners.size(); ++turn) {
            Runner& runner = runners[(turn + round) % runners.size()];
            native = std::min(native, native_ms(images, out));
            runner.time_compile(standalone_target(pipelines[(turn + round) % runners.size()], table, size,
                                                  runner.session().plan().facts),
                                diagnostics);
            runner.run(round, options, step);
        }
        scene.native_ms.values.push_back(std::min(native, native_ms(images, out)));
    }
    for (Runner& runner : runners) scene.contenders.push_back(runner.take());
    return scene;
}

}  // namespace penumbra::bench
