// SPDX-License-Identifier: MIT
// The backends of the node trace. A plan says which one a pass runs with, and `auto` never picks ray queries
// on a CPU; both give the same hit words, except where double precision says that a ray meets an edge.
#include <bit>
#include <set>

#include "app/commands.h"
#include "graph/interface.h"
#include "penumbra/dump.h"
#include "tests/alpha_oracle.h"
#include "tests/gpu_test.h"
#include "tests/ray_maker.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/test_folder.h"
#include "tests/test_scene.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

const std::filesystem::path root = PENUMBRA_SOURCE_DIR;

CheckedPipeline raw_with(const std::string& backend) {
    return shipped_pipeline("raw", {"nodes.trace.params.backend=" + backend});
}

DeviceTable table(bool cpu, bool ray_query) {
    DeviceTable device = reference_device(cpu);
    if (ray_query) device.features.insert("ray_query");
    return device;
}

std::set<std::string> scene_slots_of(const Plan& plan) {
    std::set<std::string> names;
    for (const HostSlot& slot : plan.slots)
        if (slot.name.starts_with("scene")) names.insert(slot.name);
    return names;
}

const std::set<std::string> tree_slots = {"scene.nodes", "scene.leaves", "scene"},
                            query_slots = {"scene.tlas", "scene"};

TEST(TraceBackend, AutoIsRayQueryWhereTheDeviceHasItAndIsNotACpu) {
    for (const bool cpu : {false, true})
        for (const bool ray_query : {false, true})
            for (const char* asked : {"auto", "bvh", "ray_query"}) {
                if (asked == std::string("ray_query") && !ray_query) continue;
                SCOPED_TRACE(testing::Message() << asked << " cpu " << cpu << " ray_query " << ray_query);
                const bool queries =
                    asked == std::string("ray_query") || (asked == std::string("auto") && ray_query && !cpu);
                Diagnostics diagnostics;
                const CheckedPipeline raw = raw_with(asked);
                const auto plan =
                    compile(raw, standalone_target(raw, table(cpu, ray_query), {64, 32}, {{"alpha", false}}),
                            {}, diagnostics);
                ASSERT_TRUE(plan) << diagnostics.text();
                EXPECT_EQ(scene_slots_of(*plan), queries ? query_slots : tree_slots);
                EXPECT_NE(to_text(*plan).find(queries ? "backend ray_query" : "backend bvh"),
                          std::string::npos);
            }
}

// A device that loads texels faster than it fetches them reads the same buffers otherwise: the host binds
// what it always does.
TEST(TraceBackend, TheTreeIsFetchedOrLoadedFromTheSameSlots) {
    for (const auto& [loads, alpha] : {std::pair{false, false}, {true, false}, {false, true}, {true, true}}) {
        SCOPED_TRACE(loads);
        SCOPED_TRACE(alpha);
        DeviceTable device = table(true, false);
        device.loads_texels = loads;
        Diagnostics diagnostics;
        const CheckedPipeline raw = raw_with("bvh");
        const auto plan =
            compile(raw, standalone_target(raw, device, {64, 32}, {{"alpha", alpha}}), {}, diagnostics);
        ASSERT_TRUE(plan) << diagnostics.text();
        std::set<std::string> slots = tree_slots;
        if (alpha) slots.insert({"scene.alpha_map", "scene.alpha_uv"});
        EXPECT_EQ(scene_slots_of(*plan), slots);
        size_t bound = 0;
        for (const PlanPass& pass : plan->passes)
            for (const PlanBinding& b : pass.bindings) {
                if (b.source != BindingSource::host || plan->slots[b.index].kind != PortKind::texels)
                    continue;
                ++bound;
                EXPECT_EQ(b.type, loads ? VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER
                                        : VK_DESCRIPTOR_TYPE_UNIFORM_TEXEL_BUFFER);
                EXPECT_TRUE(plan->slots[b.index].use.access & (loads ? VK_ACCESS_2_SHADER_STORAGE_READ_BIT
                                                                     : VK_ACCESS_2_SHADER_SAMPLED_READ_BIT));
            }
        EXPECT_EQ(bound, alpha ? 4u : 2u);
    }
}

// A device whose texel buffers are small reads them as plain ones, whatever it is faster at.
TEST(TraceBackend, NoTexelsAreBoundWhereTheyAreFew) {
    for (const bool loads : {false, true}) {
        SCOPED_TRACE(loads);
        DeviceTable device = table(true, false);
        device.loads_texels = loads;
        device.max_texel_elements = 65536;
        Diagnostics diagnostics;
        const CheckedPipeline raw = raw_with("bvh");
        const auto plan = compile(raw, standalone_target(raw, device, {64, 32}, {}), {}, diagnostics);
        ASSERT_TRUE(plan) << diagnostics.text();
        EXPECT_TRUE(std::ranges::none_of(plan->slots,
                                         [](const HostSlot& slot) { return slot.kind == PortKind::texels; }));
    }
}

