// SPDX-License-Identifier: MIT
// Image files come back as they were written, and a failure leaves neither a part of a file nor the loss of
// an old one.
#include "host/images/image_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <webp/demux.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <memory>
#include <thread>

#include "host/images/animation_file.h"
#include "tests/test_folder.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

class ImageFile : public ::testing::Test {
  protected:
    size_t files() const {
        return static_cast<size_t>(
            std::distance(fs::directory_iterator(folder_.path()), fs::directory_iterator()));
    }

    test::TestFolder folder_;
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
    // A folder in the file's place.
    fs::create_directories(folder_ / "taken.exr/inside");
    EXPECT_THROW(write_exr(folder_ / "taken.exr", sample(4, 4)), FileError);
    EXPECT_EQ(files(), 1u);
    PlanarImage wrong = sample(4, 4);
    wrong.planes[0].values.pop_back();
    EXPECT_THROW(write_exr(folder_ / "b.exr", wrong), std::invalid_argument);
    EXPECT_EQ(files(), 1u);
}

// A limit on the size of files stands in for a full disk: the same write fails half way.
TEST_F(ImageFile, FullDiskKeepsTheOldFile) {
    write_exr(folder_ / "a.exr", sample(4, 4));
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const auto on_signal = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{100, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    std::string text;
    try {
        write_exr(folder_ / "a.exr", sample(64, 64));
    } catch (const FileError& error) {
        text = error.what();
    }
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, on_signal);
    EXPECT_NE(text.find("a.exr: cannot be written: "), std::string::npos) << text;
    EXPECT_EQ(files(), 1u);
    Diagnostics diagnostics;
    const auto old = read_exr(folder_ / "a.exr", diagnostics);
    ASSERT_TRUE(old);
    EXPECT_EQ(old->width, 4u);
}

// A process that was killed before its rename leaves a file of this name; whoever writes the file next takes
// it over.
TEST_F(ImageFile, WhatAKilledProcessLeftIsTakenOver) {
    std::ofstream(folder_ / "a.exr.part") << std::string(1 << 20, 'x');
    write_exr(folder_ / "a.exr", sample(4, 4));
    EXPECT_EQ(files(), 1u);
    Diagnostics diagnostics;
    EXPECT_TRUE(read_exr(folder_ / "a.exr", diagnostics)) << diagnostics.text();
}

TEST_F(ImageFile, TwoWritersOfOneFileLeaveOneOfTheirs) {
    const std::vector<std::byte> ones(1 << 20, std::byte{1}), twos(1 << 20, std::byte{2});
    const auto write_often = [&](const std::vector<std::byte>& bytes) {
        for (int i = 0; i < 50; ++i) write_file(folder_ / "a", bytes);
    };
    std::thread other([&] { write_often(ones); });
    write_often(twos);
    other.join();
    std::ifstream stream(folder_ / "a", std::ios::binary);
    const std::string text(std::istreambuf_iterator<char>(stream), {});
    ASSERT_EQ(text.size(), ones.size());
    EXPECT_EQ(text.find_first_not_of(text[0]), std::string::npos);
    EXPECT_EQ(files(), 1u);
}

TEST_F(ImageFile, LinksInThePartsPlaceAreNotFollowed) {
    std::ofstream(folder_ / "victim") << "kept";
    fs::create_symlink(folder_ / "victim", folder_ / "a.exr.part");
    EXPECT_THROW(write_exr(folder_ / "a.exr", sample(4, 4)), FileError);
    EXPECT_EQ(fs::file_size(folder_ / "victim"), 4u);
}

// Whoever made a link wants the file behind it, be it there already or not.
TEST_F(ImageFile, LinksInTheFilesPlaceAreFollowed) {
    fs::create_directories(folder_ / "elsewhere");
    std::ofstream(folder_ / "elsewhere/old.exr") << "older";
    fs::create_symlink("elsewhere/old.exr", folder_ / "a.exr");
    fs::create_symlink("a.exr", folder_ / "b.exr");
    fs::create_symlink("elsewhere/new.exr", folder_ / "c.exr");
    for (const char* name : {"b.exr", "c.exr"}) write_exr(folder_ / name, sample(4, 4));
    for (const char* name : {"a.exr", "b.exr", "c.exr"}) {
        EXPECT_TRUE(fs::is_symlink(folder_ / name)) << name;
        Diagnostics diagnostics;
        EXPECT_TRUE(read_exr(folder_ / name, diagnostics)) << diagnostics.text();
    }
    EXPECT_EQ(files(), 4u) << "nothing else is left beside them";
    fs::create_symlink("d.exr", folder_ / "d.exr");
    EXPECT_THROW(write_exr(folder_ / "d.exr", sample(4, 4)), FileError) << "it leads nowhere";
    EXPECT_TRUE(fs::is_symlink(folder_ / "d.exr"));
}

