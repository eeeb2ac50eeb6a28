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
