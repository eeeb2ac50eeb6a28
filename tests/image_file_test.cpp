// SPDX-License-Identifier: MIT
// Image files come back as they were written, and a failure leaves neither a part of a file nor the loss of
// an old one.
#include "host/images/image_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>

namespace penumbra {
namespace {

namespace fs = std::filesystem;

class ImageFile : public ::testing::Test {
  protected:
    void SetUp() override {
        folder_ =
            fs::path(::testing::TempDir()) /
            (std::string("image_file_") + ::testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::remove_all(folder_);
        fs::create_directories(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    size_t files() const {
        return static_cast<size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
    }

    fs::path folder_;
};

PlanarImage sample(uint32_t width, uint32_t height) {
    PlanarImage image{
        width,
        height,
        {{"Y", PlaneType::real, {}, {}}, {"H", PlaneType::half, {}, {}}, {"W", PlaneType::uint, {}, {}}}};
    for (uint32_t i = 0; i < width * height; ++i) {
        image.planes[0].values.push_back(std::sin(static_cast<float>(i)) * 1e-30f);
        image.planes[1].values.push_back(static_cast<float>(i) * 0.25f);  // exact in half
        image.planes[2].words.push_back(0xdeadbeefu * (i + 1));
    }
    image.planes[0].values[0] = std::numeric_limits<float>::quiet_NaN();
    image.planes[0].values[1] = -std::numeric_limits<float>::infinity();
    return image;
}

std::vector<uint32_t> bits(const std::vector<float>& values) {
    std::vector<uint32_t> out(values.size());
    std::ranges::transform(values, out.begin(), [](float value) { return std::bit_cast<uint32_t>(value); });
    return out;
}

TEST_F(ImageFile, ExrComesBackBitForBit) {
    const PlanarImage image = sample(17, 5);
    write_exr(folder_ / "a.exr", image);
    Diagnostics diagnostics;
    const auto back = read_exr(folder_ / "a.exr", diagnostics);
    ASSERT_TRUE(back) << diagnostics.text();
    EXPECT_EQ(back->width, 17u);
    EXPECT_EQ(back->height, 5u);
    ASSERT_EQ(back->planes.size(), 3u);
    const Plane* real = back->find("Y");
    ASSERT_TRUE(real && back->find("H") && back->find("W"));
    EXPECT_EQ(bits(real->values), bits(image.planes[0].values));  // NaN too
    EXPECT_EQ(back->find("H")->type, PlaneType::half);
    EXPECT_EQ(back->find("H")->values, image.planes[1].values);
    EXPECT_EQ(back->find("W")->words, image.planes[2].words);
    EXPECT_EQ(back->find("Z"), nullptr);
    EXPECT_EQ(files(), 1u);
}

TEST_F(ImageFile, SameImageSameBytes) {
    write_exr(folder_ / "a.exr", sample(17, 5));
    write_exr(folder_ / "b.exr", sample(17, 5));
    const auto bytes = [&](const char* name) {
        std::ifstream stream(folder_ / name, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(stream), {});
    };
    EXPECT_EQ(bytes("a.exr"), bytes("b.exr"));
}

TEST_F(ImageFile, FailureLeavesNothingBehind) {
    EXPECT_THROW(write_exr(folder_ / "no/such/folder.exr", sample(4, 4)), FileError);
    // A folder in the file's place: everything is written, and the last step fails.
    fs::create_directories(folder_ / "taken.exr/inside");
    EXPECT_THROW(write_exr(folder_ / "taken.exr", sample(4, 4)), FileError);
    EXPECT_EQ(files(), 1u);
    PlanarImage wrong = sample(4, 4);
    wrong.planes[0].values.pop_back();
    EXPECT_THROW(write_exr(folder_ / "b.exr", wrong), std::invalid_argument);
    EXPECT_EQ(files(), 1u);
}

TEST_F(ImageFile, FullDiskKeepsTheOldFile) {
    if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
    write_exr(folder_ / "a.exr", sample(4, 4));
    // The partial file is made by name, so a link to the device that is always full stands in for a full
    // disk.
    const fs::path part = folder_ / ("a.exr." + std::to_string(::getpid()) + ".part");
    fs::create_symlink("/dev/full", part);
    try {
        write_exr(folder_ / "a.exr", sample(64, 64));
        ADD_FAILURE() << "writing to a full disk succeeded";
    } catch (const FileError& error) {
        EXPECT_NE(std::string(error.what()).find("a.exr"), std::string::npos);
    }
    EXPECT_EQ(files(), 1u);
    Diagnostics diagnostics;
    const auto old = read_exr(folder_ / "a.exr", diagnostics);
    ASSERT_TRUE(old);
    EXPECT_EQ(old->width, 4u);
}

TEST_F(ImageFile, BrokenExrIsADiagnostic) {
    write_exr(folder_ / "a.exr", sample(40, 40));
    std::string bytes;
    {
        std::ifstream stream(folder_ / "a.exr", std::ios::binary);
        bytes.assign(std::istreambuf_iterator<char>(stream), {});
    }
    for (size_t length = 0; length < bytes.size(); length += 97) {
        std::ofstream(folder_ / "b.exr", std::ios::binary) << bytes.substr(0, length);
        Diagnostics diagnostics;
        EXPECT_FALSE(read_exr(folder_ / "b.exr", diagnostics)) << length;
        EXPECT_EQ(diagnostics.size(), 1u);
    }
    Diagnostics diagnostics;
    EXPECT_FALSE(read_exr(folder_ / "missing.exr", diagnostics));
    EXPECT_FALSE(read_exr(folder_, diagnostics));
    EXPECT_EQ(diagnostics.size(), 2u);
}

TEST_F(ImageFile, PngIsWritten) {
    const std::vector<float> grey{0, 0.5f, 1, std::numeric_limits<float>::quiet_NaN()};
    write_png_linear(folder_ / "a.png", 2, 2, grey);
    std::vector<float> rgb(12, 0.5f);
    write_png_color(folder_ / "b.png", 2, 2, rgb);
    for (const char* name : {"a.png", "b.png"}) {
        std::ifstream stream(folder_ / name, std::ios::binary);
        char signature[8] = {};
        stream.read(signature, 8);
        EXPECT_EQ(std::string(signature + 1, 3), "PNG") << name;
    }
    EXPECT_THROW(write_png_linear(folder_ / "c.png", 3, 2, grey), std::invalid_argument);
    EXPECT_EQ(files(), 2u);
}

}  // namespace
}  // namespace penumbra
