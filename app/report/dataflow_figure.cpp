// SPDX-License-Identifier: MIT
// Values that are read further on than in the next layer pass through invisible items of the layers between,
// so that lines go around boxes.
#include "app/report/dataflow_figure.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "app/report/layered_layout.h"
#include "app/report/svg.h"

namespace penumbra::report {
namespace {

constexpr double row_height = 15, title_height = 21, pill_height = 20, through_height = 5, item_gap = 13,
                 layer_gap = 54, margin = 10;

enum class Kind { pass, host, previous, output, through };

struct Item {
    Kind kind = Kind::pass;
    std::string title;
    std::vector<std::string> rows;  // values that it offers
};

// A value on its way: where it comes from, and who reads it.
struct Value {
    std::string name;
    size_t item = 0, row = 0;
    bool previous = false;
    std::vector<size_t> readers;
};

struct Segment {
    size_t from = 0, to = 0, value = 0;
};

class Map {
  public:
    explicit Map(const Plan& plan) {
        add_passes(plan);
        add_reads(plan);
        add_outputs(plan);
        for (size_t v = 0; v < values_.size(); ++v) route(v);
        arrange(layout_, item_gap);
        place_layers();
    }

    std::string draw(const std::string& name, const std::string& style) const {
        double width = 0, height = 0;
        for (size_t i = 0; i < items_.size(); ++i) {
            width = std::max(width, x_[layout_[i].layer] + widths_[layout_[i].layer]);
            height = std::max(height, layout_[i].y + layout_[i].height);
        }
        Svg svg(width + 2 * margin, height + 2 * margin, "dataflow of " + name);
        for (const Segment& s : segments_) draw_segment(svg, s, style);
        for (size_t i = 0; i < items_.size(); ++i) draw_item(svg, i, style);
        return svg.str();
    }

  private:
    size_t add(Item item, uint32_t layer) {
        const double height = item.kind == Kind::through ? through_height
                              : item.kind == Kind::pass
                                  ? title_height + row_height * static_cast<double>(item.rows.size()) + 4
                                  : pill_height;
        layout_.push_back({layer, height, {}, 0});
        items_.push_back(std::move(item));
        return items_.size() - 1;
    }

    void add_passes(const Plan& plan) {
        const auto layer_of = [&](const std::string& name) -> std::optional<uint32_t> {
            const auto value = by_name_.find(name);
            if (value == by_name_.end()) return std::nullopt;
            return layout_[values_[value->second].item].layer;
        };
        for (const PlanPass& pass : plan.passes) {
            if (pass.kind == PassKind::capture) continue;
            const uint32_t layer = layer_behind(pass.reads, layer_of);
            const size_t item = add({Kind::pass, pass.node, pass.writes}, layer);
            for (size_t row = 0; row < pass.writes.size(); ++row) {
                by_name_[pass.writes[row]] = values_.size();
                values_.push_back({pass.writes[row], item, row, false, {}});
            }
            pass_items_.push_back(item);
        }
    }

    void add_reads(const Plan& plan) {
        size_t index = 0;
        for (const PlanPass& pass : plan.passes) {
            if (pass.kind == PassKind::capture) continue;
            const size_t reader = pass_items_[index++];
            for (const std::string& name : pass.reads) {
                auto value = by_name_.find(name);
                if (value ==
                    by_name_.end()) {  // the first reader in the plan's order is the leftmost or near it
                    const bool previous = is_previous(name);
                    const size_t source = add({previous ? Kind::previous : Kind::host, name, {name}}, 0);
                    value = by_name_.emplace(name, values_.size()).first;
                    values_.push_back({name, source, 0, previous, {}});
                }
                values_[value->second].readers.push_back(reader);
            }
        }
        for (const Value& value : values_) {
            if (items_[value.item].kind == Kind::pass) continue;
            uint32_t first = layout_[value.readers.front()].layer;
            for (const size_t reader : value.readers) first = std::min(first, layout_[reader].layer);
            layout_[value.item].layer = first - 1;
        }
    }

    void add_outputs(const Plan& plan) {
        uint32_t last = 0;
        for (const LayoutItem& item : layout_) last = std::max(last, item.layer);
        for (const PlanOutput& output : plan.outputs)
            if (const auto value = by_name_.find(output.name); value != by_name_.end())
                values_[value->second].readers.push_back(add({Kind::output, output.name, {}}, last + 1));
    }

    // Joins a value's source to all its readers, with one shared trunk.
    void route(size_t v) {
        const Value value = values_[v];
        uint32_t last = 0;
        for (const size_t reader : value.readers) last = std::max(last, layout_[reader].layer);
        size_t from = value.item;
        for (uint32_t layer = layout_[from].layer + 1; layer <= last; ++layer) {
            const auto join = [&](size_t to) {
                segments_.push_back({from, to, v});
                layout_[to].before.push_back(from);
            };
            for (const size_t reader : value.readers)
                if (layout_[reader].layer == layer) join(reader);
            if (layer == last) break;
            const size_t through = add({Kind::through, value.name, {}}, layer);
            join(through);
            from = through;
        }
    }

