// SPDX-License-Identifier: MIT
// The dataflow as boxes and lines; a click on a resource shows it.
#include <algorithm>

#include "app/view/dataflow.h"
#include "app/view/panels.h"

namespace penumbra::viewer {
namespace {

constexpr ImU32 box_color = IM_COL32(44, 50, 58, 255), title_color = IM_COL32(52, 84, 122, 255),
                host_color = IM_COL32(40, 62, 46, 255), previous_color = IM_COL32(74, 58, 34, 255),
                line_color = IM_COL32(130, 140, 150, 110), bright_color = IM_COL32(255, 200, 0, 230),
                text_color = IM_COL32(225, 228, 232, 255);

}  // namespace

void Panels::dataflow(const Live& live) {
    const auto height = ImGui::GetTextLineHeightWithSpacing();
    const Dataflow flow = dataflow_of(live.plan(), ImGui::CalcTextSize("m").x / static_cast<double>(height));
    const ImVec2 origin = ImGui::GetCursorScreenPos();
    const auto at = [&](double x, double y) {
        return ImVec2(origin.x + static_cast<float>(x) * height, origin.y + static_cast<float>(y) * height);
    };
    ImDrawList* draw = ImGui::GetWindowDrawList();
    const std::string shown = live.beside() == Beside::nothing ? live.shown() : "";
    for (const FlowLine& line : flow.lines) {
        const FlowBox &from = flow.boxes[line.from], &to = flow.boxes[line.to];
        const double row = static_cast<double>(line.row) + (from.title.empty() ? 0.5 : 1.5);
        const ImVec2 a = at(from.x + from.width, from.y + row), b = at(to.x, to.y + 0.5);
        const float bend = std::max((b.x - a.x) / 2, 2 * height);
        const bool bright = without_previous(from.rows[line.row]) == shown;
        draw->AddBezierCubic(a, {a.x + bend, a.y}, {b.x - bend, b.y}, b, bright ? bright_color : line_color,
                             bright ? 2.0f : 1.0f);
    }
    std::string clicked;
    const std::vector<std::string> can = resources_of(live.stage());
    for (size_t b = 0; b < flow.boxes.size(); ++b) {
        const FlowBox& box = flow.boxes[b];
        const ImU32 color = box.kind == FlowBox::Kind::pass   ? box_color
                            : box.kind == FlowBox::Kind::host ? host_color
                                                              : previous_color;
        draw->AddRectFilled(at(box.x, box.y), at(box.x + box.width, box.y + box.height), color, 3);
        double y = box.y;
        if (!box.title.empty()) {
            draw->AddRectFilled(at(box.x, y), at(box.x + box.width, y + 1), title_color, 3);
            draw->AddText(at(box.x + 0.3, y + 0.1), text_color, box.title.c_str());
            ++y;
        }
        for (size_t row = 0; row < box.rows.size(); ++row, ++y) {
            // A previous value is last frame's picture of the same name.
            const std::string name(without_previous(box.rows[row]));
            draw->AddText(at(box.x + 0.5, y + 0.1), name == shown ? bright_color : text_color,
                          box.rows[row].c_str());
            if (std::ranges::find(can, name) == can.end()) continue;
            ImGui::PushID(static_cast<int>(1000 * b + row));
            ImGui::SetCursorScreenPos(at(box.x, y));
            if (ImGui::InvisibleButton("row", {static_cast<float>(box.width) * height, height}))
                clicked = name;
            if (ImGui::IsItemHovered()) {
                draw->AddRect(ImGui::GetItemRectMin(), ImGui::GetItemRectMax(), bright_color, 3);
                ImGui::SetTooltip("show %s", name.c_str());
            }
            if (ImGui::IsItemVisible() && box.kind == FlowBox::Kind::pass) mark("resource " + name);
            ImGui::PopID();
        }
    }
    ImGui::SetCursorScreenPos(origin);
    ImGui::Dummy({static_cast<float>(flow.width) * height, static_cast<float>(flow.height) * height});
    if (!clicked.empty()) wishes_.emplace_back([clicked](Live& l) { l.show(clicked); });
}

}  // namespace penumbra::viewer
