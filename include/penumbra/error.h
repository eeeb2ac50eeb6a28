// SPDX-License-Identifier: MIT
// What goes wrong on a device, as a value: whose fault it is, where, and what to do. The runtime's calls
// throw a Failure that carries it; attempt() gives it back as a value, for hosts without exceptions around.
// Mistakes in pipelines are Diagnostics (diagnostic.h) and are never thrown.
#pragma once

#include <vulkan/vulkan_core.h>

#include <cstdint>
#include <exception>
#include <new>
#include <optional>
#include <string>
#include <utility>

#include "penumbra/export.h"

namespace penumbra PENUMBRA_API {

enum class ErrorCode : uint32_t {
    usage = 1,          // the host has passed what it may not, or nothing where something is needed
    unsupported = 2,    // the device lacks something
    out_of_memory = 3,  // of the host or the device, or the host's allocator has given none
    device_lost = 4,
    vulkan = 5  // another Vulkan call failed
};

struct Error {
    ErrorCode code = ErrorCode::usage;
    std::string place;  // the slot, pass, resource or function
    std::string text;
    VkResult result = VK_SUCCESS;  // what Vulkan said, if it was asked
};

// "the slot \"depth\": nothing is bound"
std::string to_string(const Error& error);
// "VK_ERROR_OUT_OF_DEVICE_MEMORY"
std::string result_name(VkResult result);

class Failure : public std::exception {
  public:
    explicit Failure(Error error);
    const Error& error() const { return error_; }
    const char* what() const noexcept override { return text_.c_str(); }

  private:
    Error error_;
    std::string text_;
};

// Calls `function`; what it failed with, or nothing.
template <class Function>
std::optional<Error> attempt(Function&& function) {
    try {
        std::forward<Function>(function)();
        return std::nullopt;
    } catch (const Failure& failure) {
        return failure.error();
    } catch (const std::bad_alloc&) {
        return Error{ErrorCode::out_of_memory, "the host's heap", "no memory", VK_ERROR_OUT_OF_HOST_MEMORY};
    }
}

}  // namespace penumbra
