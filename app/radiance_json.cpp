// SPDX-License-Identifier: MIT
#include "app/radiance_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "app/or_null.h"

namespace penumbra {

nlohmann::ordered_json radiance_json(const RadianceErrorSums& sums) {
    nlohmann::ordered_json json = {{"pixels", sums.pixels()}};
    json["n_eff"] = {{"value", or_null(sums.n_eff())}, {"by_roughness", nlohmann::ordered_json::array()}};
    for (size_t c = 0; c < roughness_classes; ++c)
        json["n_eff"]["by_roughness"].push_back(
            {{"to", c < roughness_class_ends.size()
                        ? std::round(static_cast<double>(roughness_class_ends[c]) * 100) / 100
                        : 1.0},
             {"pixels", sums.classes[c].pixels},
             {"value", or_null(sums.n_eff(c))}});
    json["relmse"] = or_null(sums.relmse());
    json["bias"] = or_null(sums.bias());
    json["flicker"] = or_null(sums.flicker());
    json["fireflies"] = sums.fireflies;
    json["nonfinite"] = sums.nonfinite;
    return json;
}

}  // namespace penumbra
