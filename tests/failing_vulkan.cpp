// SPDX-License-Identifier: MIT
// Preloaded: of the program's calls of Vulkan that may fail, its host's and its graph's, the one fails that
// PENUMBRA_FAIL_VULKAN names, as vkQueueSubmit2:3 for the third, with the VkResult PENUMBRA_FAIL_VULKAN_HOW,
// and leaves garbage where its result would be. Says on the standard error stream that it did, and at the end
// how often each was called and how many objects are left alive. One thread.
#include <dlfcn.h>
#include <vulkan/vulkan.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <string>
#include <tuple>
#include <type_traits>

namespace {

struct Counts {
    std::map<std::string, long> calls;
    long alive = 0;

    ~Counts() {
        for (const auto& [function, count] : calls)
            std::fprintf(stderr, "[called %s %ld]\n", function.c_str(), count);
        std::fprintf(stderr, "[alive %ld]\n", alive);
    }
} counts;

template <class F>
F real(const char* name) {
    return reinterpret_cast<F>(dlsym(RTLD_NEXT, name));
}

bool is_next(const char* name) {
    static const char* wanted = std::getenv("PENUMBRA_FAIL_VULKAN");
    const long count = ++counts.calls[name];
    if (!wanted || name + (":" + std::to_string(count)) != wanted) return false;
    std::fprintf(stderr, "[fault in %s]\n", name);
    return true;
}

bool makes(const char* name) {
    return !std::strncmp(name, "vkCreate", 8) || !std::strcmp(name, "vkAllocateMemory");
}

// What a call that fails leaves in its result is undefined, but for pipelines, which are null.
template <class T>
void spoil(const char* name, T last) {
    if constexpr (std::is_pointer_v<std::remove_pointer_t<T>> && !std::is_const_v<std::remove_pointer_t<T>>)
        if (makes(name)) std::memset(last, std::strstr(name, "Pipelines") ? 0 : 0xa5, sizeof *last);
}

template <class F>
struct Call;
template <class... Arguments>
struct Call<VkResult(VKAPI_PTR*)(Arguments...)> {
    template <size_t i>
    using Argument = std::tuple_element_t<i, std::tuple<Arguments...>>;
    static VkResult call(VkResult(VKAPI_PTR* function)(Arguments...), const char* name,
                         Arguments... arguments) {
        if (is_next(name)) {
            // Nothing goes on running on a device whose wait has failed: it is lost.
            if (!std::strcmp(name, "vkQueueWaitIdle")) function(arguments...);
            spoil(name, std::get<sizeof...(Arguments) - 1>(std::tuple(arguments...)));
            return VkResult(std::atoi(std::getenv("PENUMBRA_FAIL_VULKAN_HOW")));
        }
        const VkResult result = function(arguments...);
        if (makes(name) && result == VK_SUCCESS) ++counts.alive;
        return result;
    }
};

}  // namespace

// The functions that the program is linked to, by the number of their arguments.
#define TYPE(f, i) Call<PFN_##f>::Argument<i>
#define REAL(f) real<PFN_##f>(#f), #f
#define FAILS_1(f)                              \
    VkResult f(TYPE(f, 0) a) {                  \
        return Call<PFN_##f>::call(REAL(f), a); \
    }
#define FAILS_2(f)                                 \
    VkResult f(TYPE(f, 0) a, TYPE(f, 1) b) {       \
        return Call<PFN_##f>::call(REAL(f), a, b); \
    }
#define FAILS_3(f)                                         \
    VkResult f(TYPE(f, 0) a, TYPE(f, 1) b, TYPE(f, 2) c) { \
        return Call<PFN_##f>::call(REAL(f), a, b, c);      \
    }
#define FAILS_4(f)                                                       \
    VkResult f(TYPE(f, 0) a, TYPE(f, 1) b, TYPE(f, 2) c, TYPE(f, 3) d) { \
        return Call<PFN_##f>::call(REAL(f), a, b, c, d);                 \
    }
#define FAILS_6(f)                                                                                   \
    VkResult f(TYPE(f, 0) a, TYPE(f, 1) b, TYPE(f, 2) c, TYPE(f, 3) d, TYPE(f, 4) e, TYPE(f, 5) g) { \
        return Call<PFN_##f>::call(REAL(f), a, b, c, d, e, g);                                       \
    }
