// SPDX-License-Identifier: MIT
// A window of GLFW's that shows a canvas by a swapchain of the device that draws it: nothing passes through
// the processor on the way, and no second graphics interface is needed.
#pragma once

#include <string>
#include <vector>

#include "app/view/canvas.h"
#include "app/view/flight.h"

struct GLFWwindow;

namespace penumbra::viewer {

// GLFW, from which a device must know what surfaces need before there is one.
class WindowSystem {
  public:
    WindowSystem();  // throws DeviceError, in the window system's words, where there is none
    ~WindowSystem();
    WindowSystem(const WindowSystem&) = delete;
    WindowSystem& operator=(const WindowSystem&) = delete;

    std::vector<std::string> surface_extensions() const;
};

class Window {
  public:
    Window(Device& device, VkExtent2D extent, const std::string& title);
    ~Window();
    Window(const Window&) = delete;
    Window& operator=(const Window&) = delete;

    // Takes what has happened since; false: the window is to be closed.
    bool poll();
    // In pixels; waits while it is minimised.
    VkExtent2D extent() const;
    void present(const Canvas& canvas);
    // Keys that went down since the poll before: at five frames per second a key is up again before anybody
    // looks.
    const std::vector<int>& pressed() const { return pressed_; }
    // Keys that fly, where no field of the interface wants them.
    void fly(FlightInput& input) const;

  private:
    bool make_swapchain(VkExtent2D extent);

    Device& device_;
    GLFWwindow* window_ = nullptr;
    VkSurfaceKHR surface_ = VK_NULL_HANDLE;
    Owned<VkSwapchainKHR> swapchain_;
    std::vector<VkImage> images_;
    VkFormat format_ = VK_FORMAT_UNDEFINED;
    VkExtent2D presented_{};
    std::vector<int> pressed_;
    Owned<VkFence> acquired_;
};

}  // namespace penumbra::viewer
