// SPDX-License-Identifier: MIT
// Bars: milliseconds of every pass, bytes of every resource.
#include <fmt/format.h>

#include <algorithm>

#include "app/view/panels.h"

namespace penumbra::viewer {
namespace {

// Of the longest one's length.
void bar(double value, double longest, const std::string& text, ImU32 color) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float room = ImGui::GetContentRegionAvail().x, height = ImGui::GetTextLineHeight();
    const float length = longest > 0 ? static_cast<float>(value / longest) * room : 0;
    ImGui::GetWindowDrawList()->AddRectFilled(at, {at.x + length, at.y + height}, color, 2);
    ImGui::TextUnformatted(text.c_str());
}

constexpr ImU32 gpu_color = IM_COL32(60, 110, 170, 255), cpu_color = IM_COL32(60, 130, 80, 255),
                memory_color = IM_COL32(140, 100, 50, 255);

}  // namespace

void Panels::costs(const Live& live) {
    double longest = 0, longest_cpu = 0;
    for (const PassCost& cost : live.costs()) {
        longest = std::max(longest, cost.ms.value_or(0));
        longest_cpu = std::max(longest_cpu, cost.cpu_ms.value_or(0));
    }
    if (!ImGui::BeginTable("passes", 3, ImGuiTableFlags_SizingStretchProp)) return;
    ImGui::TableSetupColumn("pass", 0, 1);
    ImGui::TableSetupColumn("device's milliseconds", 0, 2);
    ImGui::TableSetupColumn("processor's milliseconds", 0, 2);
    ImGui::TableHeadersRow();
    for (const PassCost& cost : live.costs()) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(cost.node.c_str());
        if (ImGui::IsItemHovered()) ImGui::SetTooltip("a node of the type %s", cost.type.c_str());
        ImGui::TableNextColumn();
        if (cost.ms) bar(*cost.ms, longest, fmt::format("{:.2f}", *cost.ms), gpu_color);
        ImGui::TableNextColumn();
        if (cost.cpu_ms) bar(*cost.cpu_ms, longest_cpu, fmt::format("{:.2f}", *cost.cpu_ms), cpu_color);
    }
    ImGui::EndTable();
}

void Panels::memory(const Live& live) {
    const MemoryReport& memory = live.plan().memory;
    const auto kib = [](uint64_t bytes) { return fmt::format("{} KiB", (bytes + 1023) / 1024); };
    ImGui::TextUnformatted(fmt::format("heaps {}; {} without aliasing; {} live from frame to frame",
                                       kib(memory.heap_bytes), kib(memory.unaliased_bytes),
                                       kib(memory.persistent_bytes))
                               .c_str());
    std::vector<const PlanResource*> resources;
    for (const PlanResource& r : live.plan().resources) resources.push_back(&r);
    std::ranges::stable_sort(resources, std::greater(), [](const PlanResource* r) { return r->bytes; });
    if (resources.empty() || !ImGui::BeginTable("resources", 3, ImGuiTableFlags_SizingStretchProp)) return;
    ImGui::TableSetupColumn("resource", 0, 2);
    ImGui::TableSetupColumn("bytes", 0, 2);
    ImGui::TableSetupColumn("lives", 0, 2);
    ImGui::TableHeadersRow();
    for (const PlanResource* r : resources) {
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(r->names.back().c_str());
        ImGui::TableNextColumn();
        bar(static_cast<double>(r->bytes), static_cast<double>(resources.front()->bytes), kib(r->bytes),
            memory_color);
        ImGui::TableNextColumn();
        ImGui::Text("%u passes from %s%s", r->length, live.plan().passes[r->first_pass].node.c_str(),
                    r->history ? ", into the next frame" : "");
    }
    ImGui::EndTable();
}

}  // namespace penumbra::viewer
