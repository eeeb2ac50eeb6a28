// SPDX-License-Identifier: MIT
// "Model only what a scene needs", as a table written by hand: scenes, what is to be found out about them,
// and what then has to run. Nothing in it is computed from the pipelines; the plans must agree in nodes,
// resources, histories, host inputs and tables. That a feature which is off costs nothing is then shown
// against pipelines that never had it.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <sstream>

#include "app/session.h"
#include "host/shots/shot_facts.h"
#include "host/truth/analytic.h"
#include "penumbra/shadow_nodes.h"
#include "tests/fact_scenes.h"
#include "tests/plan_checks.h"
#include "tests/shipped.h"

namespace penumbra::test {
namespace {

// ---- what has to run

using Names = std::set<std::string>;

Names words(const std::string& text) {
    std::istringstream stream(text);
    return {std::istream_iterator<std::string>(stream), {}};
}

struct Needed {
    std::string nodes, resources, histories, inputs, tables;
};

// The required nodes and what they keep, per pipeline.
Needed needed_by(const std::string& pipeline, const FactScene& row) {
    const auto& [shadow, moves, alpha, sun_moves] = std::tie(row.shadow, row.moves, row.alpha, row.sun_moves);
    Needed needed{"guides shade", "view_depth guide_normal visibility lit", "", "depth normal albedo sun",
                  ""};
    const auto also = [&](const char* nodes, const char* resources, const char* histories, const char* inputs,
                          const char* tables) {
        needed.nodes += std::string(" ") + nodes;
        needed.resources += std::string(" ") + resources;
        needed.histories += std::string(" ") + histories;
        needed.inputs += std::string(" ") + inputs;
        needed.tables += std::string(" ") + tables;
    };
    const bool traced = shadow == Shadow::soft || shadow == Shadow::hard;
    const bool many = pipeline == "many_rays", fast = pipeline == "hybrid_shadows_fast";
    const bool main = fast || pipeline == "hybrid_shadows";
    const bool covers = shadow == Shadow::soft && (main || pipeline == "covered");
    const bool budget = pipeline == "shadows", proves = budget && shadow == Shadow::soft;
    if (traced)
        also(budget && !proves ? "classify_all" : "classify", "receiver_normal receiver_words", "",
             "scene scene.nodes scene.leaves", "");
    if (traced && budget)
        also(shadow == Shadow::soft ? "trace" : "trace_all", "candidates candidate_args", "", "", "");
    if (traced && budget && shadow == Shadow::soft)
        also("survey pilots worth allot refine",
             "tile_list trace_args known pixel_counts ray_words ray_budget classes gains further_tiles "
             "further_args "
             "ray_bits frame_worth",
             "", "", "");
    if (proves) also("beams", "unproved unproved_args facing_hits proved", "proved", "neighbours", "");
    if (traced && !budget && (!covers || main)) also("trace", "tile_list trace_args", "", "", "");
    if (traced && alpha) also("", "", "", "scene.alpha_uv scene.alpha_map", "");
    if (shadow == Shadow::soft) also("", "", "", "", "blue_noise");
    if (shadow == Shadow::none) also("open", "", "", "", "");
    if (shadow == Shadow::all) also("night", "", "", "", "");
    // One buffer of hits, named by who fills it first.
    if (traced && (main || many || pipeline == "covered"))
        also("", "facing facing_args facing_hits proved", "proved", "neighbours", "");
    if (covers)
        also("cover", "candidates candidate_args coverage", "", "",
             "half_planes_64 half_planes_128 half_planes_256 light_samples");
    const bool recalls = covers && fast && !row.casters_move && !sun_moves;
    if (recalls)
        also("beams_first recall", "unproved unproved_args uneven", "facing_hits receiver_words uneven", "",
             "");
    else if (covers)
        also("beams", "", "", "", "");
    else if (traced && (main || pipeline == "covered"))
        also("beams_alone", "", "", "", "");
    else if (traced && many)
        also("beams", shadow == Shadow::soft ? "fraction" : "", "", "", "");
    else if (traced && !proves)
        also("", "preloaded_hits", "", "", "");
    if (covers && main) also("", "fraction given_up", "given_up", "", "");
    if (pipeline == "covered" && covers && !moves && !sun_moves) {
        also("resolve_still average", "fresh mean", "mean", "", "");
        return needed;
    }
    if (pipeline == "covered" || main) {
        if (traced) also("resolve", "", "", "", "");
        if (!main) return needed;
    }
    if (pipeline == "raw" || many) {
        if (traced) also("resolve", "", "", "", "");
        return needed;
    }
    also("taa", "color", "color", "", "");
    if (moves) also("", "", "view_depth", "motion", "");
    if (main) return needed;
    if (shadow == Shadow::hard) also("hard", "", "", "", "");
    if (shadow == Shadow::soft) {
        also("prepare gather drift soften",
             "visibility_words sunward_words ray_points blockers block_blockers gathered cells idle_cells "
             "state",
             "state idle_cells", "", "edge_patterns");
        if (moves) also("", "", "guide_normal", "", "");
        if (sun_moves) also("", "", "", "sun_prev", "");
    }
    return needed;
}

// ---- what does run

// The shipped pipeline under a patch (RFC 7396).
CheckedPipeline pipeline_with(const std::string& name, const std::string& patch = "") {
    Diagnostics diagnostics;
    const std::string file = PENUMBRA_SOURCE_DIR "/pipelines/patch.json";  // beside what it extends
    const auto pipeline =
        parse_pipeline("{ \"extends\": \"" + name + ".json\"" + (patch.empty() ? "" : ", " + patch) + " }",
                       file, {}, diagnostics);
    auto result = pipeline ? check(*pipeline, shipped_nodes(), diagnostics) : std::nullopt;
    if (!result) throw std::runtime_error(diagnostics.text());
    return std::move(*result);
}

Facts facts_of(const FactScene& row) {
    return shot_facts(row.shot, Scene(row.shot.analytic ? analytic_model(row.shot) : row.model, row.shot));
}

Plan plan_of(const CheckedPipeline& pipeline, const Facts& facts) {
    Diagnostics diagnostics;
    DeviceTable device = reference_device();
    if (const auto tree = facts.find("tree"); tree != facts.end() && !tree->second)
        device.features = {"ray_query"};  // rays without a tree of ours are the device's
    Target target = standalone_target(pipeline, device, {320, 180}, facts);
    target.jitters = false;  // which makes facts of its own
    auto plan = compile(pipeline, target, {}, diagnostics);
    if (!plan) throw std::runtime_error(diagnostics.text());
    return std::move(*plan);
}

Plan plan_of(const std::string& name, const Facts& facts, const std::string& patch = "") {
    return plan_of(pipeline_with(name, patch), facts);
}

Needed used_by(const Plan& plan) {
    Needed used;
    for (const PlanPass& pass : plan.passes) {
        used.nodes += pass.node + " ";
        for (const PlanBinding& binding : pass.bindings)
            if (binding.source == BindingSource::table) used.tables += binding.port + " ";
    }
    for (const PlanResource& r : plan.resources) {
        used.resources += r.names.front() + " ";
        if (r.history) used.histories += r.names.front() + " ";
    }
    for (const HostSlot& slot : plan.slots) used.inputs += slot.name + " ";
    return used;
}

TEST(SceneFacts, AreMeasuredOnTheScene) {
    for (const FactScene& row : fact_scenes()) {
        SCOPED_TRACE(row.name);
        const Facts facts = facts_of(row);
        EXPECT_EQ(facts.size(), shadow_domain()->facts.size());
        for (const Fact& fact : shadow_domain()->facts) EXPECT_TRUE(facts.contains(fact.name)) << fact.name;
        EXPECT_EQ(facts.at("moves"), row.moves);
        EXPECT_EQ(facts.at("alpha"), row.alpha);
        EXPECT_EQ(facts.at("sun_moves"), row.sun_moves);
        EXPECT_EQ(facts.at("casters_move"), row.casters_move);
        EXPECT_EQ(facts.at("sun_up"), row.shadow != Shadow::all);
        if (row.shadow == Shadow::all) continue;  // night asks for no more
        EXPECT_EQ(facts.at("casters"), row.shadow != Shadow::none);
        if (row.shadow == Shadow::none) continue;
        EXPECT_EQ(facts.at("sun_disc"), row.shadow == Shadow::soft);
    }
}

TEST(SceneFacts, WhatRunsIsWhatTheSceneNeeds) {
    const std::vector<FactScene> rows = fact_scenes();
    EXPECT_GE(rows.size(), 24u);
    for (const FactScene& row : rows)
        for (const char* pipeline :
             {"raw", "one_ray", "shadows", "many_rays", "covered", "hybrid_shadows", "hybrid_shadows_fast"}) {
            SCOPED_TRACE(testing::Message() << row.name << ", " << pipeline);
            const Needed needed = needed_by(pipeline, row);
            const Needed used = used_by(plan_of(pipeline, facts_of(row)));
            EXPECT_EQ(words(used.nodes), words(needed.nodes));
            EXPECT_EQ(words(used.resources), words(needed.resources));
            EXPECT_EQ(words(used.histories), words(needed.histories));
            EXPECT_EQ(words(used.inputs), words(needed.inputs));
            EXPECT_EQ(words(used.tables), words(needed.tables));
        }
}

bool runs(const Plan& plan, const std::string& node) {
    return std::ranges::any_of(plan.passes, [&](const PlanPass& pass) { return pass.node == node; });
}

// The plan as text, but for the list of what was left out.
std::string without_culled(const Plan& plan) {
    std::istringstream lines(to_text(plan));
    std::string text;
    for (std::string line; std::getline(lines, line);)
        if (!line.starts_with("  culled ")) text += line + "\n";
    return text;
}

// The nodes that were left out are deleted from the pipeline: passes, bytes, offsets and barriers stay as
// they are.
TEST(SceneFacts, AFeatureThatIsOffCostsNoPassAndNoByte) {
    std::set<std::pair<std::string, Facts>> seen;
    for (const FactScene& row : fact_scenes())
        for (const std::string pipeline :
             {"raw", "one_ray", "shadows", "many_rays", "covered", "hybrid_shadows", "hybrid_shadows_fast"}) {
            const Facts facts = facts_of(row);
            if (!seen.insert({pipeline, facts}).second) continue;
            SCOPED_TRACE(testing::Message() << row.name << ", " << pipeline);
            const Plan plan = plan_of(pipeline, facts);
            std::string deleted;
            for (const Culled& culled : plan.culled) deleted += "\"" + culled.node + "\": null, ";
            for (const BoundNode& node : pipeline_with(pipeline).nodes)
                if (runs(plan, node.id))
                    deleted += "\"" + node.id + "\": { \"if\": null" +
                               (node.id == "recall" ? R"(, "in": { "reuse_words_prev": null })" : "") +
                               " }, ";
            deleted.resize(deleted.size() - 2);
            // A resource whose format was chosen goes with the node that wrote it.
            const bool fresh = pipeline == "covered" && !runs(plan, "resolve_still");
            const Plan never_had = plan_of(
                pipeline, facts,
                (fresh ? R"("resources": { "fresh": null }, )" : "") + ("\"nodes\": { " + deleted + " }"));
            EXPECT_EQ(without_culled(plan), without_culled(never_had));
            EXPECT_EQ(plan.memory.heap_bytes, never_had.memory.heap_bytes);
            EXPECT_TRUE(never_had.culled.empty());
        }
    EXPECT_GE(seen.size(), 12u);
}

// Where the visibility alone is asked for, a scene without shadows of its own is one pass and one image.
TEST(SceneFacts, OneClearIsAllThatANightNeeds) {
    for (const Facts& facts : {Facts{{"sun_up", false}}, Facts{{"casters", false}}}) {
        const Plan plan = plan_of("shadows", facts, R"("outputs": ["visibility"])");
        ASSERT_EQ(plan.passes.size(), 1u);
        EXPECT_EQ(plan.passes[0].type, "clear");
        EXPECT_EQ(plan.resources.size(), 1u);
        EXPECT_TRUE(plan.slots.empty());
        EXPECT_EQ(plan.memory.heap_bytes, plan.resources[0].bytes);
    }
}

std::vector<std::string> shipped_pipelines() {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(PENUMBRA_SOURCE_DIR "/pipelines"))
        if (entry.path().extension() == ".json" && entry.path().stem().extension() != ".schema")
            names.push_back(entry.path().stem().string());
    return names;
}

// What the facts settle of a pipeline in one case of FactCases: equal where the plan is the same.
std::vector<bool> settled(const CheckedPipeline& pipeline, size_t in_case) {
    std::vector<bool> there;
    for (size_t i = 0; i < pipeline.domain->facts.size(); ++i)
        if (const std::string& fact = pipeline.domain->facts[i].name; fact == "alpha" || fact == "tree")
            there.push_back((in_case >> i & 1) != 0);  // which slots and the device depend on
    for (const BoundNode& node : pipeline.nodes) {
        there.push_back(node.cases[in_case]);
        for (const FactCases& cases : node.tables) there.push_back(cases[in_case]);
        for (const BoundPort& port : node.ports) there.push_back(port.cases[in_case]);
    }
    return there;
}

// Under every combination of facts, every shipped pipeline has a plan in which nothing overlaps or races.
TEST(SceneFacts, EveryCombinationHasASoundPlan) {
    for (const std::string& name : shipped_pipelines()) {
        const CheckedPipeline pipeline = pipeline_with(name);
        const std::vector<Fact>& facts = pipeline.domain->facts;
        std::set<std::vector<bool>> seen;
        for (size_t in_case = 0; in_case < size_t{1} << facts.size(); ++in_case) {
            if (!seen.insert(settled(pipeline, in_case)).second) continue;
            Facts given;
            std::string names;
            for (size_t i = 0; i < facts.size(); ++i) {
                given[facts[i].name] = (in_case >> i & 1) != 0;
                if (given[facts[i].name]) names += " " + facts[i].name;
            }
            SCOPED_TRACE(name + names);
            const Plan plan = plan_of(pipeline, given);
            EXPECT_EQ(overlap_errors(plan), std::vector<std::string>{});
            EXPECT_EQ(hazard_errors(plan), std::vector<std::string>{});
        }
    }
}

// Whose past is each pixel's own where nothing moves.
TEST(SceneFacts, WhatKeepsPixelsMovesWhereTheyAreJittered) {
    const auto moves = [](const char* name, bool jitters) {
        const CheckedPipeline pipeline = pipeline_with(name);
        Target target = standalone_target(pipeline, reference_device(), {320, 180},
                                          {{"moves", false}, {"sun_moves", false}});
        target.jitters = jitters;
        Diagnostics diagnostics;
        const auto plan = compile(pipeline, target, {}, diagnostics);
        if (!plan) throw std::runtime_error(diagnostics.text());
        return plan->facts.at("moves");
    };
    for (const char* name : {"shadows", "one_ray", "denoise", "covered", "lit", "reflections", "indirect"}) {
        EXPECT_TRUE(moves(name, true)) << name;
        EXPECT_FALSE(moves(name, false)) << name;
    }
    for (const char* name : {"hybrid_shadows", "many_rays", "lights"})
        EXPECT_FALSE(moves(name, true)) << name;
}

TEST(SceneFacts, MemoryShrinksWithTheScene) {
    const auto heap = [](const Facts& facts) { return plan_of("shadows", facts).memory.heap_bytes; };
    const uint64_t all = heap({}), still = heap({{"moves", false}}), hard = heap({{"sun_disc", false}}),
                   night = heap({{"sun_up", false}});
    EXPECT_LT(still, all);
    EXPECT_LT(hard, all);
    EXPECT_LT(night, hard);
}

}  // namespace
}  // namespace penumbra::test
