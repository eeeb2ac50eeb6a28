// SPDX-License-Identifier: MIT
// The engine's device: one, with a queue, and validation that is listened to.
#pragma once

#include <penumbra/error.h>
#include <vulkan/vulkan.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

namespace engine {

namespace fs = std::filesystem;
namespace pen = penumbra;

inline void must(VkResult result, const char* what) {
    if (result == VK_SUCCESS) return;
    std::fprintf(stderr, "%s: %s\n", what, pen::result_name(result).c_str());
    std::exit(1);
}

inline std::vector<char> read(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) std::fprintf(stderr, "cannot read %s\n", file.c_str()), std::exit(1);
    return {std::istreambuf_iterator<char>(in), {}};
}

inline VkInstance instance;
inline VkDebugUtilsMessengerEXT messenger;
inline VkPhysicalDevice physical;
inline VkDevice device;
inline VkQueue queue;
inline uint32_t family = 0, messages = 0;

inline VKAPI_ATTR VkBool32 VKAPI_CALL complain(VkDebugUtilsMessageSeverityFlagBitsEXT,
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

inline void open_device() {
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

// The exit code: 1 where validation has had something to say.
inline int close_device() {
    vkDestroyDevice(device, nullptr);
    function<PFN_vkDestroyDebugUtilsMessengerEXT>("vkDestroyDebugUtilsMessengerEXT")(instance, messenger,
                                                                                     nullptr);
    vkDestroyInstance(instance, nullptr);
    return messages ? 1 : 0;
}

}  // namespace engine
