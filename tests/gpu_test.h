// SPDX-License-Identifier: MIT
// Base of every GPU test: one device per process, with validation and synchronisation checks, which must stay
// silent.
#pragma once

#include <gtest/gtest.h>

#include "host/device/device.h"

namespace penumbra::test {

// The device of this process; PENUMBRA_TEST_DEVICE chooses one by a part of its name.
Device& gpu();

// How far from a value the fixed-point texel may be that stores it, in steps: Vulkan asks for .6, a CPU
// rounds to the nearest. With what a test allows the value itself.
inline double texel_steps(double of_value) {
    return (gpu().info().is_cpu ? 0.5 : 0.6) + of_value;
}

class GpuTest : public ::testing::Test {
  protected:
    void SetUp() override { messages_before_ = gpu().messages().size(); }
    void TearDown() override {
        const std::vector<std::string> messages = gpu().messages();
        for (size_t i = messages_before_; i < messages.size(); ++i) ADD_FAILURE() << messages[i];
    }

  private:
    size_t messages_before_ = 0;
};

}  // namespace penumbra::test
