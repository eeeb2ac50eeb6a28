// SPDX-License-Identifier: MIT
// What a window shows, as an image on the device: a picture, and Dear ImGui's draw lists over it. With a
// window or without one, it is drawn by the same commands.
#pragma once

#include <imgui.h>

#include "app/view/picture.h"
#include "host/device/gpu.h"

namespace penumbra::viewer {

// In pixels of the canvas.
struct Area {
    float x = 0, y = 0, width = 0, height = 0;
};

// The largest area inside of `room` that has the proportions of width : height, in its middle.
Area fitted(const Area& room, uint32_t width, uint32_t height);

class Canvas {
  public:
    static constexpr VkFormat format = VK_FORMAT_R8G8B8A8_UNORM;

    // ImGui's context is there, and stays.
    Canvas(Device& device, VkExtent2D extent);
    ~Canvas();
    Canvas(const Canvas&) = delete;
    Canvas& operator=(const Canvas&) = delete;

    void resize(VkExtent2D extent);
    // Afterwards the image is in TRANSFER_SRC_OPTIMAL.
    void draw(const Picture& picture, const Area& area, ImDrawData* ui);

    const GpuImage& image() const { return image_; }
    // As it was drawn, rows from the top.
    std::vector<uint8_t> rgba();

  private:
    void upload(const Picture& picture);

    Device& device_;
    Owned<VkRenderPass> pass_;
    Owned<VkDescriptorPool> pool_;
    GpuImage image_, picture_;
    GpuBuffer staging_;
    Owned<VkFramebuffer> framebuffer_;
};

}  // namespace penumbra::viewer
