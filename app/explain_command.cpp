// SPDX-License-Identifier: MIT
// penumbra explain: draws what the node `cover` sees from one pixel, what the node `gather` makes of the rays
// around one, what the node `beams` proves of whole tiles, where a budget of rays went, or where the time of
// rendered frames went. The figure is written last and whole, or not at all.
#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <limits>

#include "app/beam_figure.h"
#include "app/budget_picture.h"
#include "app/captured_values.h"
#include "app/commands.h"
#include "app/cost_figure.h"
#include "app/coverage_figure.h"
#include "app/gather_figure.h"
#include "app/input_files.h"
#include "app/outputs.h"
#include "app/pipeline_file.h"
#include "app/progress.h"
#include "app/session.h"
#include "app/shipped_files.h"
#include "app/text_file.h"
#include "app/view_source.h"
#include "app/wrong.h"
#include "host/images/image_file.h"
#include "penumbra/shadow_nodes.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;
using Pixel = std::array<uint32_t, 2>;

bool complain(const std::string& text) {
    std::cerr << text << "\n";
    return false;
}

// Before any work: a figure that has no place is found at once.
bool can_hold_a_file(const fs::path& file) {
    std::error_code none;
    const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
    if (!fs::is_directory(folder, none))
        return complain(fmt::format("--out: there is no folder {}", folder.string()));
    if (fs::is_directory(file, none)) return complain(fmt::format("--out: {} is a folder", file.string()));
    return true;
}

bool is_named_as_written(const ExplainArguments& arguments) {
    const char* ending = arguments.budget ? ".png" : ".svg";
    if (fs::path(arguments.out).extension() == ending) return true;
    return complain(fmt::format("--out: {} is written as {}: end its name in {}", arguments.out,
                                arguments.budget ? "a PNG" : "an SVG", ending));
}

bool write_figure(const std::string& file, const std::string& svg) {
    try {
        write_text(file, svg);
        return true;
    } catch (const FileError& e) {
        return complain(fmt::format("--out: {}", e.what()));
    }
}

std::optional<Pixel> parse_pixel(const std::string& text, const Pixel& size) {
    const char *begin = text.data(), *end = begin + text.size();
    Pixel pixel{};
    const auto x = std::from_chars(begin, end, pixel[0]);
    const bool comma = x.ec == std::errc() && x.ptr != end && *x.ptr == ',';
    const auto y = comma ? std::from_chars(x.ptr + 1, end, pixel[1]) : x;
    if (!comma || y.ec != std::errc() || y.ptr != end) {
        complain(fmt::format("--pixel: \"{}\" is not X,Y, as 320,180", text));
        return std::nullopt;
    }
    if (pixel[0] >= size[0] || pixel[1] >= size[1]) {
        complain(fmt::format("--pixel: {} is outside of the image, which is {}x{}", text, size[0], size[1]));
        return std::nullopt;
    }
    return pixel;
}

struct Job {
    CheckedPipeline pipeline;
    Shot shot;
    Pixel size{};
    std::optional<Pixel> pixel;  // else the one with the most triangles
};