// A pipe as any device: it is still one afterwards.
TEST_F(ImageFile, APipeInTheFilesPlaceIsWrittenInto) {
    const fs::path pipe = folder_ / "pipe";
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    const int end = ::open(pipe.c_str(), O_RDWR | O_NONBLOCK);
    ASSERT_GE(end, 0);
    const std::string text = "what is written";
    write_file(pipe, std::as_bytes(std::span(text)));
    EXPECT_TRUE(fs::is_fifo(pipe));
    std::string read(2 * text.size(), '\0');
    const ssize_t count = ::read(end, read.data(), read.size());
    ::close(end);
    EXPECT_EQ(read.substr(0, count < 0 ? 0 : size_t(count)), text);
    EXPECT_EQ(files(), 1u);
}

// What a header claims is held against the file before anything is allocated for it.
TEST_F(ImageFile, HeadersMayNotClaimMoreThanTheFileHolds) {
    write_exr(folder_ / "a.exr", sample(40, 40));
    std::string bytes;
    {
        std::ifstream stream(folder_ / "a.exr", std::ios::binary);
        bytes.assign(std::istreambuf_iterator<char>(stream), {});
    }
    const std::string name("dataWindow\0box2i\0\x10\0\0\0", 21);
    const size_t at = bytes.find(name);
    ASSERT_NE(at, std::string::npos);
    const auto claim = [&](int32_t right, int32_t bottom) {
        std::string changed = bytes;
        std::memcpy(changed.data() + at + name.size() + 8, &right, 4);
        std::memcpy(changed.data() + at + name.size() + 12, &bottom, 4);
        std::ofstream(folder_ / "b.exr", std::ios::binary) << changed;
        Diagnostics diagnostics;
        EXPECT_FALSE(read_exr(folder_ / "b.exr", diagnostics));
        return diagnostics.text();
    };
    EXPECT_NE(claim(24999, 24999)
                  .find("b.exr: 25000 x 25000 texels of 3 channels take more than 2048 MiB, the limit for "
                        "one file (PENUMBRA_INPUT_LIMIT_MIB raises it)"),
              std::string::npos);
    EXPECT_NE(claim(8191, 8191).find("8192 x 8192 texels of 3 channels are more than a file of"),
              std::string::npos);
    EXPECT_NE(claim(1 << 30, 0).find("1073741825 x 1 texels is not supported"), std::string::npos);
    ::setenv("PENUMBRA_INPUT_LIMIT_MIB", "1000000", 1);
    EXPECT_NE(claim(24999, 24999).find("more than a file of"), std::string::npos);
    ::setenv("PENUMBRA_INPUT_LIMIT_MIB", "much", 1);
    EXPECT_NE(claim(24999, 24999).find("PENUMBRA_INPUT_LIMIT_MIB: \"much\" is no whole number"),
              std::string::npos);
    ::unsetenv("PENUMBRA_INPUT_LIMIT_MIB");
}

// The address of texel (0, 0) of such a file is outside of memory (sanitized builds say so of pointers).
TEST_F(ImageFile, WindowsMayBeFarAway) {
    const std::array<float, 6> texels{1, 2, 3, 4, 5, 6};
    for (const int corner : {-1000000000, -1, 1000000000}) {
        Imf::Header header(3, 2);
        header.dataWindow() = {{corner, corner}, {corner + 2, corner + 1}};
        header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
        const std::string path = (folder_ / "far.exr").string();
        {
            Imf::OutputFile file(path.c_str(), header);
            Imf::FrameBuffer planes;
            planes.insert("Y", Imf::Slice::Make(Imf::FLOAT, texels.data(), header.dataWindow()));
            file.setFrameBuffer(planes);
            file.writePixels(2);
        }
        Diagnostics diagnostics;
        const auto image = read_exr(path, diagnostics);
        ASSERT_TRUE(image) << diagnostics.text();
        EXPECT_TRUE(std::ranges::equal(image->planes.at(0).values, texels)) << corner;
    }
}

