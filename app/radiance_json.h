// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "host/metrics/radiance_error.h"

namespace penumbra {

// pixels, n_eff with its classes of roughness, relmse, bias, flicker, fireflies, nonfinite; null: unknown.
nlohmann::ordered_json radiance_json(const RadianceErrorSums& sums);

}  // namespace penumbra
