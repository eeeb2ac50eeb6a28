// SPDX-License-Identifier: MIT
// What holds for a whole shot, measured on its scene: the facts that conditions in pipelines ask for. A fact
// that is true where it need not be costs time; one that is false where it must not be costs the picture, so
// doubt means true.
#pragma once

#include <map>
#include <string>

#include "host/scene/scene.h"

namespace penumbra {

// `light`: the one that masks are of; none is the sun.
std::map<std::string, bool> shot_facts(const Shot& shot, const Scene& scene,
                                       const ShotLight* light = nullptr);

}  // namespace penumbra
