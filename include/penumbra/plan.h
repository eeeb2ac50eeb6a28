// SPDX-License-Identifier: MIT
// A compiled pipeline: the whole program of a frame, as data. Passes in order with their shaders, bindings,
// constants and dependencies; resources with their lifetimes and byte offsets; what a frame without history
// does. Program and View (program.h, view.h) carry it out and know nothing else, so that a host with a device
// layer of its own can do the same.
#pragma once

#include <vulkan/vulkan_core.h>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "penumbra/export.h"
#include "penumbra/node_set.h"

namespace penumbra PENUMBRA_API {

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
    bool linear = false;  // tiling, instead of optimal
};

// All that compile() asks of a device. device_table() (device.h) reads a real one; reference_device() is a
// fixed one for tests and for planning without a device.
struct DeviceTable {
    std::string name;
    bool cpu = false;                   // device class: selects the declarations' overrides
    uint32_t max_image_extent = 16384;  // pixels per axis
    uint32_t max_texel_elements = 1u << 27;
    bool loads_texels = false;              // imageLoad() of a texel buffer takes it less than texelFetch()
    uint32_t lanes_in_step = 1;             // of a workgroup's row or a subgroup: need no barrier
    uint32_t max_storage_bytes = 1u << 27;  // of one buffer binding
    // The rest of its limits, by the names of their members in Vulkan's structs; what is not named bounds
    // nothing.
    std::map<std::string, uint64_t> limits;
    uint64_t memory_bytes = ~uint64_t{0};  // of the largest device-local heap
    std::set<std::string>
        features;  // of Domain::features, those enabled on the device, which only the host can tell
    std::function<MemoryNeed(const ImageNeed&)> image_memory;
    std::function<MemoryNeed(uint64_t bytes, VkBufferUsageFlags usage)> buffer_memory;
    std::function<bool(Format, VkFormatFeatureFlags)> supports;
    // Optional, for devices that store words into a buffer in less time than texels into an image: how many
    // bytes lie from row to row of such an image in linear tiling, 0 where it cannot be had. Its memory is
    // then bound to a buffer, too, which shaders write (PlanResource::row_bytes).
    std::function<uint64_t(const ImageNeed&)> row_bytes;
};
DeviceTable reference_device(bool cpu = false);

// What a host brings for one declared input.
struct HostResource {
    Format format = Format::r8;  // images
    Extent extent;
    uint32_t layers = 1;
};

// Facts by name; what is absent is true.
using Facts = std::map<std::string, bool>;

struct Target {
    Extent extent;
    // Images and texels; absent: the declared extent and format, or the frame's (of texels of any extent: one
    // row) and the first that all readers accept. Of how many rows texels are must be said where an output
    // has a layer for each.
    std::map<std::string, HostResource> inputs;
    std::set<std::string> left_out;  // optional inputs that the host does not bring at all
    Facts facts;
    // Whether the host jitters its images; absent: where a node asks it to. Nodes whose past is each pixel's
    // own where nothing moves make facts true where it does (Plan::facts).
    std::optional<bool> jitters;
    DeviceTable device;
};

// What the host does with an output after record(): its image or buffer is created for that, and the plan's
// last dependency makes it visible to that.
struct OutputUse {
    VkImageUsageFlags image_usage =
        VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT;
    VkBufferUsageFlags buffer_usage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
    VkPipelineStageFlags2 stages = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    VkAccessFlags2 access = VK_ACCESS_2_MEMORY_READ_BIT;
    // The host brings the image itself, at every frame (SlotBinding); it gets a slot of the output's name.
    // Of images without a mip chain, whose previous value nobody reads. Its usage has TRANSFER_DST where a
    // node writes only some of it, or where a member of a family, whose it is, may sleep.
    bool host_image = false;
};

// What follows the frame's active size, which may change from frame to frame and is at most Plan::extent:
// width and height go through the steps, each max(ceil(x / div) * mul, 1).
struct Follows {
    struct Step {
        std::array<uint32_t, 2> div{1, 1}, mul{1, 1};
        friend bool operator==(const Step&, const Step&) = default;
    };
    std::vector<Step> steps;
    uint32_t mul = 1, add = 0;  // buffers: width * height * mul + add elements
    friend bool operator==(const Follows&, const Follows&) = default;

    Extent at(Extent frame) const;
};

// Stages and accesses of one use of a resource; all internal images stay in VK_IMAGE_LAYOUT_GENERAL.
struct Use {
    VkPipelineStageFlags2 stages = 0;
    VkAccessFlags2 access = 0;
    bool write = false;
};

