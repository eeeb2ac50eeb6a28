// SPDX-License-Identifier: MIT
// A small scene for tests of whole pipelines: a floor that faces the sun and fills the view, a bar and a
// block above it, one of which moves; camera and sun move too. A lamp for pipelines that take a light that is
// near.
#pragma once

#include <array>

#include "host/shots/shot.h"

namespace penumbra::test {

// The model is written once per process, into a temporary folder.
Shot plaza_shot(std::array<uint32_t, 2> size, uint32_t frames);

}  // namespace penumbra::test
