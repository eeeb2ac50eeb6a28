// SPDX-License-Identifier: MIT
// Scenes, and what is to be found out about each, written by hand.
#pragma once

#include <vector>

#include "host/models/model.h"
#include "host/shots/shot.h"

namespace penumbra::test {

enum class Shadow { soft, hard, none, all };  // a sun that is a disc, a point; nothing casts; the sun has set

struct FactScene {
    const char* name;
    Model model;
    Shot shot;
    Shadow shadow;
    bool moves;
    bool alpha = false;
    bool sun_moves = false;
    bool casters_move = false;
};

std::vector<FactScene> fact_scenes();

}  // namespace penumbra::test
