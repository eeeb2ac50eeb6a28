// SPDX-License-Identifier: MIT
// How far an anti-aliased picture is from the mean of many samples of every pixel, and how restless it is:
// picture_error IMAGE FINE, folders of `penumbra render` with color.NNNN.exr, and lit.NNNN.exr of N x N times
// the pixels of the same frames, which come one after the other. All after c / (1 + c), over red, green and
// blue. (docs/performance.md)
#include <fmt/core.h>

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

void measure(const fs::path& folder, const fs::path& fine) {
    constexpr double jump = 0.1;
    double error = 0, change = 0, jumps = 0, values = 0, changes = 0;
    std::vector<double> before;
    for (int frame = 0; frame < 10000; ++frame) {
        const fs::path file = folder / fmt::format("color.{:04}.exr", frame);
        if (!fs::exists(file)) continue;
        const PlanarImage image = read(file), truth = read(fine / fmt::format("lit.{:04}.exr", frame));
        const uint32_t side = truth.width / image.width;
        if (side == 0 || image.width * side != truth.width || image.height * side != truth.height)
            throw std::runtime_error("the sizes do not go into each other");
        std::vector<double> off = means(image, 1);
        const std::vector<double> true_means = means(truth, side);
        for (size_t i = 0; i < off.size(); ++i) {
            off[i] -= true_means[i];
            error += off[i] * off[i];
        }
        values += double(off.size());
        for (size_t p = 0; p + 2 < before.size(); p += 3) {
            double most = 0;
            for (size_t i = p; i < p + 3; ++i) {
                change += (off[i] - before[i]) * (off[i] - before[i]);
                most = std::max(most, std::abs(off[i] - before[i]));
            }
            jumps += most > jump;
            changes += 3;
        }
        before = std::move(off);
    }
    if (changes == 0) throw std::runtime_error(folder.string() + ": no two frames of color");
    fmt::print("rmse {:.4f}, change from frame to frame {:.4f}, pixels that jump by more than {}: {:.2f} %\n",
               std::sqrt(error / values), std::sqrt(change / changes), jump, 300 * jumps / changes);
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