    void place_layers() {
        for (size_t i = 0; i < items_.size(); ++i) {
            const uint32_t layer = layout_[i].layer;
            if (widths_.size() <= layer) widths_.resize(layer + 1);
            double widest = text_width(items_[i].title, 11.5) + 22;
            for (const std::string& row : items_[i].rows)
                widest = std::max(widest, text_width(row, 10.5) + 22);
            if (items_[i].kind != Kind::through) widths_[layer] = std::max(widths_[layer], widest);
        }
        double x = 0;
        for (const double width : widths_) {
            x_.push_back(x);
            x += width + layer_gap;
        }
    }

    double width_of(size_t item) const { return widths_[layout_[item].layer]; }
    Xy corner(size_t item) const { return {margin + x_[layout_[item].layer], margin + layout_[item].y}; }

    // Where a segment leaves its left end, and where it enters its right end: readers are entered in the
    // order of what comes in, from top to bottom.
    Xy leave(const Segment& s) const {
        const Xy at = corner(s.from);
        const double x = at.x + width_of(s.from);
        if (items_[s.from].kind != Kind::pass) return {x, at.y + layout_[s.from].height / 2};
        return {x, at.y + title_height + row_height * (static_cast<double>(values_[s.value].row) + 0.5)};
    }
    Xy enter(const Segment& s) const {
        const Xy at = corner(s.to);
        std::vector<std::pair<double, size_t>> incoming;
        for (const Segment& other : segments_)
            if (other.to == s.to) incoming.emplace_back(leave(other).y, other.value);
        std::sort(incoming.begin(), incoming.end());
        const auto place = std::find_if(incoming.begin(), incoming.end(),
                                        [&](const auto& in) { return in.second == s.value; });
        const double share =
            (static_cast<double>(place - incoming.begin()) + 1) / (static_cast<double>(incoming.size()) + 1);
        return {at.x, at.y + layout_[s.to].height * share};
    }

    void draw_segment(Svg& svg, const Segment& s, const std::string& style) const {
        const Xy a = leave(s), b = enter(s);
        const double bend = (b.x - a.x) / 2;
        std::string path = fmt::format("M{:.1f} {:.1f}C{:.1f} {:.1f} {:.1f} {:.1f} {:.1f} {:.1f}", a.x, a.y,
                                       a.x + bend, a.y, b.x - bend, b.y, b.x, b.y);
        if (items_[s.to].kind == Kind::through) path += fmt::format("H{:.1f}", b.x + width_of(s.to));
        const Value& value = values_[s.value];
        const bool inside = items_[value.item].kind == Kind::pass;
        svg.path(path, fmt::format("flow {} {}", value.previous ? "previous" : "", inside ? style : "host"),
                 items_[s.to].kind == Kind::through
                     ? value.name
                     : fmt::format("{} into {}", value.name, items_[s.to].title));
    }

    void draw_item(Svg& svg, size_t index, const std::string& style) const {
        const Item& item = items_[index];
        const Xy at = corner(index);
        const double width = width_of(index), height = layout_[index].height;
        switch (item.kind) {
            case Kind::through:
                return;
            case Kind::host:
            case Kind::previous:
            case Kind::output: {
                const char* kind = item.kind == Kind::host       ? "host"
                                   : item.kind == Kind::previous ? "previous"
                                                                 : "output";
                svg.rect(at, {width, height}, fmt::format("pill {} {}", kind, style), {}, height / 2);
                svg.text({at.x + width / 2, at.y + height / 2 + 4}, item.title, "port", Svg::Anchor::middle);
                return;
            }
            case Kind::pass:
                break;
        }
        svg.rect(at, {width, height}, "node " + style, {}, 4);
        svg.text({at.x + 10, at.y + 15}, item.title, "name " + style);
        for (size_t row = 0; row < item.rows.size(); ++row) {
            const double y = at.y + title_height + row_height * (static_cast<double>(row) + 0.5);
            svg.text({at.x + width - 10, y + 3.5}, item.rows[row], "port", Svg::Anchor::end);
            svg.circle({at.x + width, y}, 2.5, "socket " + style);
        }
    }

    std::vector<Item> items_;
    std::vector<LayoutItem> layout_;  // parallel to items_
    std::vector<size_t> pass_items_;
    std::vector<Value> values_;
    std::map<std::string, size_t> by_name_;
    std::vector<Segment> segments_;
    std::vector<double> widths_, x_;  // per layer
};

}  // namespace

std::string dataflow_figure(const Plan& plan, const std::string& style) {
    return Map(plan).draw(plan.pipeline, style);
}

}  // namespace penumbra::report
