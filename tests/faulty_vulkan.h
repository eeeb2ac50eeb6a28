// SPDX-License-Identifier: MIT
// Vulkan's functions with a count of the calls that may fail and of the objects that are alive: the call of a
// chosen number fails instead of being made. One device, one thread.
#pragma once

#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "penumbra/device.h"

namespace penumbra::test {

struct FaultyVulkan {
    static inline size_t calls = 0, fail_at = ~size_t{0};  // counted from 1
    static inline VkResult failure = VK_ERROR_OUT_OF_DEVICE_MEMORY;
    static inline std::string failed;                      // the function
    static inline std::map<std::string, long> alive;       // by the objects' kind
    static inline std::vector<VkMemoryBarrier2> barriers;  // that were recorded, in order

    static void reset() {
        calls = 0;
        fail_at = ~size_t{0};
        failed.clear();
        barriers.clear();
    }
    static long objects() {
        long sum = 0;
        for (const auto& [kind, count] : alive) sum += count;
        return sum;
    }
    static DeviceHandles handles(DeviceHandles real) {
        reset();
        alive.clear();
        real.get_instance_proc_addr = of_instance;
        return real;
    }

  private:
    template <size_t id, class F>
    struct Call;
    template <size_t id, class... Arguments>
    struct Call<id, VkResult(VKAPI_PTR*)(Arguments...)> {
        static inline VkResult(VKAPI_PTR* real)(Arguments...) = nullptr;
        static inline const char *name = nullptr, *makes = nullptr;
        static VkResult VKAPI_CALL call(Arguments... arguments) {
            if (++calls == fail_at) return failed = name, failure;
            const VkResult result = real(arguments...);
            if (makes && result == VK_SUCCESS) ++alive[makes];
            return result;
        }
    };
    template <size_t id, class Handle>
    struct Call<id, void(VKAPI_PTR*)(VkDevice, Handle, const VkAllocationCallbacks*)> {
        static inline void(VKAPI_PTR* real)(VkDevice, Handle, const VkAllocationCallbacks*) = nullptr;
        static inline const char *name = nullptr, *makes = nullptr;
        static void VKAPI_CALL call(VkDevice device, Handle handle, const VkAllocationCallbacks* callbacks) {
            if (handle) --alive[makes];
            real(device, handle, callbacks);
        }
    };

    static void VKAPI_CALL barrier(VkCommandBuffer cmd, const VkDependencyInfo* info) {
        barriers.insert(barriers.end(), info->pMemoryBarriers,
                        info->pMemoryBarriers + info->memoryBarrierCount);
        real_barrier(cmd, info);
    }
    static inline PFN_vkCmdPipelineBarrier2 real_barrier = nullptr;

    static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL of_device(VkDevice device, const char* name) {
        const PFN_vkVoidFunction real = real_of_device(device, name);
        if (!std::strcmp(name, "vkCmdPipelineBarrier2")) {
            real_barrier = reinterpret_cast<PFN_vkCmdPipelineBarrier2>(real);
            return reinterpret_cast<PFN_vkVoidFunction>(barrier);
        }
#define PENUMBRA_FAULTY(function, kind)                              \
    if (!std::strcmp(name, #function)) {                             \
        using Replaced = Call<__LINE__, PFN_##function>;             \
        Replaced::real = reinterpret_cast<PFN_##function>(real);     \
        Replaced::name = #function;                                  \
        Replaced::makes = kind;                                      \
        return reinterpret_cast<PFN_vkVoidFunction>(Replaced::call); \
    }
        PENUMBRA_FAULTY(vkAllocateDescriptorSets, nullptr)
        PENUMBRA_FAULTY(vkAllocateMemory, "memory")
        PENUMBRA_FAULTY(vkBindBufferMemory, nullptr)
        PENUMBRA_FAULTY(vkBindImageMemory, nullptr)
        PENUMBRA_FAULTY(vkCreateBuffer, "buffer")
        PENUMBRA_FAULTY(vkCreateBufferView, "buffer view")
        PENUMBRA_FAULTY(vkCreateComputePipelines, "pipeline")
        PENUMBRA_FAULTY(vkCreateDescriptorPool, "descriptor pool")
        PENUMBRA_FAULTY(vkCreateDescriptorSetLayout, "set layout")
        PENUMBRA_FAULTY(vkCreateImage, "image")
        PENUMBRA_FAULTY(vkCreateImageView, "image view")
        PENUMBRA_FAULTY(vkCreatePipelineCache, "pipeline cache")
        PENUMBRA_FAULTY(vkCreatePipelineLayout, "pipeline layout")
        PENUMBRA_FAULTY(vkCreateQueryPool, "query pool")
        PENUMBRA_FAULTY(vkCreateSampler, "sampler")
        PENUMBRA_FAULTY(vkCreateShaderModule, "shader module")
        PENUMBRA_FAULTY(vkGetPipelineCacheData, nullptr)
        PENUMBRA_FAULTY(vkGetQueryPoolResults, nullptr)
        PENUMBRA_FAULTY(vkMapMemory, nullptr)
        PENUMBRA_FAULTY(vkDestroyBuffer, "buffer")
        PENUMBRA_FAULTY(vkDestroyBufferView, "buffer view")
        PENUMBRA_FAULTY(vkDestroyDescriptorPool, "descriptor pool")
        PENUMBRA_FAULTY(vkDestroyDescriptorSetLayout, "set layout")
        PENUMBRA_FAULTY(vkDestroyImage, "image")
        PENUMBRA_FAULTY(vkDestroyImageView, "image view")
        PENUMBRA_FAULTY(vkDestroyPipeline, "pipeline")
        PENUMBRA_FAULTY(vkDestroyPipelineCache, "pipeline cache")
        PENUMBRA_FAULTY(vkDestroyPipelineLayout, "pipeline layout")
        PENUMBRA_FAULTY(vkDestroyQueryPool, "query pool")
        PENUMBRA_FAULTY(vkDestroySampler, "sampler")
        PENUMBRA_FAULTY(vkDestroyShaderModule, "shader module")
        PENUMBRA_FAULTY(vkFreeMemory, "memory")
#undef PENUMBRA_FAULTY
        return real;
    }
    static inline PFN_vkGetDeviceProcAddr real_of_device = nullptr;

    static VKAPI_ATTR PFN_vkVoidFunction VKAPI_CALL of_instance(VkInstance instance, const char* name) {
        const PFN_vkVoidFunction real = vkGetInstanceProcAddr(instance, name);
        if (std::strcmp(name, "vkGetDeviceProcAddr")) return real;
        real_of_device = reinterpret_cast<PFN_vkGetDeviceProcAddr>(real);
        return reinterpret_cast<PFN_vkVoidFunction>(of_device);
    }
};

}  // namespace penumbra::test