TEST(TraceBackend, ForcingRayQueriesOnADeviceWithoutThemIsAnError) {
    Diagnostics diagnostics;
    const CheckedPipeline raw = raw_with("ray_query");
    EXPECT_FALSE(compile(raw, standalone_target(raw, table(false, false), {64, 32}, {}), {}, diagnostics));
    const std::string text = diagnostics.text();
    EXPECT_EQ(diagnostics.size(), 1u) << text;
    EXPECT_NE(text.find("nodes.trace.params.backend"), std::string::npos) << text;
    EXPECT_NE(text.find("lacks ray_query"), std::string::npos) << text;
}

NodeType declared(const std::string& params, const std::string& condition, Diagnostics& diagnostics) {
    const std::string text =
        R"({ "node": "t", "doc": "d", "shader": "t.comp", "inputs": { "scene": { "kind": "scene" },
        "extra": { "kind": "block", "element": "Sun")" +
        condition + R"( } },
        "outputs": { "o": { "kind": "image", "format": "r32f" } }, "dispatch": { "over": "frame" },
        "params": { "backend": )" +
        params + " } }";
    const auto json = parse_json(text, "t.json", diagnostics);
    auto type = json ? parse_node_type(*json, "t", shadow_domain(), diagnostics) : std::nullopt;
    return type.value_or(NodeType{});
}

TEST(TraceBackend, DeclarationsOfABackendAreChecked) {
    const std::string good =
        R"({ "type": "enum", "values": ["auto", "bvh", "ray_query"], "default": "auto", "constant": true, "doc": "d" })";
    Diagnostics diagnostics;
    const NodeType type = declared(good, "", diagnostics);
    ASSERT_TRUE(diagnostics.empty()) << diagnostics.text();
    std::vector<std::string> keys;
    for (const Variant& variant : all_variants(type)) {
        keys.push_back(to_string(variant));
        const std::string glsl = generate_glsl(type, variant);
        const bool queries = variant.backends.at("backend") == "ray_query";
        EXPECT_EQ(glsl.find("GL_EXT_ray_query") != std::string::npos, queries);
        EXPECT_EQ(glsl.find("scene_tlas") != std::string::npos, queries);
        EXPECT_EQ(glsl.find("scene_nodes") != std::string::npos, !queries);
    }
    EXPECT_EQ(keys, (std::vector<std::string>{"backend=bvh", "backend=ray_query"}));

    for (
        const auto& [params, condition] : std::vector<std::pair<std::string, std::string>>{
            {R"({ "type": "enum", "values": ["bvh", "embree"], "default": "bvh", "constant": true, "doc": "d" })",
             ""},
            {R"({ "type": "enum", "values": ["bvh"], "default": "bvh", "doc": "d" })", ""},
            {R"({ "type": "int", "default": 0, "constant": true, "doc": "d" })", ""},
            {good, R"(, "if": "backend=bvh")"},
            {good +
                 R"(}, "tables": { "n": { "file": "n", "format": "r8", "extent": [1, 1], "if": "backend=bvh" })",
             ""}}) {
        Diagnostics errors;
        declared(params, condition, errors);
        EXPECT_EQ(errors.size(), 1u) << params << condition << "\n" << errors.text();
    }
}

// One pipeline with both, side by side: the scene's block is one slot for two passes with different bindings.
CheckedPipeline both_backends() {
    return shadow_pipeline(R"({
  "penumbra": 1, "name": "both", "doc": "The same rays by both backends.",
  "inputs": { "depth": {}, "normal": {}, "sun": {}, "scene": {} },
  "outputs": ["visibility", "visibility_query"],
  "nodes": {
    "guides":     { "type": "guides" },
    "classify":   { "type": "classify" },
    "trace":      { "type": "trace", "params": { "backend": "bvh" } },
    "resolve":    { "type": "resolve" },
    "classify_q": { "type": "classify", "out": { "tile_list": "list_q", "trace_args": "args_q", "preloaded_hits": "preloaded_q", "receiver_words": "receivers_q" } },
    "trace_q":    { "type": "trace", "in": { "tile_list": "list_q", "trace_args": "args_q", "preloaded_hits": "preloaded_q" },
                    "out": { "hits": "hits_q" }, "params": { "backend": "ray_query" } },
    "resolve_q":  { "type": "resolve", "in": { "hits": "hits_q", "receiver_words": "receivers_q" }, "out": { "visibility": "visibility_query" } }
  }
})");
}

