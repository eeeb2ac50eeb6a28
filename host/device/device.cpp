// SPDX-License-Identifier: MIT
// Instance, choice of device, features, queue, and the messenger that collects what the validation layer
// says.
#include "host/device/device.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstring>
#include <mutex>
#include <optional>

namespace penumbra {

namespace {

constexpr const char* validation_layer = "VK_LAYER_KHRONOS_validation";

// The feature structs that are asked for and enabled, chained. Copying would leave the chain dangling.
struct Features {
    VkPhysicalDeviceFeatures2 core{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
    VkPhysicalDeviceVulkan11Features v11{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES};
    VkPhysicalDeviceVulkan12Features v12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
    VkPhysicalDeviceVulkan13Features v13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    VkPhysicalDeviceAccelerationStructureFeaturesKHR acceleration{
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR};
    VkPhysicalDeviceRayQueryFeaturesKHR ray_query{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR};

    explicit Features(bool with_ray_query) {
        core.pNext = &v11;
        v11.pNext = &v12;
        v12.pNext = &v13;
        if (with_ray_query) {
            v13.pNext = &acceleration;
            acceleration.pNext = &ray_query;
        }
    }
    Features(const Features&) = delete;
    Features& operator=(const Features&) = delete;
};

bool has_extensions(VkPhysicalDevice physical, std::span<const char* const> names) {
    uint32_t count = 0;
    check(vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, nullptr),
          "vkEnumerateDeviceExtensionProperties", "count");
    std::vector<VkExtensionProperties> list(count);
    check(vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, list.data()),
          "vkEnumerateDeviceExtensionProperties", "list");
    return std::ranges::all_of(names, [&](const char* name) {
        return std::ranges::any_of(list, [&](const auto& e) { return !std::strcmp(e.extensionName, name); });
    });
}

constexpr const char* ray_query_extensions[] = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                                VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                                VK_KHR_RAY_QUERY_EXTENSION_NAME};

constexpr const char* statistics_extension = VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME;

// A family that does graphics, compute and transfers; every desktop device and lavapipe has one.
std::optional<uint32_t> find_queue_family(VkPhysicalDevice physical, bool* timestamps = nullptr) {
    uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
    for (uint32_t i = 0; i < count; ++i) {
        constexpr VkQueueFlags wanted = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
        if ((families[i].queueFlags & wanted) != wanted) continue;
        if (timestamps) *timestamps = families[i].timestampValidBits > 0;
        return i;
    }
    return std::nullopt;
}

std::string missing_parts(VkPhysicalDevice physical, uint32_t api_version,
                          const std::string& subgroup_missing) {
    if (api_version < VK_API_VERSION_1_3) return "Vulkan 1.3";
    Features f(false);
    vkGetPhysicalDeviceFeatures2(physical, &f.core);
    std::string missing = subgroup_missing;
    const auto need = [&](VkBool32 present, const char* name) {
        if (!present) missing += (missing.empty() ? "" : ", ") + std::string(name);
    };
    need(f.core.features.shaderStorageImageExtendedFormats, "shaderStorageImageExtendedFormats");
    need(f.v13.synchronization2, "synchronization2");
    need(f.v13.maintenance4, "maintenance4");
    need(f.v13.dynamicRendering, "dynamicRendering");
    need(find_queue_family(physical).has_value(), "a queue with graphics and compute");
    return missing;
}

DeviceInfo describe(VkPhysicalDevice physical) {
    VkPhysicalDeviceSubgroupProperties subgroup{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
    VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES, &subgroup};
    VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &driver};
    VkPhysicalDeviceProperties plain{};
    vkGetPhysicalDeviceProperties(physical, &plain);
    // The chained structs belong to 1.2; an older device may not know them.
    if (plain.apiVersion >= VK_API_VERSION_1_2) vkGetPhysicalDeviceProperties2(physical, &properties);

    constexpr VkSubgroupFeatureFlags wanted =
        VK_SUBGROUP_FEATURE_BASIC_BIT | VK_SUBGROUP_FEATURE_ARITHMETIC_BIT | VK_SUBGROUP_FEATURE_BALLOT_BIT;
    const bool subgroup_fits = (subgroup.supportedOperations & wanted) == wanted &&
                               (subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT);
    return {.name = plain.deviceName,
            .driver = fmt::format("{} {}", driver.driverName, driver.driverInfo),
            .is_cpu = plain.deviceType == VK_PHYSICAL_DEVICE_TYPE_CPU,
            .api_version = plain.apiVersion,
            .subgroup_size = subgroup.subgroupSize,
            .missing = missing_parts(physical, plain.apiVersion,
                                     subgroup_fits ? "" : "subgroup arithmetic and ballot in compute")};
}

