// SPDX-License-Identifier: MIT
// The picture of what a classifier decided, against the words it is made from, against the counters of the
// nodes that decided, and against the rays: what is green or blue must have the visibility that raw.json's
// ray gives it.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "app/session.h"
#include "nodes/nodes.h"
#include "tests/gpu_test.h"
#include "tests/test_scene.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

const std::filesystem::path root = PENUMBRA_SOURCE_DIR;
using Color = std::array<uint8_t, 4>;
const Color red{255, 0, 0, 255}, green{0, 255, 0, 255}, blue{0, 0, 255, 255}, black{0, 0, 0, 255};

const NodeSet& nodes() {
    static const NodeSet set = shadow_nodes();
    return set;
}

// One open view of a shipped pipeline, changed by settings.
std::unique_ptr<Session> open(const std::string& name, const std::vector<std::string>& settings,
                              const Shot& shot, SessionOptions options) {
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto pipeline = load_pipeline(root / "pipelines" / (name + ".json"), settings, diagnostics);
    const auto checked = pipeline ? check(*pipeline, nodes(), diagnostics) : std::nullopt;
    if (!checked) throw std::runtime_error(diagnostics.text());
    options.size = shot.size;
    options.optimum = false;
    auto session = Session::open(gpu(), nodes(), *checked, shot, options, diagnostics, warnings);
    if (!session) throw std::runtime_error(diagnostics.text());
    return session;
}

SessionOptions capturing(std::vector<std::string> captures) {
    SessionOptions options;
    options.captures = std::move(captures);
    options.cascade_size = 64;
    return options;
}

struct Classifier {
    const char* pipeline;
    std::vector<std::string> settings;  // that make it show its verdicts beside its visibility
    const char* undecided;              // its words for what is open
    std::vector<const char*> nodes;     // that decide, the last one last
};

const std::vector<Classifier>& classifiers() {
    static const std::string both = R"(outputs=["verdicts", "visibility"])";
    static const std::vector<Classifier> list = {
        {"verdicts", {both}, "traced_words", {"classify", "beams", "cones"}},
        {"raw", {both, "nodes.verdicts.type=verdicts"}, "undecided_words", {"classify"}},
        {"hybrid_cascades_raw",
         {both, R"(nodes.verdicts={"type": "verdicts", "in": {"undecided_words": "traced_words"}})",
          "nodes.cascades.out.undecided_words=traced_words"},
         "traced_words",
         {"classify", "cascades"}},
    };
    return list;
}

class Verdicts : public GpuTest {};

// 75x43: tiles that hang over the right and the lower border.
TEST_F(Verdicts, AreTheWordsAndTheCountersOfEachClassifier) {
    const Shot shot = plaza_shot({75, 43}, 3);
    for (const Classifier& c : classifiers()) {
        SCOPED_TRACE(c.pipeline);
        const auto session = open(c.pipeline, c.settings, shot,
                                  capturing({"verdicts", c.undecided, "preloaded_hits", "receiver_words"}));
        for (uint32_t frame = 0; frame < shot.frames; ++frame) {
            session->run_frame(frame, frame == 0);
            const View& view = session->view();
            const auto colors = captured<Color>(view, "verdicts");
            const auto undecided = captured<uint32_t>(view, c.undecided),
                       hits = captured<uint32_t>(view, "preloaded_hits"),
                       receivers = captured<uint32_t>(view, "receiver_words");
            for (uint32_t y = 0; y < shot.size[1]; ++y)
                for (uint32_t x = 0; x < shot.size[0]; ++x) {
                    const size_t word = y / 4 * ((shot.size[0] + 7) / 8) + x / 8;
                    const uint32_t bit = 1u << (y % 4 * 8 + x % 8);
                    const Color expected = !(receivers[word] & bit) ? black
                                           : undecided[word] & bit  ? red
                                           : hits[word] & bit       ? blue
                                                                    : green;
                    ASSERT_EQ(colors[size_t{y} * shot.size[0] + x], expected) << x << " " << y;
                }
            uint32_t lit = 0, shadowed = 0;
            for (const char* node : c.nodes) {
                const auto counters = counters_of(view, node);
                lit += counters.at("lit");
                if (counters.contains("shadowed")) shadowed += counters.at("shadowed");
            }
            EXPECT_EQ(std::ranges::count(colors, red), counters_of(view, c.nodes.back()).at("unknown"));
            EXPECT_EQ(std::ranges::count(colors, red), counters_of(view, "trace").at("rays"));
            EXPECT_EQ(std::ranges::count(colors, green), lit);
            EXPECT_EQ(std::ranges::count(colors, blue), shadowed);
        }
    }
}