struct Comparison {
    size_t rays = 0, blocked = 0, differ = 0;
    size_t differ_anywhere = 0;  // decided pixels too
};

// Steps through a shot and judges every ray that the two disagree about.
Comparison compare_backends(const Shot& shot, const std::vector<uint32_t>& frames) {
    SessionOptions options;
    options.size = shot.size;
    options.captures = {"view_depth", "receiver_normal", "tile_list", "trace_args", "hits", "hits_q"};
    const auto session = open_session(both_backends(), shot, options);
    Comparison sum;
    for (const uint32_t frame : frames) {
        session->run_frame(frame, frame == frames.front());
        const StandaloneFrame standalone = session->host().frame(frame, frame == frames.front());
        const RayMaker maker(*session, shipped_nodes(), standalone);
        const std::vector<Triangle> triangles = session->host().scene().triangles(frame);
        const AlphaOracle alpha(session->host().scene());
        const auto depth = captured_values<float>(*session, "view_depth");
        const auto normal = captured_values<NormalTexel>(*session, "receiver_normal");
        const auto tree = captured_values<uint32_t>(*session, "hits"),
                   query = captured_values<uint32_t>(*session, "hits_q");
        const auto list = captured_values<std::array<uint32_t, 4>>(*session, "tile_list");
        const uint32_t listed = captured_values<uint32_t>(*session, "trace_args")[3],
                       tiles_x = (shot.size[0] + 7) / 8;
        for (uint32_t i = 0; i < listed; ++i) {
            const uint32_t tile_x = list[i][0] & 0xffff, tile_y = list[i][0] >> 16,
                           word = tile_y * tiles_x + tile_x;
            const uint32_t traced = list[i][1], differing = (tree[word] ^ query[word]) & traced;
            sum.rays += std::popcount(traced);
            sum.blocked += std::popcount(tree[word] & traced);
            sum.differ += std::popcount(differing);
            for (uint32_t bit = 0; bit < 32; ++bit) {
                if ((differing >> bit & 1) == 0) continue;
                const uint32_t x = tile_x * 8 + bit % 8, y = tile_y * 4 + bit / 8,
                               pixel = y * shot.size[0] + x;
                // What is near the start the tree asks the viewer about, and ray queries start beyond.
                const Ray ray = maker.ray(x, y, depth[pixel], normal[pixel]),
                          past = maker.past_what_is_asked(ray, x, y, depth[pixel], normal[pixel]);
                const Truth whole = alpha.truth(triangles, ray, 8e-6);
                EXPECT_TRUE(whole == Truth::either || whole != alpha.truth(triangles, past, 8e-6))
                    << "pixel " << x << ", " << y << " of frame " << frame << ", the tree's word "
                    << tree[word];
            }
        }
        for (size_t i = 0; i < tree.size(); ++i) sum.differ_anywhere += std::popcount(tree[i] ^ query[i]);
    }
    EXPECT_EQ(sum.differ_anywhere, sum.differ) << "the words differ in pixels that were not traced";
    std::printf("%s: %zu rays, %zu blocked, %zu differ\n", shot.name.c_str(), sum.rays, sum.blocked,
                sum.differ);
    return sum;
}

class TraceBackendRun : public GpuTest {};

#define NEEDS_RAY_QUERIES()      \
    if (!gpu().caps().ray_query) \
    GTEST_SKIP() << gpu().info().name << " (" << gpu().info().driver << ") has no VK_KHR_ray_query"

