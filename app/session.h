// SPDX-License-Identifier: MIT
// One pipeline running on one shot: the glue between the standalone host and the graph. A frame is submitted
// and waited for before the next one, since its results are read back.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/kept_scene.h"
#include "host/cascades/cascade_maps.h"
#include "host/device/device.h"
#include "host/device/gpu.h"
#include "host/materials/environment.h"
#include "host/materials/hit_surfaces.h"
#include "host/scene/scene_tlas.h"
#include "host/scene/scene_translucents.h"
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
    bool jitter = true;          // where a node of the plan needs it
    bool always_jitter = false;  // whether one does or not
    bool validate = false;       // look at everything that the pipeline reads and writes (graph/validate.h)
    std::optional<uint32_t> poison;
    Facts facts;           // instead of what the scene says
    bool optimum = true;   // search for the smallest possible heap, for the report
    bool steered = false;  // somebody will steer(): facts promise neither a still camera nor a sun that is up
    KeptScene* kept = nullptr;  // of the shot, where more than one session looks at it
    Told doing;                 // of what comes before the first frame
    bool hold = false;          // a frame to which nothing has changed is not run where the view has settled
    std::optional<bool> cpu;    // shapes and constants of that class, whatever the device's is
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
    // Of drawing the sun's shadow maps, where the pipeline reads any; 0 where nothing had moved.
    std::optional<double> cascades_cpu_ms;
    uint32_t cascades_drawn = 0;  // how many of them
};

class Session {
  public:
    // Errors of the scene or the plan are diagnostics; failures of the device throw.
    static std::unique_ptr<Session> open(Device& device, const NodeSet& nodes,
                                         const CheckedPipeline& pipeline, Shot shot,
                                         const SessionOptions& options, Diagnostics& diagnostics,
                                         std::vector<std::string>& warnings);

    FrameCost run_frame(uint32_t index, bool reset);
    // Whether the last frame was one that SessionOptions::hold has spared.
    bool held() const { return held_; }
    // Before the frame of this index is run: from where it is seen, instead of from where the shot says.
    void steer(uint32_t index, const Stance& stance) { host_->steer(index, stance); }
    // From the next frame on: whether frames are rasterised off their pixels' centres.
    void set_jitter(bool wanted) {
        host_->set_jitter(wanted);
        last_frame_.reset();
    }

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
    const View& view() const { return *view_; }
    const StandaloneHost& host() const { return *host_; }
    uint32_t seed() const { return seed_; }
    double program_ms() const { return program_ms_; }   // of making the device's objects of the plan
    const SceneBvh* bvh() const { return bvh_.get(); }  // null: nobody traces with it
    const FrameDescription& frame_description() const { return last_; }      // of the last frame
    const CascadeMaps* cascade_maps() const { return cascade_maps_.get(); }  // null: nobody reads any
    // What the host brings to the plan's slots, as it stands since the last frame.
    std::vector<SlotBinding> bind_slots() const;

  private:
    explicit Session(Device& device) : device_(device) {}
    void write_blocks(const StandaloneFrame& frame);
    // But for the jitter and the index, of two frames that have one before them; moments: see last_moments_.
    bool unchanged(const StandaloneFrame& frame, const std::array<double, 2>& moments) const;
    // After the trees have moved to the frame. `previous`: the frame before, or the same one where there is
    // none.
    void update_surfaces(double moment, double previous);
    void draw_cascades(uint32_t index, FrameCost& cost);
    // Adds what the passes cost to `cost`.
    FrameCost run_passes(const std::function<void(VkCommandBuffer)>& record_before, FrameCost cost);

    Device& device_;
    uint32_t seed_ = 0;
    bool pass_costs_ = true, hold_ = false, held_ = false;
    double program_ms_ = 0;
    FrameDescription last_;
    std::optional<StandaloneFrame> last_frame_;  // that was run
    std::array<double, 2> last_moments_{};       // its own and that of the one before it
    std::unique_ptr<StandaloneHost> host_;
    std::shared_ptr<SceneBvh> bvh_;                  // where a pass traces with it
    std::unique_ptr<SceneTlas> tlas_;                // where a pass traces with ray queries
    std::unique_ptr<HitSurfaces> surfaces_;          // where a pass shades what its rays hit
    std::unique_ptr<TranslucentTree> translucents_;  // where a pass asks what colours the light
    GpuImage environment_;                           // where a pass looks beyond the scene
    std::unique_ptr<CascadeMaps> cascade_maps_;
    double traced_moment_ = 0;  // the moment that these stand at, but for the tree, which others move, too
    uint32_t surfaces_builds_ = 0;  // SceneBvh::builds() that `surfaces_` was made for
    std::array<double, 2>
        surfaces_moments_{};  // what `surfaces_` was made for: the frame's and its previous one's
    GpuBuffer sun_, sun_prev_, light_, light_prev_, scene_, cascades_;
    GpuTexels environment_lots_;
    GpuTexels lights_;
    struct OwnLight {
        GpuBuffer now, before;
    };
    std::vector<OwnLight> own_lights_;  // of a pipeline that has inputs for each, as host_->light_names()
    std::unique_ptr<View> view_;
};

// Whether the standalone host brings an input of this name.
bool standalone_has_input(std::string_view name);

// What a node type's "needs" may ask for, of what is enabled on the device.
std::set<std::string> features_of(const Device& device);

// The pipeline's inputs that the standalone host provides, in the formats it renders; optional ones that it
// does not know are left out, and so are lamps until somebody brings them.
Target standalone_target(const CheckedPipeline& pipeline, const DeviceTable& device,
                         std::array<uint32_t, 2> size, const Facts& facts,
                         Extent cascade_extent = {1024, 1024}, uint32_t cascades = 1);

DeviceHandles handles_of(const Device& device);

}  // namespace penumbra
