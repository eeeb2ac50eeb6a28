// SPDX-License-Identifier: MIT
// A compiled pipeline: pure data. Passes in order with their bindings, constants and dependencies; resources
// with their lifetimes and byte offsets. A host with its own RHI can realise a plan without the runtime in
// view.h.
#pragma once

#include <vulkan/vulkan_core.h>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "graph/interface.h"
#include "graph/node_set.h"

namespace penumbra {

struct Extent {
    uint32_t width = 1, height = 1;
    friend bool operator==(const Extent&, const Extent&) = default;
};

// What the device says of an image or a buffer.
struct MemoryNeed {
    uint64_t size = 0, alignment = 1;
    uint32_t type_bits = ~0u;
};

struct ImageNeed {
    Format format = Format::r8;
    Extent extent;
    uint32_t layers = 1, levels = 1;
    VkImageUsageFlags usage = 0;
};

// All that compile() asks of a device. device_table() (memory.h) reads a real one; reference_device() is a
// fixed one for tests and for planning without a device. Which features are enabled only the host can say:
// ray_query, storage8.
struct DeviceTable {
    std::string name;
    bool cpu = false;                   // device class: selects the declarations' overrides
    uint32_t max_image_extent = 16384;  // pixels per axis
    uint32_t max_texel_elements = 1u << 27;
    uint32_t max_storage_bytes = 1u << 27;  // of one buffer binding
    uint32_t max_workgroup_invocations = 1024;
    bool ray_query = false, storage8 = false;  // enabled on the host's device, which only the host can tell
    std::function<MemoryNeed(const ImageNeed&)> image_memory;
    std::function<MemoryNeed(uint64_t bytes, VkBufferUsageFlags usage)> buffer_memory;
    std::function<bool(Format, VkFormatFeatureFlags)> supports;
};
DeviceTable reference_device(bool cpu = false);

// What a host brings for one declared input.
struct HostResource {
    Format format = Format::r8;  // images
    Extent extent;
    uint32_t layers = 1;
};

struct Target {
    Extent extent;
    // Images and texels; absent: the declared extent and format, or the frame's and the first that all
    // readers accept.
    std::map<std::string, HostResource> inputs;
    std::set<std::string> left_out;  // optional inputs that the host does not bring at all
    Facts facts;
    DeviceTable device;
};

// Stages and accesses of one use of a resource; all internal images stay in VK_IMAGE_LAYOUT_GENERAL.
struct Use {
    VkPipelineStageFlags2 stages = 0;
    VkAccessFlags2 access = 0;
    bool write = false;
};

// A slot the host fills at every record(): an input, or an input's previous value.
struct HostSlot {
    std::string name;                 // "depth", "depth@-1", "scene.nodes"
    PortKind kind = PortKind::image;  // scene: an acceleration structure
    Format format = Format::r8;
    Extent extent;
    uint32_t layers = 1;
    std::string element;
    uint32_t bytes = 0;                // blocks: size of the struct
    std::vector<std::string> readers;  // node ids
};

// One internal resource: an updates chain is one resource with several names.
struct PlanResource {
    std::vector<std::string> names;  // in writing order; the last may have history
    PortKind kind = PortKind::image;
    Format format = Format::r8;
    Extent extent;
    bool layered = false;  // a 2D array, be it of one layer
    bool kept = false;     // writes: kept; one memory for all frames, which nobody else shares
    bool memo = false;     // what it brings from frames before changes nothing that is put out
    uint32_t layers = 1, levels = 1;
    std::string element;
    uint64_t count = 0;  // elements (buffers, texels)
    uint32_t element_bytes = 4;
    VkImageUsageFlags image_usage = 0;
    VkBufferUsageFlags buffer_usage = 0;
    bool history = false, output = false;
    bool clear_on_activation = false;  // writes: some
    bool clear_on_reset = false;       // first: clear
    uint32_t first_pass = 0;
    uint32_t length = 1;  // passes on the circle of 2P
    uint64_t bytes = 0, alignment = 1;
    uint32_t heap = 0;
    std::array<uint64_t, 2> offset{0, 0};  // by frame parity