std::vector<VkPhysicalDevice> physical_devices(VkInstance instance) {
    uint32_t count = 0;
    check(vkEnumeratePhysicalDevices(instance, &count, nullptr), "vkEnumeratePhysicalDevices", "count");
    std::vector<VkPhysicalDevice> list(count);
    check(vkEnumeratePhysicalDevices(instance, &count, list.data()), "vkEnumeratePhysicalDevices", "list");
    return list;
}

VkApplicationInfo application_info() {
    VkApplicationInfo info{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    info.pApplicationName = "penumbra";
    info.apiVersion = VK_API_VERSION_1_3;
    return info;
}

bool has_layer(const char* name) {
    uint32_t count = 0;
    check(vkEnumerateInstanceLayerProperties(&count, nullptr), "vkEnumerateInstanceLayerProperties", "count");
    std::vector<VkLayerProperties> layers(count);
    check(vkEnumerateInstanceLayerProperties(&count, layers.data()), "vkEnumerateInstanceLayerProperties",
          "list");
    return std::ranges::any_of(layers, [&](const auto& l) { return !std::strcmp(l.layerName, name); });
}

bool contains_ignoring_case(std::string_view text, std::string_view part) {
    const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
    const auto found = std::search(text.begin(), text.end(), part.begin(), part.end(),
                                   [&](char a, char b) { return lower(a) == lower(b); });
    return found != text.end() || part.empty();
}

template <class Function>
Function instance_function(VkInstance instance, const char* name) {
    return reinterpret_cast<Function>(vkGetInstanceProcAddr(instance, name));
}

}  // namespace

struct Device::Messages {
    std::mutex mutex;
    std::vector<std::string> list;

    static VKAPI_ATTR VkBool32 VKAPI_CALL receive(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                                  VkDebugUtilsMessageTypeFlagsEXT,
                                                  const VkDebugUtilsMessengerCallbackDataEXT* data,
                                                  void* user) {
        auto* self = static_cast<Messages*>(user);
        const std::lock_guard lock(self->mutex);
        self->list.emplace_back(data->pMessage);
        return VK_FALSE;
    }
};

