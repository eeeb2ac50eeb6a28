// SPDX-License-Identifier: MIT
// What pipelines cost: every pass, the whole frame, what comes before the first one, memory. Contenders take
// turns, round by round, and in each turn the native pass (native_pass.h) is timed beside them, so that
// whatever else the machine does meets all of them.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/device/device.h"
#include "host/shots/shot.h"
#include "penumbra/graph.h"

namespace penumbra::bench {

struct Contender {
    std::string id, file;  // id: unique
};

// A shot, and each contender's pipeline for its lights. `fewer`: the same without the last of them, by name,
// where there are several.
struct Subject {
    Shot shot;
    std::vector<CheckedPipeline> pipelines;
    std::optional<Shot> fewer;
    std::vector<CheckedPipeline> for_fewer;
};

struct Options {
    // Of the frames from 0 on, which are all run; those from the first of these to the last are timed.
    std::array<uint32_t, 2> frames{8, 15};
    uint32_t rounds = 5;
    bool still = false;  // the shots are standing_still(): a pipeline that has settled is not run again
    bool still_camera = false;  // the shots are with_still_camera()
    std::string light;          // as SessionOptions has it
};

// A figure of each round: the median over its timed frames.
struct Rounds {
    std::vector<double> values;  // empty: not measured on this device

    std::optional<double> least() const;  // what else a machine does only adds
    std::optional<double> median() const;
};

struct PassFigures {
    std::string node, type;
    bool mask = false;   // visibility depends on it
    Rounds cpu_ms;       // of the process, in a submission of its own; CPU devices only
    Rounds ms;           // by a GPU's timestamps, as part of the frame's one submission
    uint64_t bytes = 0;  // of the images, buffers and tables bound to it, each once; not the trees

    // 10^9 bytes per second, were each of them moved once.
    std::optional<double> gb_per_s() const;
};

struct Figures {
    size_t contender = 0;
    std::vector<PassFigures> passes;
    Rounds pass_cpu_ms;     // the sum over passes
    Rounds pass_ms;         // the same by a GPU's timestamps
    Rounds frame_cpu_ms;    // the frame as one submission, recording included; CPU devices only
    Rounds wall_ms;         // the same from submission to completion
    Rounds record_us;       // CPU time of recording, per pass
    Rounds compile_ms;      // from a checked pipeline to a plan
    double program_ms = 0;  // from a plan to the device's objects
    // The first frame of all, where drivers compile what they have put off, and frame 0 in later rounds.
    double first_frame_ms = 0;
    std::optional<double> frame_0_ms;
    MemoryReport memory;
    // What the plan's heap has for the last of the shot's lights, by name; none where it has fewer than two.
    std::optional<int64_t> last_light_bytes;
    std::optional<uint32_t> settles;  // Plan::settles
    // Of the last round's timed frames, those that were not run: nothing had changed, and the view had
    // settled.
    uint32_t timed = 0, held = 0;
};

// One shot at one size.
struct Scene {
    std::string shot;
    std::array<uint32_t, 2> size{};
    Rounds native_ms;  // CPU time of the native pass at this size
    std::vector<Figures> contenders;
};

// A shot cut to the first of all its keys, without its animation: nothing moves but the sub-pixel jitter.
Shot standing_still(Shot shot);
// A shot whose camera stays at its first key; what else moves does.
Shot with_still_camera(Shot shot);

// `step` is called after every frame. Nothing, with diagnostics, where a scene or a plan is wrong.
std::optional<Scene> measure(Device& device, const NodeSet& nodes, const Subject& subject,
                             std::array<uint32_t, 2> size, const Options& options,
                             const std::function<void()>& step, Diagnostics& diagnostics,
                             std::vector<std::string>& warnings);

}  // namespace penumbra::bench
