// SPDX-License-Identifier: MIT
// A small scene for tests of whole pipelines: a floor that faces the sun and fills the view, a bar and a
// block above it, one of which moves; camera and sun move too.
#pragma once

#include <array>
#include <string>

#include "host/shots/shot.h"

namespace penumbra::test {

// The model is written once per process, into a temporary folder.
Shot plaza_shot(std::array<uint32_t, 2> size, uint32_t frames);

// A lamp that is near, for pipelines that take one; its name.
std::string add_lamp(Shot& shot);

}  // namespace penumbra::test
