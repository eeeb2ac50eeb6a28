// SPDX-License-Identifier: MIT
// One pipeline running on one shot: the glue between the standalone host and the graph. A frame is submitted
// and waited for before the next one, since its results are read back.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/host_slots.h"
#include "app/kept_scene.h"
#include "app/session_lights.h"
#include "host/device/device.h"
#include "host/standalone.h"
#include "penumbra/graph.h"

namespace penumbra {

// Called with what is being done, one thing after the other, a few words each; and for a thing that takes
// long again and again, with the share of it that is done, 0 to 1.
using Told = std::function<void(const char* what, double share)>;

struct SessionOptions {
    std::array<uint32_t, 2> size{1280, 720};
    std::optional<std::array<uint32_t, 2>> largest;  // what the plan is made for, where frames are smaller
    uint32_t cascade_size = 1024;                    // texels along a side of the sun's shadow maps
    std::vector<std::string> captures;
    std::optional<uint32_t> seed;
    std::string
        light;  // of the shot, that masks are of; empty: the only one, or all where a pipeline takes several
    bool alias = true;
    std::optional<bool> jitter;  // whether frames are; absent: where a node of the plan asks for it
    bool validate = false;       // look at everything that the pipeline reads and writes (app/validate.h)
    std::optional<uint32_t> poison;
    bool timestamps = true;
    Facts facts;           // instead of what the scene says
    bool optimum = false;  // search for the smallest possible heap
    bool steered = false;  // somebody will steer(): facts promise neither a still camera nor a sun that is up
    KeptScene* kept = nullptr;  // of the shot, where more than one session looks at it
    Told doing;                 // of what comes before the first frame
    bool hold = false;          // a frame to which nothing has changed is not run where the view has settled
    std::optional<bool> cpu;    // for tests: shapes and constants of that class, whatever the device's is
    bool pass_costs = true;  // on a CPU device: every pass is a submission of its own, and its cost is known
};

// What one frame cost. Process CPU time per pass needs passes submitted one by one and is measured on CPU
// devices only.
struct FrameCost {
    std::vector<PassStatistics> passes;
    std::vector<std::optional<double>> pass_cpu_ms;
    double cpu_ms = 0;  // of the graph's passes, without captures (with those that validate)
    std::optional<double> ms;
    // Of a frame that is one submission: recording its passes, and from its submission to its completion.
    std::optional<double> record_cpu_ms, wall_ms;
    bool held = false;  // SessionOptions::hold has spared it: the times are those of finding that out
    // Of drawing the sun's shadow maps, where the pipeline reads any; 0 where nothing had moved.
    std::optional<double> cascades_cpu_ms;
    uint32_t cascades_drawn = 0;  // how many of them
};

struct EnvironmentInput;  // the environment (session_open.cpp)

class Session {
  public:
    // Errors of the scene or the plan are diagnostics; failures of the device throw.
    static std::unique_ptr<Session> open(Device& device, const NodeSet& nodes,
                                         const CheckedPipeline& pipeline, Shot shot,
                                         const SessionOptions& options, Diagnostics& diagnostics,
                                         std::vector<std::string>& warnings);

    FrameCost run_frame(uint32_t index, bool reset);
    // Before the frame of this index is run: from where it is seen, instead of from where the shot says.
    void steer(uint32_t index, const Stance& stance) { host_->steer(index, stance); }
    // From the next frame on: whether frames are rasterised off their pixels' centres.
    void set_jitter(bool wanted) {
        host_->set_jitter(wanted);
        last_frame_.reset();
    }

    // Recorded before every frame's passes from the next one on, and no part of their cost.
    void set_before(std::function<void(VkCommandBuffer)> record) { before_ = std::move(record); }

    // The last frame's passes once more, on the same inputs and the history that they have just left.
    FrameCost repeat_frame();
    // From the next frame on, on a CPU device: whether every pass is a submission of its own.
    void set_pass_costs(bool wanted) { pass_costs_ = wanted; }
    // A dynamic parameter of every node that has one of this name, from the next frame on.
    void set_param(std::string_view name, const ParamValue& value);
    // Of one pass; false where it is not of its type and range.
    bool set_param(size_t pass, size_t param, const ParamValue& value) {
        return view_->set_param(pass, param, value);
    }

    const Plan& plan() const { return view_->plan(); }
    bool on_cpu() const { return device_.info().is_cpu; }
    const View& view() const { return *view_; }
    const StandaloneHost& host() const { return *host_; }
    uint32_t seed() const { return seed_; }
    double program_ms() const { return program_ms_; }  // of making the device's objects of the plan
    const SceneBvh* bvh() const { return resources_.bvh.get(); }         // null: nobody traces with it
    const FrameDescription& frame_description() const { return last_; }  // of the last frame
    const CascadeMaps* cascade_maps() const {
        return resources_.cascade_maps.get();
    }  // null: nobody reads any
    // What the host brings to the plan's slots, as it stands since the last frame.
    std::vector<SlotBinding> bind_slots() const { return penumbra::bind_slots(plan(), *host_, resources_); }

  private:
    Session(Device& device, const SessionOptions& options, uint32_t seed)
        : device_(device), seed_(seed), pass_costs_(options.pass_costs), hold_(options.hold) {}
    void make_view(Plan plan, const SessionOptions& options);
    // What the plan's slots ask for; `environment`: what is read of it.
    void make_resources(const SessionOptions& options, KeptScene& kept, const SessionLights& lights,
                        TexelsAs as, const EnvironmentInput& environment);
    // Whether nothing but the jitter and the index differs from the last frame that was run; false where
    // either has no past. `moments`: see last_moments_.
    bool unchanged(const StandaloneFrame& frame, const std::array<double, 2>& moments) const;
    bool pass_by_pass() const { return on_cpu() && pass_costs_; }
    FrameCost held_frame(double cpu_before, double wall_before) const;
    // After the trees have moved to the frame. `previous`: the frame before, or the same one where there is
    // none.
    void update_surfaces(double moment, double previous);
    // The block of the frame that last_ describes, and the maps where anybody reads them.
    void bring_cascades(uint32_t index, FrameCost& cost);
    // Adds what the passes cost to `cost`.
    FrameCost run_passes(const std::function<void(VkCommandBuffer)>& record_before, FrameCost cost);

    Device& device_;
    uint32_t seed_ = 0;
    bool pass_costs_ = true, hold_ = false;
    std::function<void(VkCommandBuffer)> before_;
    double program_ms_ = 0;
    FrameDescription last_;
    std::optional<StandaloneFrame> last_frame_;  // that was run
    std::array<double, 2> last_moments_{};       // its own and that of the one before it
    std::unique_ptr<StandaloneHost> host_;
    HostResources resources_;
    double traced_moment_ = 0;  // the moment that these stand at, but for the tree, which others move, too
    // What the surfaces of hits were made for: SceneBvh::builds(), and the frame's moment and its previous
    // one's.
    std::optional<uint32_t> surfaces_builds_;
    std::array<double, 2> surfaces_moments_{};
    std::unique_ptr<View> view_;
    std::vector<size_t> sleepers_;  // of the host's lights, those whose passes may sleep
};

// What a node type's "needs" may ask for, of what is enabled on the device.
std::set<std::string> features_of(const Device& device);

DeviceHandles handles_of(const Device& device);

}  // namespace penumbra
