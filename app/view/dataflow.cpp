// SPDX-License-Identifier: MIT
#include "app/view/dataflow.h"

#include <algorithm>
#include <map>
#include <set>

#include "app/report/layered_layout.h"

namespace penumbra::viewer {
namespace {

using report::LayoutItem;

constexpr double layer_gap = 4, box_gap = 0.5, padding = 1;

struct Source {
    size_t box = 0, row = 0;
};

}  // namespace

Dataflow dataflow_of(const Plan& plan, double letter) {
    Dataflow flow;
    std::vector<LayoutItem> items;
    std::map<std::string, Source> sources;
    std::vector<std::pair<const PlanPass*, size_t>> passes;
    const auto add = [&](FlowBox box, uint32_t layer) {
        const size_t index = flow.boxes.size();
        const double height = static_cast<double>(box.rows.size() + !box.title.empty());
        items.push_back({layer, height, {}, 0});
        for (size_t row = 0; row < box.rows.size(); ++row) sources[box.rows[row]] = {index, row};
        flow.boxes.push_back(std::move(box));
        return index;
    };
    const auto layer_of = [&](const std::string& name) -> std::optional<uint32_t> {
        const auto source = sources.find(name);
        if (source == sources.end()) return std::nullopt;
        return items[source->second.box].layer;
    };
    for (const PlanPass& pass : plan.passes) {
        if (pass.kind == PassKind::capture) continue;
        const uint32_t layer = report::layer_behind(pass.reads, layer_of);
        passes.emplace_back(&pass, add({FlowBox::Kind::pass, pass.node, pass.writes}, layer));
    }
    std::set<std::pair<size_t, size_t>> joined;
    for (const auto& [pass, box] : passes) {
        for (const std::string& name : pass->reads) {
            auto source = sources.find(name);
            if (source == sources.end()) {
                const bool previous = is_previous(name);
                add({previous ? FlowBox::Kind::previous : FlowBox::Kind::host, "", {name}},
                    items[box].layer - 1);
                source = sources.find(name);
            }
            flow.lines.push_back({source->second.box, source->second.row, box});
            // The layout knows neighbours alone; a longer line goes behind the boxes between.
            if (items[source->second.box].layer + 1 == items[box].layer &&
                joined.emplace(source->second.box, box).second)
                items[box].before.push_back(source->second.box);
        }
    }
    report::arrange(items, box_gap);

    std::vector<double> widths, left;
    for (size_t i = 0; i < items.size(); ++i) {
        size_t letters = flow.boxes[i].title.size();
        for (const std::string& row : flow.boxes[i].rows) letters = std::max(letters, row.size());
        if (widths.size() <= items[i].layer) widths.resize(items[i].layer + 1);
        widths[items[i].layer] =
            std::max(widths[items[i].layer], static_cast<double>(letters) * letter + padding);
    }
    for (double x = 0; const double width : widths) {
        left.push_back(x);
        x += width + layer_gap;
        flow.width = x - layer_gap;
    }
    for (size_t i = 0; i < items.size(); ++i) {
        FlowBox& box = flow.boxes[i];
        box.x = left[items[i].layer];
        box.y = items[i].y;
        box.width = widths[items[i].layer];
        box.height = items[i].height;
        flow.height = std::max(flow.height, box.y + box.height);
    }
    return flow;
}

}  // namespace penumbra::viewer
