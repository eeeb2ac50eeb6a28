// SPDX-License-Identifier: MIT
// The text form shows everything that decides correctness (order, bindings, lifetimes, offsets, dependencies)
// and nothing that depends on the machine, so that a change shows up as a readable difference.
#include "penumbra/dump.h"

#include <fmt/format.h>

#include <map>

#include "graph/flag_words.h"

namespace penumbra {
namespace {

std::string join(const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : " ") + name;
    return text;
}

template <size_t n>
std::string flags(uint64_t value, const FlagWord (&words)[n]) {
    std::string text;
    const auto add = [&](const std::string& word) { text += (text.empty() ? "" : "+") + word; };
    if (const uint64_t rest = say_flags(value, words, add)) add(fmt::format("{:#x}", rest));
    return text.empty() ? "none" : text;
}

std::string dependency_text(const Plan& plan, const Dependency& d, const char* label) {
    if (d.empty()) return {};
    std::string text;
    if (d.src_stages)
        text += fmt::format("      {} {}:{} -> {}:{}\n", label, flags(d.src_stages, stage_words),
                            flags(d.src_access, access_words), flags(d.dst_stages, stage_words),
                            flags(d.dst_access, access_words));
    for (const Activation& a : d.activations)
        text += fmt::format("      {} activates {} after {}{} for {}:{}\n", label,
                            plan.resources[a.resource].names.front(), flags(a.src_stages, stage_words),
                            a.src_access ? ":" + flags(a.src_access, access_words) : "",
                            flags(a.dst_stages, stage_words), flags(a.dst_access, access_words));
    return text;
}

std::string shape(const PlanResource& r) {
    const std::string levels = r.levels > 1 ? fmt::format(" {} levels", r.levels) : "";
    if (r.layered)
        return fmt::format("{} {}x{}x{}{}", info(r.format).name, r.extent.width, r.extent.height, r.layers,
                           levels);
    if (r.kind == PortKind::buffer) return fmt::format("{} x {}", r.count, r.element);
    return fmt::format("{} {}x{}{}", info(r.format).name, r.extent.width, r.extent.height, levels);
}

}  // namespace

std::string to_text(const Plan& plan) {
    std::string text = fmt::format("plan {} {}x{}{}\n", plan.pipeline, plan.extent.width, plan.extent.height,
                                   plan.aliased ? "" : " (not aliased)");
    text += "passes\n";
    for (size_t p = 0; p < plan.passes.size(); ++p) {
        const PlanPass& pass = plan.passes[p];
        const std::string groups =
            pass.indirect
                ? "indirect"
                : fmt::format(
                      "{}x{}x{}{}", pass.groups[0], pass.groups[1], pass.groups[2],
                      pass.level_groups.empty() ? "" : fmt::format(", {} levels", pass.level_groups.size()));
        const std::string backend = pass.backends.empty() ? "" : " backend " + pass.backends;
        text += fmt::format("  {:2} {} ({}) {}{}\n      reads  {}\n      writes {}\n", p, pass.node,
                            pass.type, groups, backend, join(pass.reads), join(pass.writes));
        for (uint32_t parity = 0; parity < 2; ++parity) {
            const std::string label = fmt::format("[{}]", parity);
            text += dependency_text(plan, pass.before[parity], label.c_str());
            text += dependency_text(plan, pass.after_clears[parity], (label + " after clears").c_str());
        }
    }
    for (uint32_t parity = 0; parity < 2; ++parity)
        if (!plan.end[parity].empty())
            text += dependency_text(plan, plan.end[parity], fmt::format("end [{}]", parity).c_str());
    for (const Culled& culled : plan.culled)
        text += fmt::format("  culled {} ({}{}{})\n", culled.node, culled.why, culled.cond.empty() ? "" : " ",
                            culled.cond);
    text += "resources\n";
    for (const PlanResource& r : plan.resources)
        text += fmt::format("  {} {} {}{}{}passes {}+{} heap {} at {} {} size {}\n", join(r.names), shape(r),
                            r.history ? "history " : "", r.kept ? "kept " : "", r.output ? "output " : "",
                            r.first_pass, r.length, r.heap, r.offset[0], r.offset[1], r.bytes);
    text += "host slots\n";
    for (const HostSlot& slot : plan.slots)
        text += fmt::format("  {} for {}\n", slot.name, join(slot.readers));
    const MemoryReport& m = plan.memory;
    text += fmt::format("memory heap {} live bound {} optimum {} unaliased {} persistent {}\n", m.heap_bytes,
                        m.live_bound_bytes, m.optimum_bytes ? fmt::to_string(*m.optimum_bytes) : "unknown",
                        m.unaliased_bytes, m.persistent_bytes);
    return text;
}

std::string to_dot(const Plan& plan) {
    std::string text = fmt::format("digraph {} {{\n  rankdir=LR;\n  node [shape=box];\n", plan.pipeline);
    for (const HostSlot& slot : plan.slots) {
        text += fmt::format("  \"{}\" [shape=ellipse, style=dashed];\n", slot.name);
        for (const std::string& reader : slot.readers)
            text += fmt::format("  \"{}\" -> \"{}\";\n", slot.name, reader);
    }
    std::map<std::string, std::string> writer;
    for (const PlanPass& pass : plan.passes)
        for (const std::string& name : pass.writes) writer[name] = pass.node;
    for (const PlanPass& pass : plan.passes)
        for (const std::string& name : pass.reads) {
            const auto from = writer.find(std::string(without_previous(name)));
            if (from == writer.end()) continue;
            text += fmt::format("  \"{}\" -> \"{}\" [label=\"{}\"{}];\n", from->second, pass.node,
                                from->first, is_previous(name) ? ", style=dotted, constraint=false" : "");
        }
    for (const PlanOutput& output : plan.outputs) {
        text += fmt::format("  \"out {}\" [shape=ellipse, label=\"{}\"];\n", output.name, output.name);
        text += fmt::format("  \"{}\" -> \"out {}\";\n", writer[output.name], output.name);
    }
    return text + "}\n";
}

}  // namespace penumbra
