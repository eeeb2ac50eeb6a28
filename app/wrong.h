// SPDX-License-Identifier: MIT
// The ends of commands that cannot do what they are asked for.
#pragma once

#include <iostream>
#include <string>

#include "app/commands.h"
#include "penumbra/diagnostic.h"

namespace penumbra {

inline int wrong(const Diagnostics& diagnostics) {
    std::cerr << diagnostics.text();
    return exit_wrong;
}

// Whether --light may stand beside this --signal; where not, that is said.
inline bool light_fits(const std::string& signal, const std::string& light) {
    if (signal == "visibility" || light.empty()) return true;
    std::cerr << "--light: is of visibility alone, and --signal asks for " << signal << "\n";
    return false;
}

}  // namespace penumbra
