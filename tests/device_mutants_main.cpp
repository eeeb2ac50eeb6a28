// SPDX-License-Identifier: MIT
//   device_mutants [PIPELINE...]
// The mutants of shipped plans (plan_mutants.h), each run for four frames of a small scene: how many
// synchronisation validation reports, and how many show in the outputs where memory is poisoned. Prints the
// tables of docs/reliability.md; fails where a plan without a fault is reported or differs from itself. A
// spoilt plan may do anything, as run without an end on garbage that it takes for the size of a dispatch:
// processes of their own run them, and one that ends or hangs counts as noticed.
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <exception>

#include "app/pipeline_file.h"
#include "app/session.h"
#include "tests/plan_mutants.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/test_scene.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

constexpr uint32_t frames = 4;
constexpr std::array<uint32_t, 2> size{75, 43};
constexpr int patience_ms = 60'000;  // a mutant takes a tenth of a second
constexpr int not_sound = 3;         // exit code: the plan itself is noticed
constexpr size_t faults = 8;

// What a child says of a mutant before and after it has run it.
struct Word {
    uint32_t index = 0, count = 0;
    Fault fault{};
    enum : uint8_t { begun, unseen, seen } state = begun;
};

using Outputs = std::vector<std::vector<std::byte>>;

// With a second lamp for a pipeline of several.
Shot shot_for(const std::string& pipeline) {
    Shot shot = plaza_shot(size, frames);
    if (!pipeline.starts_with("lights")) return shot;
    ShotLight& other = shot.lights["other"] = shot.lights.at("lamp");
    other.keys.front().position = {-1, 2, 0.5};
    return shot;
}

class Runs {
  public:
    Runs(const std::string& pipeline, bool poisoned)
        : device_({"", !poisoned}), poison_(poisoned ? std::optional(1u) : std::nullopt) {
        const Shot shot = shot_for(pipeline);
        const auto opened = open_pipeline(pipeline, {}, test_nodes(), &shot, "");
        if (!opened) throw std::runtime_error("cannot be opened");
        const CheckedPipeline& checked = *opened;
        SessionOptions options;
        options.size = size;
        options.captures = checked.output_names();
        options.pass_costs = false;
        options.poison = poison_;
        options.cascade_size = 64;
        // One for each frame, so that what the host brings to each is there for all mutants.
        for (uint32_t last = 0; last < frames; ++last) {
            sessions_.push_back(open_session(checked, shot, options, test_nodes(), device_));
            for (uint32_t f = 0; f <= last; ++f) sessions_.back()->run_frame(f, f == 0);
        }
        cache_ = Program(handles_of(device_), std::make_shared<Plan>(plan())).pipeline_cache();
        expected_ = run(plan());
        if (run(plan()) != expected_ || device_.message_count()) {
            for (const std::string& message : device_.messages())
                std::fprintf(stderr, "%s\n", message.c_str());
            std::fprintf(stderr, "%s is noticed without a fault\n", pipeline.c_str());
            std::_Exit(not_sound);
        }
    }

    const Plan& plan() const { return sessions_.front()->plan(); }
    const DeviceTable table() const { return device_table(handles_of(device_)); }
    bool notices(const Plan& mutant) {
        const size_t before = device_.message_count();
        const bool same = run(mutant) == expected_;
        return poison_ ? !same : device_.message_count() != before;
    }

  private:
    Outputs run(const Plan& plan) {
        View view(std::make_shared<Program>(handles_of(device_), std::make_shared<const Plan>(plan),
                                            ProgramOptions{.pipeline_cache = cache_}),
                  {.frames_in_flight = 1, .poison = poison_});
        Outputs outputs;
        for (const auto& session : sessions_) {
            device_.run([&](VkCommandBuffer cmd) {
                view.record(cmd, session->frame_description(), session->bind_slots());
            });
            for (const PlanOutput& output : plan.outputs) {
                const auto bytes = view.captured(output.name);
                outputs.emplace_back(bytes.begin(), bytes.end());
            }
        }
        return outputs;
    }