// Ends the name of a resource's previous value: "color@-1".
inline constexpr std::string_view previous_suffix = "@-1";
inline bool is_previous(std::string_view name) {
    return name.ends_with(previous_suffix);
}
// The resource's own name, whichever value is named.
inline std::string_view without_previous(std::string_view name) {
    return is_previous(name) ? name.substr(0, name.size() - previous_suffix.size()) : name;
}

// A slot the host fills at every record(): an input, its previous value, a part of a bundle, or an image of
// its own to put an output into.
struct HostSlot {
    std::string name;         // by which the host binds it: "depth", "depth@-1", "world.nodes"
    std::string input, part;  // part: of a bundle, else empty
    bool previous = false;
    PortKind kind = PortKind::image;  // never bundle
    Format format = Format::r8;
    Extent extent;
    uint32_t layers = 1;
    bool layered = false;            // images: a 2D array, be it of one layer
    std::optional<Follows> follows;  // images: a frame of a smaller active size uses their top left part
    std::string element;
    uint32_t bytes = 0;                // of a struct: its size; else 0
    std::vector<std::string> readers;  // node ids; of an output the writer's
    bool output = false;
    bool required = true;          // false: the host may leave the input out (Target::left_out)
    std::vector<Format> accepted;  // images and texels: what it may bring (Target::inputs); `format` is one
    Use use;                       // how the frame's passes access it
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
    uint32_t settles = 0;  // frames that are alike, after which its past gets no better; 0: never
    uint32_t layers = 1, levels = 1;
    std::string element;
    uint64_t count = 0;  // elements (buffers, texels)
    // `extent` and `count` are those of the largest frame; of a smaller one, the top left part and the first
    // elements, whose rows are as long as that frame's.
    std::optional<Follows> follows;
    uint32_t element_bytes = 4;
    VkImageUsageFlags image_usage = 0;
    VkBufferUsageFlags buffer_usage = 0;
    // Images: not 0 if it has linear tiling, of so many bytes from row to row, and a storage buffer has the
    // same memory: a binding of that type whose resource is an image is that buffer.
    uint64_t row_bytes = 0;
    bool history = false, output = false;
    bool clear_on_reset = false;  // first: clear
    uint32_t first_pass = 0;
    uint32_t length = 1;  // passes on the circle of 2P
    uint64_t bytes = 0, alignment = 1;
    uint32_t heap = 0;
    std::array<uint64_t, 2> offset{0, 0};  // by frame parity
    std::optional<uint32_t> slot;          // the host's image, in no heap: of Plan::slots

    bool lasts() const { return history || kept; }  // what a frame leaves in it, a later one reads
    bool transient() const { return !slot && !lasts() && !output; }
    uint64_t buffer_bytes() const;  // of the VkBuffer, be it of an image's rows: whole words, never none
};

// What fills a binding.
enum class BindingSource : uint8_t {
    resource,     // index: of Plan::resources
    host,         // of Plan::slots
    table,        // of Plan::tables
    frame_block,  // the frame block (frame_block.h)
    counters,     // the frame's counters, u32 each
    nothing       // anything of the type and format: it is never read
};

struct PlanBinding {
    uint32_t set = 0, binding = 0;
    VkDescriptorType type = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
    BindingSource source = BindingSource::resource;
    uint32_t index = 0;
    bool previous = false;  // resource: the other parity's placement
    // Storage images are one level: the finest, or of the chain that a pass writes the level of the dispatch,
    // or the one before that.
    enum class Level : uint8_t { finest, written, finer } level = Level::finest;
    bool linear = false;         // sampled images
    bool layered = false;        // images: a 2D array
    Format format = Format::r8;  // images and texels
    std::string port;            // as the shader names it; empty: the graph's own
    bool output = false;

    bool is_texels() const {
        return type == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER ||
               type == VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER;
    }
};