    uint64_t buffer_bytes() const;  // of the VkBuffer: whole words, never none
};

struct PlanBinding {
    const Port* port = nullptr;
    uint32_t binding = 0;
    bool host = false;
    uint32_t index = 0;     // of Plan::resources or Plan::slots (a scene port has a binding per slot)
    bool previous = false;  // internal: the other parity's placement
    std::string resource;   // the name it is bound to, with @-1 where previous
};

// One image that starts to use its memory: UNDEFINED -> GENERAL.
struct Activation {
    uint32_t resource = 0;
    VkPipelineStageFlags2 src_stages = 0;  // last accesses of the memory's previous occupants; access 0
    VkPipelineStageFlags2 dst_stages = 0;
    VkAccessFlags2 dst_access = 0;
};

// One vkCmdPipelineBarrier2: a global memory barrier and the activations. Empty: nothing is recorded.
struct Dependency {
    VkPipelineStageFlags2 src_stages = 0, dst_stages = 0;
    VkAccessFlags2 src_access = 0, dst_access = 0;
    std::vector<Activation> activations;
    bool empty() const { return src_stages == 0 && activations.empty(); }
};

struct PassUse {
    uint32_t resource = 0;
    bool previous = false;
    Use use;
};

enum class PassKind : uint8_t { compute, host, capture };

struct PlanPass {
    PassKind kind = PassKind::compute;
    std::string node;  // node id; captures: the resource's name
    const NodeEntry* entry = nullptr;
    Variant variant;
    std::vector<PlanBinding> bindings;
    std::vector<uint32_t> constants;  // specialisation data: ids 0 .. n-1, four bytes each
    std::vector<std::byte> push;      // dynamic parameters' initial values
    std::array<uint32_t, 3> groups{1, 1, 1};
    std::vector<std::array<uint32_t, 3>> level_groups;  // writers of a mip chain: of each level; else empty
    std::optional<uint32_t> indirect;                   // resource with the arguments
    uint32_t indirect_offset = 0;
    uint32_t counter_base = 0;  // first of the entry's counters among all passes'
    std::vector<PassUse> uses;
    std::vector<uint32_t> clears;      // resources cleared before the pass (writes: some)
    std::array<Dependency, 2> before;  // by frame parity
    std::array<Dependency, 2> after_clears;
    std::vector<std::string> reads, writes;
};

struct Culled {
    std::string node;
    std::string why;   // "unused" | "if"
    std::string cond;  // the condition, for "if"
};

struct PlanOutput {
    std::string name;
    uint32_t resource = 0;
};

struct Heap {
    std::string type;  // "images" | "buffers"
    uint64_t bytes = 0;
    uint32_t memory_type_bits = ~0u;
};

struct MemoryReport {
    uint64_t heap_bytes = 0, live_bound_bytes = 0, unaliased_bytes = 0;
    std::optional<uint64_t> optimum_bytes;
    uint64_t dedicated_history_bytes = 0;  // what a dedicated pair per history resource would take in all
    uint64_t persistent_bytes = 0;         // live at the frame seam
};

struct Plan {
    std::string pipeline;
    Extent extent;
    Facts facts;  // every fact, with its value
    std::string device;
    bool cpu = false;
    bool aliased = true;
    bool poison = false;
    std::vector<HostSlot> slots;
    std::vector<PlanResource> resources;
    std::vector<PlanPass> passes;
    std::vector<Culled> culled;
    std::vector<PlanOutput> outputs;
    std::vector<Heap> heaps;
    std::array<Dependency, 2> end;      // makes the outputs visible to the host
    std::vector<std::string> counters;  // "node.counter", in the counter buffer's order
    bool jitter = false;                // a node asks the host to jitter
    MemoryReport memory;

    uint32_t period() const { return 2 * static_cast<uint32_t>(passes.size()); }
    const PlanOutput* output(std::string_view name) const;
};

}  // namespace penumbra
