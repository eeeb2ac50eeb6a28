// SPDX-License-Identifier: MIT
//   race
// Two views of one program, and one of another, recorded by three threads at once, while a fourth makes and
// drops what a host makes while it runs: a view of that program in each frame, and at times a plan of the
// pipeline that the others have, and its program. For ThreadSanitizer to watch:
//   cmake --preset tsan && cmake --build --preset tsan --target race && build/tsan/tests/race
// The frames are submitted and waited for by one thread. The driver is not instrumented; what it does by
// itself is not looked at (default suppressions below).
#include <vulkan/vulkan.h>

#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "penumbra/graph.h"
#include "penumbra/shadow_nodes.h"

extern "C" const char* __tsan_default_suppressions() {
    return "called_from_lib:libvulkan_lvp.so\nrace:libvulkan_lvp.so\nrace:libLLVM\nthread:libvulkan_lvp.so\n";
}

namespace pen = penumbra;

namespace {

void must(VkResult result, const char* what) {
    if (result == VK_SUCCESS) return;
    std::fprintf(stderr, "%s: %s\n", what, pen::result_name(result).c_str());
    std::exit(1);
}

struct Thread {
    VkCommandPool pool = VK_NULL_HANDLE;
    VkCommandBuffer cmd = VK_NULL_HANDLE;
};

}  // namespace

