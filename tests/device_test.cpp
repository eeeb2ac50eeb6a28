// SPDX-License-Identifier: MIT
// The host's device: what it refuses, what it hears, how it is named. Needs a Vulkan device.
#include "host/device/device.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cctype>
#include <string>

#include "host/device/gpu.h"

namespace penumbra {
namespace {

TEST(Device, RefusesBuffersThatItDoesNotHold) {
    const Device device({.name = {}, .validation = true});
    try {
        make_host_buffer(device, device.largest_buffer() + 1, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, "a sky");
        ADD_FAILURE() << "is made";
    } catch (const DeviceError& error) {
        EXPECT_EQ(error.what(), fmt::format("a sky: {} bytes, the device's buffers hold {}",
                                            device.largest_buffer() + 1, device.largest_buffer()));
    }
    EXPECT_EQ(device.message_count(), 0u);
}

// Zero messages mean something only if a mistake makes one.
TEST(Device, MessengerHearsTheValidationLayer) {
    Device device({.name = {}, .validation = true});
    EXPECT_EQ(device.message_count(), 0u);
    const GpuBuffer buffer = make_host_buffer(device, 64, VK_BUFFER_USAGE_TRANSFER_SRC_BIT, "source");
    const GpuBuffer target = make_host_buffer(device, 64, VK_BUFFER_USAGE_TRANSFER_DST_BIT, "target");
    device.run([&](VkCommandBuffer commands) {
        const VkBufferCopy region{0, 0, 64};
        vkCmdCopyBuffer(commands, buffer.get(), target.get(), 1, &region);
        vkCmdCopyBuffer(commands, buffer.get(), target.get(), 1, &region);  // writes twice without a barrier
    });
    EXPECT_GE(device.message_count(), 1u);
}

TEST(Device, UnknownNameListsWhatThereIs) {
    const std::vector<DeviceInfo> devices = list_devices();
    ASSERT_FALSE(devices.empty());
    try {
        const Device device({.name = "no such device"});
        ADD_FAILURE();
    } catch (const DeviceError& error) {
        EXPECT_NE(std::string(error.what()).find(devices[0].name), std::string::npos) << error.what();
    }
    std::string part = devices[0].name.substr(0, 4);
    for (char& c : part) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    EXPECT_EQ(Device({.name = part}).info().name, devices[0].name);
}

}  // namespace
}  // namespace penumbra
