// SPDX-License-Identifier: MIT
// The processor's coverage of a pixel is the node's, and `explain` draws it; what cannot be drawn leaves no
// file.
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <span>

#include "app/gathered_rays.h"
#include "app/outputs.h"
#include "app/tile_beams.h"
#include "host/images/image_decode.h"
#include "host/truth/coverage.h"
#include "tests/cli_run.h"
#include "tests/gpu_test.h"
#include "tests/ray_maker.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/substring.h"
#include "tests/test_scene.h"

namespace penumbra::test {
namespace {

using Json = nlohmann::json;

struct Differences {
    uint32_t receivers = 0, penumbra = 0;
    uint32_t far = 0;          // receivers whose counts differ by more than two samples
    double most = 0, sum = 0;  // in samples, of the penumbra: the largest, and signed
};

class CoverageTwin : public GpuTest {
  protected:
    Differences compare(const Shot& shot, uint32_t frame, uint32_t samples) {
        SessionOptions options;
        options.size = shot.size;
        options.captures = {"view_depth", "receiver_normal", "visibility"};
        const auto session = open_session(
            shipped_pipeline("covered", {"nodes.cover.params.samples=" + std::to_string(samples)}), shot,
            options);
        session->run_frame(frame, true);
        return compare(*session, frame, samples);
    }

    static Shot shipped(const char* name) {
        Shot shot = shot_named(name);
        shot.size = {160, 90};
        return shot;
    }