#define FAILS_8(f)                                                                                 \
    VkResult f(TYPE(f, 0) a, TYPE(f, 1) b, TYPE(f, 2) c, TYPE(f, 3) d, TYPE(f, 4) e, TYPE(f, 5) g, \
               TYPE(f, 6) h, TYPE(f, 7) i) {                                                       \
        return Call<PFN_##f>::call(REAL(f), a, b, c, d, e, g, h, i);                               \
    }
#define ALL_THAT_FAIL(X1, X2, X3, X4, X6, X8) \
    X1(vkEndCommandBuffer)                    \
    X1(vkQueueWaitIdle)                       \
    X2(vkBeginCommandBuffer)                  \
    X3(vkAllocateCommandBuffers)              \
    X3(vkAllocateDescriptorSets)              \
    X3(vkCreateInstance)                      \
    X3(vkEnumeratePhysicalDevices)            \
    X3(vkResetCommandPool)                    \
    X4(vkAllocateMemory)                      \
    X4(vkBindBufferMemory)                    \
    X4(vkBindImageMemory)                     \
    X4(vkCreateBuffer)                        \
    X4(vkCreateBufferView)                    \
    X4(vkCreateCommandPool)                   \
    X4(vkCreateDescriptorPool)                \
    X4(vkCreateDescriptorSetLayout)           \
    X4(vkCreateDevice)                        \
    X4(vkCreateImage)                         \
    X4(vkCreateImageView)                     \
    X4(vkCreatePipelineCache)                 \
    X4(vkCreatePipelineLayout)                \
    X4(vkCreateQueryPool)                     \
    X4(vkCreateSampler)                       \
    X4(vkCreateShaderModule)                  \
    X4(vkEnumerateDeviceExtensionProperties)  \
    X4(vkQueueSubmit2)                        \
    X6(vkCreateComputePipelines)              \
    X6(vkCreateGraphicsPipelines)             \
    X6(vkMapMemory)                           \
    X8(vkGetQueryPoolResults)
#define ALL_THAT_DESTROY(X) \
    X(Buffer)               \
    X(BufferView)           \
    X(CommandPool)          \
    X(DescriptorPool)       \
    X(DescriptorSetLayout)  \
    X(Image)                \
    X(ImageView)            \
    X(Pipeline)             \
    X(PipelineCache)        \
    X(PipelineLayout)       \
    X(QueryPool)            \
    X(Sampler)              \
    X(ShaderModule)

extern "C" {

ALL_THAT_FAIL(FAILS_1, FAILS_2, FAILS_3, FAILS_4, FAILS_6, FAILS_8)

#define DESTROYS(Kind)                                                                               \
    void vkDestroy##Kind(VkDevice device, Vk##Kind object, const VkAllocationCallbacks* callbacks) { \
        if (object) --counts.alive;                                                                  \
        real<PFN_vkDestroy##Kind>("vkDestroy" #Kind)(device, object, callbacks);                     \
    }
ALL_THAT_DESTROY(DESTROYS)
void vkFreeMemory(VkDevice device, VkDeviceMemory memory, const VkAllocationCallbacks* callbacks) {
    if (memory) --counts.alive;
    real<PFN_vkFreeMemory>("vkFreeMemory")(device, memory, callbacks);
}
void vkDestroyInstance(VkInstance instance, const VkAllocationCallbacks* callbacks) {
    if (instance) --counts.alive;
    real<PFN_vkDestroyInstance>("vkDestroyInstance")(instance, callbacks);
}
void vkDestroyDevice(VkDevice device, const VkAllocationCallbacks* callbacks) {
    if (device) --counts.alive;
    real<PFN_vkDestroyDevice>("vkDestroyDevice")(device, callbacks);
}

// The graph asks for its functions by name.
PFN_vkVoidFunction vkGetDeviceProcAddr(VkDevice device, const char* name) {
#define OURS(f) \
    if (!std::strcmp(name, #f)) return reinterpret_cast<PFN_vkVoidFunction>(&f);
#define OUR_DESTROYER(Kind) OURS(vkDestroy##Kind)
    ALL_THAT_FAIL(OURS, OURS, OURS, OURS, OURS, OURS)
    ALL_THAT_DESTROY(OUR_DESTROYER)
    OURS(vkFreeMemory)
    return real<PFN_vkGetDeviceProcAddr>("vkGetDeviceProcAddr")(device, name);
}
PFN_vkVoidFunction vkGetInstanceProcAddr(VkInstance instance, const char* name) {
    OURS(vkGetDeviceProcAddr)
    return real<PFN_vkGetInstanceProcAddr>("vkGetInstanceProcAddr")(instance, name);
}

}  // extern "C"