std::optional<Job> prepare(const ExplainArguments& arguments, const NodeSet& nodes) {
    Diagnostics diagnostics;
    const auto file = shipped_file(arguments.budget   ? "shadows"
                                   : arguments.beams  ? "many_rays"
                                   : arguments.gather ? "one_ray"
                                                      : "covered",
                                   shipped_root(), shipped_pipelines, diagnostics);
    auto view = open_view(arguments.view, fs::path(arguments.out).parent_path(), diagnostics);
    if (!file || !view) std::cerr << diagnostics.text();
    if (!file || !view) return std::nullopt;
    Shot* const shot = &view->shot;
    const auto size = arguments.size.empty() ? std::optional(shot->size) : parse_size(arguments.size);
    if (!size) return std::nullopt;
    std::optional<Pixel> pixel;
    if (!arguments.pixel.empty() && !(pixel = parse_pixel(arguments.pixel, *size))) return std::nullopt;
    if (arguments.frame >= shot->frames) {
        complain(fmt::format("--frame: {} is beyond the shot, which has {} frames", arguments.frame,
                             shot->frames));
        return std::nullopt;
    }
    if (!shot->has_sun) {
        complain(fmt::format("{}: has no sun, which is what explain draws", shot->name));
        return std::nullopt;
    }
    if (!(sun_at(*shot, arguments.frame).angular_radius > 0)) {
        complain(fmt::format("{}: the sun is a point, of which nothing hides a part", shot->name));
        return std::nullopt;
    }
    std::vector<std::string> settings;
    if (arguments.beams)
        settings = TileBeams::settings();
    else if (!arguments.gather && !arguments.budget)
        settings = {fmt::format("nodes.cover.params.samples={}", arguments.samples)};
    auto pipeline = open_pipeline(file->string(), settings, nodes);
    if (!pipeline) return std::nullopt;
    if (!spares({arguments.out},
                {files_of_shot(*shot, !view->made_up.empty()), files_of_pipelines({file->string()})},
                diagnostics)) {
        std::cerr << diagnostics.text();
        return std::nullopt;
    }
    return Job{std::move(*pipeline), std::move(*shot), *size, pixel};
}

// A rendered frame, and the same frame on the processor.
class Explanation {
  public:
    Explanation(const Session& session, const NodeSet& nodes, uint32_t frame, uint32_t samples)
        : size_{session.plan().extent.width, session.plan().extent.height},
          seed_(session.seed()),
          frame_(session.host().frame(frame, true)),
          depth_(captured_values<float>(session, "view_depth")),
          normal_(captured_values<std::array<float, 2>>(session, "receiver_normal")),
          visibility_(captured_image(session, "visibility").planes.at(0).values),
          sun_(samples),
          scene_(session.host().scene(), frame) {
        for (const TableData& table : nodes.find("cover")->tables)
            if (table.name == "blue_noise") {
                noise_.resize(table.texels.size() / 4);
                std::memcpy(noise_.data(), table.texels.data(), table.texels.size());
            }
    }

    const Pixel& size() const { return size_; }
    const SampledSun& sun() const { return sun_; }
    bool shows_surface(const Pixel& p) const { return depth_[index(p)] > 0; }
    float visibility(const Pixel& p) const { return visibility_[index(p)]; }

    CoverageReceiver receiver(const Pixel& p) const {
        return coverage_receiver(frame_, seed_, noise_, {p, depth_[index(p)], normal_[index(p)]});
    }
    PixelCoverage coverage(const Pixel& p, double reach) const {
        return scene_.cover(sun_, receiver(p), reach);
    }

    // In the penumbra, the first of those from which the most triangles hide a sample.
    std::optional<Pixel> richest() const {
        std::optional<Pixel> best;
        uint32_t most = 0;
        Progress progress("explain", size_[1]);
        for (uint32_t y = 0; y < size_[1]; ++y, progress.step())
            for (uint32_t x = 0; x < size_[0]; ++x) {
                const Pixel p{x, y};
                if (!shows_surface(p) || !(visibility(p) > 0 && visibility(p) < 1)) continue;
                const PixelCoverage seen = coverage(p, 1);
                if (const uint32_t hiding = seen.hiding(); seen.visibility() > 0 && hiding > most) {
                    most = hiding;
                    best = p;
                }
            }
        return best;
    }

  private:
    size_t index(const Pixel& p) const { return size_t{p[1]} * size_[0] + p[0]; }

    Pixel size_;
    uint32_t seed_;
    StandaloneFrame frame_;
    std::vector<uint32_t> noise_;
    std::vector<float> depth_;
    std::vector<std::array<float, 2>> normal_;
    std::vector<float> visibility_;
    SampledSun sun_;
    CoverageScene scene_;
};

