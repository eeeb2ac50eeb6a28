// SPDX-License-Identifier: MIT
// The explicit table of node types.
#include "nodes/nodes.h"

#include <cstring>
#include <stdexcept>

#include "nodes/embedded.h"
#include "shaders/common/blocks.h"

namespace penumbra {

#define PENUMBRA_NODES(X) \
    X(average)            \
    X(beams)              \
    X(cascade_pcf)        \
    X(cascade_pyramid)    \
    X(cascade_taps)       \
    X(cascades)           \
    X(classify)           \
    X(clear)              \
    X(cones)              \
    X(copy)               \
    X(cover)              \
    X(drift)              \
    X(filter)             \
    X(gather)             \
    X(guides)             \
    X(prepare)            \
    X(reference)          \
    X(resolve)            \
    X(shade)              \
    X(soften)             \
    X(taa)                \
    X(tileclass)          \
    X(trace)              \
    X(validate)           \
    X(verdicts)

#define PENUMBRA_DECLARE(name) extern const EmbeddedNode embedded_##name;
PENUMBRA_NODES(PENUMBRA_DECLARE)
#undef PENUMBRA_DECLARE

namespace {

NodeEntry load(const EmbeddedNode& embedded) {
    Diagnostics diagnostics;
    const auto json =
        parse_json(embedded.declaration, "nodes/" + std::string(embedded.name) + ".json", diagnostics);
    auto type = json ? parse_node_type(*json, embedded.name, diagnostics) : std::nullopt;
    if (!type) throw std::logic_error("an embedded declaration does not parse: " + diagnostics.text());
    NodeEntry entry{std::move(*type), {}, {}, {}};
    for (const EmbeddedVariant& variant : embedded.variants)
        entry.shaders[variant.key].assign(variant.spirv.begin(), variant.spirv.end());
    for (const EmbeddedTable& table : embedded.tables) {
        const auto bytes = std::as_bytes(table.words);
        entry.tables.push_back({table.name, {bytes.begin(), bytes.end()}});
    }
    return entry;
}

}  // namespace

NodeSet shadow_nodes() {
    NodeSet set;
    set.add_struct("Sun", sizeof(blocks::Sun));
    set.add_struct("Scene", sizeof(blocks::Scene));
    set.add_struct("Cascades", sizeof(blocks::Cascades));
#define PENUMBRA_ADD(name) set.add(load(embedded_##name));
    PENUMBRA_NODES(PENUMBRA_ADD)
#undef PENUMBRA_ADD
    return set;
}

}  // namespace penumbra
