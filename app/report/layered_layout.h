// SPDX-License-Identifier: MIT
// Layered drawing of an acyclic graph (Sugiyama, Tagawa, Toda 1981, without its first phase: layers are
// given). Order within a layer by barycentres, sweeping to and fro, the best order seen is kept; then heights
// by pulling every item towards its neighbours.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace penumbra::report {

struct LayoutItem {
    uint32_t layer = 0;
    double height = 0;
    std::vector<size_t> before;  // items of the layer before that it is joined to
    double y = 0;                // result: of its upper end; the highest item is at 0
};

// Of what reads these values: behind everything that makes one of them. `layer_of`: of what makes a value, or
// nothing where nobody has made it yet. Layer 0 is left to what the first ones read.
template <class LayerOf>
uint32_t layer_behind(const std::vector<std::string>& values, LayerOf&& layer_of) {
    uint32_t layer = 1;
    for (const std::string& value : values)
        if (const std::optional<uint32_t> before = layer_of(value)) layer = std::max(layer, *before + 1);
    return layer;
}

// `gap` is left between neighbours of a layer.
void arrange(std::vector<LayoutItem>& items, double gap);

// How many pairs of edges between neighbouring layers cross.
size_t crossings(const std::vector<LayoutItem>& items);

}  // namespace penumbra::report
