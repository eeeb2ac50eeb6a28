// SPDX-License-Identifier: MIT
// Writes tuning scenes and their shots: those of scenes/tuning/, or any other ones. Rooms at night come where
// their family is named.
//   penumbra_make_tuning_shots --out DIR [--family NAME] [--seed N]
#include <charconv>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

#include "host/generated/tuning/families.h"
#include "host/generated/tuning/night.h"
#include "host/images/image_file.h"
#include "host/models/glb_writer.h"

namespace {

using namespace penumbra;

struct Arguments {
    std::filesystem::path out;
    std::optional<std::string_view> family;
    std::optional<uint32_t> seed;
};

std::optional<Arguments> refused(const std::string& why) {
    std::fprintf(
        stderr,
        "%s\nusage: penumbra_make_tuning_shots --out DIR [--family NAME] [--seed N]\nfamilies:", why.c_str());
    for (const tuning::Family& family : tuning::all_families) std::fprintf(stderr, " %s", family.name);
    std::fprintf(stderr, " %s\n", tuning::night_family);
    return std::nullopt;
}

bool known(std::string_view name) {
    if (name == tuning::night_family) return true;
    for (const tuning::Family& family : tuning::all_families)
        if (name == family.name) return true;
    return false;
}

std::optional<Arguments> parse(std::span<char*> words) {
    Arguments out;
    for (size_t i = 0; i < words.size(); i += 2) {
        const std::string_view key = words[i];
        if (i + 1 == words.size()) return refused(std::string(key) + ": no value follows");
        const std::string_view value = words[i + 1];
        if (key == "--out") {
            out.out = value;
        } else if (key == "--family") {
            if (!known(value)) return refused("--family: there is no \"" + std::string(value) + "\"");
            out.family = value;
        } else if (key == "--seed") {
            uint32_t seed = 0;
            const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), seed);
            if (error != std::errc() || end != value.data() + value.size())
                return refused("--seed: \"" + std::string(value) + "\" is no number from 0 to 4294967295");
            out.seed = seed;
        } else {
            return refused("unknown option " + std::string(key));
        }
    }
    if (out.out.empty()) return refused("--out: which folder to write to is missing");
    return out;
}

void write(const std::filesystem::path& folder, const std::string& name, const Model& model,
           const std::string& shot) {
    write_file(folder / (name + ".glb"), to_glb(model));
    write_file(folder / (name + ".shot.json"), std::as_bytes(std::span(shot)));
}

}  // namespace

int main(int argc, char** argv) {
    const auto arguments = parse(std::span(argv + 1, static_cast<size_t>(argc - 1)));
    if (!arguments) return 2;
    try {
        std::filesystem::create_directories(arguments->out);
        const std::vector<uint32_t> seeds =
            arguments->seed
                ? std::vector<uint32_t>{*arguments->seed}
                : std::vector<uint32_t>(tuning::committed_seeds.begin(), tuning::committed_seeds.end());
        if (arguments->family == tuning::night_family)
            for (const uint32_t seed : seeds) {
                const tuning::NightScene scene = tuning::make_night_scene(seed);
                write(arguments->out, scene.name, scene.model, scene.shot);
                std::printf("%s: %zu triangles\n", scene.name.c_str(), scene.model.triangle_count());
            }
        for (const tuning::Family& family : tuning::all_families) {
            if (arguments->family && *arguments->family != family.name) continue;
            for (const uint32_t seed : seeds) {
                const tuning::TuningScene scene = tuning::make_tuning_scene(family, seed);
                write(arguments->out, scene.name, scene.model, scene.shot);
                const tuning::Setting& s = scene.setting;
                std::printf("%s: %zu triangles, penumbrae of %.2f px about the middle, sun of %.2f degrees\n",
                            scene.name.c_str(), scene.model.triangle_count(), s.width_px, s.sun_radius_deg);
            }
        }
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