  protected:
    Differences compare(const Session& session, uint32_t frame, uint32_t samples) const {
        const auto depth = captured_values<float>(session, "view_depth");
        const auto normal = captured_values<NormalTexel>(session, "receiver_normal");
        const std::vector<float> visibility = captured_image(session, "visibility").planes.at(0).values;
        const StandaloneFrame at = session.host().frame(frame, true);
        std::vector<uint32_t> noise(16384);
        std::memcpy(noise.data(), shipped_nodes().find("cover")->tables[0].texels.data(), noise.size() * 4);
        const SampledSun sun(samples);
        const CoverageScene scene(session.host().scene(), frame);
        const Extent extent = session.plan().extent;
        Differences d;
        for (uint32_t i = 0; i < extent.width * extent.height; ++i) {
            if (!(depth[i] > 0)) continue;
            const CoverageReceiver receiver = coverage_receiver(
                at, session.seed(), noise, {{i % extent.width, i / extent.width}, depth[i], normal[i]});
            const double twin = scene.cover(sun, receiver).visibility();
            const double off = (twin - visibility[i]) * samples;
            ++d.receivers;
            if (std::abs(off) > 2.5) ++d.far;  // a half more: the image has 8 bits
            if (!(twin > 0 && twin < 1)) continue;
            ++d.penumbra;
            d.sum += off;
            d.most = std::max(d.most, std::abs(off));
        }
        return d;
    }
};

void expect_alike(const Differences& d, double least_penumbra) {
    EXPECT_GT(d.penumbra, least_penumbra);
    EXPECT_LE(d.far, d.receivers / 1000);
    EXPECT_LT(std::abs(d.sum), 0.1 * d.penumbra) << "no bias";
}

TEST_F(CoverageTwin, CountsTheSamplesThatTheNodeCounts) {
    for (const uint32_t samples : light_sample_counts) {
        SCOPED_TRACE(samples);
        expect_alike(compare(plaza_shot({320, 180}, 8), 3, samples), 300);
    }
    Shot large = plaza_shot({320, 180}, 8);
    large.sun_angular_radius_deg = 12;
    expect_alike(compare(large, 0, 128), 300);
}

TEST_F(CoverageTwin, OnShippedScenesToo) {
    for (const char* name : {"colonnade", "engine", "trees", "cards"}) {
        SCOPED_TRACE(name);
        expect_alike(compare(shipped(name), 5, 128), 100);
    }
}

class Explain : public Cli {
  protected:
    std::string out() const { return (folder_ / "figure.svg").string(); }
    Result explain(const std::string& more) const {
        return run("explain --shot scenes/colonnade.shot.json --size 96x54 --out " + out() + " " + more);
    }
    void expect_nothing(const Result& result, int code, const std::string& in_err) const {
        expect(result, code, in_err);
        for (const auto& entry : fs::directory_iterator(folder_)) {
            const std::string name = entry.path().filename();
            EXPECT_TRUE(name == "out" || name == "err" || name.ends_with(".json")) << "left behind: " << name;
        }
    }
};

TEST_F(Explain, DrawsThePixelThatItNamesWithEverySample) {
    for (const std::string samples : {"64", "128", "256"}) {
        const Result result = explain("--samples " + samples);
        ASSERT_EQ(result.code, 0) << result.err;
        std::smatch said;
        const std::regex line(
            "pixel ([0-9]+),([0-9]+), which has the most triangles: [0-9]+ triangles.* hide ([0-9]+) of " +
            samples + " samples: visibility ([0-9.]+) \\(the node: ([0-9.]+)\\)\n");
        ASSERT_TRUE(std::regex_match(result.out, said, line)) << result.out;
        const size_t hidden = std::stoul(said[3]), all = std::stoul(samples);
        EXPECT_NEAR(std::stod(said[4]), 1 - double(hidden) / double(all), 0.001);
        EXPECT_NEAR(std::stod(said[4]), std::stod(said[5]), 2.5 / double(all));
        const std::string svg = read_file(out());
        EXPECT_EQ(svg.rfind("<svg xmlns=", 0), 0u);
        EXPECT_EQ(occurrences(svg, "class=\"hidden\""), hidden + 1) << "one more in the legend";
        EXPECT_EQ(occurrences(svg, "class=\"visible\""), all - hidden + 1);
        EXPECT_NE(svg.find("pixel " + said[1].str() + "," + said[2].str()), std::string::npos);

        const Result again =
            explain("--samples " + samples + " --pixel " + said[1].str() + "," + said[2].str());
        EXPECT_EQ(again.code, 0) << again.err;
        EXPECT_EQ(read_file(out()), svg) << "the same pixel, chosen or asked for";
    }
}

TEST_F(Explain, WhatCannotBeDrawnIsSaidAndLeavesNoFile) {
    expect_nothing(explain("--pixel 96,3"), 2, "outside of the image, which is 96x54");
    for (const char* pixel : {"-1,3", "3", "3,", ",3", "3x4", "3,4,5", "99999999999,1"})
        expect_nothing(explain("--pixel=" + std::string(pixel)), 2, "is not X,Y");
    expect_nothing(run("explain --shot scenes/engine.shot.json --size 96x54 --pixel 0,0 --out " + out()), 2,
                   "0,0 shows no surface");
    std::string point = read_file(fs::path(PENUMBRA_SOURCE_DIR) / "scenes/colonnade.shot.json");
    point.replace(point.find("0.2665"), 6, "0");
    point.replace(point.find("colonnade.glb"), 13, PENUMBRA_SOURCE_DIR "/scenes/colonnade.glb");
    expect_nothing(run("explain --shot " + file("point.shot.json", point) + " --out " + out()), 2,
                   "the sun is a point");
    const std::string shown = "explain --shot scenes/colonnade.shot.json --size 96x54 ";
    expect_nothing(run(shown + "--out " + in("a.png")), 2,
                   "a.png is written as an SVG: end its name in .svg");
    expect_nothing(run(shown + "--beams --out " + in("a")), 2, "is written as an SVG");
    expect_nothing(run(shown + "--budget --out " + in("a.svg")), 2,
                   "a.svg is written as a PNG: end its name in .png");
    expect_nothing(run("explain --costs x.json --out " + in("a.txt")), 2, "is written as an SVG");
    expect_nothing(explain("--frame 64"), 2, "which has 64 frames");
    expect_nothing(explain("--samples 100"), 2, "samples");
    expect_nothing(explain("--costs x.json"), 2, "costs");
    expect_nothing(run("explain --out " + out()), 2, "--shot");
    expect_nothing(run("explain --pixel 1,1 --out " + out()), 2, "--shot");
    expect_nothing(run("explain --shot nosuch.shot.json --out " + out()), 2, "nosuch.shot.json");
    expect_nothing(run("explain --shot scenes/colonnade.shot.json --out " + out() + "/a.svg"), 2,
                   "there is no folder");
    expect_nothing(run("explain --shot scenes/colonnade.shot.json --out " + folder_.string()), 2,
                   "is a folder");
    expect_nothing(run("explain --shot scenes/colonnade.shot.json --size 96x54 --out /proc/figure.svg"), 1,
                   "cannot be written");
}

// The picture's colours are the numbers that it says: where no ray could go, none, one, more.
TEST_F(Explain, ABudgetIsDrawnPixelByPixel) {
    const std::string png = file("budget.png", "");
    const Result result =
        run("explain --shot scenes/colonnade.shot.json --size 160x90 --frame 1 --budget --out " + png);
    ASSERT_EQ(result.code, 0) << result.err;
    std::smatch said;
    const std::regex line(
        "frame 1: ([0-9]+) rays for ([0-9]+) pixels that look at the sun: none for ([0-9.]+) %, "
        "one for ([0-9.]+) %, .*\n");
    ASSERT_TRUE(std::regex_match(result.out, said, line)) << result.out;
    const double rays = std::stod(said[1]), receivers = std::stod(said[2]);
    EXPECT_NEAR(rays, 2 * receivers, 0.02 * receivers) << "what is proved casts none";
    const std::string bytes = read_file(png);
    const RgbaImage image = decode_png(std::as_bytes(std::span(bytes)), 1 << 20);
    std::map<std::array<uint8_t, 3>, double> colors;
    for (size_t i = 0; i < image.rgba.size(); i += 4)
        ++colors[{image.rgba[i], image.rgba[i + 1], image.rgba[i + 2]}];
    EXPECT_EQ(colors.at({20, 20, 24}), 160 * 90 - receivers);
    EXPECT_NEAR(100 * colors.at({92, 92, 96}) / receivers, std::stod(said[3]), 0.051);
    EXPECT_NEAR(100 * colors.at({38, 84, 156}) / receivers, std::stod(said[4]), 0.051);
    EXPECT_GE(colors.size(), 4u) << "some got more than one";

    fs::remove(png);
    expect(run("explain --shot colonnade --size 96x54 --budget --gather --out " + png), 2, "--gather");
    expect(run("explain --shot colonnade --size 96x54 --budget --out /proc/budget.png"), 1,
           "cannot be written");
}

TEST_F(Explain, CostsAreABarPerReport) {
    std::string reports;
    for (const char* pipeline : {"raw", "covered"}) {
        ASSERT_EQ(run("render pipelines/" + std::string(pipeline) +
                      ".json --shot scenes/colonnade.shot.json --size 64x36 " + "--frames 0..2 --out " +
                      (folder_ / pipeline).string())
                      .code,
                  0);
        reports += " " + (folder_ / pipeline / "report.json").string();
    }
    const Result result = run("explain --out " + out() + " --costs" + reports);
    ASSERT_EQ(result.code, 0) << result.err;
    const std::string svg = read_file(out());
    EXPECT_EQ(svg.rfind("<svg xmlns=", 0), 0u);
    for (const char* part : {"raw, trace: ", "covered, cover: ", "colonnade, 64x36"})
        EXPECT_NE(svg.find(part), std::string::npos) << part;
    EXPECT_EQ(svg.find("raw, cover"), std::string::npos);
}

TEST_F(Explain, ReportsThatSayNothingOfTimeAreTheCommandsMistake) {
    const auto costs = [&](const std::string& report) {
        return run("explain --out " + out() + " --costs " + report);
    };
    expect_nothing(costs("nosuch.json"), 2, "nosuch.json: no such file");
    expect_nothing(costs(file("broken.json", "{")), 2, "is no JSON");
    expect_nothing(costs(file("other.json", "{}")), 2, "is no report.json");
    // Of a GPU the device's timestamps tell, if it has them.
    const auto on_gpu = [&](const Json& ms) {
        const Json pass = {{"node", "trace"},
                           {"type", "trace"},
                           {"cpu_ms", {{"median", nullptr}}},
                           {"ms", {{"median", ms}}}};
        return Json{{"pipeline", "raw"},
                    {"shot", "s"},
                    {"device", {{"name", "d"}}},
                    {"size", {4, 4}},
                    {"passes", {pass}}}
            .dump();
    };
    expect_nothing(costs(file("dark.json", on_gpu(nullptr))), 2, "no times of passes");
    ASSERT_EQ(costs(file("gpu.json", on_gpu(0.25))).code, 0);
    EXPECT_NE(read_file(out()).find("GPU ms per frame"), std::string::npos);
}

// What the processor sees of a tile's beam agrees with what the node made of it: nothing is in what is lit,
// what is dark is closed off, and what is closed off was not called lit. The node errs towards "open".
TEST_F(CoverageTwin, BeamsSeeWhatTheNodeDecidedBy) {
    Shot shot = shipped("colonnade");
    shot.size = {320, 180};
    SessionOptions options;
    options.size = shot.size;
    options.captures = TileBeams::captures();
    const auto session = open_session(shipped_pipeline("many_rays", TileBeams::settings()), shot, options);
    session->run_frame(0, true);
    const TileBeams tiles(*session, 0);
    std::map<TileVerdict, uint32_t> counts;
    uint32_t closed = 0, bordered = 0;
    for (uint32_t i = 0; i < tiles.tiles()[0] * tiles.tiles()[1]; i += 5) {
        const std::array<uint32_t, 2> tile{i % tiles.tiles()[0], i / tiles.tiles()[0]};
        const auto verdict = tiles.verdict(tile);
        if (!verdict) continue;
        ++counts[*verdict];
        const TileBeam beam = tiles.beam(tile);
        EXPECT_GT(beam.pixels, 0u);
        if (*verdict == TileVerdict::lit) {
            EXPECT_GT(beam.nearest(), 0.9999) << tile[0] << "," << tile[1];
            EXPECT_FALSE(beam.closed);
        }
        closed += *verdict == TileVerdict::dark && beam.closed;
        bordered += *verdict == TileVerdict::open && beam.nearest_border() < 1.0001;
    }
    EXPECT_GT(counts[TileVerdict::lit], 10u);
    EXPECT_GT(counts[TileVerdict::dark], 10u);
    EXPECT_GT(counts[TileVerdict::open], 10u);
    EXPECT_GE(closed, 0.97 * counts[TileVerdict::dark]) << counts[TileVerdict::dark];
    EXPECT_GT(bordered, 0.8 * counts[TileVerdict::open]) << counts[TileVerdict::open];
}

TEST_F(Cli, ExplainDrawsWhyTilesAreDecided) {
    const std::string svg = (folder_ / "beams.svg").string();
    const Result drawn = run("explain --shot colonnade --size 320x180 --beams --out " + svg);
    ASSERT_EQ(drawn.code, 0) << drawn.err;
    std::smatch said;
    const std::regex words("tile (\\d+),(\\d+) \\(32 pixels\\): dark, closed off by (\\d+) triangle");
    ASSERT_TRUE(std::regex_search(drawn.out, said, words)) << drawn.out;
    EXPECT_NE(drawn.out.find(": lit, nothing in it"), std::string::npos) << drawn.out;
    EXPECT_NE(drawn.out.find(": open, a border in it"), std::string::npos) << drawn.out;
    const auto patches = [&](const std::string& text) {
        size_t found = 0;
        for (size_t at = text.find("class=\"patch\""); at != std::string::npos;
             at = text.find("class=\"patch\"", at + 1))
            ++found;
        return found;
    };
    EXPECT_EQ(patches(read_file(svg)), std::stoul(said[3]));
    const std::string pixel =
        std::to_string(std::stoul(said[1]) * 8 + 3) + "," + std::to_string(std::stoul(said[2]) * 4 + 2);
    const Result one =
        run("explain --shot colonnade --size 320x180 --beams --pixel " + pixel + " --out " + svg);
    EXPECT_EQ(one.out, said[0].str() + (said[3] == "1" ? "" : "s") + "\n");
    EXPECT_EQ(patches(read_file(svg)), std::stoul(said[3]));
    fs::remove(svg);
    expect(run("explain --shot lamp --size 96x54 --beams --pixel 0,0 --out " + svg), 2, "no surface");
    expect(run("explain --shot lamp --beams --gather --out " + svg), 2, "--gather");
    EXPECT_FALSE(fs::exists(svg));
}

// Rays around, sheared by how far off blockers are, tell a pixel's visibility; the same rays as they are tell
// a blur of it. Judged by coverage, in all pixels whose sun enough rays test.
TEST_F(CoverageTwin, ShearedRaysTellAPixelsSunAndUnshearedOnesABlur) {
    Shot shot = plaza_shot({160, 90}, 1);
    shot.sun_angular_radius_deg = 10;  // penumbrae of many pixels
    const auto run = [&](const char* name, const std::vector<std::string>& captures) {
        const CheckedPipeline checked = shipped_pipeline(name);
        SessionOptions options;
        options.size = shot.size;
        options.jitter = false;
        options.captures = captures;
        auto session = open_session(checked, shot, options);
        session->run_frame(0, true);
        return session;
    };
    const auto rays = run("one_ray", RayGatherer::captures()), exact = run("covered", {"visibility"});
    const std::vector<float> visibility = captured_image(*exact, "visibility").planes.at(0).values;
    const RayGatherer gatherer(*rays, 0);
    double sheared = 0, unsheared = 0;
    uint32_t pixels = 0;
    for (uint32_t y = 0; y < shot.size[1]; ++y)
        for (uint32_t x = 0; x < shot.size[0]; ++x) {
            const double truth = static_cast<double>(visibility[size_t{y} * shot.size[0] + x]);
            const auto gathered = gatherer.gather({x, y});
            if (!gathered || gathered->counted() < 12 || truth < 0.05 || truth > 0.95) continue;
            sheared += std::pow(gathered->visibility() - truth, 2);
            unsheared += std::pow(gathered->unsheared() - truth, 2);
            ++pixels;
        }
    ASSERT_GT(pixels, 100u);
    EXPECT_LT(std::sqrt(sheared / pixels), 0.17) << pixels;
    EXPECT_GT(unsheared, 1.5 * sheared);
}

TEST_F(Cli, ExplainDrawsWhatRaysAroundAPixelSay) {
    const std::string svg = (folder_ / "gather.svg").string();
    const Result drawn = run("explain --shot colonnade --size 640x360 --gather --out " + svg);
    ASSERT_EQ(drawn.code, 0) << drawn.err;
    std::smatch said;
    const std::regex words(
        "pixel (\\d+),(\\d+), whose sun most rays test: (\\d+) of 121 rays .* (\\d+) of them lit");
    ASSERT_TRUE(std::regex_search(drawn.out, said, words)) << drawn.out;
    const std::string text = read_file(svg);
    const auto count = [&](const std::string& style) {
        size_t found = 0;
        for (size_t at = text.find(style); at != std::string::npos; at = text.find(style, at + 1)) ++found;
        return found;
    };
    // Every ray that counts is a dot of the right figure, besides its dot in the left one.
    const size_t pale = count("class=\"lit-ray outside\"") + count("class=\"dark-ray outside\"");
    const size_t dots = count("class=\"lit-ray\"") + count("class=\"dark-ray\"");
    EXPECT_EQ(dots - std::stoul(said[3]), count("class=\"disc\""));
    EXPECT_GT(std::stoul(said[3]), 12u);
    EXPECT_GT(pale, 0u);
    const Result again = run("explain --shot colonnade --size 640x360 --gather --pixel " + said[1].str() +
                             "," + said[2].str() + " --out " + svg);
    EXPECT_EQ(again.code, 0);
    EXPECT_EQ(read_file(svg), text);
    expect(run("explain --shot lamp --size 96x54 --gather --pixel 0,0 --out " + svg), 2, "shows no surface");
}

}  // namespace
}  // namespace penumbra::test