std::vector<DeviceInfo> list_devices() {
    const VkApplicationInfo app = application_info();
    VkInstanceCreateInfo create{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    create.pApplicationInfo = &app;
    VkInstance instance = VK_NULL_HANDLE;
    check(vkCreateInstance(&create, nullptr, &instance), "vkCreateInstance", "list of devices");
    const std::unique_ptr<VkInstance_T, void (*)(VkInstance)> owner(
        instance, [](VkInstance i) { vkDestroyInstance(i, nullptr); });
    std::vector<DeviceInfo> list;
    for (VkPhysicalDevice physical : physical_devices(instance)) list.push_back(describe(physical));
    return list;
}

Device::Device(const DeviceOptions& options) : messages_(std::make_unique<Messages>()) {
    try {
        create_instance(options);
        pick_physical_device(options.name);
        create_device(options);
    } catch (...) {
        destroy();
        throw;
    }
}

Device::~Device() {
    destroy();
}

void Device::destroy() {
    pool_ = {};
    if (device_) vkDestroyDevice(device_, nullptr);
    if (messenger_) {
        instance_function<PFN_vkDestroyDebugUtilsMessengerEXT>(instance_, "vkDestroyDebugUtilsMessengerEXT")(
            instance_, messenger_, nullptr);
    }
    if (instance_) vkDestroyInstance(instance_, nullptr);
}

void Device::create_instance(const DeviceOptions& options) {
    const VkApplicationInfo app = application_info();
    VkDebugUtilsMessengerCreateInfoEXT messenger{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    messenger.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    messenger.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    messenger.pfnUserCallback = Messages::receive;
    messenger.pUserData = messages_.get();
    const VkValidationFeatureEnableEXT enabled[] = {
        VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, &messenger};
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = enabled;
    std::vector<const char*> extensions;
    for (const std::string& name : options.surface_extensions) extensions.push_back(name.c_str());

    VkInstanceCreateInfo create{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    create.pApplicationInfo = &app;
    if (options.validation) {
        if (!has_layer(validation_layer)) {
            throw DeviceError(
                fmt::format("validation was asked for, but the layer {} is not installed", validation_layer));
        }
        create.pNext = &features;
        create.enabledLayerCount = 1;
        create.ppEnabledLayerNames = &validation_layer;
        extensions.push_back(VK_EXT_DEBUG_UTILS_EXTENSION_NAME);
        extensions.push_back(VK_EXT_VALIDATION_FEATURES_EXTENSION_NAME);
    }
    create.enabledExtensionCount = static_cast<uint32_t>(extensions.size());
    create.ppEnabledExtensionNames = extensions.data();
    // What a call that fails leaves in its result is undefined; destroy() must not see it.
    VkInstance instance = VK_NULL_HANDLE;
    check(vkCreateInstance(&create, nullptr, &instance), "vkCreateInstance", "standalone host");
    instance_ = instance;
    if (options.validation) {
        const auto make = instance_function<PFN_vkCreateDebugUtilsMessengerEXT>(
            instance_, "vkCreateDebugUtilsMessengerEXT");
        VkDebugUtilsMessengerEXT made = VK_NULL_HANDLE;
        check(make(instance_, &messenger, nullptr, &made), "vkCreateDebugUtilsMessengerEXT", "messenger");
        messenger_ = made;
    }
}

void Device::pick_physical_device(const std::string& wish) {
    std::string seen;
    for (VkPhysicalDevice physical : physical_devices(instance_)) {
        DeviceInfo info = describe(physical);
        seen += fmt::format("\n  {} ({}){}", info.name, info.driver,
                            info.missing.empty() ? "" : ": lacks " + info.missing);
        if (physical_ || !info.missing.empty() || !contains_ignoring_case(info.name, wish)) continue;
        physical_ = physical;
        info_ = std::move(info);
    }
    if (physical_) return;
    if (seen.empty()) throw DeviceError("no Vulkan device on this machine");
    if (wish.empty()) throw DeviceError("no usable Vulkan device among:" + seen);
    throw NoSuchDevice(fmt::format("no usable Vulkan device is named \"{}\" among:{}", wish, seen));
}

void Device::create_device(const DeviceOptions& options) {
    bool timestamps = false;
    queue_family_ = *find_queue_family(physical_, &timestamps);
    VkPhysicalDeviceMaintenance3Properties allocation{
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_3_PROPERTIES};
    VkPhysicalDeviceMaintenance4Properties buffer{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_MAINTENANCE_4_PROPERTIES,
                                                  &allocation};
    VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &buffer};
    vkGetPhysicalDeviceProperties2(physical_, &properties);
    limits_ = properties.properties.limits;
    largest_buffer_ = std::min(buffer.maxBufferSize, allocation.maxMemoryAllocationSize);
    vkGetPhysicalDeviceMemoryProperties(physical_, &memory_);

    const bool may_query_rays = has_extensions(physical_, ray_query_extensions);
    Features has(may_query_rays);
    vkGetPhysicalDeviceFeatures2(physical_, &has.core);
    caps_ = {.ray_query = may_query_rays && has.acceleration.accelerationStructure &&
                          has.ray_query.rayQuery && has.v12.bufferDeviceAddress,
             .storage8 = has.v12.storageBuffer8BitAccess && has.v12.shaderInt8,
             .depth_clamp = has.core.features.depthClamp == VK_TRUE,
             .timestamps = timestamps};

    Features use(caps_.ray_query);
    use.core.features.shaderStorageImageExtendedFormats = VK_TRUE;
    use.core.features.depthClamp = has.core.features.depthClamp;
    // What a user's shaders may declare (graph/requirements.cpp).
    for (const auto feature :
         {&VkPhysicalDeviceFeatures::shaderFloat64, &VkPhysicalDeviceFeatures::shaderInt64,
          &VkPhysicalDeviceFeatures::shaderInt16, &VkPhysicalDeviceFeatures::shaderImageGatherExtended,
          &VkPhysicalDeviceFeatures::shaderStorageImageReadWithoutFormat,
          &VkPhysicalDeviceFeatures::shaderStorageImageWriteWithoutFormat})
        use.core.features.*feature = has.core.features.*feature;
    for (const auto feature : {&VkPhysicalDeviceVulkan11Features::storageBuffer16BitAccess,
                               &VkPhysicalDeviceVulkan11Features::uniformAndStorageBuffer16BitAccess})
        use.v11.*feature = has.v11.*feature;
    for (const auto feature :
         {&VkPhysicalDeviceVulkan12Features::storageBuffer8BitAccess,
          &VkPhysicalDeviceVulkan12Features::uniformAndStorageBuffer8BitAccess,
          &VkPhysicalDeviceVulkan12Features::shaderInt8, &VkPhysicalDeviceVulkan12Features::shaderFloat16,
          &VkPhysicalDeviceVulkan12Features::shaderBufferInt64Atomics,
          &VkPhysicalDeviceVulkan12Features::vulkanMemoryModel,
          &VkPhysicalDeviceVulkan12Features::vulkanMemoryModelDeviceScope})
        use.v12.*feature = has.v12.*feature;
    use.v13.shaderIntegerDotProduct = has.v13.shaderIntegerDotProduct;
    use.v12.bufferDeviceAddress = caps_.ray_query;
    use.v13.synchronization2 = VK_TRUE;
    use.v13.maintenance4 = VK_TRUE;
    use.v13.dynamicRendering = VK_TRUE;
    use.acceleration.accelerationStructure = caps_.ray_query;
    use.ray_query.rayQuery = caps_.ray_query;
    if (caps_.ray_query) extensions_.assign(std::begin(ray_query_extensions), std::end(ray_query_extensions));
    VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR executables{
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR, nullptr, VK_TRUE};
    if (options.statistics) {
        if (!has_extensions(physical_, {&statistics_extension, 1}))
            throw DeviceError(fmt::format("{} ({}) tells no statistics of pipelines: it lacks {}", info_.name,
                                          info_.driver, statistics_extension));
        extensions_.push_back(statistics_extension);
        (caps_.ray_query ? use.ray_query.pNext : use.v13.pNext) = &executables;
    }

    if (!options.surface_extensions.empty()) {
        const char* swapchain = VK_KHR_SWAPCHAIN_EXTENSION_NAME;
        if (!has_extensions(physical_, {&swapchain, 1}))
            throw DeviceError(fmt::format("{} ({}) shows nothing in a window: it lacks {}", info_.name,
                                          info_.driver, swapchain));
        extensions_.push_back(swapchain);
    }

    const float priority = 1;
    VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queue.queueFamilyIndex = queue_family_;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    VkDeviceCreateInfo create{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &use.core};
    create.queueCreateInfoCount = 1;
    create.pQueueCreateInfos = &queue;
    create.enabledExtensionCount = static_cast<uint32_t>(extensions_.size());
    create.ppEnabledExtensionNames = extensions_.data();
    VkDevice device = VK_NULL_HANDLE;
    check(vkCreateDevice(physical_, &create, nullptr, &device), "vkCreateDevice", info_.name);
    device_ = device;
    vkGetDeviceQueue(device_, queue_family_, 0, &queue_);

    VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
    pool.queueFamilyIndex = queue_family_;
    VkCommandPool handle = VK_NULL_HANDLE;
    check(vkCreateCommandPool(device_, &pool, nullptr, &handle), "vkCreateCommandPool", "one-off commands");
    pool_ = {device_, handle};
    VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    allocate.commandPool = pool_.get();
    allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    allocate.commandBufferCount = 1;
    check(vkAllocateCommandBuffers(device_, &allocate, &commands_), "vkAllocateCommandBuffers",
          "one-off commands");
}

void Device::run(const std::function<void(VkCommandBuffer)>& commands) {
    // Also ends a recording that an exception left half done.
    check(vkResetCommandPool(device_, pool_.get(), 0), "vkResetCommandPool", "one-off commands");
    VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vkBeginCommandBuffer(commands_, &begin), "vkBeginCommandBuffer", "one-off commands");
    commands(commands_);
    check(vkEndCommandBuffer(commands_), "vkEndCommandBuffer", "one-off commands");
    VkCommandBufferSubmitInfo submitted{VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO};
    submitted.commandBuffer = commands_;
    VkSubmitInfo2 submit{VK_STRUCTURE_TYPE_SUBMIT_INFO_2};
    submit.commandBufferInfoCount = 1;
    submit.pCommandBufferInfos = &submitted;
    check(vkQueueSubmit2(queue_, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit2", "one-off commands");
    check(vkQueueWaitIdle(queue_), "vkQueueWaitIdle", "one-off commands");
}

std::vector<std::string> Device::messages() const {
    const std::lock_guard lock(messages_->mutex);
    return messages_->list;
}

size_t Device::message_count() const {
    const std::lock_guard lock(messages_->mutex);
    return messages_->list.size();
}

}  // namespace penumbra
