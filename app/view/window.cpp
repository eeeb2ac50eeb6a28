// SPDX-License-Identifier: MIT
// A frame is waited for before it is shown, as everywhere in this program: its results are read back.
#include "app/view/window.h"

#define GLFW_INCLUDE_VULKAN
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <fmt/format.h>

#include <algorithm>

namespace penumbra::viewer {
namespace {

std::string glfw_words() {
    const char* text = nullptr;
    return glfwGetError(&text) == GLFW_NO_ERROR || !text ? "no reason given" : text;
}

}  // namespace

WindowSystem::WindowSystem() {
    if (!glfwInit())
        throw DeviceError(
            fmt::format("no window can be opened: {} (`--headless FILE.png` needs none)", glfw_words()));
    if (!glfwVulkanSupported()) {
        const std::string words = glfw_words();
        glfwTerminate();
        throw DeviceError(fmt::format("the window system shows nothing of Vulkan's: {}", words));
    }
}

WindowSystem::~WindowSystem() {
    glfwTerminate();
}

std::vector<std::string> WindowSystem::surface_extensions() const {
    uint32_t count = 0;
    const char** names = glfwGetRequiredInstanceExtensions(&count);
    if (!names) throw DeviceError(fmt::format("no surfaces for windows: {}", glfw_words()));
    return {names, names + count};
}

Window::Window(Device& device, VkExtent2D extent, const std::string& title) : device_(device) {
    glfwWindowHint(GLFW_CLIENT_API, GLFW_NO_API);
    window_ = glfwCreateWindow(static_cast<int>(extent.width), static_cast<int>(extent.height), title.c_str(),
                               nullptr, nullptr);
    if (!window_) throw DeviceError(fmt::format("no window can be opened: {}", glfw_words()));
    try {
        check(glfwCreateWindowSurface(device.instance(), window_, nullptr, &surface_),
              "glfwCreateWindowSurface", "the window");
        VkBool32 shows = VK_FALSE;
        check(
            vkGetPhysicalDeviceSurfaceSupportKHR(device.physical(), device.queue_family(), surface_, &shows),
            "vkGetPhysicalDeviceSurfaceSupportKHR", "the window");
        if (!shows)
            throw DeviceError(fmt::format("{} shows nothing in this window system", device.info().name));
        VkFenceCreateInfo create{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
        VkFence fence = VK_NULL_HANDLE;
        check(vkCreateFence(device.get(), &create, nullptr, &fence), "vkCreateFence", "the window");
        acquired_ = {device.get(), fence};
    } catch (...) {
        if (surface_) vkDestroySurfaceKHR(device.instance(), surface_, nullptr);
        glfwDestroyWindow(window_);
        throw;
    }
    glfwSetInputMode(window_, GLFW_STICKY_KEYS, GLFW_TRUE);  // a short tap flies a frame long
    glfwSetWindowUserPointer(window_, this);
    glfwSetKeyCallback(window_, [](GLFWwindow* window, int key, int, int action, int) {
        if (action == GLFW_PRESS)
            static_cast<Window*>(glfwGetWindowUserPointer(window))->pressed_.push_back(key);
    });
    ImGui_ImplGlfw_InitForVulkan(window_, true);  // calls what was there before
}

Window::~Window() {
    ImGui_ImplGlfw_Shutdown();
    swapchain_ = {};
    vkDestroySurfaceKHR(device_.instance(), surface_, nullptr);
    glfwDestroyWindow(window_);
}

bool Window::poll() {
    pressed_.clear();
    glfwPollEvents();
    return !glfwWindowShouldClose(window_);
}

VkExtent2D Window::extent() const {
    int width = 0, height = 0;
    glfwGetFramebufferSize(window_, &width, &height);
    while ((width == 0 || height == 0) && !glfwWindowShouldClose(window_)) {
        glfwWaitEvents();
        glfwGetFramebufferSize(window_, &width, &height);
    }
    return {static_cast<uint32_t>(std::max(width, 1)), static_cast<uint32_t>(std::max(height, 1))};
}

// False: the window has no room at the moment.
bool Window::make_swapchain(VkExtent2D extent) {
    VkSurfaceCapabilitiesKHR can{};
    check(vkGetPhysicalDeviceSurfaceCapabilitiesKHR(device_.physical(), surface_, &can),
          "vkGetPhysicalDeviceSurfaceCapabilitiesKHR", "the window");
    if (can.currentExtent.width != ~0u) extent = can.currentExtent;
    if (extent.width == 0 || extent.height == 0) return false;
    uint32_t count = 0;
    check(vkGetPhysicalDeviceSurfaceFormatsKHR(device_.physical(), surface_, &count, nullptr),
          "vkGetPhysicalDeviceSurfaceFormatsKHR", "the window");
    std::vector<VkSurfaceFormatKHR> formats(count);
    check(vkGetPhysicalDeviceSurfaceFormatsKHR(device_.physical(), surface_, &count, formats.data()),
          "vkGetPhysicalDeviceSurfaceFormatsKHR", "the window");
    // The canvas is encoded already.
    const auto plain = std::ranges::find_if(formats, [](const VkSurfaceFormatKHR& f) {
        return f.format == VK_FORMAT_B8G8R8A8_UNORM || f.format == VK_FORMAT_R8G8B8A8_UNORM;
    });
    if (plain == formats.end())
        throw DeviceError("the window takes no 8-bit colours without a transfer curve");
    if (!(can.supportedUsageFlags & VK_IMAGE_USAGE_TRANSFER_DST_BIT))
        throw DeviceError("the window takes no copies of images");
    format_ = plain->format;
    VkSwapchainCreateInfoKHR create{VK_STRUCTURE_TYPE_SWAPCHAIN_CREATE_INFO_KHR};
    create.surface = surface_;
    create.minImageCount =
        can.maxImageCount ? std::min(can.minImageCount + 1, can.maxImageCount) : can.minImageCount + 1;
    create.imageFormat = format_;
    create.imageColorSpace = plain->colorSpace;
    create.imageExtent = extent;
    create.imageArrayLayers = 1;
    create.imageUsage = VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    create.preTransform = can.currentTransform;
    create.compositeAlpha = VK_COMPOSITE_ALPHA_OPAQUE_BIT_KHR;
    create.presentMode = VK_PRESENT_MODE_FIFO_KHR;
    create.clipped = VK_TRUE;
    create.oldSwapchain = swapchain_.get();
    VkSwapchainKHR made = VK_NULL_HANDLE;
    check(vkCreateSwapchainKHR(device_.get(), &create, nullptr, &made), "vkCreateSwapchainKHR", "the window");
    swapchain_ = {device_.get(), made};
    check(vkGetSwapchainImagesKHR(device_.get(), made, &count, nullptr), "vkGetSwapchainImagesKHR", "count");
    images_.resize(count);
    check(vkGetSwapchainImagesKHR(device_.get(), made, &count, images_.data()), "vkGetSwapchainImagesKHR",
          "list");
    presented_ = extent;
    return true;
}

void Window::present(const Canvas& canvas) {
    const VkExtent2D now = extent();
    if (!swapchain_ || presented_.width != now.width || presented_.height != now.height)
        if (!make_swapchain(now)) return;
    uint32_t index = 0;
    VkFence fence = acquired_.get();
    const VkResult acquired =
        vkAcquireNextImageKHR(device_.get(), swapchain_.get(), ~0ull, VK_NULL_HANDLE, fence, &index);
    if (acquired == VK_ERROR_OUT_OF_DATE_KHR) {
        presented_ = {};  // made anew for the next frame
        return;
    }
    if (acquired != VK_SUBOPTIMAL_KHR) check(acquired, "vkAcquireNextImageKHR", "the window");
    check(vkWaitForFences(device_.get(), 1, &fence, VK_TRUE, ~0ull), "vkWaitForFences", "the window");
    check(vkResetFences(device_.get(), 1, &fence), "vkResetFences", "the window");
    device_.run([&](VkCommandBuffer cmd) {
        full_barrier(cmd, images_[index], format_, VK_IMAGE_LAYOUT_UNDEFINED,
                     VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        const VkExtent2D from = canvas.image().extent;
        VkImageBlit blit{};  // copies would not change the order of the channels
        blit.srcSubresource = blit.dstSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        blit.srcOffsets[1] = {static_cast<int32_t>(from.width), static_cast<int32_t>(from.height), 1};
        blit.dstOffsets[1] = {static_cast<int32_t>(presented_.width), static_cast<int32_t>(presented_.height),
                              1};
        vkCmdBlitImage(cmd, canvas.image().get(), VK_IMAGE_LAYOUT_TRANSFER_SRC_OPTIMAL, images_[index],
                       VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &blit, VK_FILTER_NEAREST);
        full_barrier(cmd, images_[index], format_, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL,
                     VK_IMAGE_LAYOUT_PRESENT_SRC_KHR);
    });
    VkPresentInfoKHR present{VK_STRUCTURE_TYPE_PRESENT_INFO_KHR};
    const VkSwapchainKHR swapchain = swapchain_.get();
    present.swapchainCount = 1;
    present.pSwapchains = &swapchain;
    present.pImageIndices = &index;
    const VkResult shown = vkQueuePresentKHR(device_.queue(), &present);
    if (shown == VK_ERROR_OUT_OF_DATE_KHR || shown == VK_SUBOPTIMAL_KHR)
        presented_ = {};
    else
        check(shown, "vkQueuePresentKHR", "the window");
}

void Window::fly(FlightInput& input) const {
    if (ImGui::GetIO().WantCaptureKeyboard) return;
    const auto down = [&](int key) { return glfwGetKey(window_, key) == GLFW_PRESS ? 1.0 : 0.0; };
    input.move = {down(GLFW_KEY_D) - down(GLFW_KEY_A), down(GLFW_KEY_E) - down(GLFW_KEY_Q),
                  down(GLFW_KEY_W) - down(GLFW_KEY_S)};
    input.hurry = down(GLFW_KEY_LEFT_SHIFT) > 0;
}

}  // namespace penumbra::viewer
