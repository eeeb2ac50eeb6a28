// SPDX-License-Identifier: MIT
#include "app/report/page.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <set>

#include "app/mebibytes.h"
#include "app/report/assets.h"
#include "app/report/crops.h"
#include "app/report/dataflow_figure.h"
#include "app/report/front_figures.h"
#include "app/report/html.h"
#include "app/report/images.h"
#include "app/report/memory_figure.h"
#include "app/report/motion_image.h"
#include "app/report/page_tables.h"
#include "app/report/plots.h"
#include "host/images/image_decode.h"
#include "host/images/image_file.h"

namespace penumbra::report {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t largest_magnification = 4;  // of the slider's images

// How large errors are, of a picture of this size that write_error_image() has written: how much colour there
// is. What is right or does not count has none.
std::vector<uint8_t> errors_of(const fs::path& file, const std::array<uint32_t, 2>& size) {
    const std::string bytes = file_bytes(file);
    RgbaImage image;
    try {
        image = decode_image(std::as_bytes(std::span(bytes)), uint64_t{8} * size[0] * size[1]);
    } catch (const ImageError& error) {
        throw FileError(file.string() + ": " + error.what());
    }
    if (image.width != size[0] || image.height != size[1])
        throw FileError(file.string() + ": is not of the size that was written");
    std::vector<uint8_t> errors(size_t{size[0]} * size[1]);
    for (size_t i = 0; i < errors.size(); ++i) {
        const auto [least, most] = std::minmax_element(&image.rgba[4 * i], &image.rgba[4 * i] + 3);
        errors[i] = static_cast<uint8_t>(*most - *least);
    }
    return errors;
}

std::string image(const fs::path& file, const std::string& name) {
    return fmt::format("<img src=\"{}\" alt=\"{}\">", data_uri(file), escape(name));
}

// `more`: markup.
std::string image_figure(const std::string& images, const std::string& caption, const std::string& more) {
    return fmt::format("<figure><div class=\"pair\">{}</div><figcaption>{}{}</figcaption></figure>\n", images,
                       escape(caption), more);
}

std::string fact(const std::string& name, const std::string& value) {
    return fmt::format("<dt>{}</dt><dd>{}</dd>\n", escape(name), escape(value));
}

std::string legend(const Results& results) {
    std::string out;
    std::set<std::string> shown;
    for (size_t c = 0; c < results.contenders.size(); ++c) {
        const Contender& contender = results.contenders[c];
        const std::string style = accent(results, c);
        if (contender.variant() && !shown.insert(style).second) continue;
        const std::string name = !contender.variant()      ? contender.id
                                 : contender.brute_force() ? "brute force"
                                                           : "rays behind proofs";
        out += fmt::format(
            "<button type=\"button\" class=\"{0}\" data-style=\"{0}\" aria-pressed=\"true\"><span "
            "class=\"key\" style=\"background:currentColor;color:inherit\"></span><span>{1}</span></button>",
            style, escape(name));
    }
    return out;
}

std::string images(const Results& results, size_t shot, const fs::path& folder) {
    const ShotFacts& facts = results.shots[shot];
    constexpr const char* truth = "reference";
    std::string out = image_figure(image(folder / facts.reference_image, truth), truth, "");
    for (const Row& row : results.rows) {
        if (row.shot != shot || row.images.size() != 2) continue;
        const std::string name = label(results.contenders[row.contender]);
        std::optional<double> rmse;
        for (const Judged& judged : row.over_time)
            if (judged.frame == facts.image_frame) rmse = judged.metrics.rmse_all;
        out += image_figure(
            image(folder / row.images[0], name) + image(folder / row.images[1], name + ", error"),
            fmt::format("{}: RMSE {}", name, number_or_dash(rmse)),
            fmt::format(
                ", <a href=\"#{}\">where it is farthest off</a>",
                crop_fragment(facts.name, name, truth,
                              worst_crop(facts.size, errors_of(folder / row.images[1], facts.size)))));
    }
    return out;
}

// Which of images() the slider starts with: noise on the left, the last pipeline's mask on the right.
size_t slider_choice(const Results& results, bool noisy) {
    size_t choice = 0;
    for (size_t c = 0; c < results.contenders.size(); ++c)
        if (!results.contenders[c].variant() && (!noisy || results.contenders[c].id == "raw"))
            choice = 1 + 2 * c;  // behind the reference: mask and error in turns
    return choice;
}

std::string after_cut_figure(const Results& results, size_t shot) {
    if (results.study.after_cut.empty()) return {};
    return "<figure class=\"after-cut\">" + after_cut_plot(results, shot) +
           "<figcaption>Error after a cut, nothing moves: what accumulation gains.</figcaption></figure>";
}

std::string over_time_figure(const Results& results, size_t shot) {
    if (results.study.moving_frames < 2 * results.study.moving_every) return {};  // one frame is judged
    return "<figure class=\"over-time\">" + over_time_plot(results, shot) +
           "<figcaption>Error over the moving shot.</figcaption></figure>";
}

// The masks side by side in motion, each with its name over it.
std::string motion_figure(const Results& results, const ShotFacts& facts, const fs::path& folder) {
    if (facts.motion_image.empty()) return {};
    const std::vector<size_t> shown = shown_in_motion(results.contenders);
    const MotionGrid grid(shown.size());
    const auto [width, height] = grid.size(facts.size);
    std::string labels;
    for (size_t panel = 0; panel < shown.size(); ++panel) {
        const auto [x, y] = grid.corner(panel, facts.size);
        labels += fmt::format("<span style=\"left:{:.3f}%;top:{:.3f}%\">{}</span>", 100.0 * x / width,
                              100.0 * y / height, escape(label(results.contenders[shown[panel]])));
    }
    const uint32_t frames = std::min(results.study.motion_frames, results.study.moving_frames);
    return fmt::format(
        "<details class=\"motion\" open><summary>In motion</summary><figure><div class=\"panels\" "
        "style=\"max-width:{}px\"><img src=\"{}\" alt=\"masks in motion\" width=\"{}\" height=\"{}\">{}</div>"
        "<figcaption>Frames {} to {} of the moving shot, first seed, ten a second.</figcaption></figure>"
        "</details>",
        2 * width, data_uri(folder / facts.motion_image), width, height, labels,
        results.study.moving_frames - frames, results.study.moving_frames - 1);
}

std::string shot_section(const Results& results, size_t shot, const fs::path& folder) {
    const ShotFacts& facts = results.shots[shot];
    const Study& study = results.study;
    const std::string truth =
        facts.exact ? "the truth is a closed form"
                    : fmt::format("the truth is {} stratified rays per pixel of the penumbra", study.rays);
    const std::string text = fmt::format(
        "{} × {} pixels, {} receivers of which {} lie in the penumbra (frame {}); {}; {} seeds; {}; measured "
        "{}",
        facts.size[0], facts.size[1], facts.receivers, facts.penumbra, facts.image_frame, truth, study.seeds,
        facts.file, facts.measured);
    return fill(assets::shot_html, {{"name", escape(facts.name)},
                                    {"facts", escape(text)},
                                    {"legend", legend(results)},
                                    {"pareto_rmse", pareto_plot(results, shot, Quality::rmse)},
                                    {"pareto_n_eff", pareto_plot(results, shot, Quality::n_eff)},
                                    {"after_cut", after_cut_figure(results, shot)},
                                    {"over_time", over_time_figure(results, shot)},
                                    {"passes", passes_plot(results, shot)},
                                    {"left", fmt::to_string(slider_choice(results, true))},
                                    {"right", fmt::to_string(slider_choice(results, false))},
                                    {"stage_width", fmt::to_string(largest_magnification * facts.size[0])},
                                    {"aspect", fmt::format("{} / {}", facts.size[0], facts.size[1])},
                                    {"image_frame", fmt::to_string(facts.image_frame)},
                                    {"motion", motion_figure(results, facts, folder)},
                                    {"images", images(results, shot, folder)},
                                    {"error_full", fmt::format("± {:g}", error_at_full)},
                                    {"table", shot_table(results, shot)}});
}

std::string pipeline_article(const Results& results, const PipelinePlan& planned) {
    const Plan& plan = planned.plan;
    const Contender& contender = results.contenders[planned.contender];
    const MemoryReport& m = plan.memory;
    const double pixels = static_cast<double>(plan.extent.width) * plan.extent.height;
    std::string memory = fmt::format(
        "Memory at {} × {}: heap {} ({:.1f} bytes per pixel), live bound {}, optimum {}, without aliasing "
        "{}.",
        plan.extent.width, plan.extent.height, mebibytes(m.heap_bytes),
        static_cast<double>(m.heap_bytes) / pixels, mebibytes(m.live_bound_bytes),
        m.optimum_bytes ? mebibytes(*m.optimum_bytes) : "unknown", mebibytes(m.unaliased_bytes));
    for (const Culled& culled : plan.culled)
        memory += fmt::format(" Culled: {} ({}{}).", culled.node, culled.why,
                              culled.cond.empty() ? "" : " " + culled.cond);
    const std::string style = accent(results, planned.contender);
    return fill(assets::pipeline_html, {{"accent", style},
                                        {"name", escape(contender.id)},
                                        {"doc", escape(contender.doc)},
                                        {"memory", escape(memory)},
                                        {"dataflow", dataflow_figure(plan, style)},
                                        {"timeline", memory_figure(plan, style)},
                                        {"passes", passes_table(plan)}});
}

std::string method(const Results& results) {
    const Study& study = results.study;
    std::string out = fmt::format(
        "<p>All contenders stand ready in one process and take turns frame by frame, in an order that "
        "rotates; "
        "errors are those of {} seeds, without jitter, since the truth is that of pixel centres. Times are "
        "of the "
        "frames whose errors are pooled, in the same run: each pass counts at the least of {} rounds, since "
        "other "
        "work on the machine only adds, and the figure is the median over the frames, with a 95 % interval "
        "from "
        "order statistics where there are six or more. {}</p>",
        study.seeds, study.rounds,
        cost_is_cpu(results) ? "On this CPU device the cost is process CPU time, each pass submitted by "
                               "itself: wall time would measure the machine's other work too."
                             : "The cost is GPU time between timestamps.");
    out +=
        "<p>Cost of the mask: all passes that visibility depends on, in the frame or through history, guides "
        "and "
        "classification among them; not the shadow maps or the tree of triangles, which the host makes. "
        "Brute force "
        "of N rays: the pipeline ";
    out += study.light.empty() ? "raw with N rays per pixel, spread evenly over the sun"
                               : "light_raw with N rays per pixel, spread evenly over the light";
    out += " (<code>--set nodes.trace.params.rays_per_pixel=N</code>)";
    if (study.light.empty()) out += "; many_rays N: the same where no proof has decided a tile before";
    out +=
        ".</p>"
        "<p>Equal time: the plain contenders that none of the others beats make a line, straight between "
        "logarithms "
        "of time and N<sub>eff</sub>; beyond its ends it goes on with the slope of its last piece, marked ~. "
        "A "
        "contender's N<sub>eff</sub> is divided by the line's at its time; for the time of brute force its "
        "own line "
        "is read the other way. An error that cannot be told from the truth's own counts as none (exact).</p>"
        "<p>A pipeline without history is judged where nothing moves in the last two frames alone: all "
        "frames "
        "after a cut are alike. One whose masks are to the bit those of another in all judged frames under "
        "the "
        "first seed (\"= other\" in a shot's table) is taken to have the other's under the other seeds, and "
        "behind the moving edges where that held in every shot; its cost is its own.</p>";
    if (!results.left_out.empty()) {
        out += "<p>Left out:</p><ul>";
        for (const LeftOut& left : results.left_out)
            out += fmt::format("<li>{}: {}</li>", escape(left.file), escape(left.why));
        out += "</ul>";
    }
    return out;
}

}  // namespace

