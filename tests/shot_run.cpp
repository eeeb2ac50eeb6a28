// SPDX-License-Identifier: MIT
#include "tests/shot_run.h"

#include <filesystem>
#include <stdexcept>

#include "tests/view_run.h"

namespace penumbra::test {

Shot shot_named(const std::string& name) {
    Diagnostics diagnostics;
    auto shot =
        read_shot(std::filesystem::path(PENUMBRA_SOURCE_DIR) / "scenes" / (name + ".shot.json"), diagnostics);
    if (!shot) throw std::runtime_error(diagnostics.text());
    return std::move(*shot);
}

std::unique_ptr<Session> open_session(const CheckedPipeline& pipeline, Shot shot,
                                      const SessionOptions& options, const NodeSet& nodes, Device& device) {
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    auto session = Session::open(device, nodes, pipeline, std::move(shot), options, diagnostics, warnings);
    if (!session) throw std::runtime_error(diagnostics.text());
    return session;
}

ShotRun::ShotRun(Shot shot, const std::string& pipeline, std::vector<std::string> settings,
                 std::vector<std::string> captures, const Facts& facts, std::array<uint32_t, 2> size)
    : shot_(std::move(shot)) {
    settings.emplace_back("outputs=[\"visibility\"]");
    SessionOptions options;
    options.size = size;
    options.captures = std::move(captures);
    options.captures.emplace_back("visibility");
    options.optimum = false;
    options.jitter = false;
    options.facts = facts;
    session_ = open_session(shipped_pipeline(pipeline, settings), shot_, options);
}

void ShotRun::frame(uint32_t index, bool reset) {
    session_->run_frame(index, reset);
}

std::vector<uint32_t> ShotRun::words(const char* name) const {
    return captured<uint32_t>(session_->view(), name);
}

std::vector<float> ShotRun::visibility() const {
    return captured_planes(session_->view(), "visibility").at(0);
}

}  // namespace penumbra::test