TEST_F(TraceBackendRun, BothGiveTheSameWordsWhileThingsMove) {
    NEEDS_RAY_QUERIES();
    const Comparison seen = compare_backends(plaza_shot({128, 72}, 8), {0, 1, 2, 7});
    EXPECT_GT(seen.rays, 20'000u);
    EXPECT_GT(seen.blocked, seen.rays / 100);
    EXPECT_LT(seen.differ, seen.rays / 1000);
}

// A session that starts in the middle finds its objects where they are then, by either backend. The block
// stands far away in frame 0 and shades the floor in frame 16.
class ColdStart : public GpuTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(ColdStart, TracesWhereThingsAreNow) {
    if (GetParam() == std::string("ray_query")) NEEDS_RAY_QUERIES();
    Shot shot = plaza_shot({96, 54}, 17);
    shot.objects["block"].keys = {{0, {300, 0, 0}, {0, 0, 0}}, {16, {1, 1, 1}, {0, 20, 0}}};
    SessionOptions options;
    options.size = shot.size;
    options.captures = {"view_depth", "receiver_normal", "tile_list", "trace_args", "hits"};
    const auto session = open_session(raw_with(GetParam()), shot, options);
    session->run_frame(16, true);
    const StandaloneFrame standalone = session->host().frame(16, true);
    const RayMaker maker(*session, shipped_nodes(), standalone);
    const std::vector<Triangle> now = session->host().scene().triangles(16),
                                at_first = session->host().scene().triangles(0);
    const auto depth = captured_values<float>(*session, "view_depth");
    const auto normal = captured_values<NormalTexel>(*session, "receiver_normal");
    const auto hits = captured_values<uint32_t>(*session, "hits");
    const auto list = captured_values<std::array<uint32_t, 4>>(*session, "tile_list");
    const uint32_t listed = captured_values<uint32_t>(*session, "trace_args")[3];
    size_t wrong = 0, wrong_at_first = 0;
    for (uint32_t i = 0; i < listed; ++i) {
        const uint32_t tile_x = list[i][0] & 0xffff, tile_y = list[i][0] >> 16;
        for (uint32_t bit = 0; bit < 32; ++bit) {
            if ((list[i][1] >> bit & 1) == 0) continue;
            const uint32_t x = tile_x * 8 + bit % 8, y = tile_y * 4 + bit / 8, pixel = y * 96 + x;
            const Ray ray = maker.ray(x, y, depth[pixel], normal[pixel]);
            const Truth opposite =
                (hits[tile_y * 12 + tile_x] >> bit & 1) != 0 ? Truth::clear : Truth::blocked;
            wrong += truth(now, ray, 1e-6) == opposite;
            wrong_at_first += truth(at_first, ray, 1e-6) == opposite;
        }
    }
    EXPECT_EQ(wrong, 0u);
    EXPECT_GT(wrong_at_first, 10u) << "the test would not see a tree of the first frame";
}

INSTANTIATE_TEST_SUITE_P(Backends, ColdStart, ::testing::Values("bvh", "ray_query"),
                         [](const auto& test) { return std::string(test.param); });

TEST_F(TraceBackendRun, BothGiveTheSameWordsInAColonnade) {
    NEEDS_RAY_QUERIES();
    Shot shot = shot_named("colonnade");
    shot.size = {160, 90};
    const Comparison seen = compare_backends(shot, {0, 1});
    EXPECT_GT(seen.rays, 5'000u);
    EXPECT_GT(seen.blocked, seen.rays / 100);
    EXPECT_LT(seen.differ, seen.rays / 500);
}

// Opaque and alpha-tested triangles are structures of their own for ray queries, pairs of the tree hold both;
// and one tree moves.
TEST_F(TraceBackendRun, BothSeeTheSameHolesInLeafCards) {
    NEEDS_RAY_QUERIES();
    Shot shot = shot_named("cards");
    shot.size = {160, 90};
    shot.objects["tree_0"].keys = {{0, {0, 0, 0}, {0, 0, 0}}, {8, {1.5, 0, 0.5}, {0, 50, 0}}};
    const Comparison seen = compare_backends(shot, {0, 1, 7});
    EXPECT_GT(seen.rays, 15'000u);
    EXPECT_GT(seen.blocked, seen.rays / 100);
    EXPECT_LT(seen.differ, seen.rays / 500);
}

TEST_F(TraceBackendRun, AutoOnThisDeviceFollowsTheRule) {
    SessionOptions options;
    options.size = {64, 32};
    const auto session = open_session(raw_with("auto"), plaza_shot({64, 32}, 1), options);
    const bool queries = gpu().caps().ray_query && !gpu().info().is_cpu;
    EXPECT_EQ(scene_slots_of(session->plan()), queries ? query_slots : tree_slots);
}

TEST_F(TraceBackendRun, TheProgramRefusesRayQueriesThatTheDeviceLacks) {
    if (gpu().caps().ray_query) GTEST_SKIP() << gpu().info().name << " has VK_KHR_ray_query";
    const TestFolder folder;
    RenderArguments arguments;
    arguments.files = {(root / "pipelines/raw.json").string()};
    arguments.view.shot = (root / "scenes/colonnade.shot.json").string();
    arguments.out = folder.string();
    arguments.size = "64x32";
    arguments.settings = {"nodes.trace.params.backend=ray_query"};
    testing::internal::CaptureStderr();
    const int code = run_render(arguments);
    const std::string text = testing::internal::GetCapturedStderr();
    EXPECT_EQ(code, exit_wrong);
    EXPECT_NE(text.find("lacks ray_query"), std::string::npos) << text;
    EXPECT_FALSE(std::filesystem::exists(folder / "report.json"));
}

}  // namespace
}  // namespace penumbra::test