int main() {
    VkApplicationInfo app{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    app.apiVersion = VK_API_VERSION_1_3;
    const VkInstanceCreateInfo instance_info{
        VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, nullptr, 0, &app, 0, nullptr, 0, nullptr};
    VkInstance instance = VK_NULL_HANDLE;
    must(vkCreateInstance(&instance_info, nullptr, &instance), "vkCreateInstance");
    uint32_t one = 1;
    VkPhysicalDevice physical = VK_NULL_HANDLE;
    vkEnumeratePhysicalDevices(instance, &one, &physical);
    VkPhysicalDeviceVulkan13Features v13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    VkPhysicalDeviceFeatures2 features{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2, &v13};
    vkGetPhysicalDeviceFeatures2(physical, &features);
    const float priority = 1;
    const VkDeviceQueueCreateInfo queues{
        VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, nullptr, 0, 0, 1, &priority};
    VkDeviceCreateInfo device_info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features};
    device_info.queueCreateInfoCount = 1;
    device_info.pQueueCreateInfos = &queues;
    VkDevice device = VK_NULL_HANDLE;
    must(vkCreateDevice(physical, &device_info, nullptr, &device), "vkCreateDevice");
    VkQueue queue = VK_NULL_HANDLE;
    vkGetDeviceQueue(device, 0, 0, &queue);
    const pen::DeviceHandles handles{instance, physical, device, 0, vkGetInstanceProcAddr, {}};

    pen::Diagnostics errors;
    const auto pipeline =
        pen::load_pipeline(PIPELINES "/denoise.json", {}, errors);  // has tables, histories, counters
    const auto checked = pipeline ? pen::check(*pipeline, pen::shadow_nodes(), errors) : std::nullopt;
    const auto program_of = [&](pen::Extent extent) {
        auto plan = checked ? pen::compile(*checked, {.extent = extent, .device = pen::device_table(handles)},
                                           {}, errors)
                            : std::nullopt;
        if (!plan) std::fputs(errors.text().c_str(), stderr), std::exit(1);
        return std::make_shared<const pen::Program>(handles,
                                                    std::make_shared<const pen::Plan>(std::move(*plan)));
    };
    const std::shared_ptr<const pen::Program> programs[2] = {program_of({64, 32}), program_of({48, 24})};

    // What the slots hold does not matter: memory of their own for each thread's view.
    const auto memory_for = [&](const VkMemoryRequirements& need) {
        const VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, nullptr, need.size,
                                        static_cast<uint32_t>(__builtin_ctz(need.memoryTypeBits))};
        VkDeviceMemory memory = VK_NULL_HANDLE;
        must(vkAllocateMemory(device, &info, nullptr, &memory), "vkAllocateMemory");
        return memory;
    };
    const auto bind = [&](const pen::Plan& plan, pen::Externals& externals) {
        for (const pen::HostSlot& slot : plan.slots) {
            VkMemoryRequirements need;
            if (slot.kind != pen::PortKind::image) {
                VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
                info.size = 65536;
                info.usage = VK_BUFFER_USAGE_UNIFORM_BUFFER_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
                VkBuffer& buffer = externals[slot.name].buffer;
                must(vkCreateBuffer(device, &info, nullptr, &buffer), "vkCreateBuffer");
                vkGetBufferMemoryRequirements(device, buffer, &need);
                vkBindBufferMemory(device, buffer, memory_for(need), 0);
                continue;
            }
            VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
            info.imageType = VK_IMAGE_TYPE_2D;
            info.format = pen::info(slot.format).vk;
            info.extent = {slot.extent.width, slot.extent.height, 1};
            info.mipLevels = info.arrayLayers = 1;
            info.samples = VK_SAMPLE_COUNT_1_BIT;
            info.usage = VK_IMAGE_USAGE_SAMPLED_BIT;
            VkImage image = VK_NULL_HANDLE;
            must(vkCreateImage(device, &info, nullptr, &image), "vkCreateImage");
            vkGetImageMemoryRequirements(device, image, &need);
            vkBindImageMemory(device, image, memory_for(need), 0);
            VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
            view.image = image;
            view.viewType = VK_IMAGE_VIEW_TYPE_2D;
            view.format = info.format;
            const bool depth = slot.format == pen::Format::d32 || slot.format == pen::Format::d16;
            view.subresourceRange = {
                VkImageAspectFlags(depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT), 0, 1, 0,
                1};
            must(vkCreateImageView(device, &view, nullptr, &externals[slot.name].image), "vkCreateImageView");
            externals[slot.name].handover =
                pen::Handover{.image = image, .layout_before = VK_IMAGE_LAYOUT_UNDEFINED};
        }
    };
    constexpr int count = 4;  // of threads; the last one's views last a frame each
    std::vector<std::unique_ptr<pen::View>> views(count);
    std::vector<pen::Externals> externals;
    Thread threads[count];
    for (int t = 0; t < count; ++t) {
        const auto& program = programs[t == 2];
        if (t < 3) views[t] = std::make_unique<pen::View>(program, pen::ViewOptions{.frames_in_flight = 1});
        externals.emplace_back(program->plan());
        bind(program->plan(), externals.back());
        const VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO, nullptr, 0, 0};
        must(vkCreateCommandPool(device, &pool, nullptr, &threads[t].pool), "vkCreateCommandPool");
        const VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, nullptr,
                                                   threads[t].pool, VK_COMMAND_BUFFER_LEVEL_PRIMARY, 1};
        must(vkAllocateCommandBuffers(device, &allocate, &threads[t].cmd), "vkAllocateCommandBuffers");
    }
    std::shared_ptr<const pen::Program> fresh;
    for (uint32_t f = 0; f < 100; ++f) {
        std::vector<std::thread> running;
        for (int t = 0; t < count; ++t)
            running.emplace_back([&, t] {
                if (t == 3) {
                    if (f % 20 == 10) fresh = program_of({40, 20});
                    views[t] =
                        std::make_unique<pen::View>(fresh && f % 2 ? fresh : programs[0], pen::ViewOptions{});
                }
                must(vkResetCommandPool(device, threads[t].pool, 0), "vkResetCommandPool");
                const VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
                must(vkBeginCommandBuffer(threads[t].cmd, &begin), "vkBeginCommandBuffer");
                pen::FrameDescription frame;
                frame.camera.clip_from_view = frame.previous.clip_from_view = pen::perspective(1, 1, 0.1);
                const pen::Extent most = views[t]->plan().extent;
                frame.size = {most.width - f % 16, most.height - f % 8};
                frame.index = f;
                views[t]->record(threads[t].cmd, frame, externals[t]);
                if (!views[t]->completed() && f && t < 3) {
                    std::fputs("no statistics of the frame before\n", stderr);
                    std::_Exit(1);
                }
                must(vkEndCommandBuffer(threads[t].cmd), "vkEndCommandBuffer");
            });
        for (std::thread& thread : running) thread.join();
        VkCommandBuffer all[count];
        for (int t = 0; t < count; ++t) all[t] = threads[t].cmd;
        VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
        submit.commandBufferCount = count;
        submit.pCommandBuffers = all;
        must(vkQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE), "vkQueueSubmit");
        must(vkQueueWaitIdle(queue), "vkQueueWaitIdle");
    }
    std::puts("100 frames of four views on four threads");
    return 0;  // and not _Exit(), by which ThreadSanitizer's status would be lost; the process takes the
               // device with it
}
