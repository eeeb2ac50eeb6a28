/* SPDX-License-Identifier: MIT */
/* examples/minimal in C: the same frames through penumbra/penumbra.h.
       minimal_c PIPELINE.json WIDTH HEIGHT FRAMES FOLDER */
#include <penumbra/penumbra.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <vulkan/vulkan.h>

static void must(VkResult result, const char* what) {
    if (result == VK_SUCCESS) return;
    fprintf(stderr, "%s: VkResult %d\n", what, result);
    exit(1);
}

static penumbra_error error = {.struct_size = sizeof error};

static void fine(penumbra_code code) {
    if (code == PENUMBRA_OK) return;
    fprintf(stderr, "%s: %s\n", error.place, error.text);
    exit(code == PENUMBRA_PIPELINE ? 2 : 1);
}

static char* read_file(const char* folder, int frame, const char* name, size_t* size) {
    char path[1024];
    snprintf(path, sizeof path, "%s/%d/%s.bin", folder, frame, name);
    FILE* file = fopen(path, "rb");
    if (!file) fprintf(stderr, "cannot read %s\n", path), exit(1);
    fseek(file, 0, SEEK_END);
    *size = (size_t)ftell(file);
    rewind(file);
    char* bytes = malloc(*size);
    if (!bytes || fread(bytes, 1, *size, file) != *size) fprintf(stderr, "cannot read %s\n", path), exit(1);
    fclose(file);
    return bytes;
}

/* --- The engine's device: yours exists already. -------------------------------------------------------- */
static VkInstance instance;
static VkPhysicalDevice physical;
static VkDevice device;
static VkQueue queue;
static uint32_t family, messages;
static VkDebugUtilsMessengerEXT messenger;

static VKAPI_ATTR VkBool32 VKAPI_CALL complain(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                               VkDebugUtilsMessageTypeFlagsEXT type,
                                               const VkDebugUtilsMessengerCallbackDataEXT* data, void* user) {
    (void)severity, (void)type, (void)user;
    fprintf(stderr, "%s\n", data->pMessage);
    ++messages;
    return VK_FALSE;
}

static void open_device(void) {
    const VkDebugUtilsMessengerCreateInfoEXT debug = {
        .sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT,
        .messageSeverity = VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT,
        .messageType = VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT,
        .pfnUserCallback = complain};
    const VkValidationFeatureEnableEXT sync = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
    const VkValidationFeaturesEXT checks = {.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT,
                                            .enabledValidationFeatureCount = 1,
                                            .pEnabledValidationFeatures = &sync};
    const VkApplicationInfo app = {.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_3};
    const char *layer = "VK_LAYER_KHRONOS_validation", *extension = "VK_EXT_debug_utils";
    const VkInstanceCreateInfo create = {.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO,
                                         .pNext = &checks,
                                         .pApplicationInfo = &app,
                                         .enabledLayerCount = 1,
                                         .ppEnabledLayerNames = &layer,
                                         .enabledExtensionCount = 1,
                                         .ppEnabledExtensionNames = &extension};
    must(vkCreateInstance(&create, NULL, &instance), "vkCreateInstance");
    const PFN_vkCreateDebugUtilsMessengerEXT listen = (PFN_vkCreateDebugUtilsMessengerEXT)vkGetInstanceProcAddr(
        instance, "vkCreateDebugUtilsMessengerEXT");
    must(listen(instance, &debug, NULL, &messenger), "vkCreateDebugUtilsMessengerEXT");
    uint32_t one = 1;
    vkEnumeratePhysicalDevices(instance, &one, &physical);
}

/* What a plan needs, asked before the device is made. An engine enables these beside its own. */
static void make_device(const penumbra_plan* plan) {
    VkPhysicalDeviceVulkan13Features v13 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    VkPhysicalDeviceVulkan12Features v12 = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
                                            .pNext = &v13};
    VkPhysicalDeviceFeatures2 features = {.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, .pNext = &v12};
    for (uint32_t i = 0; i < penumbra_plan_requirement_count(plan); ++i) {
        penumbra_requirement need = {.struct_size = sizeof need};
        fine(penumbra_plan_requirement(plan, i, &need, &error));
        if (strcmp(need.kind, "feature") != 0) continue;
        fine(penumbra_enable_feature(need.name, &features, &error));
    }
    const float priority = 1;
    const VkDeviceQueueCreateInfo queues = {.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO,
                                            .queueFamilyIndex = family,
                                            .queueCount = 1,
                                            .pQueuePriorities = &priority};
    const VkDeviceCreateInfo create = {.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO,
                                       .pNext = &features,
                                       .queueCreateInfoCount = 1,
                                       .pQueueCreateInfos = &queues};
    must(vkCreateDevice(physical, &create, NULL, &device), "vkCreateDevice");
    vkGetDeviceQueue(device, family, 0, &queue);
}

