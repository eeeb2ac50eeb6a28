// SPDX-License-Identifier: MIT
// penumbra compare: what is known of a rendered visibility, as text or as JSON with null for what cannot be
// known.
#include <fmt/format.h>

#include <iostream>
#include <nlohmann/json.hpp>

#include "app/color_compare.h"
#include "app/comparison.h"
#include "app/metrics_json.h"
#include "app/or_null.h"
#include "app/radiance_compare.h"
#include "app/wrong.h"
#include "host/json_dump.h"

namespace penumbra {
namespace {

using OrderedJson = nlohmann::ordered_json;

OrderedJson to_json(const CompareArguments& arguments, const Comparison& c) {
    const MaskMetrics& m = c.mask;
    OrderedJson json = {{"image", arguments.image}, {"reference", arguments.reference}, {"frames", c.frames}};
    json["seeds"] = c.seeds;
    json.update(metrics_json(m));
    json["n_eff"]["exact"] = c.truth.exact;
    json["eps"] = penumbra_eps;
    json["reference_rays"] = c.truth.rays ? OrderedJson(*c.truth.rays) : OrderedJson();
    json["bias_max_9x9"] = or_null(c.bias_max_9x9);
    json["ssim"] = or_null(c.ssim);
    json["flip"] = flip_json(c.flip);
    json["relmse"] = or_null(c.relmse);
    json["peter_panning_px"] = or_null(c.peter_panning_px);
    const DecisionMetrics& d = c.decisions;
    json["misclassified"] = {{"eps", or_null(d.beyond_eps)},
                             {"0.05", or_null(d.beyond_05)},
                             {"0.25", or_null(d.beyond_25)},
                             {"false_lit", or_null(d.false_lit)},
                             {"false_shadow", or_null(d.false_shadow)},
                             {"me", or_null(d.rms)},
                             {"recall", or_null(d.recall)},
                             {"eta_ray", or_null(d.eta_ray)},
                             {"traced_per_penumbra", or_null(d.traced_per_penumbra)},
                             {"interval", or_null(c.interval)}};
    json["flicker"] = {{"rms", or_null(c.flicker_rms)}, {"p99", or_null(c.flicker_p99)}};
    json["lag"] = {
        {"k90", or_null(c.step.k90)}, {"lag_px", or_null(c.lag_px)}, {"residual", or_null(c.step.residual)}};
    return json;
}

std::string text_of(const std::optional<double>& value) {
    return value ? fmt::format("{:.5g}", *value) : "-";
}

void print_text(const CompareArguments& arguments, const Comparison& c) {
    const MaskMetrics& m = c.mask;
    const std::string quality = c.truth.exact ? "exact" : fmt::format("{} rays", c.truth.rays.value_or(0));
    fmt::print("{} against {} ({}): {} frames, {} seeds\n", arguments.image, arguments.reference, quality,
               c.frames.size(), c.seeds);
    fmt::print("pixels   receivers {}  penumbra {}  lit {}  umbra {}\n", m.receivers, m.penumbra, m.lit,
               m.umbra);
    fmt::print("rmse     all {}  penumbra {}  lit {}  umbra {}   psnr {} dB   largest {}\n",
               text_of(m.rmse_all), text_of(m.rmse_penumbra), text_of(m.rmse_lit), text_of(m.rmse_umbra),
               text_of(m.psnr_db), text_of(m.max_abs));
    fmt::print("n_eff    {}  in the penumbra {}  variance {}  bias {}", text_of(m.n_eff),
               text_of(m.n_eff_penumbra), text_of(m.n_variance), text_of(m.n_bias));
    if (m.n_eff_ci95) fmt::print("  95 % {:.4g} .. {:.4g}", (*m.n_eff_ci95)[0], (*m.n_eff_ci95)[1]);
    fmt::print("\npicture  ssim {}  bias {}", text_of(c.ssim), text_of(c.bias_max_9x9));
    if (c.flip)
        fmt::print("  flip mean {:.5g} weighted median {:.5g} p95 {:.5g}", c.flip->mean,
                   c.flip->weighted_median, c.flip->p95);
    fmt::print("  relmse {}\n", text_of(c.relmse));
    fmt::print("time     flicker {} p99 {}  lag {} px  after a change {} frames, residual {}\n",
               text_of(c.flicker_rms), text_of(c.flicker_p99), text_of(c.lag_px), text_of(c.step.k90),
               text_of(c.step.residual));
    if (c.decisions.recall)
        fmt::print("decided  wrong by eps {}  .05 {}  .25 {}  rms {}  recall {}  rays in the penumbra {}\n",
                   text_of(c.decisions.beyond_eps), text_of(c.decisions.beyond_05),
                   text_of(c.decisions.beyond_25), text_of(c.decisions.rms), text_of(c.decisions.recall),
                   text_of(c.decisions.eta_ray));
    if (c.interval) fmt::print("interval other answers {}\n", text_of(c.interval));
    fmt::print("defects  leak {}  acne {}  contact gap {} px  not finite {}\n", text_of(m.leak),
               text_of(m.acne), text_of(c.peter_panning_px), m.nonfinite);
}

}  // namespace

int run_compare(const CompareArguments& arguments) {
    if (arguments.signal == "lit" || arguments.signal == "color") return compare_pictures(arguments);
    Diagnostics diagnostics;
    if (!arguments.picture.empty()) {
        diagnostics.add({}, "--picture", "is of pictures: --signal lit or color");
        return wrong(diagnostics);
    }
    if (arguments.signal == "transmittance") return compare_colors(arguments);
    if (arguments.signal != "visibility") return compare_radiance(arguments);
    const auto comparison = compare_folders(arguments, diagnostics);
    if (!comparison) return wrong(diagnostics);
    if (arguments.json)
        std::cout << json_dump(to_json(arguments, *comparison), 2) << "\n";
    else
        print_text(arguments, *comparison);
    return exit_good;
}

}  // namespace penumbra
