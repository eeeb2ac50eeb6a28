// SPDX-License-Identifier: MIT
#include "app/report/memory_figure.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/mebibytes.h"
#include "app/report/svg.h"

namespace penumbra::report {
namespace {

constexpr double width = 1080, left = 62, right = 118, top = 12, area_height = 300, heap_gap = 10;

std::string bytes_text(uint64_t bytes) {
    if (bytes >= 1 << 20) return mebibytes(bytes);
    return fmt::format("{:.1f} KiB", static_cast<double>(bytes) / 1024);
}

// Most bytes of a heap that are live at once.
uint64_t most_live(const Plan& plan, uint32_t heap) {
    std::vector<uint64_t> live(plan.period());
    for (const PlanResource& r : plan.resources) {
        if (r.heap != heap) continue;
        for (uint32_t start : {r.first_pass, r.first_pass + plan.period() / 2})
            for (uint32_t i = 0; i < r.length; ++i) live[(start + i) % plan.period()] += r.bytes;
    }
    return live.empty() ? 0 : *std::max_element(live.begin(), live.end());
}

std::string names_of(const PlanResource& r) {
    std::string names;
    for (const std::string& name : r.names) names += (names.empty() ? "" : " = ") + name;
    return names;
}

class Figure {
  public:
    Figure(const Plan& plan, const std::string& style)
        : plan_(plan), style_(style), svg_(width, top + area_height + 92, "memory of " + plan.pipeline) {}

    std::string draw() {
        const auto period = static_cast<double>(plan_.period());
        step_ = (width - left - right) / period;
        const double gaps = heap_gap * static_cast<double>(std::max<size_t>(plan_.heaps.size(), 1) - 1);
        uint64_t bytes = 0;
        for (const Heap& heap : plan_.heaps) bytes += heap.bytes;
        scale_ = bytes == 0 ? 0 : (area_height - gaps) / static_cast<double>(bytes);
        passes();
        double bottom = top + area_height;
        for (uint32_t h = 0; h < plan_.heaps.size(); ++h) {
            heap(h, bottom);
            bottom -= static_cast<double>(plan_.heaps[h].bytes) * scale_ + heap_gap;
        }
        return svg_.str();
    }

  private:
    void passes() {
        const auto count = static_cast<uint32_t>(plan_.passes.size());
        for (uint32_t i = 0; i <= plan_.period(); ++i) {
            const double x = left + step_ * i;
            svg_.line({x, top}, {x, top + area_height}, i % count == 0 ? "axis" : "grid");
            if (i == plan_.period()) break;
            svg_.text({x + step_ / 2 + 3, top + area_height + 12}, plan_.passes[i % count].node, "tick",
                      Svg::Anchor::end, -48);
        }
        for (uint32_t frame = 0; frame < 2; ++frame)
            svg_.text({left + step_ * (frame + 0.5) * count, top + area_height + 86},
                      frame == 0 ? "even frames" : "odd frames", "title", Svg::Anchor::middle);
    }

    void heap(uint32_t index, double bottom) {
        const Heap& heap = plan_.heaps[index];
        const double height = static_cast<double>(heap.bytes) * scale_;
        svg_.rect({left, bottom - height}, {width - left - right, height}, "heap");
        for (const PlanResource& r : plan_.resources)
            if (r.heap == index)
                for (uint32_t parity = 0; parity < 2; ++parity) resource(r, parity, bottom);
        const uint64_t bound = most_live(plan_, index);
        const double line = bottom - static_cast<double>(bound) * scale_;
        svg_.line({left - 4, line}, {width - right + 4, line}, "bound");
        svg_.text({left - 8, bottom - height / 2 + 4}, heap.type, "tick", Svg::Anchor::end);
        svg_.text({width - right + 8, line + 4}, "bound " + bytes_text(bound), "tick");
        if (height > 30) svg_.text({width - right + 8, line + 18}, "heap " + bytes_text(heap.bytes), "tick");
    }

    // A life that runs past the second frame goes on in the first.
    void resource(const PlanResource& r, uint32_t parity, double bottom) {
        const uint32_t period = plan_.period(), start = r.first_pass + parity * period / 2;
        const double y = bottom - static_cast<double>(r.offset[parity] + r.bytes) * scale_,
                     height = static_cast<double>(r.bytes) * scale_;
        const std::string title =
            fmt::format("{}: {} at {}, {} of {} passes{}{}", names_of(r), bytes_text(r.bytes),
                        bytes_text(r.offset[parity]), r.length, period / 2, r.history ? ", history" : "",
                        r.output ? ", output" : "");
        for (uint32_t done = 0; done < r.length;) {
            const uint32_t from = (start + done) % period, length = std::min(r.length - done, period - from);
            const Xy corner{left + step_ * from, y}, size{step_ * length, height};
            svg_.rect({corner.x + 0.5, corner.y + 0.5}, {size.x - 1, size.y - 1},
                      fmt::format("life {} {}", r.history ? "history" : "transient", style_), title, 2);
            if (height > 11 && size.x > text_width(r.names.back(), 10) + 6)
                svg_.text({corner.x + size.x / 2, corner.y + height / 2 + 3.5}, r.names.back(), "on small",
                          Svg::Anchor::middle);
            done += length;
        }
    }

    const Plan& plan_;
    const std::string& style_;
    Svg svg_;
    double step_ = 0, scale_ = 0;
};

}  // namespace

std::string memory_figure(const Plan& plan, const std::string& style) {
    return Figure(plan, style).draw();
}

}  // namespace penumbra::report
