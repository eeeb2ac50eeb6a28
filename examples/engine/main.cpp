// SPDX-License-Identifier: MIT
// An engine with a frame graph, an allocator and barriers of its own, in which penumbra is one node with
// ports: the G-buffer goes in, visibility comes out into an image that the engine's graph owns. Two frames
// are in flight, and nothing waits but for the fence of the frame before the last. What the G-buffer pass
// would render is read from files (FOLDER/FRAME/SLOT.bin).
//     engine PIPELINE.json WIDTH HEIGHT FRAMES FOLDER
#include <penumbra/graph.h>
#include <penumbra/shadow_nodes.h>
#include <vulkan/vulkan.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>

namespace fs = std::filesystem;
namespace pen = penumbra;

namespace engine {

void must(VkResult result, const char* what) {
    if (result == VK_SUCCESS) return;
    std::fprintf(stderr, "%s: %s\n", what, pen::result_name(result).c_str());
    std::exit(1);
}

std::vector<char> read(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) std::fprintf(stderr, "cannot read %s\n", file.c_str()), std::exit(1);
    return {std::istreambuf_iterator<char>(in), {}};
}

// --- Device: one, with validation.
// ---------------------------------------------------------------------------
VkInstance instance;
VkDebugUtilsMessengerEXT messenger;
VkPhysicalDevice physical;
VkDevice device;
VkQueue queue;
uint32_t family = 0, messages = 0;

VKAPI_ATTR VkBool32 VKAPI_CALL complain(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                        VkDebugUtilsMessageTypeFlagsEXT,
                                        const VkDebugUtilsMessengerCallbackDataEXT* data, void*) {
    std::fprintf(stderr, "%s\n", data->pMessage);
    ++messages;
    return VK_FALSE;
}

template <class F>
F function(const char* name) {
    return reinterpret_cast<F>(vkGetInstanceProcAddr(instance, name));
}

void open_device() {
    const VkValidationFeatureEnableEXT sync = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    const VkValidationFeaturesEXT checks{
        VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, nullptr, 1, &sync, 0, nullptr};
    VkApplicationInfo app{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    app.apiVersion = VK_API_VERSION_1_3;
    const char *layer = "VK_LAYER_KHRONOS_validation", *extension = "VK_EXT_debug_utils";
    const VkInstanceCreateInfo create{
        VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, &checks, 0, &app, 1, &layer, 1, &extension};
    must(vkCreateInstance(&create, nullptr, &instance), "vkCreateInstance");
    VkDebugUtilsMessengerCreateInfoEXT debug{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    debug.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    debug.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    debug.pfnUserCallback = complain;
    must(function<PFN_vkCreateDebugUtilsMessengerEXT>("vkCreateDebugUtilsMessengerEXT")(instance, &debug,
                                                                                        nullptr, &messenger),
         "vkCreateDebugUtilsMessengerEXT");
    uint32_t one = 1;
    vkEnumeratePhysicalDevices(instance, &one, &physical);
    // This engine enables what it finds; requirements() says what penumbra wants of that.
    VkPhysicalDeviceVulkan13Features v13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    VkPhysicalDeviceVulkan12Features v12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, &v13};
    VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &v12};
    vkGetPhysicalDeviceFeatures2(physical, &features);
    features.features.robustBufferAccess = VK_FALSE;
    const float priority = 1;
    const VkDeviceQueueCreateInfo queues{
        VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, family, 1, &priority};
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features};
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queues;
    must(vkCreateDevice(physical, &info, nullptr, &device), "vkCreateDevice");
    vkGetDeviceQueue(device, family, 0, &queue);
}

// --- Allocator: blocks of a type, filled from the front; a block that nobody uses any more begins anew.
// ---------
struct Block {
    VkDeviceMemory memory;
    uint32_t type, users = 0;
    bool linear;
    VkDeviceSize size, filled = 0;
    char* mapped = nullptr;
};
std::vector<Block> blocks;

struct Place {
    size_t block;
    VkDeviceSize offset;
};

