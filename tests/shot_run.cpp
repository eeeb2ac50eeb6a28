// SPDX-License-Identifier: MIT
#include "tests/shot_run.h"

#include <stdexcept>

#include "penumbra/shadow_nodes.h"
#include "tests/gpu_test.h"
#include "tests/view_run.h"

namespace penumbra::test {

Shot shot_named(const std::string& name) {
    Diagnostics diagnostics;
    auto shot =
        read_shot(std::filesystem::path(PENUMBRA_SOURCE_DIR) / "scenes" / (name + ".shot.json"), diagnostics);
    if (!shot) throw std::runtime_error(diagnostics.text());
    return std::move(*shot);
}

ShotRun::ShotRun(Shot shot, const std::string& pipeline, std::vector<std::string> settings,
                 std::vector<std::string> captures, const Facts& facts, std::array<uint32_t, 2> size)
    : shot_(std::move(shot)) {
    static const NodeSet nodes = shadow_nodes();
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    settings.emplace_back("outputs=[\"visibility\"]");
    const auto loaded =
        load_pipeline(std::filesystem::path(PENUMBRA_SOURCE_DIR) / "pipelines" / (pipeline + ".json"),
                      settings, diagnostics);
    const auto checked = loaded ? check(*loaded, nodes, diagnostics) : std::nullopt;
    if (!checked) throw std::runtime_error(diagnostics.text());
    SessionOptions options;
    options.size = size;
    options.captures = std::move(captures);
    options.captures.emplace_back("visibility");
    options.optimum = false;
    options.jitter = false;
    options.facts = facts;
    session_ = Session::open(gpu(), nodes, *checked, shot_, options, diagnostics, warnings);
    if (!session_) throw std::runtime_error(diagnostics.text());
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
