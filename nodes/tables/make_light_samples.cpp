// SPDX-License-Identifier: MIT
// Build tool: writes the tables of the node `cover` into a folder, little-endian: half_planes_N.bin for N =
// 64, 128, 256 (nodes/tables/light_samples.h), first the disc's directions, then the square's, and
// light_samples.bin, a row of 256 points (two floats each, 0 where there are fewer) for each N, of the disc,
// then of the square.
#include <bit>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "nodes/tables/light_samples.h"

namespace {

bool write(const std::filesystem::path& path, const std::vector<uint32_t>& words) {
    std::ofstream file(path, std::ios::binary);
    for (const uint32_t word : words)
        for (int shift = 0; shift < 32; shift += 8) file.put(static_cast<char>(word >> shift & 255));
    file.close();
    if (!file) std::fprintf(stderr, "make_light_samples: cannot write %s\n", path.c_str());
    return static_cast<bool>(file);
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: make_light_samples FOLDER\n");
        return 2;
    }
    const std::filesystem::path folder = argv[1];
    std::vector<uint32_t> points;
    std::array<std::vector<uint32_t>, penumbra::light_sample_counts.size()> tables;
    for (const auto shape : {penumbra::LightShape::disc, penumbra::LightShape::square})
        for (size_t n = 0; n < tables.size(); ++n) {
            const uint32_t count = penumbra::light_sample_counts[n];
            const auto samples = penumbra::light_samples(count, shape);
            for (uint32_t i = 0; i < 256; ++i)
                for (const double x : i < count ? samples[i] : penumbra::LightSample{})
                    points.push_back(std::bit_cast<uint32_t>(static_cast<float>(x)));
            const auto table = penumbra::half_plane_table(samples);
            tables[n].insert(tables[n].end(), table.begin(), table.end());
        }
    for (size_t n = 0; n < tables.size(); ++n) {
        const std::string name = "half_planes_" + std::to_string(penumbra::light_sample_counts[n]) + ".bin";
        if (!write(folder / name, tables[n])) return 1;
    }
    return write(folder / "light_samples.bin", points) ? 0 : 1;
}
