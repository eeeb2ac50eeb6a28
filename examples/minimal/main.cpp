// SPDX-License-Identifier: MIT
// The smallest host: raw Vulkan, one queue, a frame at a time. What an engine renders is read from files here
// (FOLDER/FRAME/SLOT.bin); each step says where it goes in yours.
//     minimal PIPELINE.json WIDTH HEIGHT FRAMES FOLDER
#include <penumbra/graph.h>
#include <penumbra/shadow_nodes.h>
#include <vulkan/vulkan.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace fs = std::filesystem;
namespace pen = penumbra;

static void must(VkResult result, const char* what) {
    if (result == VK_SUCCESS) return;
    std::fprintf(stderr, "%s: %s\n", what, pen::result_name(result).c_str());
    std::exit(1);
}

static std::vector<char> read(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    if (!in) std::fprintf(stderr, "cannot read %s\n", file.c_str()), std::exit(1);
    return {std::istreambuf_iterator<char>(in), {}};
}

// --- The engine's device: yours exists already. -----------------------------------------------------------
static VkInstance instance;
static VkPhysicalDevice physical;
static VkDevice device;
static VkQueue queue;
static uint32_t family, messages;
static VkDebugUtilsMessengerEXT messenger;

static VKAPI_ATTR VkBool32 VKAPI_CALL complain(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                               VkDebugUtilsMessageTypeFlagsEXT,
                                               const VkDebugUtilsMessengerCallbackDataEXT* data, void*) {
    std::fprintf(stderr, "%s\n", data->pMessage);
    ++messages;
    return VK_FALSE;
}

static void open_device() {
    VkDebugUtilsMessengerCreateInfoEXT debug{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    debug.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    debug.messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT;
    debug.pfnUserCallback = complain;
    const VkValidationFeatureEnableEXT sync = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    const VkValidationFeaturesEXT checks{
        VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, nullptr, 1, &sync, 0, nullptr};
    VkApplicationInfo app{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    app.apiVersion = VK_API_VERSION_1_3;
    const char *layer = "VK_LAYER_KHRONOS_validation", *extension = "VK_EXT_debug_utils";
    const VkInstanceCreateInfo create{
        VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, &checks, 0, &app, 1, &layer, 1, &extension};
    must(vkCreateInstance(&create, nullptr, &instance), "vkCreateInstance");
    const auto listen = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance, "vkCreateDebugUtilsMessengerEXT"));
    must(listen(instance, &debug, nullptr, &messenger), "vkCreateDebugUtilsMessengerEXT");
    uint32_t one = 1;
    vkEnumeratePhysicalDevices(instance, &one, &physical);
}

// What a plan needs, asked before the device is made. An engine enables these beside its own.
static void make_device(const pen::Plan& plan) {
    VkPhysicalDeviceVulkan13Features v13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    VkPhysicalDeviceVulkan12Features v12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES, &v13};
    VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &v12};
    for (const pen::Requirement& need : pen::requirements(plan))
        if (need.kind == pen::Requirement::Kind::feature && !pen::enable(need, features))
            std::fprintf(stderr, "%s needs %s\n", need.why.c_str(), need.name.c_str()), std::exit(1);
    const float priority = 1;
    const VkDeviceQueueCreateInfo queues{
        VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, family, 1, &priority};
    VkDeviceCreateInfo create{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features};
    create.queueCreateInfoCount = 1;
    create.pQueueCreateInfos = &queues;
    must(vkCreateDevice(physical, &create, nullptr, &device), "vkCreateDevice");
    vkGetDeviceQueue(device, family, 0, &queue);
}

// --- The engine's G-buffer and buffers: here as files have them. -----------------------------------------
struct Resource {
    VkBuffer buffer = VK_NULL_HANDLE;
    VkImage image = VK_NULL_HANDLE;
    VkImageView view = VK_NULL_HANDLE;
    VkBufferView texels = VK_NULL_HANDLE;
    VkDeviceMemory memory[2] = {};
};

static VkDeviceMemory allocate(const VkMemoryRequirements& need, VkMemoryPropertyFlags wanted) {
    VkPhysicalDeviceMemoryProperties types;
    vkGetPhysicalDeviceMemoryProperties(physical, &types);
    VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, need.size, 0};
    while (!(need.memoryTypeBits >> info.memoryTypeIndex & 1) ||
           (types.memoryTypes[info.memoryTypeIndex].propertyFlags & wanted) != wanted)
        ++info.memoryTypeIndex;
    VkDeviceMemory memory;
    must(vkAllocateMemory(device, &info, nullptr, &memory), "vkAllocateMemory");
    return memory;
}

