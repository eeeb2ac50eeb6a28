// SPDX-License-Identifier: MIT
#pragma once

#include "app/commands.h"

namespace penumbra {

// penumbra report --signal specular or diffuse. Returns an exit code.
int run_radiance_report(const ReportArguments& arguments);

}  // namespace penumbra
