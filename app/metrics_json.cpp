// SPDX-License-Identifier: MIT
#include "app/metrics_json.h"

#include <nlohmann/json.hpp>

#include "app/or_null.h"

namespace penumbra {

nlohmann::ordered_json metrics_json(const MaskMetrics& m) {
    return {{"pixels",
             {{"receivers", m.receivers}, {"penumbra", m.penumbra}, {"lit", m.lit}, {"umbra", m.umbra}}},
            {"rmse",
             {{"all", or_null(m.rmse_all)},
              {"penumbra", or_null(m.rmse_penumbra)},
              {"lit", or_null(m.rmse_lit)},
              {"umbra", or_null(m.rmse_umbra)}}},
            {"psnr_db", or_null(m.psnr_db)},
            {"max_abs", or_null(m.max_abs)},
            {"n_eff",
             {{"value", or_null(m.n_eff)},
              {"penumbra_only", or_null(m.n_eff_penumbra)},
              {"ci95", or_null(m.n_eff_ci95)},
              {"variance_part", or_null(m.n_variance)},
              {"bias_part", or_null(m.n_bias)}}},
            {"leak", or_null(m.leak)},
            {"acne", or_null(m.acne)},
            {"nonfinite", m.nonfinite}};
}

nlohmann::ordered_json flip_json(const std::optional<FlipPool>& flip) {
    if (!flip) return {{"mean", nullptr}, {"weighted_median", nullptr}, {"p95", nullptr}};
    return {{"mean", flip->mean}, {"weighted_median", flip->weighted_median}, {"p95", flip->p95}};
}

}  // namespace penumbra
