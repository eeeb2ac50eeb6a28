// SPDX-License-Identifier: MIT
// How far an anti-aliased picture is from the mean of many samples of every pixel, and how restless it is:
// picture_error IMAGE FINE, folders of `penumbra render` with color, lit, motion and view_depth.NNNN.exr, and
// lit.NNNN.exr of N x N times the pixels of the same frames, which come one after the other. What a pixel's
// error was before is looked up where its surface was, so that an edge that goes on by a pixel and takes its
// error along is no change. All after c / (1 + c), over red, green and blue. (docs/performance.md)
#include <fmt/core.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <vector>

#include "host/images/image_file.h"
#include "penumbra/diagnostic.h"

using namespace penumbra;

namespace {

namespace fs = std::filesystem;

// The means of blocks of `side` squared pixels, red, green and blue in turn.
std::vector<double> means(const PlanarImage& image, uint32_t side) {
    const uint32_t width = image.width / side, height = image.height / side;
    std::vector<double> out(size_t{width} * height * 3);
    size_t c = 0;
    for (const char* name : {"R", "G", "B"}) {
        const Plane* plane = image.find(name);
        if (!plane) throw std::runtime_error(fmt::format("there is no channel {}", name));
        for (uint32_t y = 0; y < height * side; ++y)
            for (uint32_t x = 0; x < width * side; ++x) {
                const double v = plane->values[size_t{y} * image.width + x];
                out[(size_t{y / side} * width + x / side) * 3 + c] += v / (1 + v) / (side * side);
            }
        ++c;
    }
    return out;
}

PlanarImage read(const fs::path& file) {
    Diagnostics diagnostics;
    auto image = read_exr(file, diagnostics);
    if (!image) throw std::runtime_error(diagnostics.text());
    return std::move(*image);
}

PlanarImage read(const fs::path& folder, const char* resource, int frame) {
    return read(folder / fmt::format("{}.{:04}.exr", resource, frame));
}

std::vector<double> minus(std::vector<double> a, const std::vector<double>& b) {
    for (size_t i = 0; i < a.size(); ++i) a[i] -= b[i];
    return a;
}

// Where each pixel's surface was in the frame before, in texels from the first one's centre; of the nearest
// surface in 3x3 pixels, as an edge belongs to what is in front.
class Past {
  public:
    Past(const PlanarImage& depth, const PlanarImage& motion)
        : width_(int(depth.width)), height_(int(depth.height)) {
        const std::vector<float>&z = depth.planes.front().values, &x = motion.find("X")->values,
              &y = motion.find("Y")->values;
        for (int row = 0; row < height_; ++row)
            for (int column = 0; column < width_; ++column) {
                size_t nearest = at(column, row);
                for (int i = 0; i < 9; ++i) {
                    const int c = column + i % 3 - 1, r = row + i / 3 - 1;
                    if (c < 0 || r < 0 || c >= width_ || r >= height_) continue;
                    if (z[at(c, r)] > 0 && !(z[nearest] > 0 && z[nearest] <= z[at(c, r)])) nearest = at(c, r);
                }
                places_.push_back({column + double(x[nearest]) * width_, row + double(y[nearest]) * height_});
            }
    }
    bool seen(size_t pixel) const {
        const auto [x, y] = places_[pixel];
        return x >= 0 && y >= 0 && x <= width_ - 1 && y <= height_ - 1;
    }
    double of(const std::vector<double>& values, size_t pixel, size_t channel) const {
        const auto [x, y] = places_[pixel];
        const int left = std::min(int(x), width_ - 2), top = std::min(int(y), height_ - 2);
        const auto value = [&](int c, int r) { return values[at(c, r) * 3 + channel]; };
        return std::lerp(std::lerp(value(left, top), value(left + 1, top), x - left),
                         std::lerp(value(left, top + 1), value(left + 1, top + 1), x - left), y - top);
    }

  private:
    size_t at(int column, int row) const { return size_t(row) * size_t(width_) + size_t(column); }

    int width_, height_;
    std::vector<std::array<double, 2>> places_;
};

void measure(const fs::path& folder, const fs::path& fine) {
    constexpr double jump = 0.1;
    double error = 0, change = 0, values = 0, pixels = 0;
    double jumps = 0, unfiltered_jumps = 0, alone = 0;  // alone: and the unfiltered picture does not
    std::vector<double> before, unfiltered_before;
    for (int frame = 0; frame < 10000; ++frame) {
        if (!fs::exists(folder / fmt::format("color.{:04}.exr", frame))) continue;
        const PlanarImage image = read(folder, "color", frame), truth = read(fine, "lit", frame);
        const uint32_t side = truth.width / image.width;
        if (side == 0 || image.width * side != truth.width || image.height * side != truth.height)
            throw std::runtime_error("the sizes do not go into each other");
        const std::vector<double> true_means = means(truth, side);
        std::vector<double> off = minus(means(image, 1), true_means),
                            unfiltered_off = minus(means(read(folder, "lit", frame), 1), true_means);
        for (const double e : off) error += e * e;
        values += double(off.size());
        const Past past(read(folder, "view_depth", frame), read(folder, "motion", frame));
        for (size_t p = 0; p < before.size() / 3; ++p) {
            if (!past.seen(p)) continue;
            double most = 0, unfiltered_most = 0;
            for (size_t c = 0; c < 3; ++c) {
                const double by = off[3 * p + c] - past.of(before, p, c);
                change += by * by;
                most = std::max(most, std::abs(by));
                unfiltered_most = std::max(
                    unfiltered_most, std::abs(unfiltered_off[3 * p + c] - past.of(unfiltered_before, p, c)));
            }
            jumps += most > jump;
            unfiltered_jumps += unfiltered_most > jump;
            alone += most > jump && !(unfiltered_most > jump);
            ++pixels;
        }
        before = std::move(off);
        unfiltered_before = std::move(unfiltered_off);
    }
    if (pixels == 0) throw std::runtime_error(folder.string() + ": no two frames of color");
    fmt::print(
        "rmse {:.4f}, change from frame to frame {:.4f}\n"
        "pixels that jump by more than {}: {:.2f} %, of the unfiltered picture {:.2f} %, where that does not "
        "{:.3f} %\n",
        std::sqrt(error / values), std::sqrt(change / (3 * pixels)), jump, 100 * jumps / pixels,
        100 * unfiltered_jumps / pixels, 100 * alone / pixels);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) {
        fmt::print(stderr, "usage: picture_error IMAGE FINE\n");
        return 2;
    }
    try {
        measure(argv[1], argv[2]);
    } catch (const std::exception& e) {
        fmt::print(stderr, "{}\n", e.what());
        return 1;
    }
    return 0;
}