/* --- The engine's G-buffer and buffers: here as files have them. --------------------------------------- */
typedef struct resource {
    VkBuffer buffer;
    VkImage image;
    VkImageView view;
    VkBufferView texels;
    VkDeviceMemory memory[2];
} resource;

static VkDeviceMemory allocate(const VkMemoryRequirements* need, VkMemoryPropertyFlags wanted) {
    VkPhysicalDeviceMemoryProperties types;
    vkGetPhysicalDeviceMemoryProperties(physical, &types);
    VkMemoryAllocateInfo info = {.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = need->size};
    while (!(need->memoryTypeBits >> info.memoryTypeIndex & 1) ||
           (types.memoryTypes[info.memoryTypeIndex].propertyFlags & wanted) != wanted)
        ++info.memoryTypeIndex;
    VkDeviceMemory memory;
    must(vkAllocateMemory(device, &info, NULL, &memory), "vkAllocateMemory");
    return memory;
}

static resource load(const penumbra_slot* slot, const char* bytes, size_t size, VkCommandBuffer cmd) {
    resource r = {0};
    const VkBufferCreateInfo buffer = {
        .sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO,
        .size = size,
        .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT |
                 VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT |
                 VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT};
    must(vkCreateBuffer(device, &buffer, NULL, &r.buffer), "vkCreateBuffer");
    VkMemoryRequirements need;
    vkGetBufferMemoryRequirements(device, r.buffer, &need);
    r.memory[0] = allocate(&need, VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT);
    vkBindBufferMemory(device, r.buffer, r.memory[0], 0);
    void* mapped;
    must(vkMapMemory(device, r.memory[0], 0, VK_WHOLE_SIZE, 0, &mapped), "vkMapMemory");
    memcpy(mapped, bytes, size);
    if (slot->kind == PENUMBRA_TEXELS) {
        const VkBufferViewCreateInfo view = {.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO,
                                             .buffer = r.buffer,
                                             .format = slot->format,
                                             .range = VK_WHOLE_SIZE};
        must(vkCreateBufferView(device, &view, NULL, &r.texels), "vkCreateBufferView");
    }
    if (slot->kind != PENUMBRA_IMAGE) return r;
    const VkImageAspectFlags aspect =
        slot->format == VK_FORMAT_D32_SFLOAT ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
    const VkImageCreateInfo image = {.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO,
                                     .imageType = VK_IMAGE_TYPE_2D,
                                     .format = slot->format,
                                     .extent = {slot->width, slot->height, 1},
                                     .mipLevels = 1,
                                     .arrayLayers = slot->layers,
                                     .samples = VK_SAMPLE_COUNT_1_BIT,
                                     .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT};
    must(vkCreateImage(device, &image, NULL, &r.image), "vkCreateImage");
    vkGetImageMemoryRequirements(device, r.image, &need);
    r.memory[1] = allocate(&need, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT);
    vkBindImageMemory(device, r.image, r.memory[1], 0);
    const VkImageViewCreateInfo view = {.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO,
                                        .image = r.image,
                                        .viewType = slot->layered ? VK_IMAGE_VIEW_TYPE_2D_ARRAY
                                                                  : VK_IMAGE_VIEW_TYPE_2D,
                                        .format = slot->format,
                                        .subresourceRange = {aspect, 0, 1, 0, slot->layers}};
    must(vkCreateImageView(device, &view, NULL, &r.view), "vkCreateImageView");
    const VkImageMemoryBarrier2 fresh = {.sType = VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER_2,
                                         .dstStageMask = VK_PIPELINE_STAGE_2_COPY_BIT,
                                         .dstAccessMask = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                         .newLayout = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                         .image = r.image,
                                         .subresourceRange = view.subresourceRange};
    const VkDependencyInfo dependency = {.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO,
                                         .imageMemoryBarrierCount = 1,
                                         .pImageMemoryBarriers = &fresh};
    vkCmdPipelineBarrier2(cmd, &dependency);
    const VkBufferImageCopy copy = {.imageSubresource = {aspect, 0, 0, slot->layers},
                                    .imageExtent = image.extent};
    vkCmdCopyBufferToImage(cmd, r.buffer, r.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
    return r;
}

static void release(const resource* r) {
    vkDestroyBufferView(device, r->texels, NULL);
    vkDestroyImageView(device, r->view, NULL);
    vkDestroyImage(device, r->image, NULL);
    vkDestroyBuffer(device, r->buffer, NULL);
    for (int i = 0; i < 2; ++i) vkFreeMemory(device, r->memory[i], NULL);
}

/* --- Penumbra. ----------------------------------------------------------------------------------------- */
/* `ahead`: a plan for no device, whose slots say what the pipeline takes; null for that one itself. */
static penumbra_plan* compile(char** argv, const penumbra_device* host, const penumbra_plan* ahead) {
    static const char* const outputs[] = {"visibility"}; /* to write it to a file */
    const penumbra_fact facts[] = {{.struct_size = sizeof *facts, .name = "alpha", .holds = VK_FALSE},
                                   {.struct_size = sizeof *facts, .name = "translucent", .holds = VK_FALSE}};
    const uint32_t width = (uint32_t)atoi(argv[2]), height = (uint32_t)atoi(argv[3]);
    const penumbra_input inputs[] = {
        {.struct_size = sizeof *inputs, .name = "normal", .format = "rgba32f", .width = width, .height = height},
        {.struct_size = sizeof *inputs, .name = "moved_boxes", .left_out = VK_TRUE}}; /* the camera hardly ever stands */
    uint32_t input_count = 1;
    for (uint32_t i = 0; ahead && i < penumbra_plan_slot_count(ahead); ++i) {
        penumbra_slot slot = {.struct_size = sizeof slot};
        fine(penumbra_plan_slot(ahead, i, &slot, &error));
        if (strcmp(slot.name, "moved_boxes") == 0) input_count = 2;
    }
    const penumbra_plan_request request = {.struct_size = sizeof request,
                                           .width = width,
                                           .height = height,
                                           .file = argv[1],
                                           .device = host,
                                           .captures = outputs,
                                           .capture_count = 1,
                                           .facts = facts,
                                           .fact_count = 2,
                                           .inputs = inputs,
                                           .input_count = input_count};
    penumbra_plan* plan;
    fine(penumbra_plan_create(&request, &plan, &error));
    return plan;
}

enum { most_slots = 32 };

int main(int argc, char** argv) {
    if (argc != 6) return fputs("usage: minimal_c PIPELINE.json WIDTH HEIGHT FRAMES FOLDER\n", stderr), 2;
    open_device();
    penumbra_plan* ahead = compile(argv, NULL, NULL);
    make_device(ahead);
    const penumbra_device host = {.struct_size = sizeof host,
                                  .queue_family = family,
                                  .instance = instance,
                                  .physical = physical,
                                  .device = device,
                                  .get_instance_proc_addr = vkGetInstanceProcAddr,
                                  .debug_utils = 1};

    /* Once, or when what the plan was made for changes: 1. a plan for this device, 2. its shaders, 3. a view
       for each camera. */
    penumbra_plan* plan = compile(argv, &host, ahead);
    penumbra_plan_destroy(ahead);
    penumbra_program* program;
    fine(penumbra_program_create(&host, plan, NULL, &program, &error));
    const penumbra_view_options options = {.struct_size = sizeof options, .frames_in_flight = 1};
    penumbra_view* view;
    fine(penumbra_view_create(program, &options, &view, &error));

    const VkCommandPoolCreateInfo pool_info = {.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO,
                                               .queueFamilyIndex = family};
    VkCommandPool pool;
    must(vkCreateCommandPool(device, &pool_info, NULL, &pool), "vkCreateCommandPool");
    const VkCommandBufferAllocateInfo allocate_info = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO,
                                                       .commandPool = pool,
                                                       .commandBufferCount = 1};
    VkCommandBuffer cmd;
    must(vkAllocateCommandBuffers(device, &allocate_info, &cmd), "vkAllocateCommandBuffers");
    const uint32_t slots = penumbra_plan_slot_count(plan);
    if (slots > most_slots) return fputs("more slots than this example has room for\n", stderr), 1;

    for (int f = 0; f < atoi(argv[4]); ++f) {
        must(vkResetCommandPool(device, pool, 0), "vkResetCommandPool");
        const VkCommandBufferBeginInfo begin = {.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
        must(vkBeginCommandBuffer(cmd, &begin), "vkBeginCommandBuffer");

        /* Your G-buffer pass goes here. What it leaves its images in is what is handed over. */
        resource resources[most_slots];
        penumbra_external externals[most_slots];
        penumbra_handover handovers[most_slots];
        size_t size;
        for (uint32_t i = 0; i < slots; ++i) {
            penumbra_slot slot = {.struct_size = sizeof slot};
            fine(penumbra_plan_slot(plan, i, &slot, &error));
            char* bytes = read_file(argv[5], f, slot.name, &size);
            resources[i] = load(&slot, bytes, size, cmd);
            free(bytes);
            externals[i] = (penumbra_external){.struct_size = sizeof *externals,
                                               .name = slot.name,
                                               .image = resources[i].view,
                                               .texels = resources[i].texels,
                                               .buffer = resources[i].buffer};
            if (slot.kind != PENUMBRA_IMAGE) continue;
            handovers[i] = (penumbra_handover){.struct_size = sizeof *handovers,
                                               .image = resources[i].image,
                                               .stages_before = VK_PIPELINE_STAGE_2_COPY_BIT,
                                               .access_before = VK_ACCESS_2_TRANSFER_WRITE_BIT,
                                               .layout_before = VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                                               .layout_after = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL,
                                               .family_before = VK_QUEUE_FAMILY_IGNORED,
                                               .family_after = VK_QUEUE_FAMILY_IGNORED};
            externals[i].handover = &handovers[i];
        }

        /* Your camera, in double precision. */
        penumbra_frame frame = {.struct_size = sizeof frame};
        char* bytes = read_file(argv[5], f, "frame", &size);
        const char* at = bytes; /* the file has a C++ FrameDescription: these members, in its order */
        memcpy(&frame.camera, at, 2 * sizeof frame.camera + 4 * sizeof(double) + 2 * sizeof(uint32_t));
        at += 2 * sizeof frame.camera + 4 * sizeof(double) + 4 * sizeof(uint32_t);
        memcpy(&frame.index, at, 4);
        memcpy(&frame.dt_s, at + 4, 4);
        memcpy(&frame.flags, at + 8, 4);
        memcpy(&frame.sub_pixel_bits, at + 12, 4);
        free(bytes);

        /* 4. The frame. Nothing is submitted, nothing is waited for. */
        fine(penumbra_view_record(view, cmd, &frame, externals, slots, &error));

        /* Your lighting goes here: penumbra_view_output() has the image, in GENERAL, visible to all stages. */
        must(vkEndCommandBuffer(cmd), "vkEndCommandBuffer");
        const VkSubmitInfo submit = {.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO,
                                     .commandBufferCount = 1,
                                     .pCommandBuffers = &cmd};
        must(vkQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
        must(vkQueueWaitIdle(queue), "vkQueueWaitIdle"); /* only since files are written */
        const void* data;
        fine(penumbra_view_captured(view, "visibility", &data, &size, &error));
        char path[1024];
        snprintf(path, sizeof path, "%s/%d/visibility.minimal_c", argv[5], f);
        FILE* file = fopen(path, "wb");
        if (!file || fwrite(data, 1, size, file) != size || fclose(file)) return fprintf(stderr, "cannot write %s\n", path), 1;
        for (uint32_t i = 0; i < slots; ++i) release(&resources[i]);
    }
    penumbra_view_destroy(view);
    penumbra_program_destroy(program);
    penumbra_plan_destroy(plan);
    vkDestroyCommandPool(device, pool, NULL);
    vkDestroyDevice(device, NULL);
    ((PFN_vkDestroyDebugUtilsMessengerEXT)vkGetInstanceProcAddr(instance, "vkDestroyDebugUtilsMessengerEXT"))(
        instance, messenger, NULL);
    vkDestroyInstance(instance, NULL);
    return messages ? 1 : 0;
}