int draw(const ExplainArguments& arguments, const Job& job, const Explanation& explanation) {
    const std::optional<Pixel> pixel = job.pixel ? job.pixel : explanation.richest();
    if (!pixel) {
        complain("no pixel of this frame sees a part of the sun alone");
        return exit_failed;
    }
    const std::string name = fmt::format("{},{}", (*pixel)[0], (*pixel)[1]);
    if (!explanation.shows_surface(*pixel)) {
        complain(fmt::format("--pixel: {} shows no surface", name));
        return exit_wrong;
    }
    const PixelCoverage coverage = explanation.coverage(*pixel, coverage_figure_reach);
    const CoverageCaption caption{job.shot.name, arguments.frame, explanation.size(), *pixel};
    if (!write_figure(arguments.out,
                      coverage_figure(explanation.sun(), explanation.receiver(*pixel), coverage, caption)))
        return exit_failed;
    fmt::print("pixel {}{}: {} (the node: {:.3f})\n", name, job.pixel ? "" : ", which has the most triangles",
               coverage_summary(coverage), explanation.visibility(*pixel));
    return exit_good;
}

// The first of the pixels whose sun most rays around test, of those that see a half of it or so.
std::optional<Pixel> best_tested(const RayGatherer& gatherer) {
    std::optional<Pixel> best;
    size_t most = 0;
    Progress progress("explain", gatherer.size()[1]);
    for (uint32_t y = 0; y < gatherer.size()[1]; ++y, progress.step())
        for (uint32_t x = 0; x < gatherer.size()[0]; ++x) {
            const auto gathered = gatherer.gather({x, y});
            if (!gathered || std::abs(gathered->visibility() - 0.5) > 0.15) continue;
            if (const size_t counted = gathered->counted(); counted > most) {
                most = counted;
                best = Pixel{x, y};
            }
        }
    return best;
}

int draw_gather(const ExplainArguments& arguments, const Job& job, const RayGatherer& gatherer) {
    const std::optional<Pixel> pixel = job.pixel ? job.pixel : best_tested(gatherer);
    if (!pixel) {
        complain("no pixel of this frame sees about a half of the sun");
        return exit_failed;
    }
    const auto gathered = gatherer.gather(*pixel);
    const std::string name = fmt::format("{},{}", (*pixel)[0], (*pixel)[1]);
    if (!gathered) {
        complain(fmt::format("--pixel: {} shows no surface, or no ray around it has met anything", name));
        return exit_wrong;
    }
    const CoverageCaption caption{job.shot.name, arguments.frame, gatherer.size(), *pixel};
    if (!write_figure(arguments.out, gather_figure(*gathered, caption))) return exit_failed;
    fmt::print("pixel {}{}: {}\n", name, job.pixel ? "" : ", whose sun most rays test",
               gather_summary(*gathered));
    return exit_good;
}

// Of a few hundred tiles, those that show best why, one of each verdict: what is lit passes close by
// something, what is dark takes several triangles to close, what is open has a border in its middle; and
// there are few triangles beside.
std::vector<TileBeam> telling_beams(const TileBeams& tiles) {
    constexpr uint32_t whole = 32;  // pixels
    const auto score_of = [](const TileBeam& beam) {
        const double crowd = 0.02 * static_cast<double>(beam.triangles.size());
        if (beam.verdict == TileVerdict::dark) return static_cast<double>(beam.patch()) - crowd;
        return -crowd - 3 * (beam.verdict == TileVerdict::lit ? beam.nearest() : beam.nearest_border());
    };
    std::array<std::optional<TileBeam>, 3> best;
    std::array<double, 3> scores;
    scores.fill(-std::numeric_limits<double>::infinity());
    const auto [columns, rows] = tiles.tiles();
    const uint32_t stride = 1 + columns * rows / 800;
    Progress progress("explain", rows);
    for (uint32_t y = 0; y < rows; ++y, progress.step())
        for (uint32_t x = 0; x < columns; ++x) {
            if ((y * columns + x) % stride != 0) continue;
            const auto verdict = tiles.verdict({x, y});
            if (!verdict) continue;
            TileBeam beam = tiles.beam({x, y});
            const size_t kind = static_cast<size_t>(*verdict);
            if (const double score = score_of(beam); beam.pixels == whole && score > scores[kind]) {
                scores[kind] = score;
                best[kind] = std::move(beam);
            }
        }
    std::vector<TileBeam> beams;
    for (std::optional<TileBeam>& beam : best)
        if (beam) beams.push_back(std::move(*beam));
    return beams;
}

