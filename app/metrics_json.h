// SPDX-License-Identifier: MIT
// Errors as the documents have them that we write; null: not known.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>

#include "host/metrics/flip.h"
#include "host/metrics/metrics.h"

namespace penumbra {

// pixels, rmse, psnr_db, max_abs, n_eff, leak, acne, nonfinite.
nlohmann::ordered_json metrics_json(const MaskMetrics& m);

nlohmann::ordered_json flip_json(const std::optional<FlipPool>& flip);

}  // namespace penumbra
