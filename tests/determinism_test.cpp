// SPDX-License-Identifier: MIT
// One device gives one picture: over six runs, and whatever order the scheduling leaves the tile lists in.
// (Memory: shadow_pipeline_test.) And the two
// trace backends differ where their rays do.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <glm/glm.hpp>
#include <numeric>

#include "app/outputs.h"
#include "app/session.h"
#include "tests/gpu_test.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/test_scene.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

// A node that works through a list of tiles, and the list; the dispatch's arguments are named after it.
struct ListReader {
    std::string node, port, list, args;
};

std::vector<ListReader> list_readers(std::string_view name) {
    const ListReader trace{"trace", "tile_list", "tile_list", "trace_args"};
    const auto of = [](const char* node, const char* list) {
        return ListReader{node, "candidates", list,
                          list == std::string("facing") ? "facing_args" : "candidate_args"};
    };
    if (name == "covered") return {of("cover", "candidates"), of("beams", "facing")};
    if (name == "hybrid_shadows" || name == "lit")
        return {trace, of("cover", "candidates"), of("beams", "facing")};
    if (name == "shadows")
        return {trace, of("pilots", "candidates"), {"refine", "tile_list", "further_tiles", "further_args"}};
    if (name == "many_rays") return {trace, of("beams", "facing")};
    return {trace};
}

bool has_beams(std::string_view name) {
    return list_readers(name).back().list == "facing";
}

// Little enough that some pixels are given up.
std::vector<std::string> with_budget(std::string_view name, std::vector<std::string> settings) {
    if (name == "hybrid_shadows" || name == "lit") settings.emplace_back("nodes.cover.params.budget=4");
    return settings;
}

std::unique_ptr<Session> open(const std::string& name, const std::vector<std::string>& settings,
                              const std::vector<std::string>& captures) {
    const CheckedPipeline checked = shipped_pipeline(name, with_budget(name, settings), test_nodes());
    const Shot shot = plaza_shot({160, 90}, 8);
    SessionOptions options;
    options.size = shot.size;
    options.captures = captures;
    for (const std::string& output : checked.output_names()) options.captures.push_back(output);
    if (has_beams(name)) options.captures.emplace_back("proved");
    if (name == "lit") options.captures.emplace_back("visibility");
    return open_session(checked, shot, options, test_nodes());
}

// The outputs of every frame, and which tiles were proved: a shadow that is has no blockers whose distances a
// denoiser could know.
std::vector<std::vector<std::byte>> run(Session& session, const std::string& name, uint32_t frames) {
    std::vector<std::string> outputs{"visibility"};
    if (name != "raw" && name != "many_rays" && name != "covered") outputs.emplace_back("color");
    if (has_beams(name)) outputs.emplace_back("proved");
    std::vector<std::vector<std::byte>> result;
    for (uint32_t frame = 0; frame < frames; ++frame) {
        session.run_frame(frame, frame == 0);
        for (const std::string& output : outputs) {
            const auto bytes = session.view().captured(output);
            result.emplace_back(bytes.begin(), bytes.end());
        }
    }
    return result;
}

class Determinism : public GpuTest, public ::testing::WithParamInterface<const char*> {};

// Half of the runs in a program of their own, the others after a reset.
TEST_P(Determinism, SixRunsGiveTheSameBits) {
    const auto one = open(GetParam(), {}, {}), other = open(GetParam(), {}, {});
    const auto expected = run(*one, GetParam(), 6);
    for (int i = 1; i < 6; ++i)
        EXPECT_TRUE(run(i % 2 ? *other : *one, GetParam(), 6) == expected) << "run " << i + 1;
}

// What a frame after a reset leaves for the next one, too, is what a first frame leaves: pictures alone hide
// most of it.
class Resets : public GpuTest {};

TEST_F(Resets, ForgetWhichCellsWereIdle) {
    const std::vector<std::string> kept{"idle_cells"};
    const auto one = open("shadows", {}, kept), other = open("shadows", {}, kept);
    const auto idle = [](Session& session) {
        const auto bytes = session.view().captured("idle_cells");
        return std::vector<std::byte>(bytes.begin(), bytes.end());
    };
    one->run_frame(0, true);
    const auto expected = idle(*one);
    EXPECT_NE(std::ranges::count(expected, std::byte{0}), std::ptrdiff_t(expected.size()));
    for (uint32_t frame = 0; frame < 5; ++frame) other->run_frame(frame, frame == 0);
    EXPECT_NE(idle(*other), expected) << "nothing is remembered";
    other->run_frame(0, true);
    EXPECT_TRUE(idle(*other) == expected);
}