TEST_F(Verdicts, AreWhatTheRaysSay) {
    Shot shot = plaza_shot({160, 96}, 1);
    shot.camera = {{0, {0.5, 1.5, 4}, {-0.4, 0.9, -1}, {0, 1, 0}}};  // with sky
    const auto rays = open("raw", {}, shot, capturing({"visibility"}));
    rays->run_frame(0, true);
    const auto visibility = captured<uint8_t>(rays->view(), "visibility");
    for (const Classifier& c : classifiers()) {
        SCOPED_TRACE(c.pipeline);
        const auto session = open(c.pipeline, c.settings, shot, capturing({"verdicts", "visibility"}));
        session->run_frame(0, true);
        const auto colors = captured<Color>(session->view(), "verdicts");
        for (size_t i = 0; i < colors.size(); ++i)
            if (colors[i] != red) {
                ASSERT_EQ(visibility[i], colors[i] == blue ? 0 : 255) << i;
            }
        EXPECT_GT(std::ranges::count(colors, black), 500);
        EXPECT_GT(std::ranges::count(colors, red), 50);
        EXPECT_GT(std::ranges::count(colors, blue), 50);
        // Normals alone prove nothing lit.
        EXPECT_GT(std::ranges::count(colors, green), c.nodes.size() > 1 ? 500 : -1);
        EXPECT_EQ(captured<uint8_t>(session->view(), "visibility"), visibility) << "looking changes nothing";
    }
}

TEST_F(Verdicts, CastNoRayUnlessAskedTo) {
    const auto session = open("verdicts", {}, plaza_shot({75, 43}, 1), capturing({"verdicts"}));
    for (const PlanPass& pass : session->plan().passes) EXPECT_NE(pass.node, "trace");
}

// At night, and where nothing casts, nothing is classified: all black, and nothing else runs.
TEST_F(Verdicts, AreBlackWhereNothingIsClassified) {
    for (const char* fact : {"sun_up", "casters"}) {
        SessionOptions options = capturing({"verdicts"});
        options.facts = {{fact, false}};
        const auto session = open("verdicts", {}, plaza_shot({75, 43}, 1), options);
        session->run_frame(0, true);
        const auto colors = captured<Color>(session->view(), "verdicts");
        EXPECT_EQ(std::ranges::count(colors, black), 75 * 43) << fact;
        EXPECT_EQ(session->plan().passes.size(), 2u) << fact << ": the clear and the capture";
    }
}

TEST_F(Verdicts, AliasingAndPoisonDoNotShow) {
    const Shot shot = plaza_shot({203, 117}, 8);
    const auto run = [&](bool alias, std::optional<uint32_t> poison) {
        SessionOptions options = capturing({"verdicts"});
        options.alias = alias;
        options.poison = poison;
        const auto session = open("verdicts", {}, shot, options);
        std::vector<std::vector<Color>> frames;
        for (uint32_t frame = 0; frame < shot.frames; ++frame) {
            session->run_frame(frame, frame == 0 || frame == 5);
            frames.push_back(captured<Color>(session->view(), "verdicts"));
        }
        return frames;
    };
    const auto expected = run(false, std::nullopt);
    for (const uint32_t poison : {0u, 1u})
        for (const bool alias : {true, false})
            EXPECT_TRUE(run(alias, poison) == expected) << "poison " << poison << " alias " << alias;
}

}  // namespace
}  // namespace penumbra::test
