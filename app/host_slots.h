// SPDX-License-Identifier: MIT
// What the standalone host brings to the inputs of a pipeline and the slots of its plan, which are found by
// name.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "host/cascades/cascade_maps.h"
#include "host/device/gpu.h"
#include "host/materials/hit_surfaces.h"
#include "host/scene/scene_bvh.h"
#include "host/scene/scene_tlas.h"
#include "host/scene/scene_translucents.h"
#include "host/standalone.h"
#include "penumbra/graph.h"

namespace penumbra {

// The blocks that are written before each frame, in memory that the host sees.
struct HostBlocks {
    struct OwnLight {
        GpuBuffer now, before;
    };

    // `own_lights`: those that a pipeline has inputs for, each; `lights`: how many the input "lights" holds,
    // `emitters` how many bodies shine for that input; 0 where nobody takes it.
    HostBlocks(Device& device, const std::vector<std::string>& own_lights, size_t lights, size_t emitters);
    void write(const StandaloneFrame& frame);
    void write_moved(const blocks::MovedBoxes& boxes);
    void write_cascades(const blocks::Cascades& block);

    GpuBuffer sun, sun_prev, light, light_prev, scene, cascades, moved_boxes;
    std::vector<OwnLight> own_lights;  // as the host's light_names()
    GpuTexels lights, emitters;
};

// What lies on the device behind the slots, where some pass reads it: an empty one is in no plan's slots.
struct HostResources {
    std::unique_ptr<HostBlocks> blocks;
    std::shared_ptr<SceneBvh> bvh;
    std::unique_ptr<SceneTlas> tlas;
    std::unique_ptr<HitSurfaces> surfaces;
    std::unique_ptr<TranslucentTree> translucents;
    GpuImage environment;
    GpuTexels environment_lots;
    std::unique_ptr<CascadeMaps> cascade_maps;
};

// Whether the standalone host brings an input of this name.
bool standalone_has_input(std::string_view name);

// The pipeline's inputs that the standalone host provides, in the formats it renders; optional ones that it
// does not know are left out, and so are lamps until somebody brings them.
Target standalone_target(const CheckedPipeline& pipeline, const DeviceTable& device,
                         std::array<uint32_t, 2> size, const Facts& facts,
                         Extent cascade_extent = {1024, 1024}, uint32_t cascades = 1);

// The input that one light's block is brought to, where a pipeline has nodes for each light.
std::string slot_of_light(const std::string& light);

bool reads(const Plan& plan, std::string_view slot);

// Of the optional inputs that the standalone host has never heard of, a line each: what reads them is left
// out, which is what a wrong letter must not do without a word.
std::vector<std::string> unknown_inputs_left_out(const CheckedPipeline& pipeline);

// A slot that the host does not know is an error, and so is one of what `scene` has not; `own_lights` as
// above.
void check_slots(const Plan& plan, const std::string& file, const std::vector<std::string>& own_lights,
                 const Scene& scene, Diagnostics& diagnostics);

// `host`: whose images and lights they are.
std::vector<SlotBinding> bind_slots(const Plan& plan, const StandaloneHost& host,
                                    const HostResources& resources);

}  // namespace penumbra
