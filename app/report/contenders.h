// SPDX-License-Identifier: MIT
// What competes: pipelines, and plain rays as the line that they have to beat. Brute force of N rays is the
// pipeline `raw` whose trace casts N rays per pixel, towards points that are spread evenly over the sun (the
// better case for brute force: they are stratified, not random); `many_rays` casts them only where no proof
// has decided a tile before.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/shipped_files.h"
#include "penumbra/check.h"
#include "penumbra/node_set.h"

namespace penumbra::report {

struct PlainRays {
    uint32_t per_pixel = 1;
    bool proofs = false;  // before them: many_rays, not raw
};

struct Contender {
    std::string id;    // the pipeline's name, or "rays_16", "many_rays_16"; unique
    std::string file;  // as a command line would give it
    std::string doc;
    std::optional<PlainRays> plain = {};
    std::vector<std::string> settings = {};  // --set; where there are any it is no pipeline of its own
    CheckedPipeline pipeline = {};

    bool variant() const { return !settings.empty(); }
    bool brute_force() const { return plain && !plain->proofs; }
};

// A shipped pipeline that cannot compete, and why.
struct LeftOut {
    std::string file, why;
};

struct Contenders {
    // Pipelines as given, then brute force and many_rays by rising rays, each with those numbers that no
    // given one has.
    std::vector<Contender> list;
    std::vector<LeftOut> left_out;
};

// `wanted`: files, or names of shipped pipelines; empty: all shipped ones, and those that the standalone host
// cannot run, or that put out no `visibility`, are left out (with `without_maps` also those that read shadow
// maps: drawing these is no part of a mask's cost). A named one that cannot compete is an error.
std::optional<Contenders> open_contenders(const std::vector<std::string>& wanted,
                                          const std::filesystem::path& root, const NodeSet& nodes,
                                          Diagnostics& diagnostics, bool without_maps = false,
                                          bool of_lamp = false);

}  // namespace penumbra::report
