// SPDX-License-Identifier: MIT
// penumbra bench as a shell sees it: figures that hold together, one row per pass, mistakes found before
// anything runs.
#include <nlohmann/json.hpp>

#include "tests/cli_run.h"

namespace penumbra::test {
namespace {

using Json = nlohmann::json;

std::string bench(const std::string& more) {
    return "bench raw one_ray --shots lamp --sizes 96x54 --frames 1..3 --rounds 2 " + more;
}

void expect_rounds(const Json& rounds) {
    ASSERT_TRUE(rounds.at("least").is_number()) << rounds.dump();
    EXPECT_GE(rounds.at("least").get<double>(), 0);
    EXPECT_LE(rounds.at("least").get<double>(), rounds.at("median").get<double>());
}

TEST_F(Cli, BenchFiguresHoldTogether) {
    const Result result = run(bench("--format json"));
    ASSERT_EQ(result.code, 0) << result.err;
    const Json json = Json::parse(result.out);
    ASSERT_EQ(json.at("scenes").size(), 1u);
    const Json& scene = json["scenes"][0];
    EXPECT_EQ(scene.at("size"), Json({96, 54}));
    const double native = scene.at("native_pass_ms").at("least");
    EXPECT_GT(native, 0);
    ASSERT_EQ(scene.at("pipelines").size(), 2u);
    const bool cpu = json.at("device").at("class") == "cpu";
    for (const Json& pipeline : scene["pipelines"]) {
        SCOPED_TRACE(pipeline.at("id").get<std::string>());
        double sum = 0, sum_ms = 0;
        for (const Json& pass : pipeline.at("passes")) {
            EXPECT_NE(pass.at("type"), "capture") << "a bench measures what a host would run";
            EXPECT_GT(pass.at("bound_bytes").get<uint64_t>(), 0u);
            if (cpu) {
                EXPECT_TRUE(pass.at("ms").at("least").is_null()) << "no timestamps there";
                EXPECT_TRUE(pass.at("gb_per_s").is_null());
            }
            if (!pass.at("ms").at("least").is_null()) {
                const double ms = pass["ms"]["least"];
                sum_ms += ms;
                if (ms > 0) {
                    EXPECT_NEAR(pass.at("gb_per_s").get<double>() * ms * 1e6,
                                pass["bound_bytes"].get<double>(), 1e-6 * pass["bound_bytes"].get<double>());
                }
            }
            if (!cpu) continue;
            expect_rounds(pass.at("cpu_ms"));
            const double least = pass["cpu_ms"]["least"];
            sum += least;
            EXPECT_NEAR(pass.at("native_passes").get<double>() * native, least, 1e-6 * least);
            EXPECT_NEAR(pass.at("cpu_ns_per_pixel").get<double>() * 96 * 54, least * 1e6, least);
        }
        if (cpu) {
            // Each pass has its own best round and its own median frame.
            EXPECT_GT(pipeline.at("sum").at("cpu_ms").at("least").get<double>(), 0.5 * sum);
            expect_rounds(pipeline.at("frame").at("cpu_ms"));
            EXPECT_GT(pipeline["frame"]["cpu_ms"]["least"].get<double>(), 0);
        }
        if (!pipeline.at("sum").at("ms").at("least").is_null()) {
            expect_rounds(pipeline["sum"]["ms"]);
            EXPECT_GT(pipeline["sum"]["ms"]["least"].get<double>(), 0.5 * sum_ms);
            EXPECT_GT(sum_ms, 0);
        }
        expect_rounds(pipeline.at("frame").at("wall_ms"));
        expect_rounds(pipeline["frame"].at("record_us_per_pass"));
        expect_rounds(pipeline.at("compile_ms"));
        EXPECT_GT(pipeline.at("first_frame_ms").get<double>(), 0);
        EXPECT_TRUE(pipeline.at("frame_0_ms").is_number());
        const Json& memory = pipeline.at("memory");
        EXPECT_GE(memory.at("heap_bytes"), memory.at("live_bound_bytes"));
        EXPECT_NEAR(memory.at("bytes_per_pixel").get<double>() * 96 * 54, memory["heap_bytes"].get<double>(),
                    1);
    }
}

TEST_F(Cli, BenchTableHasARowPerPass) {
    const Result result = run(bench("--still"));
    ASSERT_EQ(result.code, 0) << result.err;
    for (const char* row : {"**raw**, 96x54, frames 1 to 3 standing still", "**one_ray**", "| guides |",
                            "| gather |", "| taa |", "| sum |", "| wall ms |", "| heap, bytes per pixel |"})
        EXPECT_NE(result.out.find(row), std::string::npos) << row << "\n" << result.out;
}

// Of several lights it says what one of them takes: at this size, which heaps' alignment favours, a mask and
// a past at least, and no more than LightsMemory allows.
TEST_F(Cli, BenchSaysWhatALightTakes) {
    const Result result =
        run("bench lights_shadows lights --shots lights/interior --sizes 320x180 --frames 0..1 --rounds 1 "
            "--format json");
    ASSERT_EQ(result.code, 0) << result.err;
    const Json contenders = Json::parse(result.out).at("scenes").at(0).at("pipelines");
    const auto bytes = [&](size_t i) {
        return contenders.at(i).at("memory").at("last_light_bytes_per_pixel");
    };
    EXPECT_GT(bytes(0).get<double>(), 6);
    EXPECT_LT(bytes(0).get<double>(), 10.5);
    EXPECT_GE(bytes(1).get<double>(), 1);  // a mask
    EXPECT_LT(bytes(1).get<double>(), 10);
    const Result one = run("bench raw --shots lamp --sizes 96x54 --frames 0..1 --rounds 1 --format json");
    ASSERT_EQ(one.code, 0) << one.err;
    EXPECT_TRUE(Json::parse(one.out)
                    .at("scenes")
                    .at(0)
                    .at("pipelines")
                    .at(0)
                    .at("memory")
                    .at("last_light_bytes_per_pixel")
                    .is_null());
}

// As render has it: of several lights one is chosen, by a pipeline for one or for all of them.
TEST_F(Cli, BenchIsOfTheLightThatIsAskedFor) {
    const std::string shot = " --shots lights/interior --sizes 96x54 --frames 0..1 --rounds 1";
    expect(run("bench light" + shot), 2, "--light: the shot has several lights");
    expect(run("bench light" + shot + " --light pannel"), 2, "did you mean \"panel\"?");
    const Result one = run("bench light lights_shadows" + shot + " --light panel --format json");
    ASSERT_EQ(one.code, 0) << one.err;
    EXPECT_NE(one.out.find("\"gather_panel\""), std::string::npos);
    EXPECT_EQ(one.out.find("\"gather_bulb\""), std::string::npos);
}

TEST_F(Cli, BenchFindsMistakesBeforeItRuns) {
    expect(run("bench"), 2, "pipelines");
    expect(run("bench one_rays"), 2, "did you mean \"one_ray\"?");
    expect(run("bench lights_shadows --shots lamp"), 2, "takes lights that are near, and the shot has none");
    expect(run("bench raw --shots lamb"), 2, "did you mean \"lamp\"?");
    expect(run("bench raw --sizes 640"), 2, "is not WIDTHxHEIGHT");
    expect(run("bench raw --frames 4..2"), 2, "is not A..B");
    expect(run("bench raw --shots lamp --frames 0..1000000"), 2, "lamp.shot.json: --frames: the shot has");
    expect(run("bench raw --format xml"), 2, "xml");
    expect(run("bench raw --shots lamp --sizes 96x54 --device nosuch"), 2, "nosuch");
    expect(run("bench raw --shots lamp --sizes 96x54 --set nodes.trace.params.nosuch=1"), 2, "nosuch");
}

}  // namespace
}  // namespace penumbra::test
