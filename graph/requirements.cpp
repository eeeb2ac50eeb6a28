// SPDX-License-Identifier: MIT
// Each need with everything that has it, or for a limit with what has the most.
#include "penumbra/requirements.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "graph/device.h"
#include "graph/limits.h"

namespace penumbra {
namespace {

using Kind = Requirement::Kind;

// Those that there are; the others are null.
struct FeatureStructs {
    VkPhysicalDeviceFeatures* core = nullptr;
    VkPhysicalDeviceVulkan11Features* v11 = nullptr;
    VkPhysicalDeviceVulkan12Features* v12 = nullptr;
    VkPhysicalDeviceVulkan13Features* v13 = nullptr;
};

// A feature, where it stands, and the capabilities of SPIR-V that stand for it; 0: no more.
struct NamedFeature {
    const char* name;
    VkBool32* (*of)(const FeatureStructs&);
    std::array<uint32_t, 4> capabilities;
};

#define PENUMBRA_FEATURE(group, feature) \
#feature, [](const FeatureStructs& f) { return f.group ? &f.group->feature : nullptr; }
constexpr NamedFeature known_features[] = {
    {PENUMBRA_FEATURE(v13, synchronization2), {}},
    {PENUMBRA_FEATURE(v13, maintenance4), {}},
    {PENUMBRA_FEATURE(v13, shaderIntegerDotProduct), {6016, 6017, 6018, 6019}},
    {PENUMBRA_FEATURE(v12, bufferDeviceAddress), {}},
    {PENUMBRA_FEATURE(v12, shaderFloat16), {9}},
    {PENUMBRA_FEATURE(v12, shaderBufferInt64Atomics), {12}},
    {PENUMBRA_FEATURE(v12, shaderInt8), {39}},
    {PENUMBRA_FEATURE(v12, storageBuffer8BitAccess), {4448}},
    {PENUMBRA_FEATURE(v12, uniformAndStorageBuffer8BitAccess), {4449}},
    {PENUMBRA_FEATURE(v12, vulkanMemoryModel), {5345}},
    {PENUMBRA_FEATURE(v11, storageBuffer16BitAccess), {4433}},
    {PENUMBRA_FEATURE(v11, uniformAndStorageBuffer16BitAccess), {4434}},
    {PENUMBRA_FEATURE(core, shaderFloat64), {10}},
    {PENUMBRA_FEATURE(core, shaderInt64), {11}},
    {PENUMBRA_FEATURE(core, shaderInt16), {22}},
    {PENUMBRA_FEATURE(core, shaderImageGatherExtended), {25}},
    {PENUMBRA_FEATURE(core, shaderStorageImageExtendedFormats), {49}},
    {PENUMBRA_FEATURE(core, shaderStorageImageReadWithoutFormat), {55}},
    {PENUMBRA_FEATURE(core, shaderStorageImageWriteWithoutFormat), {56}}};
#undef PENUMBRA_FEATURE

constexpr std::pair<uint32_t, VkSubgroupFeatureFlags> capability_operations[] = {
    {61, VK_SUBGROUP_FEATURE_BASIC_BIT},      {62, VK_SUBGROUP_FEATURE_VOTE_BIT},
    {63, VK_SUBGROUP_FEATURE_ARITHMETIC_BIT}, {64, VK_SUBGROUP_FEATURE_BALLOT_BIT},
    {65, VK_SUBGROUP_FEATURE_SHUFFLE_BIT},    {66, VK_SUBGROUP_FEATURE_SHUFFLE_RELATIVE_BIT},
    {67, VK_SUBGROUP_FEATURE_CLUSTERED_BIT},  {68, VK_SUBGROUP_FEATURE_QUAD_BIT}};
// Matrix, Shader, Sampled1D, Image1D, SampledBuffer, ImageBuffer, ImageQuery: with every device.
constexpr uint32_t always_there[] = {0, 1, 43, 44, 46, 47, 50};
constexpr std::string_view unknown_capability = "SPIR-V capability ";

const NamedFeature* feature_of(uint32_t capability) {
    const auto found = std::ranges::find_if(known_features, [&](const NamedFeature& f) {
        return std::ranges::find(f.capabilities, capability) != f.capabilities.end();
    });
    return found == std::end(known_features) ? nullptr : found;
}

std::vector<uint32_t> capabilities_of(const std::vector<uint32_t>& spirv) {
    std::vector<uint32_t> found;
    constexpr uint32_t op_capability = 17;
    for (size_t at = 5; at + 1 < spirv.size() && (spirv[at] & 0xffff) == op_capability; at += 2)
        found.push_back(spirv[at + 1]);
    return found;
}

class Needs {
  public:
    void add(Kind kind, const std::string& name, uint64_t bits, const std::string& why) {
        Requirement& r = at(kind, name);
        r.value |= bits;
        if ((" " + r.why + " ").find(" " + why + " ") == std::string::npos)
            r.why += (r.why.empty() ? "" : " ") + why;
    }
    std::vector<Requirement> list;

