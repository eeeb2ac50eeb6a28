// SPDX-License-Identifier: MIT
// The program's commands. Each returns the process's exit code: 0 good, 1 the work failed, 2 the command or a
// file is wrong.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace penumbra {

// How long reports look for the smallest possible heap: found at once where the packing meets the live bound.
inline constexpr uint64_t report_search_nodes = 20'000'000;

enum ExitCode : int { exit_good = 0, exit_failed = 1, exit_wrong = 2 };

struct RenderArguments {
    std::string pipeline, shot, out;
    std::string frames;  // "A..B", inclusive; empty: all of the shot's
    bool cold = false;   // start at A with a reset instead of executing from frame 0
    std::string size;    // "WxH"; empty: the shot's
    std::vector<std::string> captures;
    uint32_t every = 1;  // write every Nth of the selected frames
    std::vector<std::string> settings;
    std::string device;
    std::optional<uint32_t> seed;
    bool validate = false;
    bool no_alias = false;
    bool no_jitter = false;
};

struct PlanArguments {
    std::string pipeline, size, facts, format = "text";
    std::vector<std::string> settings;
    bool no_alias = false;
};

struct NodesArguments {
    std::string type, format = "text";
};

int run_render(const RenderArguments& arguments);
int run_plan(const PlanArguments& arguments);
int run_check(const std::vector<std::string>& pipelines);
int run_nodes(const NodesArguments& arguments);
int run_devices();

// "1280x720"; nothing where it is not two positive numbers.
std::optional<std::array<uint32_t, 2>> parse_size(const std::string& text);

}  // namespace penumbra
