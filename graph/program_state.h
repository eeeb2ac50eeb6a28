// SPDX-License-Identifier: MIT
// What a program holds on its device.
#pragma once

#include <array>
#include <map>

#include "graph/memory.h"
#include "penumbra/program.h"

namespace penumbra {

inline VkImageAspectFlags aspects_of(Format format) {
    return info(format).kind == FormatClass::depth ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

// Of all passes that differ in nothing that a pipeline knows, as instances' do.
struct PassProgram {
    std::array<Held<VkDescriptorSetLayout>, 2> set_layouts;
    Held<VkPipelineLayout> layout;
    Held<VkPipeline> pipeline;
};

// An image of one texel array, sampled or stored to: a table, or what stands for an absent one.
struct StaticImage {
    HeldMemory memory;
    Held<VkImage> image;
    Held<VkImageView> view;
};

class ProgramState {
  public:
    ProgramState(const DeviceHandles& handles, std::shared_ptr<const Plan> plan,
                 const ProgramOptions& options);

    const DevicePtr& device() const { return device_; }
    const Plan& plan() const { return *plan_; }
    const PassProgram& pass(size_t index) const { return programs_[program_of_[index]]; }
    VkPipelineCache cache() const { return cache_.get(); }
    VkSampler sampler(bool linear) const { return samplers_[linear].get(); }
    VkImageView table(uint32_t index) const { return tables_[index].image.view.get(); }
    // What is bound where there is nothing: never read, so that all bindings alike share one.
    VkImageView absent_image(const PlanBinding& binding) const;
    VkBufferView absent_texels(Format format) const { return absent_texels_.at(format).get(); }
    VkBuffer absent_buffer() const { return absent_buffer_.get(); }

    void record_uploads(VkCommandBuffer cmd) const;
    uint64_t bytes() const;

  private:
    struct TableImage {
        StaticImage image;
        MappedBuffer staging;
    };
    struct AbsentKey {
        Format format;
        bool storage, layered;
        friend auto operator<=>(const AbsentKey&, const AbsentKey&) = default;
    };

    StaticImage make_image(Format format, std::array<uint32_t, 2> extent, VkImageUsageFlags usage,
                           bool layered, const std::string& what) const;
    void make_tables();
    void make_absent();
    PassProgram make_program(const PlanPass& pass) const;

    DevicePtr device_;
    std::shared_ptr<const Plan> plan_;
    std::array<Held<VkSampler>, 2> samplers_;
    Held<VkPipelineCache> cache_;
    std::vector<PassProgram> programs_;
    std::vector<size_t> program_of_;  // per pass; of host passes none
    std::vector<TableImage> tables_;
    std::map<AbsentKey, StaticImage> absent_images_;
    MappedBuffer absent_buffer_;
    std::map<Format, Held<VkBufferView>> absent_texels_;
};

}  // namespace penumbra