// As the report does: a frame in motion is like the one that was run, and not like the one before it.
TEST_F(Resets, AFrameInMotionMayBeRunAgain) {
    const auto session = open("raw", {}, {});
    session->run_frame(0, true);
    session->run_frame(1, false);
    ASSERT_FALSE(session->frame_description().camera == session->frame_description().previous);
    const auto once = captured_image(*session, "visibility").planes.front().values;
    session->run_frame(1, false);
    EXPECT_EQ(captured_image(*session, "visibility").planes.front().values, once);
}

TEST_P(Determinism, TheOrderOfTheTilesDoesNotShow) {
    const auto expected = run(*open(GetParam(), {}, {}), GetParam(), 4);
    for (const uint32_t stride : {0u, 5003u, 65521u}) {
        const std::string params =
            R"("type": "permute_list", "params": { "stride": )" + std::to_string(stride) + " }";
        std::vector<std::string> settings;
        for (const ListReader& r : list_readers(GetParam())) {
            const std::string other = "other_" + r.list;
            settings.push_back("nodes." + other + "={ " + params +
                               (GetParam() == std::string("shadows") ? R"(, "if": "sun_disc")"
                                : r.node == "cover"                  ? R"(, "if": "sun_disc & tree")"
                                : has_beams(GetParam())              ? R"(, "if": "tree")"
                                                                     : "") +
                               R"(, "in": { "tile_list": ")" + r.list + R"(", "trace_args": ")" + r.args +
                               R"(" }, "out": { "permuted_list": ")" + other + R"(" } })");
            settings.push_back("nodes." + r.node + ".in." + r.port + "=" + other);
        }
        const ListReader last = list_readers(GetParam()).front();
        const auto session = open(GetParam(), settings, {last.list, "other_" + last.list, last.args});
        EXPECT_TRUE(run(*session, GetParam(), 4) == expected) << "stride " << stride;
        using Record = std::array<uint32_t, 4>;
        const auto before = captured<Record>(session->view(), last.list),
                   after = captured<Record>(session->view(), "other_" + last.list);
        const uint32_t count = captured<uint32_t>(session->view(), last.args).at(3);
        ASSERT_GT(count, 0u);
        if (stride != 0 && std::gcd(stride - 1, count) * 5 > count)
            continue;  // that many places are their own
        size_t elsewhere = 0;
        for (uint32_t i = 0; i < count; ++i) elsewhere += before[i] != after[i];
        EXPECT_GT(elsewhere, count * 8 / 10) << "the list was hardly permuted, stride " << stride;
    }
}

// Which rays differ between the backends is judged in trace_backend_test, ray by ray. Of who traced, later
// passes know how far away a blocker is, which is any of those that a ray meets: the picture stays.
class TraceBackends : public GpuTest, public ::testing::WithParamInterface<const char*> {};

TEST_P(TraceBackends, GiveTheSamePicture) {
    if (!gpu().caps().ray_query) GTEST_SKIP() << gpu().info().name << " has no VK_KHR_ray_query";
    const std::string query = "nodes.trace.params.backend=ray_query", tree = "nodes.trace.params.backend=bvh";
    const auto query_run = open(GetParam(), {query}, {}), tree_run = open(GetParam(), {tree}, {});
    size_t shadowed = 0;
    double squares = 0;
    for (uint32_t frame = 0; frame < 6; ++frame) {
        for (Session* session : {query_run.get(), tree_run.get()}) session->run_frame(frame, frame == 0);
        const auto v = [](const Session& session) {
            return captured_planes(session.view(), "visibility")[0];
        };
        const std::vector<float> c = v(*query_run), d = v(*tree_run);
        for (size_t i = 0; i < c.size(); ++i) {
            shadowed += c[i] < 1;
            squares += std::pow(double(c[i]) - d[i], 2) / (6.0 * double(c.size()));
        }
    }
    std::printf("%s: RMSE %.5f\n", GetParam(), std::sqrt(squares));
    EXPECT_LT(std::sqrt(squares), 1.0 / 255);
    EXPECT_GT(shadowed, 1000u);
}

INSTANTIATE_TEST_SUITE_P(Pipelines, TraceBackends, ::testing::Values("shadows"),
                         [](const auto& test) { return std::string(test.param); });

INSTANTIATE_TEST_SUITE_P(Pipelines, Determinism,
                         ::testing::Values("raw", "many_rays", "fidelityfx", "shadows", "covered",
                                           "hybrid_shadows", "lit", "sigma"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace penumbra::test
