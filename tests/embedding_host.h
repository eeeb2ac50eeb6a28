// SPDX-License-Identifier: MIT
// A host to embed penumbra in, for tests: small plans of toy nodes, functions that listen, an allocator that
// may fail, command buffers of threads.
#pragma once

#include <array>
#include <cstring>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "app/session.h"
#include "host/device/gpu.h"
#include "penumbra/graph.h"
#include "tests/gpu_test.h"
#include "tests/toy_set.h"

namespace penumbra::test {

constexpr uint32_t width = 29, height = 13;  // of the toys' frames

CheckedPipeline checked(const std::string& body, const NodeSet& set = toy_set());
extern const char* const given_and_history;  // reads the slot "given" and its own past

std::shared_ptr<const Plan> plan_of(const CheckedPipeline& pipeline, const CompileOptions& options);
std::shared_ptr<const Program> program_with(const CheckedPipeline& pipeline, const Facts& facts,
                                            bool hand_on = true, Extent extent = {width, height});
CompileOptions capturing(const CheckedPipeline& pipeline, bool share = false);
FrameDescription description(uint32_t index, Extent size = {width, height});

std::vector<float> floats(std::span<const std::byte> bytes);
using Outputs = std::map<std::string, std::vector<float>>;
Outputs outputs_of(const View& view);
Outputs run_toys(const DeviceHandles& handles, uint32_t frames);

GpuImage image_of(VkFormat format, VkImageUsageFlags usage);  // a frame's size

// The functions that were asked for, and the barriers that belong to another queue family, which are not
// passed on: this device has but one.
struct Spy {
    static inline std::set<std::string> asked;
    static inline std::vector<VkImageMemoryBarrier2> transfers;
    static inline std::vector<VkMemoryBarrier2> barriers;
    static inline std::vector<VkImageMemoryBarrier2> images;    // all of them
    static inline std::vector<VkBufferMemoryBarrier2> buffers;  // all of them
    static inline std::vector<std::byte> cache;                 // that a program was made with

    static inline std::set<std::string> names, labels;  // of objects, of what passes record
    static VKAPI_ATTR VkResult VKAPI_CALL set_name(VkDevice, const VkDebugUtilsObjectNameInfoEXT* info) {
        names.insert(info->pObjectName);
        return VK_SUCCESS;
    }
    static VKAPI_ATTR void VKAPI_CALL begin_label(VkCommandBuffer, const VkDebugUtilsLabelEXT* info) {
        labels.insert(info->pLabelName);
    }
    static VKAPI_ATTR void VKAPI_CALL end_label(VkCommandBuffer) {}

    static VKAPI_ATTR VkResult VKAPI_CALL make_cache(VkDevice device, const VkPipelineCacheCreateInfo* info,
                                                     const VkAllocationCallbacks* callbacks,
                                                     VkPipelineCache* handle) {
        const auto* data = static_cast<const std::byte*>(info->pInitialData);
        cache.assign(data, data + info->initialDataSize);
        return vkCreatePipelineCache(device, info, callbacks, handle);
    }

    static VKAPI_ATTR void VKAPI_CALL barrier(VkCommandBuffer cmd, const VkDependencyInfo* info) {
        images.insert(images.end(), info->pImageMemoryBarriers,
                      info->pImageMemoryBarriers + info->imageMemoryBarrierCount);
        buffers.insert(buffers.end(), info->pBufferMemoryBarriers,
                       info->pBufferMemoryBarriers + info->bufferMemoryBarrierCount);
        barriers.insert(barriers.end(), info->pMemoryBarriers,
                        info->pMemoryBarriers + info->memoryBarrierCount);
        if (info->imageMemoryBarrierCount > 0 &&
            info->pImageMemoryBarriers[0].srcQueueFamilyIndex != VK_QUEUE_FAMILY_IGNORED)
            transfers.insert(transfers.end(), info->pImageMemoryBarriers,
                             info->pImageMemoryBarriers + info->imageMemoryBarrierCount);
        else
            vkCmdPipelineBarrier2(cmd, info);
    }
    static inline uint32_t uploads = 0;  // of tables
    static VKAPI_ATTR void VKAPI_CALL upload(VkCommandBuffer cmd, VkBuffer from, VkImage to,
                                             VkImageLayout layout, uint32_t count,
                                             const VkBufferImageCopy* regions) {
        ++uploads;
        vkCmdCopyBufferToImage(cmd, from, to, layout, count, regions);
    }
    static inline std::vector<VkDescriptorBufferInfo> blocks;  // uniform, as they were bound
    static VKAPI_ATTR void VKAPI_CALL update(VkDevice device, uint32_t count,
                                             const VkWriteDescriptorSet* writes, uint32_t copies,
                                             const VkCopyDescriptorSet* from) {
        for (uint32_t i = 0; i < count; ++i)
            if (writes[i].descriptorType == VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER)
                blocks.push_back(*writes[i].pBufferInfo);
        vkUpdateDescriptorSets(device, count, writes, copies, from);
    }
    static inline std::vector<std::array<uint32_t, 3>> dispatches;
    static VKAPI_ATTR void VKAPI_CALL dispatch(VkCommandBuffer cmd, uint32_t x, uint32_t y, uint32_t z) {
        dispatches.push_back({x, y, z});
        vkCmdDispatch(cmd, x, y, z);
    }

