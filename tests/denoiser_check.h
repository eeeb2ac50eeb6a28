// SPDX-License-Identifier: MIT
// Compares one frame of the published denoiser on a device, node by node and pixel by pixel, with what double
// precision makes of the same node's inputs as the device left them: errors cannot add up, so tolerances are
// those of one store.
#pragma once

#include <map>

#include "shaders/common/blocks.h"
#include "tests/denoiser_model.h"
#include "tests/view_run.h"

namespace penumbra::test {

// What the host gave the frame. `hits`: the ray-hit words that prepare read.
struct HostFrame {
    std::vector<float> depth;
    std::vector<std::array<float, 4>> normal;
    std::vector<std::array<float, 4>> motion;
    std::vector<uint32_t> hits;
    blocks::Sun sun{};
    bool whole_disc = false;  // classify's terminator
};

class DenoiserCheck {
  public:
    // `sampler_error_px`: how far the device's linear filter may move a coordinate.
    DenoiserCheck(Extent extent, double sampler_error_px);

    // The frame that the view ran last; `captures` of it hold what names() says.
    void frame(const View& view, const HostFrame& host, const FrameDescription& description);
    static std::vector<std::string> names();

    // Pixels compared by tileclass with the full computation, and those among them so near to a threshold
    // that the result of either side of it was accepted.
    size_t worked() const { return worked_; }
    size_t on_threshold() const { return on_threshold_; }
    // Largest difference per node and quantity, as a part of what is tolerated.
    const std::map<std::string, double>& worst() const { return worst_; }

  private:
    struct Compare;
    void guides(const View& view, const HostFrame& host);
    void classify(const View& view, const HostFrame& host);
    void prepare(const View& view, const HostFrame& host);
    void tileclass(const View& view);
    void filters(const View& view);
    void read_inputs(const View& view, const HostFrame& host);
    model::Image<model::Signal> signal(const View& view, const std::string& name) const;

    int width_, height_;
    double sampler_error_px_;
    FrameBlock block_{};
    model::DenoiserInputs inputs_;
    model::DenoiserState before_;
    std::vector<model::BlockState> tile_meta_;
    size_t worked_ = 0, on_threshold_ = 0;
    std::map<std::string, double> worst_;
};

}  // namespace penumbra::test
