// SPDX-License-Identifier: MIT
// Dependencies of a plan's passes, from declared uses alone. Pure.
#pragma once

#include "penumbra/plan.h"

namespace penumbra {

constexpr VkAccessFlags2 write_accesses =
    VK_ACCESS_2_SHADER_WRITE_BIT | VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT | VK_ACCESS_2_TRANSFER_WRITE_BIT |
    VK_ACCESS_2_COLOR_ATTACHMENT_WRITE_BIT | VK_ACCESS_2_DEPTH_STENCIL_ATTACHMENT_WRITE_BIT |
    VK_ACCESS_2_HOST_WRITE_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;

// Fills before, after_clears and end of a plan whose uses, lifetimes and offsets are known.
void place_barriers(Plan& plan);

}  // namespace penumbra
