// SPDX-License-Identifier: MIT
// Layouts, modules and pipelines alone, made from the plan as data: a Program would also make images and
// memory for its tables, which null hardware does not have.
#include "app/pass_statics.h"

#include <array>

#include "host/device/descriptor_sets.h"
#include "host/device/shader_module.h"

namespace penumbra {
namespace {

template <class Function>
Function device_function(const Device& device, const char* name) {
    return reinterpret_cast<Function>(vkGetDeviceProcAddr(device.get(), name));
}

// An array that Vulkan counts first and fills then.
template <class Item, class Call>
std::vector<Item> all_of(const Call& call, const Item& blank, const char* name, const std::string& what) {
    uint32_t count = 0;
    check(call(&count, nullptr), name, what);
    std::vector<Item> items(count, blank);
    check(call(&count, items.data()), name, what);
    items.resize(count);
    return items;
}

Owned<VkPipeline> make_pipeline(const Device& device, const Plan& plan, const PlanPass& pass) {
    const char* node = pass.node.c_str();
    std::array<std::vector<VkDescriptorSetLayoutBinding>, 2> bindings;
    for (const PlanBinding& b : pass.bindings)
        bindings.at(b.set).push_back({b.binding, b.type, 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
    const Owned<VkDescriptorSetLayout> owners[] = {make_set_layout(device, bindings[0], node),
                                                   make_set_layout(device, bindings[1], node)};
    const VkDescriptorSetLayout sets[] = {owners[0].get(), owners[1].get()};
    const Owned<VkPipelineLayout> layout = make_pipeline_layout(
        device, sets, VK_SHADER_STAGE_COMPUTE_BIT, static_cast<uint32_t>(pass.push.size()), node);
    std::vector<VkSpecializationMapEntry> entries;
    for (uint32_t id = 0; id < pass.constants.size(); ++id) entries.push_back({id, id * 4, 4});
    const VkSpecializationInfo constants{static_cast<uint32_t>(entries.size()), entries.data(),
                                         pass.constants.size() * 4, pass.constants.data()};
    return make_compute_pipeline(device, plan.modules[*pass.module], layout.get(), node, &constants,
                                 VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR);
}

Statistic statistic(const VkPipelineExecutableStatisticKHR& s) {
    Statistic result{s.name, s.description, false};
    switch (s.format) {
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_BOOL32_KHR:
            result.value = s.value.b32 == VK_TRUE;
            break;
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_INT64_KHR:
            result.value = s.value.i64;
            break;
        case VK_PIPELINE_EXECUTABLE_STATISTIC_FORMAT_UINT64_KHR:
            result.value = s.value.u64;
            break;
        default:
            result.value = s.value.f64;
            break;
    }
    return result;
}

std::vector<ExecutableStatics> executables_of(const Device& device, VkPipeline pipeline,
                                              const std::string& node) {
    const auto properties = device_function<PFN_vkGetPipelineExecutablePropertiesKHR>(
        device, "vkGetPipelineExecutablePropertiesKHR");
    const auto statistics = device_function<PFN_vkGetPipelineExecutableStatisticsKHR>(
        device, "vkGetPipelineExecutableStatisticsKHR");
    const VkPipelineInfoKHR of_pipeline{VK_STRUCTURE_TYPE_PIPELINE_INFO_KHR, nullptr, pipeline};
    std::vector<ExecutableStatics> result;
    for (const VkPipelineExecutablePropertiesKHR& found : all_of(
             [&](uint32_t*n, VkPipelineExecutablePropertiesKHR*to) {
                 return properties(device.get(), &of_pipeline, n, to);
             },
             VkPipelineExecutablePropertiesKHR{VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_PROPERTIES_KHR},
             "vkGetPipelineExecutablePropertiesKHR", node)) {
        const VkPipelineExecutableInfoKHR which{VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR, nullptr,
                                                pipeline, static_cast<uint32_t>(result.size())};
        ExecutableStatics& e = result.emplace_back(ExecutableStatics{found.name, found.subgroupSize});
        for (const VkPipelineExecutableStatisticKHR& s : all_of(
                 [&](uint32_t*n, VkPipelineExecutableStatisticKHR*to) {
                     return statistics(device.get(), &which, n, to);
                 },
                 VkPipelineExecutableStatisticKHR{VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR},
                 "vkGetPipelineExecutableStatisticsKHR", node))
            e.statistics.push_back(statistic(s));
    }
    return result;
}

}  // namespace

std::vector<PassStatics> pass_statics(const Device& device, const Plan& plan,
                                      const std::function<void(double share)>& progress) {
    std::vector<PassStatics> result;
    double done = 0;
    for (const PlanPass& pass : plan.passes) {
        if (progress) progress(done++ / static_cast<double>(plan.passes.size()));
        if (!pass.module) continue;
        const Owned<VkPipeline> pipeline = make_pipeline(device, plan, pass);
        result.push_back({pass.node,
                          pass.type,
                          {pass.constants[0], pass.constants[1], pass.constants[2]},
                          executables_of(device, pipeline.get(), pass.node)});
    }
    return result;
}

}  // namespace penumbra