int draw_beams(const ExplainArguments& arguments, const Job& job, const TileBeams& tiles) {
    std::vector<TileBeam> beams;
    if (job.pixel) {
        const Pixel tile{(*job.pixel)[0] / 8, (*job.pixel)[1] / 4};
        if (tiles.verdict(tile)) beams.push_back(tiles.beam(tile));
    } else {
        beams = telling_beams(tiles);
    }
    if (beams.empty()) {
        complain(job.pixel ? "--pixel: no surface in its tile looks at the sun"
                           : "no whole tile of this frame looks at the sun");
        return job.pixel ? exit_wrong : exit_failed;
    }
    const CoverageCaption caption{job.shot.name, arguments.frame, job.size, {}};
    if (!write_figure(arguments.out, beam_figure(beams, caption))) return exit_failed;
    for (const TileBeam& beam : beams) fmt::print("{}\n", beam_summary(beam));
    return exit_good;
}

int draw_budget(const ExplainArguments& arguments, Session& session) {
    Progress progress("explain", arguments.frame + 1);
    for (uint32_t frame = 0; frame <= arguments.frame; ++frame, progress.step())
        session.run_frame(frame, frame == 0);
    const BudgetPicture picture = budget_picture(session);
    try {
        write_file(arguments.out, png_of_rgba(picture.size[0], picture.size[1], picture.rgba));
    } catch (const FileError& e) {
        complain(fmt::format("--out: {}", e.what()));
        return exit_failed;
    }
    fmt::print("frame {}: {}\n", arguments.frame, picture.summary());
    return exit_good;
}

int explain_pixel(const ExplainArguments& arguments) {
    const NodeSet nodes = shadow_nodes();
    const auto job = prepare(arguments, nodes);
    if (!job) return exit_wrong;
    Device device({arguments.device, false});
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    SessionOptions options;
    options.size = job->size;
    options.captures = arguments.budget  ? budget_captures()
                       : arguments.beams ? TileBeams::captures()
                       : arguments.gather
                           ? RayGatherer::captures()
                           : std::vector<std::string>{"view_depth", "receiver_normal", "visibility"};
    if (arguments.no_jitter) options.jitter = false;
    options.pass_costs = false;
    Doing doing;
    options.doing = [&](const char* what, double share) { doing(what, share); };
    const auto session =
        Session::open(device, nodes, job->pipeline, job->shot, options, diagnostics, warnings);
    doing.clear();
    print_warnings(warnings);
    if (!session) return wrong(diagnostics);
    if (arguments.budget) return draw_budget(arguments, *session);
    doing("rendering the frame");
    session->run_frame(arguments.frame, true);
    doing("reading the scene back");
    const auto drawn = [&](auto figure, auto&& of) {
        doing.clear();
        return figure(arguments, *job, of);
    };
    if (arguments.beams) return drawn(draw_beams, TileBeams{*session, arguments.frame});
    if (arguments.gather) return drawn(draw_gather, RayGatherer{*session, arguments.frame});
    return drawn(draw, Explanation{*session, nodes, arguments.frame, arguments.samples});
}

int explain_costs(const ExplainArguments& arguments) {
    Diagnostics diagnostics;
    std::vector<PipelineCosts> costs;
    for (const std::string& file : arguments.costs)
        if (auto read = read_costs(file, diagnostics)) costs.push_back(std::move(*read));
    spares({arguments.out}, {FileList(arguments.costs.begin(), arguments.costs.end())}, diagnostics);
    if (!diagnostics.empty()) return wrong(diagnostics);
    return write_figure(arguments.out, cost_figure(costs)) ? exit_good : exit_failed;
}

}  // namespace

int run_explain(const ExplainArguments& arguments) {
    const bool looks = !arguments.view.shot.empty() || !arguments.view.models.empty();
    if (looks == !arguments.costs.empty()) {
        complain("explain: give --shot or --model, or reports by --costs");
        return exit_wrong;
    }
    if (!can_hold_a_file(arguments.out) || !is_named_as_written(arguments)) return exit_wrong;
    if (!arguments.costs.empty()) return explain_costs(arguments);
    return explain_pixel(arguments);
}

}  // namespace penumbra