std::string report_page(const Results& results, const std::vector<PipelinePlan>& plans,
                        const fs::path& folder) {
    const Study& study = results.study;
    const bool edges = !study.edge_widths_px.empty(), still = !study.after_cut.empty(),
               of_lamp = !study.light.empty();
    std::string links = still ? "<li><a href=\"#headline\">Headline</a></li>\n" : "";
    std::string shots, edge_plots, pipelines;
    for (size_t s = 0; s < results.shots.size(); ++s) {
        const std::string name = escape(results.shots[s].name);
        links += fmt::format("<li><a href=\"#shot-{0}\">{0}</a></li>\n", name);
        shots += shot_section(results, s, folder);
    }
    if (edges) links += "<li><a href=\"#edge\">Moving edge</a></li>\n";
    for (const double width : study.edge_widths_px)
        edge_plots += fmt::format(
            "<figure>{}<figcaption>Penumbra {:g} px wide, {} × {} pixels.</figcaption></figure>\n",
            edge_plot(results, width), width, study.edge_size[0], study.edge_size[1]);
    for (const PipelinePlan& planned : plans) pipelines += pipeline_article(results, planned);
    // What was not measured has no section.
    const std::string worst_edge =
        !edges ? ""
               : fmt::format(
                     "; and the worst of all speeds of a straight edge (penumbra {:g} px), which is a "
                     "property of the pipeline, not of the shot",
                     headline_width_px(results));
    const std::string headline =
        !still ? ""
               : fill(assets::headline_html,
                      {{"worst_edge", worst_edge}, {"headline_table", headline_table(results)}});
    const std::string edge =
        !edges ? ""
               : fill(assets::edge_html, {{"edge_frames", fmt::to_string(study.edge_frame + 1)},
                                          {"edge_plots", edge_plots},
                                          {"edge_table", edge_table(results)}});
    const DeviceInfo& device = results.device;
    const std::string facts =
        fact("Device", fmt::format("{} ({}), subgroup of {}", device.name, device.is_cpu ? "CPU" : "GPU",
                                   device.subgroup_size)) +
        fact("Driver", device.driver) + fact("penumbra", PENUMBRA_VERSION) +
        fact("Extent", results.quick ? "quick: small images, few frames and seeds; intervals are wide"
                       : still       ? "full"
                                     : "speed against error alone, of shots as they move");
    return fill(
        assets::page_html,
        {{"title", "penumbra report"},
         {"lead",
          fmt::format("Masks of {} against the truth, and what they cost, beside brute force.",
                      of_lamp ? fmt::format("the soft shadows of the light \"{}\"", escape(study.light))
                              : "soft sun shadows")},
         {"style", assets::style_css},
         {"facts", facts},
         {"links", links},
         {"headline", headline},
         {"shots", shots},
         {"edge", edge},
         {"pipelines", pipelines},
         {"method", method(results)},
         {"command", escape(results.command)},
         {"commands", commands(results)},
         {"script", assets::page_js}});
}

}  // namespace penumbra::report
