// SPDX-License-Identifier: MIT
// One pipeline running on one shot: the glue between the standalone host and the graph. A frame is submitted
// and waited for before the next one, since its results are read back.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "graph/graph.h"
#include "host/device.h"
#include "host/scene_bvh.h"
#include "host/scene_tlas.h"
#include "host/standalone.h"

namespace penumbra {

struct SessionOptions {
    std::array<uint32_t, 2> size{1280, 720};
    std::vector<std::string> captures;
    std::optional<uint32_t> seed;
    bool alias = true;
    bool jitter = true;
    std::optional<uint32_t> poison;
    Facts facts;          // instead of what the scene says
    bool optimum = true;  // search for the smallest possible heap, for the report
};

// What one frame cost. Process CPU time per pass needs passes submitted one by one and is measured on CPU
// devices only.
struct FrameCost {
    std::vector<PassStatistics> passes;
    std::vector<std::optional<double>> pass_cpu_ms;
    double cpu_ms = 0;  // of the graph's passes, without captures
    std::optional<double> ms;
};

class Session {
  public:
    // Errors of the scene or the plan are diagnostics; failures of the device throw.
    static std::unique_ptr<Session> open(Device& device, const NodeSet& nodes,
                                         const CheckedPipeline& pipeline, Shot shot,
                                         const SessionOptions& options, Diagnostics& diagnostics,
                                         std::vector<std::string>& warnings);

    FrameCost run_frame(uint32_t index, bool reset);

    // The last frame's passes once more, on the same inputs and the history that they have just left.
    void repeat_frame();
    // A dynamic parameter of every node that has one of this name, from the next frame on.
    void set_param(std::string_view name, const ParamValue& value);

    const Plan& plan() const { return view_->plan(); }
    const View& view() const { return *view_; }
    const StandaloneHost& host() const { return *host_; }
    uint32_t seed() const { return seed_; }

  private:
    explicit Session(Device& device) : device_(device) {}
    std::vector<SlotBinding> bind_slots() const;
    void write_blocks(const StandaloneFrame& frame);

    Device& device_;
    uint32_t seed_ = 0;
    FrameDescription last_;
    std::unique_ptr<StandaloneHost> host_;
    std::unique_ptr<SceneBvh> bvh_;    // where a pass traces with it
    std::unique_ptr<SceneTlas> tlas_;  // where a pass traces with ray queries
    uint32_t traced_frame_ = 0;        // the frame that both stand at
    MappedBuffer sun_, scene_;
    std::unique_ptr<View> view_;
};

// Host inputs that the standalone host can provide, in the formats it renders.
Target standalone_target(const DeviceTable& device, std::array<uint32_t, 2> size, const Facts& facts);

DeviceHandles handles_of(const Device& device);

}  // namespace penumbra
