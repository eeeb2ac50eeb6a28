// SPDX-License-Identifier: MIT
#include "app/report/layered_layout.h"

#include <algorithm>

namespace penumbra::report {
namespace {

using Layers = std::vector<std::vector<size_t>>;  // items in order

std::vector<std::vector<size_t>> neighbours_after(const std::vector<LayoutItem>& items) {
    std::vector<std::vector<size_t>> after(items.size());
    for (size_t i = 0; i < items.size(); ++i)
        for (const size_t b : items[i].before) after[b].push_back(i);
    return after;
}

void stack(std::vector<LayoutItem>& items, const Layers& layers, double gap) {
    for (const std::vector<size_t>& layer : layers) {
        double y = 0;
        for (const size_t i : layer) {
            items[i].y = y;
            y += items[i].height + gap;
        }
    }
}

double centre(const LayoutItem& item) {
    return item.y + item.height / 2;
}

double mean_centre(const std::vector<LayoutItem>& items, const std::vector<size_t>& of, double otherwise) {
    if (of.empty()) return otherwise;
    double sum = 0;
    for (const size_t i : of) sum += centre(items[i]);
    return sum / static_cast<double>(of.size());
}

// Puts items as near to `wanted` (centres) as order and gaps allow: blocks of items that touch share the mean
// of what they want (isotonic regression by pooling adjacent violators).
void place(std::vector<LayoutItem>& items, const std::vector<size_t>& layer,
           const std::vector<double>& wanted, double gap) {
    struct Block {
        double sum = 0;  // of the wanted positions of the block's upper end
        size_t count = 0, first = 0;
        double height = 0;  // of all its items and the gaps behind them
        double at() const { return sum / static_cast<double>(count); }
    };
    std::vector<Block> blocks;
    for (size_t k = 0; k < layer.size(); ++k) {
        const LayoutItem& item = items[layer[k]];
        blocks.push_back({wanted[k] - item.height / 2, 1, k, item.height + gap});
        while (blocks.size() > 1) {
            const Block last = blocks.back();
            Block& previous = blocks[blocks.size() - 2];
            if (previous.at() + previous.height <= last.at()) break;
            previous.sum += last.sum - previous.height * static_cast<double>(last.count);
            previous.count += last.count;
            previous.height += last.height;
            blocks.pop_back();
        }
    }
    for (const Block& block : blocks) {
        double y = block.at();
        for (size_t k = block.first; k < block.first + block.count; ++k) {
            items[layer[k]].y = y;
            y += items[layer[k]].height + gap;
        }
    }
}

}  // namespace

size_t crossings(const std::vector<LayoutItem>& items) {
    size_t count = 0;
    for (size_t a = 0; a < items.size(); ++a)
        for (size_t b = a + 1; b < items.size(); ++b) {
            if (items[a].layer != items[b].layer) continue;
            for (const size_t u : items[a].before)
                for (const size_t v : items[b].before)
                    count += (items[a].y - items[b].y) * (items[u].y - items[v].y) < 0;
        }
    return count;
}

void arrange(std::vector<LayoutItem>& items, double gap) {
    if (items.empty()) return;
    constexpr int order_sweeps = 24, height_sweeps = 12;
    const std::vector<std::vector<size_t>> after = neighbours_after(items);
    Layers layers;
    for (size_t i = 0; i < items.size(); ++i) {
        if (layers.size() <= items[i].layer) layers.resize(items[i].layer + 1);
        layers[items[i].layer].push_back(i);
    }
    stack(items, layers, gap);
    Layers best = layers;
    size_t fewest = crossings(items);
    for (int sweep = 0; sweep < order_sweeps; ++sweep) {
        const bool forward = sweep % 2 == 0;
        for (size_t l = 0; l < layers.size(); ++l) {
            std::vector<size_t>& layer = layers[forward ? l : layers.size() - 1 - l];
            std::vector<std::pair<double, size_t>> keys;
            for (const size_t i : layer)
                keys.emplace_back(mean_centre(items, forward ? items[i].before : after[i], centre(items[i])),
                                  i);
            std::stable_sort(keys.begin(), keys.end(),
                             [](const auto& a, const auto& b) { return a.first < b.first; });
            for (size_t k = 0; k < layer.size(); ++k) layer[k] = keys[k].second;
            stack(items, {layer}, gap);
        }
        if (const size_t count = crossings(items); count < fewest) {
            fewest = count;
            best = layers;
        }
    }
    stack(items, best, gap);
    for (int sweep = 0; sweep < height_sweeps; ++sweep)
        for (size_t l = 0; l < best.size(); ++l) {
            const std::vector<size_t>& layer = best[sweep % 2 == 0 ? l : best.size() - 1 - l];
            std::vector<double> wanted;
            for (const size_t i : layer) {
                std::vector<size_t> around = items[i].before;
                around.insert(around.end(), after[i].begin(), after[i].end());
                wanted.push_back(mean_centre(items, around, centre(items[i])));
            }
            place(items, layer, wanted, gap);
        }
    double top = items.front().y;
    for (const LayoutItem& item : items) top = std::min(top, item.y);
    for (LayoutItem& item : items) item.y -= top;
}

}  // namespace penumbra::report
