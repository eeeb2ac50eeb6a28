// SPDX-License-Identifier: MIT
// What a tile remembers of the frame before spares walks and changes no answer: the bits are those of rays
// that remember nothing, on moving objects, through holes, after a reset, with any workgroup, and with
// garbage for a memory, such as leaves that the tree does not have.
#include <algorithm>
#include <bit>

#include "app/session.h"
#include "nodes/nodes.h"
#include "tests/gpu_test.h"
#include "tests/test_scene.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

const std::filesystem::path root = PENUMBRA_SOURCE_DIR;

CheckedPipeline load(const std::string& name, const NodeSet& nodes,
                     const std::vector<std::string>& settings) {
    Diagnostics diagnostics;
    const auto pipeline = load_pipeline(root / "pipelines" / (name + ".json"), settings, diagnostics);
    auto checked = pipeline ? check(*pipeline, nodes, diagnostics) : std::nullopt;
    if (!checked) throw std::runtime_error(diagnostics.text());
    return std::move(*checked);
}

Shot shipped(const char* name) {
    Diagnostics diagnostics;
    auto shot = read_shot(root / "scenes" / (std::string(name) + ".shot.json"), diagnostics);
    if (!shot) throw std::runtime_error(diagnostics.text());
    shot->size = {200, 113};
    return *shot;
}

struct Frame {
    std::vector<uint32_t> hits;
    uint32_t rays = 0, ended_early = 0;

    uint32_t blocked() const {
        uint32_t n = 0;
        for (const uint32_t word : hits) n += static_cast<uint32_t>(std::popcount(word));
        return n;
    }
};

struct Variant {
    bool remember = true;
    std::optional<uint32_t> poison;
    std::string pipeline = "raw";
    std::vector<std::string> settings;
};

// Frames 0, 1, 2, 3, with a reset before the first and before frame 2.
std::vector<Frame> run(const NodeSet& nodes, const Shot& shot, const Variant& variant) {
    SessionOptions options;
    options.size = shot.size;
    options.optimum = false;
    options.cascade_size = 256;
    options.captures = {"hits"};
    options.poison = variant.poison;
    std::vector<std::string> settings = variant.settings;
    if (variant.remember) settings.push_back("nodes.trace.params.remember=true");
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto session = Session::open(gpu(), nodes, load(variant.pipeline, nodes, settings), shot, options,
                                       diagnostics, warnings);
    if (!session) throw std::runtime_error(diagnostics.text());
    std::vector<Frame> frames;
    for (uint32_t frame = 0; frame < 4; ++frame) {
        session->run_frame(frame, frame % 2 == 0);
        const auto counted = counters_of(session->view(), "trace");
        frames.push_back(
            {captured<uint32_t>(session->view(), "hits"), counted.at("rays"), counted.at("ended_early")});
    }
    return frames;
}

// The node trace, changed.
template <class Change>
NodeSet with_trace(const Change& change) {
    NodeSet nodes = shadow_nodes();
    NodeEntry trace = *nodes.find("trace");
    change(trace.type);
    nodes.add(std::move(trace));
    return nodes;
}

// `least`: share of the blocked pixels, those that face away among them, that must end early after one frame
// to learn from.
void expect_the_same_bits(const std::vector<Frame>& remembering, const std::vector<Frame>& forgetful,
                          double least) {
    for (size_t f = 0; f < forgetful.size(); ++f) {
        EXPECT_TRUE(remembering[f].hits == forgetful[f].hits) << "frame " << f;
        EXPECT_EQ(remembering[f].rays, forgetful[f].rays) << "a ray that ends early is one";
        EXPECT_EQ(forgetful[f].ended_early, 0u);
        EXPECT_LE(remembering[f].ended_early, forgetful[f].blocked());
        if (f % 2 == 0) {
            EXPECT_EQ(remembering[f].ended_early, 0u) << "a reset forgets";
        } else {
            EXPECT_GT(remembering[f].ended_early, least * forgetful[f].blocked()) << "frame " << f;
        }
    }
}

class BlockingLeaves : public GpuTest {};

