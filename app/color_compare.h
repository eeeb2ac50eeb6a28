// SPDX-License-Identifier: MIT
// penumbra compare --signal transmittance: the colour of light that arrives, channel by channel.
#pragma once

#include "app/commands.h"

namespace penumbra {

// Prints text, or JSON on request; returns an exit code.
int compare_colors(const CompareArguments& arguments);

}  // namespace penumbra
