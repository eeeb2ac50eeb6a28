// SPDX-License-Identifier: MIT
// penumbra compare --signal: rendered radiance against what `penumbra reference` wrote.
#pragma once

#include "app/commands.h"

namespace penumbra {

// Prints text, or JSON on request; returns an exit code.
int compare_radiance(const CompareArguments& arguments);

// The same of whole pictures (`lit`, `color`): relative error and FLIP.
int compare_pictures(const CompareArguments& arguments);

}  // namespace penumbra
