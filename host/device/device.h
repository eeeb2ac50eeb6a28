// SPDX-License-Identifier: MIT
// A headless Vulkan 1.3 device with one queue: what the standalone host runs on. Every feature that the node
// set may use is turned on where the device has it; what is required and missing is an error that names it.
#pragma once

#include <vulkan/vulkan_core.h>

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "host/device/vulkan.h"

namespace penumbra {

// The user's wish cannot be met: no such device, a missing layer or feature. The text is meant for the user.
class DeviceError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

// No device of the name that was asked for.
class NoSuchDevice : public DeviceError {
  public:
    using DeviceError::DeviceError;
};

struct DeviceInfo {
    std::string name;    // "llvmpipe (LLVM 15.0.6, 256 bits)"
    std::string driver;  // "llvmpipe Mesa 25.0.7"
    bool is_cpu = false;
    uint32_t api_version = 0;
    uint32_t subgroup_size = 0;
    std::string missing;  // what this device lacks to run penumbra; empty: usable
};

struct DeviceOptions {
    std::string name;         // substring of the device's name, any case; empty: the first usable one
    bool validation = false;  // the Khronos validation layer with synchronisation checks
    // Of the instance, as a window system's library names those that it needs for surfaces. With any, the
    // device brings VK_KHR_swapchain; an error where it cannot.
    std::vector<std::string> surface_extensions;
    bool statistics = false;  // have the driver say what it made of pipelines; an error where it cannot
};

// What the device has beyond the required features.
struct DeviceCaps {
    bool ray_query = false;
    bool storage8 = false;
    bool depth_clamp = false;
    bool timestamps = false;
};

// All devices of the machine, usable or not, in the loader's order.
std::vector<DeviceInfo> list_devices();

class Device {
  public:
    // Throws DeviceError where the wish cannot be met, NoSuchDevice where that is its name, VulkanError where
    // a call fails.
    explicit Device(const DeviceOptions& options);
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    VkInstance instance() const { return instance_; }
    VkPhysicalDevice physical() const { return physical_; }
    VkDevice get() const { return device_; }
    VkQueue queue() const { return queue_; }
    uint32_t queue_family() const { return queue_family_; }
    const DeviceInfo& info() const { return info_; }
    const DeviceCaps& caps() const { return caps_; }
    const VkPhysicalDeviceLimits& limits() const { return limits_; }
    VkDeviceSize largest_buffer() const { return largest_buffer_; }  // bytes
    const VkPhysicalDeviceMemoryProperties& memory() const { return memory_; }
    bool names_objects() const { return messenger_ != VK_NULL_HANDLE; }      // VK_EXT_debug_utils is enabled
    std::span<const char* const> extensions() const { return extensions_; }  // enabled on the device

    // Records `commands` into a command buffer, submits it and waits for the queue; not from within
    // `commands`. One buffer serves all calls: validation layers hold on to a submitted buffer on a thread of
    // their own for a while after the queue is idle, and freeing one per call then races with it.
    void run(const std::function<void(VkCommandBuffer)>& commands);

    // Warnings and errors of the validation layer so far (copies: the layer may report from any thread).
    std::vector<std::string> messages() const;
    size_t message_count() const;

  private:
    struct Messages;
    void create_instance(const DeviceOptions& options);
    void pick_physical_device(const std::string& wish);
    void create_device(const DeviceOptions& options);
    void destroy();

    std::unique_ptr<Messages> messages_;
    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    uint32_t queue_family_ = 0;
    DeviceInfo info_;
    DeviceCaps caps_;
    VkPhysicalDeviceLimits limits_{};
    VkDeviceSize largest_buffer_ = 0;
    VkPhysicalDeviceMemoryProperties memory_{};
    std::vector<const char*> extensions_;
    Owned<VkCommandPool> pool_;
    VkCommandBuffer commands_ = VK_NULL_HANDLE;  // the pool's only one
};

}  // namespace penumbra