    static inline uint32_t made = 0;  // objects, by the functions that penumbra makes any with while it runs
    struct Bound {
        VkDeviceMemory memory;
        VkDeviceSize offset;
        bool image;
    };
    static inline std::vector<Bound> bound;  // where objects were
    static VKAPI_ATTR VkResult VKAPI_CALL bind_image(VkDevice device, VkImage image, VkDeviceMemory memory,
                                                     VkDeviceSize offset) {
        bound.push_back({memory, offset, true});
        return vkBindImageMemory(device, image, memory, offset);
    }
    static VKAPI_ATTR VkResult VKAPI_CALL bind_buffer(VkDevice device, VkBuffer buffer, VkDeviceMemory memory,
                                                      VkDeviceSize offset) {
        bound.push_back({memory, offset, false});
        return vkBindBufferMemory(device, buffer, memory, offset);
    }

    static inline uint32_t sets = 0, room = 0;  // taken from descriptor pools, and what these have
    static inline std::map<VkDescriptorType, uint32_t> descriptors;
    static VKAPI_ATTR VkResult VKAPI_CALL make_pool(VkDevice device, const VkDescriptorPoolCreateInfo* info,
                                                    const VkAllocationCallbacks* callbacks,
                                                    VkDescriptorPool* pool) {
        room += info->maxSets;
        for (uint32_t i = 0; i < info->poolSizeCount; ++i)
            descriptors[info->pPoolSizes[i].type] += info->pPoolSizes[i].descriptorCount;
        return vkCreateDescriptorPool(device, info, callbacks, pool);
    }
    static VKAPI_ATTR VkResult VKAPI_CALL take_sets(VkDevice device, const VkDescriptorSetAllocateInfo* info,
                                                    VkDescriptorSet* taken) {
        sets += info->descriptorSetCount;
        ++made;
        return vkAllocateDescriptorSets(device, info, taken);
    }

    template <auto function, class... A>
    static VKAPI_ATTR VkResult VKAPI_CALL counted(A... arguments) {
        ++made;
        return function(arguments...);
    }
    template <auto function, class... A>
    static PFN_vkVoidFunction counting(VkResult(VKAPI_PTR*)(A...)) {
        return reinterpret_cast<PFN_vkVoidFunction>(&counted<function, A...>);
    }