static Resource load(const pen::HostSlot& slot, const std::vector<char>& bytes, VkCommandBuffer cmd) {
    Resource r;
    VkBufferCreateInfo buffer{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    buffer.size = bytes.size();
    buffer.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT |
                   VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT |
                   VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT;
    must(vkCreateBuffer(device, &buffer, nullptr, &r.buffer), "vkCreateBuffer");
    VkMemoryRequirements need;
    vkGetBufferMemoryRequirements(device, r.buffer, &need);
    r.memory[0] = allocate(need, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    vkBindBufferMemory(device, r.buffer, r.memory[0], 0);
    void* mapped;
    must(vkMapMemory(device, r.memory[0], 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
    std::memcpy(mapped, bytes.data(), bytes.size());
    const VkFormat format = pen::info(slot.format).vk;
    if (slot.kind == pen::PortKind::texels) {
        const VkBufferViewCreateInfo view{
            VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO, nullptr, 0, r.buffer, format, 0, VK_WHOLE_SIZE};
        must(vkCreateBufferView(device, &view, nullptr, &r.texels), "vkCreateBufferView");
    }
    if (slot.kind != pen::PortKind::image) return r;
    const VkImageAspectFlags aspect =
        format == VK_FORMAT_D32_SFLOAT ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
    VkImageCreateInfo image{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO, nullptr, 0, VK_IMAGE_TYPE_2D, format};
    image.extent = {slot.extent.width, slot.extent.height, 1};
    image.mipLevels = 1;
    image.arrayLayers = slot.layers;
    image.samples = VK_SAMPLE_COUNT_1_BIT;
    image.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    must(vkCreateImage(device, &image, nullptr, &r.image), "vkCreateImage");
    vkGetImageMemoryRequirements(device, r.image, &need);
    r.memory[1] = allocate(need, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    vkBindImageMemory(device, r.image, r.memory[1], 0);
    const VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                     nullptr,
                                     0,
                                     r.image,
                                     slot.layered ? VK_IMAGE_VIEW_TYPE_2D_ARRAY : VK_IMAGE_VIEW_TYPE_2D,
                                     format,
                                     {},
                                     {aspect, 0, 1, 0, slot.layers}};
    must(vkCreateImageView(device, &view, nullptr, &r.view), "vkCreateImageView");
    VkImageMemoryBarrier2 fresh{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2};
    fresh.dstStageMask = VK_PIPELINE_STAGE_2_COPY_BIT;
    fresh.dstAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT;
    fresh.newLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL;
    fresh.image = r.image;
    fresh.subresourceRange = view.subresourceRange;
    VkDependencyInfo dependency{VK_STRUCTURE_TYPE_DEPENDENCY_INFO};
    dependency.imageMemoryBarrierCount = 1;
    dependency.pImageMemoryBarriers = &fresh;
    vkCmdPipelineBarrier2(cmd, &dependency);
    const VkBufferImageCopy copy{0, 0, 0, {aspect, 0, 0, slot.layers}, {}, image.extent};
    vkCmdCopyBufferToImage(cmd, r.buffer, r.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
    return r;
}

static void release(const Resource& r) {
    vkDestroyBufferView(device, r.texels, nullptr);
    vkDestroyImageView(device, r.view, nullptr);
    vkDestroyImage(device, r.image, nullptr);
    vkDestroyBuffer(device, r.buffer, nullptr);
    for (VkDeviceMemory memory : r.memory) vkFreeMemory(device, memory, nullptr);
}

// --- Penumbra. --------------------------------------------------------------------------------------------
static pen::Plan compile(const char* file, pen::Extent extent, const pen::DeviceTable& table) {
    pen::Diagnostics errors;
    const auto pipeline = pen::load_pipeline(file, {}, errors);
    const auto checked = pipeline ? pen::check(*pipeline, pen::shadow_nodes(), errors) : std::nullopt;
    pen::CompileOptions options;
    if (checked) options.captures = checked->output_names();  // to write them to files
    // This G-buffer's formats; what is not named is as the pipeline has it. Nothing here has holes in it.
    pen::Target target{
        .extent = extent, .facts = {{"alpha", false}, {"translucent", false}}, .device = table};
    if (checked)
        for (const pen::HostInput& input : checked->inputs) {
            if (input.name == "normal") target.inputs["normal"] = {pen::Format::rgba32f, extent};
            if (input.name == "moved_boxes")
                target.left_out.insert(input.name);  // its camera hardly ever stands
        }
    auto plan = checked ? pen::compile(*checked, target, options, errors) : std::nullopt;
    if (!plan) std::fputs(errors.text().c_str(), stderr), std::exit(2);
    return std::move(*plan);
}

int main(int argc, char** argv) {
    if (argc != 6) return std::fputs("usage: minimal PIPELINE.json WIDTH HEIGHT FRAMES FOLDER\n", stderr), 2;
    const pen::Extent extent{static_cast<uint32_t>(std::atoi(argv[2])),
                             static_cast<uint32_t>(std::atoi(argv[3]))};
    open_device();
    make_device(compile(argv[1], extent, pen::reference_device()));
    const pen::DeviceHandles handles{instance, physical, device, family, vkGetInstanceProcAddr, {}, true};

    // Once, or when what the plan was made for changes: 1. a plan for this device, 2. its shaders, 3. a view
    // for each camera.
    auto plan = std::make_shared<const pen::Plan>(compile(argv[1], extent, pen::device_table(handles)));
    auto program = std::make_shared<const pen::Program>(handles, plan);
    auto view = std::make_unique<pen::View>(program, pen::ViewOptions{.frames_in_flight = 1});
    pen::Externals externals(*plan);

    const VkCommandPoolCreateInfo pool_info{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr, 0, family};
    VkCommandPool pool;
    must(vkCreateCommandPool(device, &pool_info, nullptr, &pool), "vkCreateCommandPool");
    const VkCommandBufferAllocateInfo allocate_info{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr,
                                                    pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
    VkCommandBuffer cmd;
    must(vkAllocateCommandBuffers(device, &allocate_info, &cmd), "vkAllocateCommandBuffers");

    for (int f = 0; f < std::atoi(argv[4]); ++f) {
        const fs::path folder = fs::path(argv[5]) / std::to_string(f);
        must(vkResetCommandPool(device, pool, 0), "vkResetCommandPool");
        const VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
        must(vkBeginCommandBuffer(cmd, &begin), "vkBeginCommandBuffer");

        // Your G-buffer pass goes here. What it leaves its images in is what is handed over.
        std::vector<Resource> resources;
        for (const pen::HostSlot& slot : plan->slots) {
            const Resource& r = resources.emplace_back(load(slot, read(folder / (slot.name + ".bin")), cmd));
            pen::SlotBinding& binding = externals[slot.name];
            binding = {.image = r.view, .texels = r.texels, .buffer = r.buffer};
            if (slot.kind != pen::PortKind::image) continue;
            binding.handover = pen::Handover{.image = r.image,
                                             .stages_before = VK_PIPELINE_STAGE_2_COPY_BIT,
                                             .access_before = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                             .layout_before = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL};
        }

        // Your camera, in double precision.
        pen::FrameDescription frame;
        std::memcpy(static_cast<void*>(&frame), read(folder / "frame.bin").data(), sizeof frame);

        // 4. The frame. Nothing is submitted, nothing is waited for.
        if (const auto error = pen::attempt([&] { view->record(cmd, frame, externals); }))
            return std::fprintf(stderr, "%s\n", pen::to_string(*error).c_str()), 1;

        // Your lighting goes here: it reads view->output("visibility"), an image in GENERAL, which is visible
        // to all stages.
        must(vkEndCommandBuffer(cmd), "vkEndCommandBuffer");
        VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
        submit.commandBufferCount = 1;
        submit.pCommandBuffers = &cmd;
        must(vkQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
        must(vkQueueWaitIdle(queue), "vkQueueWaitIdle");  // only since files are written
        for (const pen::PlanOutput& output : plan->outputs) {
            const auto bytes = view->captured(output.name);
            std::ofstream(folder / (output.name + ".minimal"), std::ios::binary)
                .write(reinterpret_cast<const char*>(bytes.data()),
                       static_cast<std::streamsize>(bytes.size()));
        }
        for (const Resource& r : resources) release(r);
    }
    view.reset();
    program.reset();
    vkDestroyCommandPool(device, pool, nullptr);
    vkDestroyDevice(device, nullptr);
    reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance, "vkDestroyDebugUtilsMessengerEXT"))(instance, messenger, nullptr);
    vkDestroyInstance(instance, nullptr);
    return messages ? 1 : 0;
}