    Device device_;
    std::optional<uint32_t> poison_;
    std::vector<std::unique_ptr<Session>> sessions_;
    std::vector<std::byte> cache_;
    Outputs expected_;
};

[[noreturn]] void run_from(uint32_t first, const std::string& pipeline, bool poisoned, int out) {
    const auto say = [&](const Word& word) {
        if (::write(out, &word, sizeof word) != sizeof word) std::_Exit(1);
    };
    try {
        Runs runs(pipeline, poisoned);
        const std::vector<Mutant> all = mutants(runs.plan(), runs.table());
        for (uint32_t i = first; i < all.size(); ++i) {
            Word word{i, static_cast<uint32_t>(all.size()), all[i].fault, Word::begun};
            say(word);
            word.state = runs.notices(all[i].plan) ? Word::seen : Word::unseen;
            say(word);
        }
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s: %s\n", pipeline.c_str(), error.what());
        std::_Exit(1);
    }
    std::_Exit(0);
}

struct Counts {
    std::array<size_t, faults> made{}, noticed{}, ended{};
};

// Whether all mutants were run.
bool run_all(const std::string& pipeline, bool poisoned, Counts& counts) {
    for (uint32_t first = 0;;) {
        int ends[2];
        if (::pipe(ends) != 0) return false;
        const pid_t child = ::fork();
        if (child == 0) run_from(first, pipeline, poisoned, ends[1]);
        ::close(ends[1]);
        Word word, last;
        bool any = false;
        for (pollfd wait{ends[0], POLLIN, 0}; ::poll(&wait, 1, patience_ms) > 0;) {
            if (::read(ends[0], &word, sizeof word) != sizeof word) break;
            any = true;
            last = word;
            if (word.state == Word::begun) continue;
            ++counts.made[size_t(word.fault)];
            counts.noticed[size_t(word.fault)] += word.state == Word::seen;
        }
        ::close(ends[0]);
        ::kill(child, SIGKILL);  // where it hangs
        int status = 0;
        ::waitpid(child, &status, 0);
        if (!any) return false;
        if (last.state != Word::begun) return last.index + 1 == last.count;
        for (auto* count : {&counts.made, &counts.noticed, &counts.ended}) ++(*count)[size_t(last.fault)];
        first = last.index + 1;
        if (first == last.count) return true;
    }
}

int run_all_of(const std::vector<std::string>& pipelines) {
    Counts all[2];
    bool good = true;
    plaza_shot(size, frames);  // whose file is this process's
    for (const std::string& pipeline : pipelines) {
        size_t made[2], noticed[2], ended = 0;
        for (const bool poisoned : {false, true}) {
            Counts counts;
            good &= run_all(pipeline, poisoned, counts);
            made[poisoned] = noticed[poisoned] = 0;
            for (size_t f = 0; f < faults; ++f) {
                made[poisoned] += counts.made[f];
                noticed[poisoned] += counts.noticed[f];
                ended += counts.ended[f];
                all[poisoned].made[f] += counts.made[f];
                all[poisoned].noticed[f] += counts.noticed[f];
                all[poisoned].ended[f] += counts.ended[f];
            }
        }
        std::printf("%s: validation %zu of %zu, poison %zu of %zu; %zu ended or hung\n", pipeline.c_str(),
                    noticed[0], made[0], noticed[1], made[1], ended);
        std::fflush(stdout);
    }
    for (size_t f = 0; f < faults; ++f)
        std::printf("| %s | %zu of %zu | %zu of %zu | %zu |\n", name_of(Fault(f)), all[0].noticed[f],
                    all[0].made[f], all[1].noticed[f], all[1].made[f], all[0].ended[f] + all[1].ended[f]);
    return good ? 0 : 1;
}

}  // namespace
}  // namespace penumbra::test

int main(int count, char** arguments) {
    const std::vector<std::string> named(arguments + 1, arguments + count);
    return penumbra::test::run_all_of(named.empty() ? penumbra::test::rendering_pipeline_files() : named);
}