  private:
    Requirement& at(Kind kind, const std::string& name) {
        const auto same = std::ranges::find_if(
            list, [&](const Requirement& r) { return r.kind == kind && r.name == name; });
        return same != list.end() ? *same : list.emplace_back(Requirement{kind, name, 0, {}});
    }
};

void need_of_shader(const Plan& plan, const PlanPass& pass, Needs& needs) {
    if (!pass.module) return;
    for (const uint32_t capability : capabilities_of(plan.modules[*pass.module])) {
        if (std::ranges::find(always_there, capability) != std::end(always_there)) continue;
        const auto operation = std::ranges::find(capability_operations, capability,
                                                 &std::pair<uint32_t, VkSubgroupFeatureFlags>::first);
        if (const NamedFeature* known = feature_of(capability)) {
            needs.add(Kind::feature, known->name, 0, pass.node);
        } else if (operation != std::end(capability_operations)) {
            needs.add(Kind::subgroup, "supportedOperations", operation->second, pass.node);
        } else if (const auto own = plan.domain->capabilities.find(capability);
                   own != plan.domain->capabilities.end()) {
            for (const std::string& extension : own->second.extensions)
                needs.add(Kind::extension, extension, 0, pass.node);
            for (const std::string& feature : own->second.features)
                needs.add(Kind::feature, feature, 0, pass.node);
        } else {
            needs.add(Kind::feature, std::string(unknown_capability) + std::to_string(capability), 0,
                      pass.node);
        }
    }
}

// What a binding asks of its format.
void need_of_binding(const PlanBinding& b, const std::string& name, Needs& needs) {
    VkFormatFeatureFlags features = 0;
    if (b.type == VK_DESCRIPTOR_TYPE_STORAGE_IMAGE) features = VK_FORMAT_FEATURE_STORAGE_IMAGE_BIT;
    if (b.type == VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER)
        features = VK_FORMAT_FEATURE_UNIFORM_TEXEL_BUFFER_BIT;
    if (b.type == VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER)
        features = VK_FORMAT_FEATURE_STORAGE_TEXEL_BUFFER_BIT;
    if (b.type == VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER) {
        features = VK_FORMAT_FEATURE_SAMPLED_IMAGE_BIT;
        if (b.linear) features |= VK_FORMAT_FEATURE_SAMPLED_IMAGE_FILTER_LINEAR_BIT;
    }
    if (features) needs.add(Kind::format, info(b.format).name, features, name);
}

}  // namespace

const char* kind_name(Requirement::Kind kind) {
    constexpr const char* names[] = {"version", "extension", "feature", "subgroup", "limit", "format"};
    return names[static_cast<size_t>(kind)];
}

std::vector<Requirement> requirements(const Plan& plan) {
    Needs needs;
    needs.add(Kind::version, "Vulkan", VK_API_VERSION_1_3, "every plan");
    needs.add(Kind::feature, "synchronization2", 0, "every plan");
    needs.add(Kind::feature, "maintenance4", 0, "every plan");  // sizes before anything is made
    for (const PlanPass& pass : plan.passes) {
        if (pass.kind != PassKind::compute) continue;
        need_of_shader(plan, pass, needs);
        for (const PlanBinding& b : pass.bindings)
            need_of_binding(b, b.source == BindingSource::host ? plan.slots[b.index].name : pass.node, needs);
    }
    for (const NeededLimit& limit : needed_limits(plan))
        needs.list.push_back({Kind::limit, limit.name, limit.value, limit.why});
    std::ranges::stable_sort(needs.list, {}, &Requirement::kind);
    return std::move(needs.list);
}

bool enable(const Requirement& feature, VkPhysicalDeviceFeatures2& chain) {
    FeatureStructs there{.core = &chain.features};
    const auto take = [](auto*& to, VkBaseOutStructure* from) {
        to = reinterpret_cast<std::remove_reference_t<decltype(to)>>(from);
    };
    for (auto* next = static_cast<VkBaseOutStructure*>(chain.pNext); next; next = next->pNext) {
        if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES) take(there.v11, next);
        if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES) take(there.v12, next);
        if (next->sType == VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES) take(there.v13, next);
    }
    if (feature.kind != Kind::feature) return false;
    const auto known = std::ranges::find(known_features, feature.name, &NamedFeature::name);
    VkBool32* const member = known == std::end(known_features) ? nullptr : known->of(there);
    if (member) *member = VK_TRUE;
    return member != nullptr;
}

