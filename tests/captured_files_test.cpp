// SPDX-License-Identifier: MIT
// What `render --capture` writes of a resource: all its channels, and all its elements.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "host/images/image_file.h"
#include "tests/cli_run.h"

namespace penumbra::test {
namespace {

using Json = nlohmann::json;

class CapturedFiles : public Cli {};

// Whatever a captured image's fourth channel holds is in the file; of the host's images it holds nothing.
TEST_F(CapturedFiles, AnImageHasAllItsChannels) {
    ASSERT_EQ(
        run("render shadows --shot lamp --size 48x32 --frames 0..1 --capture guide_normal,motion --out " +
            in("o"))
            .code,
        0);
    Diagnostics diagnostics;
    const auto color = read_exr(folder_ / "o/color.0001.exr", diagnostics),
               normal = read_exr(folder_ / "o/guide_normal.0001.exr", diagnostics),
               motion = read_exr(folder_ / "o/motion.0001.exr", diagnostics);
    ASSERT_TRUE(color && normal && motion) << diagnostics.text();
    ASSERT_TRUE(normal->find("W"));
    EXPECT_EQ(*std::ranges::max_element(normal->find("W")->values), 1) << "where there is a surface";
    EXPECT_EQ(motion->planes.size(), 3u);
    EXPECT_EQ(color->planes.size(), 3u) << "a picture, that viewers would show through";
    for (const Json& output : Json::parse(read_file(in("o/report.json")))["outputs"])
        if (output["resource"] == "guide_normal") {
            EXPECT_EQ(output["channels"], "X,Y,Z,W");
        }
}

// A pipeline's own image is meant where it is called as one of the host's is, be it an output or not.
TEST_F(CapturedFiles, AnImageNamedAsAHostImageIsThePipelines) {
    const auto mine = [&](const std::string& call, const std::string& output) {
        return file("mine.json", R"({ "extends": ")" PENUMBRA_SOURCE_DIR R"(/pipelines/raw.json",
            "name": "mine", "inputs": { "albedo": null }, "outputs": [")" +
                                     output + R"("], "nodes": { "shade": null,
            "again": { "type": "invert", "out": { "shadow": ")" +
                                     call + R"(" } } } })");
    };
    const std::string of_lamp = " --nodes examples/invert/nodes --shot lamp --size 48x32 ";
    const auto written = [&](const std::string& pipeline, const std::string& name, const char* more = "") {
        fs::remove_all(folder_ / "o");
        const Result result = run("render " + pipeline + of_lamp + "--frames 0 --out " + in("o") + more);
        EXPECT_EQ(result.code, 0) << result.err;
        return read_file(in("o/" + name + ".0000.png"));
    };
    const std::string expected = written(mine("mask", "mask"), "mask");
    EXPECT_EQ(written(mine("albedo", "albedo"), "albedo"), expected);
    EXPECT_EQ(written(mine("albedo", "visibility"), "albedo", " --capture albedo"), expected);
}

// What lights or covers the scene may lie where a frame would be written.
TEST_F(CapturedFiles, AFrameIsNotWrittenOverWhatIsRead) {
    fs::create_directories(folder_ / "o");
    fs::copy_file(PENUMBRA_SOURCE_DIR "/scenes/lamp.glb", in("lamp.glb"));
    PlanarImage sky{.width = 8, .height = 4, .planes = {}};
    for (const char* channel : {"R", "G", "B"})
        sky.planes.push_back({.name = channel, .values = std::vector<float>(32, 1)});
    write_exr(in("o/visibility.0000.exr"), sky);
    file("lit.shot.json", R"({ "penumbra_shot": 1, "scene": "lamp.glb", "frames": 2,
        "environment": { "file": "o/visibility.0000.exr" } })");
    const std::string before = read_file(in("o/visibility.0000.exr")),
                      command = "render raw --size 48x32 --shot " + in("lit.shot.json") + " --out " + in("o");
    expect(run(command + " --frames 0..1"), 2,
           in("o/visibility.0000.exr") + ": is read, and would be written over");
    EXPECT_EQ(read_file(in("o/visibility.0000.exr")), before);
    EXPECT_FALSE(fs::exists(in("o/visibility.0000.png"))) << "nothing is written in part";
    const Result others = run(command + " --frames 1");
    EXPECT_EQ(others.code, 0) << others.err;
    EXPECT_EQ(read_file(in("o/visibility.0000.exr")), before);
}

// A buffer of vectors has four channels, and all of its elements: two for each of 12x8 cells.
TEST_F(CapturedFiles, ABufferOfVectorsIsWhole) {
    const std::string out = (folder_ / "cells").string();
    ASSERT_EQ(run("render one_ray --shot lamp --size 48x32 --frames 0 --capture cells --out " + out).code, 0);
    Diagnostics diagnostics;
    const auto cells = read_exr(folder_ / "cells/cells.0000.exr", diagnostics);
    ASSERT_TRUE(cells) << diagnostics.text();
    EXPECT_EQ(cells->planes.size(), 4u);
    EXPECT_EQ(cells->width, 2u * 12 * 8);
    EXPECT_EQ(cells->height, 1u);
}

}  // namespace
}  // namespace penumbra::test
