// SPDX-License-Identifier: MIT
// The standalone host: everything that a pipeline's host inputs need for each frame of a shot. It knows
// nothing of the graph; the program glues the two together.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/cascades/cascade_fit.h"
#include "host/gbuffer/gbuffer.h"
#include "host/materials/emitters.h"
#include "host/scene/scene.h"
#include "host/scene/scene_file.h"
#include "host/shots/light_choice.h"
#include "host/shots/shot.h"
#include "penumbra/frame_block.h"
#include "shaders/common/blocks.h"

namespace penumbra {

struct StandaloneOptions {
    std::array<uint32_t, 2> size{1280, 720};
    uint32_t frames_in_flight = 2;
    bool jitter = true;               // whether frames are jittered
    uint32_t cascade_size = 1024;     // texels along a side of a shadow map
    std::string light = "sun";        // a name of the shot's: which one masks are of
    std::vector<std::string> lights;  // names of the shot's: those that a pipeline takes together
    bool materials = false;           // whether the G-buffer has `material` and `emissive`
    bool emitters = false;            // whether frames have what shines
    bool steered = false;             // somebody will steer(): maps are made for any camera and sun
};

// Where somebody stands who looks around, and the moment of the shot that is seen, in frames of it: an
// animation may be held while frames go on.
struct Stance {
    CameraKey camera;
    SunKey sun;
    double moment = 0;
};

// One frame's data, a pure function of its index. Its shadow maps are fitted apart, by cascade_fit(), to the
// box of all triangles.
struct StandaloneFrame {
    FrameDescription description;
    blocks::Sun sun{}, sun_prev{};                   // of the previous frame; of this one where there is none
    blocks::Light light{}, light_prev{};             // of the one that masks are of, where it is not the sun
    std::vector<blocks::Light> lights, lights_prev;  // in the options' order
    std::vector<Texel> emitters;                     // host/materials/emitters.h
    blocks::Scene scene{};
};

// Whether what shaders see of two frames differs in nothing but the jitter, the index and what follows from
// the scene's moment and the camera (the sun's maps). False where either has no frame before it.
bool alike(const StandaloneFrame& a, const StandaloneFrame& b);

class StandaloneHost {
  public:
    StandaloneHost(Device& device, Shot shot, Scene scene, const StandaloneOptions& options);
    // The scene of the shot, which others may look at as well.
    StandaloneHost(Device& device, Shot shot, std::shared_ptr<const Scene> scene,
                   const StandaloneOptions& options);
    StandaloneHost(const StandaloneHost&) = delete;
    StandaloneHost& operator=(const StandaloneHost&) = delete;

    // `reset`: the frame has no history (the first one, a cold start); its previous camera is its own.
    StandaloneFrame frame(uint32_t index, bool reset) const;
    // From this frame on, instead of the shot's own course; the frame before it is seen as it was steered
    // last.
    void steer(uint32_t index, const Stance& stance);
    // The moment of the shot that a frame shows: its number, unless somebody steers.
    double moment(uint32_t index) const;
    // Whether the shot cuts to this frame: it then has no history either.
    bool cut(uint32_t index) const;
    // How far off their pixels' centres a frame's points are, in uv.
    std::array<double, 2> jitter(uint32_t index) const {
        return options_.jitter ? halton_jitter(index, options_.size) : std::array<double, 2>{};
    }
    // The shadow maps of a frame.
    CascadeFit cascade_fit(uint32_t index) const;
    // The most cascades that a frame of the shot has, at least one: layers of the maps. Where nobody steers
    // it fits those of every frame.
    uint32_t cascade_layers() const;

    // Records the frame's G-buffer; see GBuffer::record() for what holds afterwards.
    void record(VkCommandBuffer commands, const StandaloneFrame& frame);

    // A pipeline says only once it is compiled whether it wants jitter.
    void set_jitter(bool on) { options_.jitter = on; }

    const GBufferImages& images() const { return gbuffer_.images(); }
    const Scene& scene() const { return *scene_; }
    const Shot& shot() const { return shot_; }
    // nullptr: the sun.
    const ShotLight* light() const {
        return options_.light == "sun" ? nullptr : &shot_.lights.at(options_.light);
    }

    const Emitters& emitters() const { return emitters_; }
    const std::string& light_name() const { return options_.light; }  // "sun", or of light()

    const std::vector<std::string>& light_names() const { return options_.lights; }

    // What holds for the whole shot: the facts that conditions in pipelines ask for.
    std::map<std::string, bool> facts() const;

  private:
    Shot shot_;
    std::shared_ptr<const Scene> scene_;
    Emitters emitters_;
    StandaloneOptions options_;
    uint32_t sub_pixel_bits_;  // of what drew the G-buffer; many where nothing was rasterised
    GBuffer gbuffer_;
    std::vector<Stance> stances_;  // as steered: of the last two frames, by CameraKey::frame
};

}  // namespace penumbra
