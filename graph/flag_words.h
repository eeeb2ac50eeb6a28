// SPDX-License-Identifier: MIT
// Vulkan's flags in words, for a plan's text and for its JSON; docs/embedding.md says what they stand for.
#pragma once

#include <vulkan/vulkan_core.h>

#include <cstddef>
#include <cstdint>

namespace penumbra {

struct FlagWord {
    uint64_t bit;
    const char* word;
};

inline constexpr FlagWord stage_words[] = {
    {VK_PIPELINE_STAGE_2_COMPUTE_SHADER_BIT, "compute"}, {VK_PIPELINE_STAGE_2_DRAW_INDIRECT_BIT, "indirect"},
    {VK_PIPELINE_STAGE_2_ALL_TRANSFER_BIT, "transfer"},  {VK_PIPELINE_STAGE_2_COPY_BIT, "copy"},
    {VK_PIPELINE_STAGE_2_TOP_OF_PIPE_BIT, "top"},        {VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, "all"}};
inline constexpr FlagWord access_words[] = {{VK_ACCESS_2_SHADER_STORAGE_WRITE_BIT, "write"},
                                            {VK_ACCESS_2_SHADER_STORAGE_READ_BIT, "read"},
                                            {VK_ACCESS_2_SHADER_SAMPLED_READ_BIT, "sample"},
                                            {VK_ACCESS_2_UNIFORM_READ_BIT, "uniform"},
                                            {VK_ACCESS_2_ACCELERATION_STRUCTURE_READ_BIT_KHR, "structure"},
                                            {VK_ACCESS_2_INDIRECT_COMMAND_READ_BIT, "arguments"},
                                            {VK_ACCESS_2_TRANSFER_READ_BIT, "copy_read"},
                                            {VK_ACCESS_2_TRANSFER_WRITE_BIT, "copy_write"},
                                            {VK_ACCESS_2_MEMORY_READ_BIT, "any_read"},
                                            {VK_ACCESS_2_MEMORY_WRITE_BIT, "any_write"}};
inline constexpr FlagWord image_usage_words[] = {{VK_IMAGE_USAGE_STORAGE_BIT, "storage"},
                                                 {VK_IMAGE_USAGE_SAMPLED_BIT, "sampled"},
                                                 {VK_IMAGE_USAGE_TRANSFER_SRC_BIT, "copy_source"},
                                                 {VK_IMAGE_USAGE_TRANSFER_DST_BIT, "copy_target"},
                                                 {VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT, "attachment"}};
inline constexpr FlagWord buffer_usage_words[] = {{VK_BUFFER_USAGE_STORAGE_BUFFER_BIT, "storage"},
                                                  {VK_BUFFER_USAGE_UNIFORM_TEXEL_BUFFER_BIT, "texels"},
                                                  {VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT, "arguments"},
                                                  {VK_BUFFER_USAGE_TRANSFER_SRC_BIT, "copy_source"},
                                                  {VK_BUFFER_USAGE_TRANSFER_DST_BIT, "copy_target"}};

// `say` is called with the word of each flag, in the table's order. The flags that have none are returned.
template <size_t n, class Say>
uint64_t say_flags(uint64_t flags, const FlagWord (&words)[n], Say&& say) {
    for (const FlagWord& w : words)
        if (flags & w.bit) {
            say(w.word);
            flags &= ~w.bit;
        }
    return flags;
}

}  // namespace penumbra