// One image that starts to use its memory: UNDEFINED -> GENERAL.
struct Activation {
    uint32_t resource = 0;
    // Last accesses of the memory's previous occupants, and of those the writes that nobody has read.
    VkPipelineStageFlags2 src_stages = 0;
    VkAccessFlags2 src_access = 0;
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

// A parameter that may change per frame, in the push constants.
struct PlanParam {
    Param param;
    uint32_t offset = 0;  // bytes
};

struct PlanPass {
    PassKind kind = PassKind::compute;
    std::string node;                // node id; captures: the resource's name
    std::string type;                // node type; "capture"
    std::string variant;             // of the shader, to print
    std::string backends;            // of the node's bundles, to print
    std::optional<uint32_t> module;  // of Plan::modules, entry point "main"; none: the type has no shader
    HostCallback callback;           // host nodes
    std::vector<PlanBinding> bindings;
    std::vector<uint32_t> constants;  // specialisation data: ids 0 .. n-1, four bytes each
    std::vector<std::byte> push;      // the parameters' initial values
    std::vector<PlanParam> params;
    std::optional<uint32_t> mip_level;        // offset in `push`: the level of a dispatch
    std::array<uint32_t, 3> groups{1, 1, 1};  // at the plan's extent
    // What the dispatch is over; a group covers so many pixels of it. Nothing: `groups` holds for every size.
    std::optional<Follows> over;
    std::array<uint32_t, 2> group_pixels{1, 1};
    std::vector<std::array<uint32_t, 3>> level_groups;  // writers of a mip chain: of each level; else empty
    std::optional<uint32_t> indirect;                   // resource with the arguments
    uint32_t indirect_offset = 0;
    std::vector<std::string> counters;  // names; they are the pass's part of the frame's counters
    uint32_t counter_base = 0;
    std::vector<PassUse> uses;
    std::vector<uint32_t> clears;      // resources cleared before the pass (writes: some)
    std::array<Dependency, 2> before;  // by frame parity
    std::array<Dependency, 2> after_clears;
    std::vector<std::string> reads, writes;
    // Of a family of instances: of Plan::members. While that one is asleep (View::set_awake) a pass that
    // `rests` is left out, and in its place these resources, which others read, become 0.
    std::optional<uint32_t> member;
    bool rests = false;
    std::vector<uint32_t> zero_at_rest;

    const PlanBinding* binding(std::string_view port) const;  // nullptr: none
    // Of a frame of this size; `level`: of a mip chain.
    std::array<uint32_t, 3> groups_at(Extent frame, uint32_t level = 0) const;
};

// Static texels, which every view uploads in its first frame and in each reset frame
// (Program::record_uploads).
struct PlanTable {
    std::string name;  // "node type/table"
    Format format = Format::r8;
    std::array<uint32_t, 2> extent{1, 1};
    bool storage = false;  // bound as a storage image instead of as a sampled one; in GENERAL either way
    std::shared_ptr<const std::vector<std::byte>> texels;
};

// On a frame without history, before the first pass: the previous parity's image gets its layout (from
// UNDEFINED), and where `clear` is set the resource becomes 0.
struct ResetAction {
    uint32_t resource = 0;
    bool clear = false;
};

struct Culled {
    std::string node;
    std::string why;   // "unused" | "if" | "with"
    std::string cond;  // the condition, for "if"; the input that the host leaves out, for "with"
};

struct PlanOutput {
    std::string name;
    uint32_t resource = 0;
    Use use;  // the host's, after the frame
};

struct Heap {
    std::string type;  // "images" | "buffers"
    uint64_t bytes = 0;
    uint32_t memory_type_bits = ~0u;
    uint64_t alignment = 1;
    bool shared = false;  // holds nothing from one frame to the next: views that take turns may share it
};

struct MemoryReport {
    uint64_t heap_bytes = 0, live_bound_bytes = 0, unaliased_bytes = 0;
    std::optional<uint64_t> optimum_bytes;
    uint64_t dedicated_history_bytes = 0;  // what a dedicated pair per history resource would take in all
    uint64_t persistent_bytes = 0;         // live at the frame seam
    uint64_t shared_bytes = 0;             // of heap_bytes: of shared heaps
};

struct Plan {
    std::string pipeline;
    std::shared_ptr<const Domain> domain;
    Extent extent;  // of the largest frame
    Facts facts;    // every fact, with its value
    std::string device;
    bool aliased = true;
    bool poison = false;
    std::vector<HostSlot> slots;
    std::vector<PlanTable> tables;
    std::vector<std::vector<uint32_t>> modules;  // SPIR-V, with the passes' sets
    std::vector<PlanResource> resources;
    std::vector<PlanPass> passes;
    std::vector<std::string> members;  // of families of instances that have nodes
    std::vector<Culled> culled;
    std::vector<PlanOutput> outputs;
    std::vector<Heap> heaps;
    std::vector<ResetAction> reset;
    std::array<Dependency, 2> end;      // makes the outputs visible to the host
    std::vector<std::string> counters;  // "node.counter", in the counter buffer's order
    bool jitter = false;                // the host is to jitter (Target::jitters)
    bool camera = false;                // the host is to say what its camera is: a node asks for it
    // Number of frames, alike but for jitter and index, after which one more improves no output: histories
    // settle one after another. Empty: one of them never does.
    std::optional<uint32_t> settles;
    MemoryReport memory;

    uint32_t period() const { return 2 * static_cast<uint32_t>(passes.size()); }
    const PlanOutput* output(std::string_view name) const;
    std::optional<uint32_t> slot(std::string_view name) const;
    const PlanPass* pass(std::string_view node) const;  // nullptr: it does not run
};

}  // namespace penumbra