Place allocate(const VkMemoryRequirements& need, VkMemoryPropertyFlags wanted, bool linear) {
    VkPhysicalDeviceMemoryProperties types;
    vkGetPhysicalDeviceMemoryProperties(physical, &types);
    uint32_t type = 0;
    while (!(need.memoryTypeBits >> type & 1) || (types.memoryTypes[type].propertyFlags & wanted) != wanted)
        ++type;
    const auto offset_in = [&](const Block& b) {
        return (b.filled + need.alignment - 1) / need.alignment * need.alignment;
    };
    size_t at = 0;
    while (at < blocks.size() && (blocks[at].type != type || blocks[at].linear != linear ||
                                  offset_in(blocks[at]) + need.size > blocks[at].size))
        ++at;
    if (at == blocks.size()) {
        Block block{VK_NULL_HANDLE, type, 0, linear, std::max<VkDeviceSize>(need.size, 4 << 20)};
        const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, block.size, type};
        must(vkAllocateMemory(device, &info, nullptr, &block.memory), "vkAllocateMemory");
        void* mapped = nullptr;
        if (types.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT)
            must(vkMapMemory(device, block.memory, 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
        block.mapped = static_cast<char*>(mapped);
        blocks.push_back(block);
    }
    const Place place{at, offset_in(blocks[at])};
    blocks[at].filled = place.offset + need.size;
    ++blocks[at].users;
    return place;
}

void release(size_t block) {
    if (--blocks[block].users == 0) blocks[block].filled = 0;
}

// The same for penumbra: each request is one of the allocator's.
pen::HostMemory memory_of_the_engine() {
    return {[](const pen::MemoryRequest& request, pen::MemoryBlock& out) {
                const Place place = allocate(request.need, request.properties, request.linear);
                const Block& block = blocks[place.block];
                out = {block.memory, place.offset, block.mapped ? block.mapped + place.offset : nullptr,
                       reinterpret_cast<void*>(place.block)};
                return VK_SUCCESS;
            },
            [](const pen::MemoryBlock& block) { release(reinterpret_cast<size_t>(block.user)); }};
}

struct Buffer {
    VkBuffer handle = VK_NULL_HANDLE;
    VkBufferView texels = VK_NULL_HANDLE;
    Place place{};
    char* mapped() const { return blocks[place.block].mapped + place.offset; }
};

Buffer make_buffer(VkDeviceSize size, VkFormat texels) {
    Buffer b;
    VkBufferCreateInfo create{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    create.size = size;
    create.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT |
                   VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT;
    must(vkCreateBuffer(device, &create, nullptr, &b.handle), "vkCreateBuffer");
    VkMemoryRequirements need;
    vkGetBufferMemoryRequirements(device, b.handle, &need);
    b.place =
        allocate(need, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT, true);
    must(vkBindBufferMemory(device, b.handle, blocks[b.place.block].memory, b.place.offset),
         "vkBindBufferMemory");
    if (texels == VK_FORMAT_UNDEFINED) return b;
    const VkBufferViewCreateInfo view{
        VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO, nullptr, 0, b.handle, texels, 0, VK_WHOLE_SIZE};
    must(vkCreateBufferView(device, &view, nullptr, &b.texels), "vkCreateBufferView");
    return b;
}

void destroy(const Buffer& b) {
    vkDestroyBufferView(device, b.texels, nullptr);
    vkDestroyBuffer(device, b.handle, nullptr);
    release(b.place.block);
}

// --- Frame graph: passes say how they use which image; the barriers follow.
// --------------------------------------
struct Access {
    VkPipelineStageFlags2 stages = VK_PIPELINE_STAGE_2_NONE;
    VkAccessFlags2 access = VK_ACCESS_2_NONE;
    VkImageLayout layout = VK_IMAGE_LAYOUT_UNDEFINED;
    bool write = false;
};

struct Image {
    VkImage handle = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;
    VkImageAspectFlags aspect = VK_IMAGE_ASPECT_COLOR_BIT;
    VkExtent3D extent{};
    Place place{};
    Access last;  // how it was used last
};

Image make_image(VkFormat format, VkExtent3D extent, VkImageUsageFlags usage) {
    Image image;
    image.extent = extent;
    if (format == VK_FORMAT_D32_SFLOAT) image.aspect = VK_IMAGE_ASPECT_DEPTH_BIT;
    VkImageCreateInfo create{
        VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO, nullptr, 0, VK_IMAGE_TYPE_2D, format, extent};
    create.mipLevels = create.arrayLayers = 1;
    create.samples = VK_SAMPLE_COUNT_1_BIT;
    create.usage = usage;
    must(vkCreateImage(device, &create, nullptr, &image.handle), "vkCreateImage");
    VkMemoryRequirements need;
    vkGetImageMemoryRequirements(device, image.handle, &need);
    image.place = allocate(need, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, false);
    must(vkBindImageMemory(device, image.handle, blocks[image.place.block].memory, image.place.offset),
         "vkBindImageMemory");
    const VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                     nullptr,
                                     0,
                                     image.handle,
                                     VK_IMAGE_VIEW_TYPE_2D,
                                     format,
                                     {},
                                     {image.aspect, 0, 1, 0, 1}};
    must(vkCreateImageView(device, &view, nullptr, &image.view), "vkCreateImageView");
    return image;
}

void destroy(const Image& image) {
    vkDestroyImageView(device, image.view, nullptr);
    vkDestroyImage(device, image.handle, nullptr);
    release(image.place.block);
}

constexpr Access copy_target{VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_WRITE_BIT,
                             VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, true};
constexpr Access copy_source{VK_PIPELINE_STAGE_2_COPY_BIT, VK_ACCESS_2_TRANSFER_READ_BIT,
                             VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, false};

class FrameGraph {
  public:
    std::map<std::string, Image> images;
    void add(std::map<std::string, Access> uses, std::function<void(VkCommandBuffer)> record) {
        passes_.push_back({std::move(uses), std::move(record)});
    }
    void execute(VkCommandBuffer cmd) {
        for (const Pass& pass : passes_) {
            std::vector<VkImageMemoryBarrier2> barriers;
            for (const auto& [name, use] : pass.uses) {
                Image& image = images.at(name);
                if (!use.write && !image.last.write && use.layout == image.last.layout) {
                    image.last.stages |= use.stages;
                    continue;
                }
                VkImageMemoryBarrier2 b{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
                b.srcStageMask = image.last.stages;
                b.srcAccessMask = image.last.write ? image.last.access : VkAccessFlags2{};
                b.dstStageMask = use.stages;
                b.dstAccessMask = use.access;
                b.oldLayout = use.write ? VK_IMAGE_LAYOUT_UNDEFINED : image.last.layout;
                b.newLayout = use.layout;
                b.srcQueueFamilyIndex = b.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
                b.image = image.handle;
                b.subresourceRange = {image.aspect, 0, 1, 0, 1};
                barriers.push_back(b);
                image.last = use;
            }
            VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
            info.imageMemoryBarrierCount = static_cast<uint32_t>(barriers.size());
            info.pImageMemoryBarriers = barriers.data();
            if (!barriers.empty()) vkCmdPipelineBarrier2(cmd, &info);
            pass.record(cmd);
        }
        passes_.clear();
    }

  private:
    struct Pass {
        std::map<std::string, Access> uses;
        std::function<void(VkCommandBuffer)> record;
    };
    std::vector<Pass> passes_;
};

}  // namespace engine

// --- Penumbra as a node of the engine's graph: its slots are the node's ports.
// -------------------------------------
class ShadowNode {
  public:
    ShadowNode(const char* file, pen::Extent extent, uint32_t frames_in_flight) {
        const pen::DeviceHandles handles{engine::instance,      engine::physical,
                                         engine::device,        engine::family,
                                         vkGetInstanceProcAddr, engine::memory_of_the_engine()};
        pen::Diagnostics errors;
        const auto pipeline = pen::load_pipeline(file, {}, errors);
        const auto checked = pipeline ? pen::check(*pipeline, pen::shadow_nodes(), errors) : std::nullopt;
        pen::Target target{
            .extent = extent, .facts = {{"alpha", false}}, .device = pen::device_table(handles)};
        pen::CompileOptions options;
        options.outputs["visibility"].host_image = true;  // the engine's graph owns what it passes on
        if (checked)
            for (const pen::HostInput& input : checked->inputs)
                if (input.name == "normal") target.inputs["normal"] = {pen::Format::rgba32f, extent};
        auto compiled = checked ? pen::compile(*checked, target, options, errors) : std::nullopt;
        if (!compiled) std::fputs(errors.text().c_str(), stderr), std::exit(2);
        plan = std::make_shared<const pen::Plan>(std::move(*compiled));
        view_ = std::make_unique<pen::View>(std::make_shared<const pen::Program>(handles, plan),
                                            pen::ViewOptions{.frames_in_flight = frames_in_flight});
        externals_ = std::make_unique<pen::Externals>(*plan);
    }

    // What the engine's graph is told: the plan knows how each slot is used, and in which layout.
    std::map<std::string, engine::Access> uses() const {
        std::map<std::string, engine::Access> uses;
        for (const pen::HostSlot& slot : plan->slots)
            if (slot.kind == pen::PortKind::image)
                uses[slot.name] = {
                    slot.use.stages, slot.use.access,
                    slot.output ? VK_IMAGE_LAYOUT_GENERAL : VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                    slot.output};
        return uses;
    }

    void record(VkCommandBuffer cmd, const pen::FrameDescription& frame, const engine::FrameGraph& graph,
                const std::map<std::string, engine::Buffer>& buffers) {
        for (const pen::HostSlot& slot : plan->slots) {
            pen::SlotBinding& binding = (*externals_)[slot.name];
            if (slot.kind != pen::PortKind::image) {
                binding = {.texels = buffers.at(slot.name).texels, .buffer = buffers.at(slot.name).handle};
                continue;
            }
            const engine::Image& image = graph.images.at(slot.name);
            binding = {.image = image.view};
            // The graph has brought it to `uses()`, and takes it from there.
            if (slot.output)
                binding.handover = pen::Handover{.image = image.handle,
                                                 .stages_before = slot.use.stages,
                                                 .layout_after = VK_IMAGE_LAYOUT_GENERAL};
        }
        if (const auto error = pen::attempt([&] { view_->record(cmd, frame, *externals_); }))
            std::fprintf(stderr, "%s\n", pen::to_string(*error).c_str()), std::exit(1);
    }

    std::shared_ptr<const pen::Plan> plan;

  private:
    std::unique_ptr<pen::View> view_;
    std::unique_ptr<pen::Externals> externals_;
};

int main(int argc, char** argv) {
    using namespace engine;
    if (argc != 6) return std::fputs("usage: engine PIPELINE.json WIDTH HEIGHT FRAMES FOLDER\n", stderr), 2;
    const pen::Extent extent{static_cast<uint32_t>(std::atoi(argv[2])),
                             static_cast<uint32_t>(std::atoi(argv[3]))};
    open_device();
    constexpr uint32_t in_flight = 2;
    auto shadows = std::make_unique<ShadowNode>(argv[1], extent, in_flight);
    FrameGraph graph;
    for (const pen::HostSlot& slot : shadows->plan->slots)
        if (slot.kind == pen::PortKind::image)
            graph.images[slot.name] =
                make_image(pen::info(slot.format).vk, {slot.extent.width, slot.extent.height, 1},
                           VK_IMAGE_USAGE_SAMPLED_BIT |
                               (slot.output ? VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT
                                            : VK_IMAGE_USAGE_TRANSFER_DST_BIT));

    struct InFlight {
        VkCommandPool pool;
        VkCommandBuffer cmd;
        VkFence fence;
        std::map<std::string, Buffer> buffers;  // of the frame, until its fence
        std::function<void()> done;
    } ring[in_flight];
    for (InFlight& slot : ring) {
        const VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr, 0, family};
        must(vkCreateCommandPool(device, &pool, nullptr, &slot.pool), "vkCreateCommandPool");
        const VkCommandBufferAllocateInfo allocate_info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                        nullptr, slot.pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY,
                                                        1};
        must(vkAllocateCommandBuffers(device, &allocate_info, &slot.cmd), "vkAllocateCommandBuffers");
        const VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO, nullptr,
                                      VK_FENCE_CREATE_SIGNALED_BIT};
        must(vkCreateFence(device, &fence, nullptr, &slot.fence), "vkCreateFence");
    }
    const auto retire = [&](InFlight& slot) {  // the frame that was here has completed
        must(vkWaitForFences(device, 1, &slot.fence, VK_TRUE, UINT64_MAX), "vkWaitForFences");
        if (slot.done) slot.done();
        slot.done = {};
        for (const auto& [name, buffer] : slot.buffers) destroy(buffer);
        slot.buffers.clear();
    };

    for (int f = 0; f < std::atoi(argv[4]); ++f) {
        InFlight& slot = ring[f % in_flight];
        retire(slot);
        must(vkResetFences(device, 1, &slot.fence), "vkResetFences");
        must(vkResetCommandPool(device, slot.pool, 0), "vkResetCommandPool");
        const VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
        must(vkBeginCommandBuffer(slot.cmd, &begin), "vkBeginCommandBuffer");
        const fs::path folder = fs::path(argv[5]) / std::to_string(f);

        // The G-buffer pass, and what it draws; uniform and texel buffers of the frame.
        std::map<std::string, Access> drawn;
        for (const pen::HostSlot& port : shadows->plan->slots) {
            if (port.output) continue;
            const std::vector<char> bytes = read(folder / (port.name + ".bin"));
            const bool texels = port.kind == pen::PortKind::texels;
            Buffer& buffer = slot.buffers[port.name] =
                make_buffer(bytes.size(), texels ? pen::info(port.format).vk : VK_FORMAT_UNDEFINED);
            std::memcpy(buffer.mapped(), bytes.data(), bytes.size());
            if (port.kind == pen::PortKind::image) drawn[port.name] = copy_target;
        }
        graph.add(drawn, [&](VkCommandBuffer cmd) {
            for (const auto& [name, use] : drawn) {
                const Image& image = graph.images.at(name);
                const VkBufferImageCopy copy{0, 0, 0, {image.aspect, 0, 0, 1}, {}, image.extent};
                vkCmdCopyBufferToImage(cmd, slot.buffers.at(name).handle, image.handle, use.layout, 1, &copy);
            }
        });

        // Shadows.
        pen::FrameDescription frame;
        std::memcpy(static_cast<void*>(&frame), read(folder / "frame.bin").data(), sizeof frame);
        graph.add(shadows->uses(),
                  [&](VkCommandBuffer cmd) { shadows->record(cmd, frame, graph, slot.buffers); });

        // Lighting, which here is a copy into a file.
        const pen::HostSlot& output = shadows->plan->slots[*shadows->plan->slot("visibility")];
        const size_t size = size_t{extent.width} * extent.height * pen::info(output.format).bytes;
        const Buffer& result = slot.buffers["result"] = make_buffer(size, VK_FORMAT_UNDEFINED);
        graph.add({{"visibility", copy_source}}, [&](VkCommandBuffer cmd) {
            const Image& image = graph.images.at("visibility");
            const VkBufferImageCopy copy{0, 0, 0, {image.aspect, 0, 0, 1}, {}, image.extent};
            vkCmdCopyImageToBuffer(cmd, image.handle, copy_source.layout, result.handle, 1, &copy);
            VkMemoryBarrier2 barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER_2};
            barrier.srcStageMask = VK_PIPELINE_STAGE_2_COPY_BIT;
            barrier.srcAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
            barrier.dstStageMask = VK_PIPELINE_STAGE_2_HOST_BIT;
            barrier.dstAccessMask = VK_ACCESS_2_HOST_READ_BIT;
            VkDependencyInfo info{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
            info.memoryBarrierCount = 1;
            info.pMemoryBarriers = &barrier;
            vkCmdPipelineBarrier2(cmd, &info);
        });
        slot.done = [&result, size, folder] {
            std::ofstream(folder / "visibility.engine", std::ios::binary)
                .write(result.mapped(), static_cast<std::streamsize>(size));
        };

        graph.execute(slot.cmd);
        must(vkEndCommandBuffer(slot.cmd), "vkEndCommandBuffer");
        VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
        submit.commandBufferCount = 1;
        submit.pCommandBuffers = &slot.cmd;
        must(vkQueueSubmit(queue, 1, &submit, slot.fence), "vkQueueSubmit");
    }
    for (InFlight& slot : ring) {
        retire(slot);
        vkDestroyFence(device, slot.fence, nullptr);
        vkDestroyCommandPool(device, slot.pool, nullptr);
    }
    shadows.reset();
    for (const auto& [name, image] : graph.images) destroy(image);
    for (const Block& block : blocks) {
        if (block.users) std::fprintf(stderr, "memory has leaked\n"), ++messages;
        vkFreeMemory(device, block.memory, nullptr);
    }
    vkDestroyDevice(device, nullptr);
    function<PFN_vkDestroyDebugUtilsMessengerEXT>("vkDestroyDebugUtilsMessengerEXT")(instance, messenger,
                                                                                     nullptr);
    vkDestroyInstance(instance, nullptr);
    return messages ? 1 : 0;
}