std::vector<Requirement> unmet(const Plan& plan, const DeviceHandles& handles) {
    const VulkanFunctions vk = instance_functions(handles);
    VkPhysicalDeviceSubgroupProperties subgroup{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES};
    VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &subgroup};
    vk.vkGetPhysicalDeviceProperties2(handles.physical, &properties);
    const uint32_t version = properties.properties.apiVersion;
    VkPhysicalDeviceVulkan13Features v13{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES};
    VkPhysicalDeviceVulkan12Features v12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES,
                                         version >= VK_API_VERSION_1_3 ? &v13 : nullptr};
    VkPhysicalDeviceVulkan11Features v11{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES, &v12};
    VkPhysicalDeviceFeatures2 asked{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2,
                                    version >= VK_API_VERSION_1_2 ? &v11 : nullptr};
    vk.vkGetPhysicalDeviceFeatures2(handles.physical, &asked);
    // An extension's own feature is there where the extension is.
    const FeatureStructs features{.core = &asked.features, .v11 = &v11, .v12 = &v12, .v13 = &v13};
    uint32_t count = 0;
    constexpr const char* call = "vkEnumerateDeviceExtensionProperties";
    require(vk.vkEnumerateDeviceExtensionProperties(handles.physical, nullptr, &count, nullptr), call,
            "count");
    std::vector<VkExtensionProperties> extensions(count);
    require(vk.vkEnumerateDeviceExtensionProperties(handles.physical, nullptr, &count, extensions.data()),
            call, "list");
    const auto limits = limits_of(handles.physical, vk);

    const auto met = [&](const Requirement& r) {
        switch (r.kind) {
            case Kind::version:
                return version >= r.value;
            case Kind::subgroup:
                return (subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) &&
                       (subgroup.supportedOperations & r.value) == r.value;
            case Kind::extension:
                return std::ranges::any_of(extensions,
                                           [&](const auto& e) { return r.name == e.extensionName; });
            case Kind::limit:
                return limits.at(r.name) >= r.value;
            case Kind::feature:
                // Nobody knows what else a shader declares.
                return !r.name.starts_with(unknown_capability) &&
                       std::ranges::none_of(known_features, [&](const NamedFeature& f) {
                           return r.name == f.name && f.of(features) && !*f.of(features);
                       });
            case Kind::format: {
                VkFormatProperties supported;
                vk.vkGetPhysicalDeviceFormatProperties(handles.physical, info(*format_named(r.name)).vk,
                                                       &supported);
                return ((supported.optimalTilingFeatures | supported.bufferFeatures) & r.value) == r.value;
            }
        }
        return false;
    };
    std::vector<Requirement> left = requirements(plan);
    std::erase_if(left, met);
    return left;
}

}  // namespace penumbra