// Of an attribute's size, too, and of each part: OpenEXR takes so much memory before it reads.
TEST_F(ImageFile, AttributesMayNotClaimMoreThanTheFileHas) {
    const auto read = [](const fs::path& path) {
        std::ifstream stream(path, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(stream), {});
    };
    const auto refused = [&](std::string bytes, std::string_view attribute, size_t at, uint32_t value) {
        const size_t where = bytes.rfind(attribute);
        EXPECT_NE(where, std::string::npos);
        std::memcpy(bytes.data() + where + attribute.size() + at, &value, 4);
        std::ofstream(folder_ / "b.exr", std::ios::binary) << bytes;
        Diagnostics diagnostics;
        EXPECT_FALSE(read_exr(folder_ / "b.exr", diagnostics));
        return diagnostics.text();
    };
    using namespace std::string_view_literals;
    write_exr(folder_ / "a.exr", sample(40, 40));
    const std::string one = read(folder_ / "a.exr");
    EXPECT_NE(refused(one, "screenWindowWidth\0float\0"sv, 0, 0x70000000)
                  .find("attribute \"screenWindowWidth\" claims 1879048192 bytes, more than the file has"),
              std::string::npos);
    EXPECT_NE(refused(one, "screenWindowWidth\0float\0"sv, 0, 0xffffffff).find("claims 4294967295 bytes"),
              std::string::npos);
    // Values that do not end where their attributes do.
    const auto corpus_says = [](const char* name) {
        Diagnostics diagnostics;
        EXPECT_FALSE(read_exr(fs::path(PENUMBRA_SOURCE_DIR) / "tests/fuzz/corpus/exr" / name, diagnostics));
        return diagnostics.text();
    };
    EXPECT_NE(corpus_says("channels_beyond_their_attribute.exr").find("54 bytes are no chlist"),
              std::string::npos);
    EXPECT_NE(corpus_says("channels_without_an_end.exr").find("\"channels\": 56 bytes are no chlist"),
              std::string::npos);
    EXPECT_NE(refused(one, "pixelAspectRatio\0float\0"sv, 0, 5).find("5 bytes are no float"),
              std::string::npos);
    // The last part's.
    const std::string parts = read(fs::path(PENUMBRA_SOURCE_DIR) / "tests/fuzz/corpus/exr/parts.exr");
    EXPECT_NE(refused(parts, "screenWindowWidth\0float\0"sv, 0, 0x70000000).find("claims 1879048192 bytes"),
              std::string::npos);
    EXPECT_NE(refused(parts, "dataWindow\0box2i\0\x10\0\0\0"sv, 12, 0x10000000)
                  .find("11 x 268435457 texels is not supported"),
              std::string::npos);
    Diagnostics diagnostics;
    EXPECT_TRUE(read_exr(fs::path(PENUMBRA_SOURCE_DIR) / "tests/fuzz/corpus/exr/parts.exr", diagnostics))
        << diagnostics.text();
    // By its version, or by its part's type; OpenEXR would not free what it has read of this one.
    EXPECT_NE(corpus_says("deep_that_breaks_off.exr").find("deep images are not supported"),
              std::string::npos);
}

// A flat image is the smallest file of its size; it is read.
TEST_F(ImageFile, FlatImagesAreRead) {
    const PlanarImage flat{4096, 2048, {{"Y", PlaneType::real, std::vector<float>(size_t(4096) * 2048), {}}}};
    write_exr(folder_ / "a.exr", flat);
    Diagnostics diagnostics;
    EXPECT_TRUE(read_exr(folder_ / "a.exr", diagnostics)) << diagnostics.text();
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
    EXPECT_FALSE(read_exr(folder_ / std::string(300, 'a'), diagnostics));
    ASSERT_EQ(diagnostics.size(), 3u);
    EXPECT_NE(diagnostics.list()[2].message.find("cannot be read: "), std::string::npos);
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

// Read by libwebp's decoder: frames in their order, for so long, for ever, and near what they were.
TEST(AnimationFile, ComesBackFrameByFrame) {
    constexpr uint32_t width = 40, height = 24;
    std::vector<std::vector<uint8_t>> frames(3, std::vector<uint8_t>(4 * width * height, 255));
    for (size_t f = 0; f < frames.size(); ++f)
        for (size_t p = 0; p < size_t{width} * height; ++p)
            for (size_t c = 0; c < 3; ++c)
                frames[f][4 * p + c] = static_cast<uint8_t>(p % width < 10 * (f + 1) ? 20 : 220);
    const std::vector<std::byte> file = webp_animation(width, height, frames, 70);
    const WebPData data{reinterpret_cast<const uint8_t*>(file.data()), file.size()};
    const std::unique_ptr<WebPAnimDecoder, decltype(&WebPAnimDecoderDelete)> decoder(
        WebPAnimDecoderNew(&data, nullptr), WebPAnimDecoderDelete);
    ASSERT_TRUE(decoder);
    WebPAnimInfo info{};
    ASSERT_TRUE(WebPAnimDecoderGetInfo(decoder.get(), &info));
    EXPECT_EQ(info.canvas_width, width);
    EXPECT_EQ(info.canvas_height, height);
    EXPECT_EQ(info.loop_count, 0u) << "for ever";
    ASSERT_EQ(info.frame_count, frames.size());
    for (size_t f = 0; f < frames.size(); ++f) {
        uint8_t* rgba = nullptr;
        int until_ms = 0;
        ASSERT_TRUE(WebPAnimDecoderGetNext(decoder.get(), &rgba, &until_ms));
        EXPECT_EQ(until_ms, 70 * static_cast<int>(f + 1));
        double sum = 0;
        for (size_t i = 0; i < frames[f].size(); ++i) sum += std::pow(int{rgba[i]} - int{frames[f][i]}, 2);
        EXPECT_LT(std::sqrt(sum / static_cast<double>(frames[f].size())), 12) << f;
    }
    EXPECT_THROW(webp_animation(width, height, {}, 70), FileError);
    frames[1].pop_back();
    EXPECT_THROW(webp_animation(width, height, frames, 70), FileError);
    const std::vector<std::vector<uint8_t>> wide(1, std::vector<uint8_t>(80000));
    EXPECT_THROW(webp_animation(20000, 1, wide, 70), FileError);
}

}  // namespace
}  // namespace penumbra