TEST_F(BlockingLeaves, SpareWalksAndChangeNoAnswerOnMovingObjects) {
    const NodeSet nodes = shadow_nodes();
    const Shot shot = plaza_shot({160, 96}, 8);
    expect_the_same_bits(run(nodes, shot, {}), run(nodes, shot, {.remember = false}), 0.15);
}

TEST_F(BlockingLeaves, SpareWalksAndChangeNoAnswerThroughHoles) {
    const NodeSet nodes = shadow_nodes();
    const Shot shot = shipped("cards");
    expect_the_same_bits(run(nodes, shot, {}), run(nodes, shot, {.remember = false}), 0.15);
}

// Four subgroups of a device with eight lanes share a tile and its memory.
TEST_F(BlockingLeaves, ChangeNoAnswerWhateverTheWorkgroup) {
    const NodeSet nodes = shadow_nodes(), wide = with_trace([](NodeType&type) { type.cpu = {}; });
    const Shot shot = shipped("colonnade");
    const std::vector<Frame> expected = run(nodes, shot, {.remember = false});
    expect_the_same_bits(run(nodes, shot, {}), expected, 0.1);
    expect_the_same_bits(run(wide, shot, {}), expected, 0.1);
    const std::vector<Frame> wide_forgetful = run(wide, shot, {.remember = false});
    for (size_t f = 0; f < expected.size(); ++f) EXPECT_TRUE(wide_forgetful[f].hits == expected[f].hits);
}

// Shadow maps bound the rays, and the bounded ones start at the far end.
TEST_F(BlockingLeaves, ChangeNoAnswerOfReversedRays) {
    Shot shot = shipped("colonnade");
    shot.size = {128, 72};
    const NodeSet nodes = shadow_nodes();
    Variant reversed{.pipeline = "hybrid_cascades_raw", .settings = {"nodes.trace.params.reverse=true"}};
    const std::vector<Frame> remembering = run(nodes, shot, reversed);
    reversed.remember = false;
    expect_the_same_bits(remembering, run(nodes, shot, reversed), 0.02);
}

// A memory that does not last: what the heap holds there, or a pattern in every word. Leaves that the tree
// lacks, the last one that a word can name, and one that is not what blocked here.
TEST_F(BlockingLeaves, ChangeNoAnswerWhateverTheyAre) {
    const NodeSet nodes = shadow_nodes(), garbage = with_trace([](NodeType&type) {
                                              for (Port& port : type.ports)
                                                  if (port.name == "blocking_leaves")
                                                      port.writes = Writes::all;
                                          });
    for (const Shot& shot : {plaza_shot({160, 96}, 8), shipped("cards")}) {
        const std::vector<Frame> expected = run(nodes, shot, {.remember = false});
        for (const std::optional<uint32_t> pattern :
             {std::optional<uint32_t>(), std::optional(0xffffffffu), std::optional(0x80000000u),
              std::optional(1000000u), std::optional(3u)}) {
            const std::vector<Frame> frames = run(garbage, shot, {.poison = pattern});
            for (size_t f = 0; f < expected.size(); ++f)
                EXPECT_TRUE(frames[f].hits == expected[f].hits)
                    << shot.name << ", frame " << f << ", " << pattern.value_or(0);
        }
    }
}

// What is not asked for costs nothing; nor can several rays per pixel ask.
TEST_F(BlockingLeaves, ExistWhereOneRayAsksForThem) {
    const NodeSet nodes = shadow_nodes();
    const auto exist = [&](const std::vector<std::string>& settings) {
        Target target;
        target.extent = {160, 96};
        target.device = reference_device();
        Diagnostics diagnostics;
        const auto plan = compile(load("raw", nodes, settings), target, {}, diagnostics);
        if (!plan) throw std::runtime_error(diagnostics.text());
        for (const PlanResource& r : plan->resources)
            if (std::ranges::find(r.names, "blocking_leaves") != r.names.end()) return r.bytes;
        return VkDeviceSize{0};
    };
    EXPECT_EQ(exist({}), 0u);
    EXPECT_EQ(exist({"nodes.trace.params.remember=true"}), 20u * 24u * 16u);
    EXPECT_EQ(exist({"nodes.trace.params.remember=true", "nodes.trace.params.rays_per_pixel=2"}), 0u);
}

}  // namespace
}  // namespace penumbra::test