    static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL of_device(VkDevice device, const char* name) {
        asked.insert(name);
#define PENUMBRA_COUNTED(function) \
    if (!std::strcmp(name, #function)) return counting<function>(function);
        PENUMBRA_COUNTED(vkCreateComputePipelines)
        PENUMBRA_COUNTED(vkCreateImage)
        PENUMBRA_COUNTED(vkCreateBuffer)
#undef PENUMBRA_COUNTED
        if (!std::strcmp(name, "vkCmdPipelineBarrier2")) return reinterpret_cast<PFN_vkVoidFunction>(barrier);
        if (!std::strcmp(name, "vkBindImageMemory")) return reinterpret_cast<PFN_vkVoidFunction>(bind_image);
        if (!std::strcmp(name, "vkBindBufferMemory"))
            return reinterpret_cast<PFN_vkVoidFunction>(bind_buffer);
        if (!std::strcmp(name, "vkCreateDescriptorPool"))
            return reinterpret_cast<PFN_vkVoidFunction>(make_pool);
        if (!std::strcmp(name, "vkAllocateDescriptorSets"))
            return reinterpret_cast<PFN_vkVoidFunction>(take_sets);
        if (!std::strcmp(name, "vkUpdateDescriptorSets")) return reinterpret_cast<PFN_vkVoidFunction>(update);
        if (!std::strcmp(name, "vkCmdCopyBufferToImage")) return reinterpret_cast<PFN_vkVoidFunction>(upload);
        if (!std::strcmp(name, "vkCmdDispatch")) return reinterpret_cast<PFN_vkVoidFunction>(dispatch);
        if (!std::strcmp(name, "vkSetDebugUtilsObjectNameEXT"))
            return reinterpret_cast<PFN_vkVoidFunction>(set_name);
        if (!std::strcmp(name, "vkCmdBeginDebugUtilsLabelEXT"))
            return reinterpret_cast<PFN_vkVoidFunction>(begin_label);
        if (!std::strcmp(name, "vkCmdEndDebugUtilsLabelEXT"))
            return reinterpret_cast<PFN_vkVoidFunction>(end_label);
        if (!std::strcmp(name, "vkCreatePipelineCache"))
            return reinterpret_cast<PFN_vkVoidFunction>(make_cache);
        return vkGetDeviceProcAddr(device, name);
    }
    static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL of_instance(VkInstance instance, const char* name) {
        asked.insert(name);
        if (!std::strcmp(name, "vkGetDeviceProcAddr")) return reinterpret_cast<PFN_vkVoidFunction>(of_device);
        return vkGetInstanceProcAddr(instance, name);
    }
    static DeviceHandles handles() {
        asked.clear();
        transfers.clear();
        barriers.clear();
        images.clear();
        uploads = 0;
        DeviceHandles handles = handles_of(gpu());
        handles.get_instance_proc_addr = of_instance;
        handles.debug_utils = true;
        return handles;
    }
};

// A host's allocator: blocks inside larger allocations, mapped where asked for, and no more after so many.
class Allocator {
  public:
    HostMemory callbacks() {
        return {[this](const MemoryRequest& request, MemoryBlock& block) { return allocate(request, block); },
                [this](const MemoryBlock& block) { release(block); }};
    }
    size_t calls = 0, fail_at = ~size_t{0};
    VkResult failure = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    std::map<void*, MemoryBlock> live;
    uint64_t bytes = 0;  // that were asked for, in all
    struct Block {
        VkDeviceSize offset;
        bool linear;
    };
    std::map<VkDeviceMemory, Block> blocks;  // all so far

  private:
    VkResult allocate(const MemoryRequest& request, MemoryBlock& block) {
        if (++calls == fail_at) return failure;
        VkPhysicalDeviceMemoryProperties memory;
        vkGetPhysicalDeviceMemoryProperties(gpu().physical(), &memory);
        uint32_t type = 0;
        while (!(request.need.memoryTypeBits >> type & 1) ||
               (memory.memoryTypes[type].propertyFlags & request.properties) != request.properties)
            ++type;
        block.offset = (12345 / request.need.alignment + 1) * request.need.alignment;
        const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr,
                                        block.offset + request.need.size + 999, type};
        check(vkAllocateMemory(gpu().get(), &info, nullptr, &block.memory), "vkAllocateMemory", request.what);
        if (request.mapped) {
            check(vkMapMemory(gpu().get(), block.memory, 0, VK_WHOLE_SIZE, 0, &block.mapped), "vkMapMemory",
                  "");
            block.mapped = static_cast<std::byte*>(block.mapped) + block.offset;
        }
        bytes += request.need.size;
        blocks[block.memory] = {block.offset, request.linear};
        block.user = block.memory;
        live[block.user] = block;
        return VK_SUCCESS;
    }
    void release(const MemoryBlock& block) {
        ASSERT_EQ(live.erase(block.user), 1u);
        vkFreeMemory(gpu().get(), block.memory, nullptr);
    }
};

// Command buffers that threads of a host record into.
struct Recorder {
    Recorder() {
        VkCommandPoolCreateInfo create{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
        create.queueFamilyIndex = gpu().queue_family();
        VkCommandPool handle = VK_NULL_HANDLE;
        check(vkCreateCommandPool(gpu().get(), &create, nullptr, &handle), "vkCreateCommandPool",
              "a thread's");
        pool = {gpu().get(), handle};
        VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
        allocate.commandPool = handle;
        allocate.commandBufferCount = 1;
        check(vkAllocateCommandBuffers(gpu().get(), &allocate, &cmd), "vkAllocateCommandBuffers",
              "a thread's");
    }
    template <class F>
    void record(F&& function) {
        check(vkResetCommandPool(gpu().get(), pool.get(), 0), "vkResetCommandPool", "a thread's");
        VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
        check(vkBeginCommandBuffer(cmd, &begin), "vkBeginCommandBuffer", "a thread's");
        function(cmd);
        check(vkEndCommandBuffer(cmd), "vkEndCommandBuffer", "a thread's");
    }
    Owned<VkCommandPool> pool;
    VkCommandBuffer cmd = VK_NULL_HANDLE;
};

}  // namespace penumbra::test
