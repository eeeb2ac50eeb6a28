// SPDX-License-Identifier: MIT
// Whole pictures against each other, as compare --signal lit judges them.
#include "app/lit_picture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "host/images/image_decode.h"
#include "tests/test_folder.h"

namespace penumbra {
namespace {

Picture uniform(uint32_t width, uint32_t height, glm::vec3 rgb) {
    return {width, height, std::vector<glm::vec3>(size_t{width} * height, rgb)};
}

TEST(LitPictureError, IsNothingForTheSameAndKnownForAnOffset) {
    const Picture truth = uniform(24, 16, {0.5f, 0.5f, 0.5f});
    const PictureError same = picture_error(truth, truth);
    EXPECT_EQ(same.relmse, 0);
    EXPECT_EQ(*same.bias, 0);
    EXPECT_EQ(same.flip.mean, 0);
    const PictureError brighter = picture_error(uniform(24, 16, {0.6f, 0.6f, 0.6f}), truth);
    EXPECT_NEAR(brighter.relmse, 3 * 0.01 / 0.26, 1e-6);
    EXPECT_NEAR(*brighter.bias, 0.2, 1e-6);
    EXPECT_GT(brighter.flip.mean, 0.05);
}

// What a display clips cannot be seen, but is an error of the radiance.
TEST(LitPictureError, NobodySeesWhatIsBrighterThanWhite) {
    const PictureError error = picture_error(uniform(24, 16, {5, 5, 5}), uniform(24, 16, {2, 2, 2}));
    EXPECT_EQ(error.flip.mean, 0);
    EXPECT_GT(error.relmse, 1);
}

TEST(LitPictureError, WhatIsNoNumberIsCountedAndSeen) {
    Picture broken = uniform(24, 16, {0.5f, 0.5f, 0.5f});
    broken.rgb[100].y = std::numeric_limits<float>::quiet_NaN();
    const PictureError error = picture_error(broken, uniform(24, 16, {0.5f, 0.5f, 0.5f}));
    EXPECT_EQ(error.nonfinite, 1u);
    EXPECT_TRUE(std::isfinite(error.relmse));
    EXPECT_GT(error.flip.mean, 0);
    Diagnostics diagnostics;
    EXPECT_FALSE(is_finite(broken, "truth/lit.0000.exr", diagnostics)) << "nothing to hold an image against";
    EXPECT_NE(diagnostics.text().find("truth/lit.0000.exr: is a reference, and pixel 4,4"), std::string::npos)
        << diagnostics.text();
}

TEST(LitPictureError, AFileIsReadAsItWasWritten) {
    Picture picture = uniform(5, 3, {1, 2, 3});
    picture.rgb[7] = {0.25f, 0.5f, 8};
    const test::TestFolder folder;
    const auto file = folder / "lit.exr";
    write_exr(file, planar(picture));
    Diagnostics diagnostics;
    const auto read = read_picture(file, diagnostics);
    ASSERT_TRUE(read) << diagnostics.text();
    EXPECT_EQ(read->rgb, picture.rgb);
    std::filesystem::remove(file);
    EXPECT_FALSE(read_picture(file, diagnostics));
    EXPECT_FALSE(diagnostics.empty());
}

}  // namespace
}  // namespace penumbra
