// SPDX-License-Identifier: MIT
// Which pixels are receivers and which lie in the penumbra is the reference's word, never the pipeline's own
// verdict.
#include "app/comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "app/frame_range.h"
#include "app/is_there.h"
#include "app/progress.h"
#include "app/signal_files.h"
#include "host/images/triples.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

// Frames to compare: those asked for, else those that all folders have and the truth says it has: what else
// lies in its folder is older.
std::optional<std::vector<uint32_t>> choose_frames(const CompareArguments& arguments,
                                                   const std::vector<fs::path>& images,
                                                   const ReferenceInfo& info, Diagnostics& diagnostics) {
    const auto is_of_it = [&](uint32_t frame) { return info.frames.empty() || info.frames.contains(frame); };
    if (!arguments.frames.empty()) {
        const auto range = parse_frames(arguments.frames, diagnostics);
        if (!range) return std::nullopt;
        std::vector<uint32_t> frames;
        for (uint32_t frame = (*range)[0]; frame <= (*range)[1]; ++frame) frames.push_back(frame);
        if (const auto other = std::ranges::find_if_not(frames, is_of_it); other != frames.end())
            diagnostics.add(
                {arguments.reference, 0, 0}, "--frames",
                fmt::format("frame {} is none of this truth's: reference.json has no such one", *other));
        return frames;
    }
    auto frames = visibility_frames(arguments.reference, diagnostics);
    if (frames) std::erase_if(*frames, std::not_fn(is_of_it));
    for (const fs::path& folder : images) {
        const auto present = visibility_frames(folder, diagnostics, arguments.light);
        if (!frames || !present) return std::nullopt;
        std::erase_if(*frames, [&](uint32_t frame) {
            return !std::binary_search(present->begin(), present->end(), frame);
        });
    }
    if (frames->empty())
        diagnostics.add({arguments.reference, 0, 0}, "", "shares no frame with " + arguments.image);
    return frames;
}

const Plane* plane_of(const std::optional<PlanarImage>& image, const fs::path& file, const char* name,
                      Diagnostics& diagnostics, bool words = false) {
    if (!image) return nullptr;
    const Plane* plane = image->find(name);
    if (plane && (plane->type == PlaneType::uint) == words) return plane;
    const char* problem = !plane  ? "there is no such channel"
                          : words ? "the channel does not hold integers"
                                  : "the channel holds integers";
    diagnostics.add({file.string(), 0, 0}, name, problem);
    return nullptr;
}

bool in_border(size_t pixel, uint32_t width, uint32_t height, uint32_t border) {
    const size_t x = pixel % width, y = pixel / width;
    return x < border || y < border || x + border >= width || y + border >= height;
}

void check_size(const PlanarImage& image, const PlanarImage& reference, const fs::path& file,
                Diagnostics& diagnostics) {
    if (image.width == reference.width && image.height == reference.height) return;
    diagnostics.add({file.string(), 0, 0}, "",
                    fmt::format("{} x {} pixels, the reference has {} x {}", image.width, image.height,
                                reference.width, reference.height));
}

// One frame's files. Views into it stay good when it is moved.
struct LoadedFrame {
    uint32_t number = 0;
    PlanarImage truth;
    std::vector<PlanarImage> images;
    std::vector<uint8_t> counted;
    std::optional<PlanarImage> motion, depth;  // of the reference

    ComparedFrame view() const {
        ComparedFrame frame{truth.width, truth.height, truth.find("Y")->values, counted, {}};
        for (const PlanarImage& image : images) frame.seeds.emplace_back(image.find("Y")->values);
        // A truth without this channel, or with zeros in it, is a closed form.
        if (const Plane* rays = truth.find("rays")) frame.reference_rays = rays->values;
        return frame;
    }
};

// Everything that `compare` has to do with files.
class Loader {
  public:
    Loader(const CompareArguments& arguments, Diagnostics& diagnostics)
        : arguments_(arguments), diagnostics_(diagnostics), folders_{arguments.image} {
        folders_.insert(folders_.end(), arguments.also.begin(), arguments.also.end());
    }

    const std::vector<fs::path>& folders() const { return folders_; }

    void read_mask() {
        if (arguments_.mask.empty()) return;
        mask_ = read_exr(arguments_.mask, diagnostics_);
        if (mask_ && (mask_->planes.empty() || mask_->planes.front().type == PlaneType::uint))
            diagnostics_.add({arguments_.mask, 0, 0}, "", "a mask needs a channel of floats");
    }

    // Visibility and receivers alone.
    std::optional<LoadedFrame> truth(uint32_t number) const {
        const fs::path file = visibility_file(arguments_.reference, number);
        auto image = read_exr(file, diagnostics_);
        const Plane* visibility = plane_of(image, file, "Y", diagnostics_);
        const Plane* receiver = plane_of(image, file, "receiver", diagnostics_);
        if (!visibility || !receiver) return std::nullopt;
        if (mask_) check_size(*mask_, *image, arguments_.mask, diagnostics_);
        if (!diagnostics_.empty()) return std::nullopt;
        if (2 * uint64_t{arguments_.border} >= std::min(image->width, image->height)) {
            diagnostics_.add({"--border"}, "",
                             fmt::format("leaves none of {} x {} pixels", image->width, image->height));
            return std::nullopt;
        }
        LoadedFrame frame;
        frame.number = number;
        frame.counted.resize(visibility->values.size());
        for (size_t p = 0; p < frame.counted.size(); ++p)
            frame.counted[p] = receiver->values[p] > 0.5f &&
                               (!mask_ || mask_->planes.front().values[p] > 0) &&
                               !in_border(p, image->width, image->height, arguments_.border);
        frame.truth = std::move(*image);
        return frame;
    }

    std::optional<LoadedFrame> frame(uint32_t number) const {
        auto loaded = truth(number);
        if (!loaded) return std::nullopt;
        for (const fs::path& folder : folders_) {
            const fs::path file = visibility_file(folder, number, arguments_.light);
            auto image = read_exr(file, diagnostics_);
            if (!plane_of(image, file, "Y", diagnostics_)) continue;
            check_size(*image, loaded->truth, file, diagnostics_);
            loaded->images.push_back(std::move(*image));
        }
        if (!diagnostics_.empty()) return std::nullopt;
        loaded->motion = beside_truth("motion", *loaded, {"X", "Y", "Z"});
        loaded->depth = beside_truth("depth", *loaded, {"Z"});
        return loaded;
    }

    // An image that `reference` writes beside the truth; absent where there is no such file.
    std::optional<PlanarImage> beside_truth(const char* name, const LoadedFrame& frame,
                                            std::initializer_list<const char*> channels) const {
        const fs::path file =
            fs::path(arguments_.reference) / fmt::format("{}.{:04}.exr", name, frame.number);
        if (!is_there(file, diagnostics_)) return std::nullopt;
        auto image = read_exr(file, diagnostics_);
        for (const char* channel : channels)
            if (!plane_of(image, file, channel, diagnostics_)) return std::nullopt;
        check_size(*image, frame.truth, file, diagnostics_);
        return diagnostics_.empty() ? std::move(image) : std::nullopt;
    }

    // A capture of tile words in the first image's folder.
    std::optional<PlanarImage> words(const char* name, const LoadedFrame& frame) const {
        return words(arguments_.image, name, frame);
    }

    // A folder, or nothing.
    const std::string& whole_rays() const { return arguments_.whole_rays; }

    // What --whole-rays compares: rays that may be shortened, and in a folder of their own the same ones
    // whole. An error where it is not there.
    std::optional<PlanarImage> interval_words(const fs::path& folder, const char* name,
                                              const LoadedFrame& frame) const {
        auto found = words(folder, name, frame);
        if (!found && diagnostics_.empty())
            diagnostics_.add(
                {folder.string(), 0, 0}, "",
                fmt::format("--whole-rays needs a capture of {}, and frame {} has none", name, frame.number));
        return found;
    }

    std::optional<PlanarImage> words(const fs::path& folder, const char* name,
                                     const LoadedFrame& frame) const {
        const fs::path file = folder / fmt::format("{}.{:04}.exr", name, frame.number);
        if (!is_there(file, diagnostics_)) return std::nullopt;
        auto image = read_exr(file, diagnostics_);
        if (!plane_of(image, file, "W", diagnostics_, true)) return std::nullopt;
        const uint32_t across = (frame.truth.width + tile_width - 1) / tile_width,
                       down = (frame.truth.height + tile_height - 1) / tile_height;
        if (image->width == across && image->height == down) return image;
        diagnostics_.add({file.string(), 0, 0}, "",
                         fmt::format("{} x {} words, the reference has {} x {} tiles", image->width,
                                     image->height, across, down));
        return std::nullopt;
    }

    // The truth of the frame before, whether it is among those compared or not.
    std::optional<LoadedFrame> truth_before(uint32_t number) const {
        if (number == 0 || !is_there(visibility_file(arguments_.reference, number - 1), diagnostics_))
            return std::nullopt;
        return truth(number - 1);
    }

  private:
    const CompareArguments& arguments_;
    Diagnostics& diagnostics_;
    std::vector<fs::path> folders_;
    std::optional<PlanarImage> mask_;
};

// Sums over frames, until all of them have been seen.
struct Sums {
    MetricSums mask;
    std::optional<double> bias;
    SsimSum ssim;
    std::vector<float> flip;
    RelativeErrorSum relative;
    FlickerSums flicker;
    DecisionSums decisions;
    IntervalSums interval;
    double lag = 0, gap = 0;
    size_t lags = 0, gaps = 0;
    std::vector<double> remainders;
};

void add_lit_picture(const Loader& loader, const LoadedFrame& loaded, const glm::dvec3& to_sun, Sums& sums) {
    const auto albedo = loader.beside_truth("albedo", loaded, {"R", "G", "B"}),
               normal = loader.beside_truth("normal", loaded, {"X", "Y", "Z"});
    if (!albedo || !normal) return;
    const std::vector<glm::vec3> colors = triples(*albedo, {"R", "G", "B"}),
                                 normals = triples(*normal, {"X", "Y", "Z"});
    const ComparedFrame frame = loaded.view();
    const Surfaces surfaces{colors, normals, to_sun};
    const auto truth = shade_surfaces(surfaces, frame, frame.truth);
    for (size_t seed = 0; seed < frame.seeds.size(); ++seed) {
        const auto image = shade_surfaces(surfaces, frame, frame.seeds[seed]);
        sums.relative.add(relative_error(frame, image, truth));
        if (seed > 0) continue;
        const std::vector<float> map =
            flip_map(frame.width, frame.height, display_linear(truth), display_linear(image));
        for (size_t p = 0; p < map.size(); ++p)
            if (frame.counted[p]) sums.flip.push_back(map[p]);
    }
}

void add_decisions(const Loader& loader, const LoadedFrame& loaded, Sums& sums) {
    const auto undecided = loader.words("undecided_words", loaded),
               shadowed = loader.words("preloaded_hits", loaded);
    if (undecided && shadowed)
        sums.decisions.add(
            judge_decisions(loaded.view(), {undecided->find("W")->words, shadowed->find("W")->words}));
    if (loader.whole_rays().empty()) return;
    const auto decided = loader.interval_words(loader.folders().front(), "undecided_words", loaded),
               hits = loader.interval_words(loader.folders().front(), "hits", loaded),
               whole = loader.interval_words(loader.whole_rays(), "hits", loaded);
    if (decided && hits && whole)
        sums.interval.add(judge_interval(loaded.view(), decided->find("W")->words, hits->find("W")->words,
                                         whole->find("W")->words));
}

void add_step_in_time(const LoadedFrame& now, const LoadedFrame& before, FlickerSums& sums) {
    if (!now.motion || !now.depth || !before.depth) return;
    const ComparedFrame a = now.view(), b = before.view();
    add_flicker(
        {a, b, now.motion->find("X")->values, now.motion->find("Y")->values, now.motion->find("Z")->values,
         now.depth->find("Z")->values, before.depth->find("Z")->values},
        sums);
}

void add_frame(const Loader& loader, const LoadedFrame& loaded, const ReferenceInfo& info, Sums& sums) {
    const ComparedFrame frame = loaded.view();
    sums.mask.add_frame(loaded.number, measure(frame));
    if (const auto bias = largest_bias_9x9(frame)) sums.bias = std::max(sums.bias.value_or(0), *bias);
    sums.ssim.add(ssim_near_penumbra(frame));
    if (const auto about = info.frames.find(loaded.number); about != info.frames.end()) {
        add_lit_picture(loader, loaded, about->second.to_sun, sums);
        if (about->second.contact)
            if (const auto gap = peter_panning_px(frame, *about->second.contact)) {
                sums.gap += *gap;
                ++sums.gaps;
            }
    }
    add_decisions(loader, loaded, sums);
    const auto before = loader.truth_before(loaded.number);
    if (before && before->truth.width == frame.width && before->truth.height == frame.height)
        if (const auto lag = lag_px(frame, before->truth.find("Y")->values)) {
            sums.lag += *lag;
            ++sums.lags;
        }
}

// Truths alone, first: which frame begins anew is known when all have been seen.
std::optional<StepFinder::Step> find_step(const Loader& loader, const std::vector<uint32_t>& frames) {
    StepFinder finder;
    const auto add = [&](const std::optional<LoadedFrame>& loaded) {
        if (loaded) finder.add(loaded->number, loaded->truth.find("Y")->values, loaded->counted);
        return loaded.has_value();
    };
    add(loader.truth_before(frames.front()));
    // The first that is missing is an error, and enough of them.
    return std::ranges::all_of(frames, [&](uint32_t frame) { return add(loader.truth(frame)); })
               ? finder.step()
               : std::nullopt;
}

Comparison conclude(const Sums& sums) {
    const auto mean = [](double sum, size_t count) {
        return count ? std::optional(sum / static_cast<double>(count)) : std::nullopt;
    };
    Comparison out;
    out.mask = metrics_of(sums.mask);
    out.bias_max_9x9 = sums.bias;
    out.ssim = sums.ssim.mean();
    out.flip = pool_flip(sums.flip);
    out.relmse = sums.relative.mean();
    out.peter_panning_px = mean(sums.gap, sums.gaps);
    out.decisions = metrics_of(sums.decisions);
    out.interval = sums.interval.share();
    out.flicker_rms = sums.flicker.rms();
    out.flicker_p99 = sums.flicker.p99();
    out.lag_px = mean(sums.lag, sums.lags);
    out.step = step_response(sums.remainders);
    return out;
}

}  // namespace

std::optional<Comparison> compare_folders(const CompareArguments& arguments, Diagnostics& diagnostics) {
    Loader loader(arguments, diagnostics);
    check_folders(arguments, diagnostics);
    const auto info = read_reference_info(arguments.reference, diagnostics);
    const auto frames =
        choose_frames(arguments, loader.folders(), info.value_or(ReferenceInfo()), diagnostics);
    loader.read_mask();
    if (!info || !frames || !diagnostics.empty()) return std::nullopt;

    for (const fs::path& folder : loader.folders())
        check_jitter(folder, arguments.reference, *info, *frames, diagnostics);
    if (!diagnostics.empty()) return std::nullopt;

    const auto step = find_step(loader, *frames);
    Sums sums;
    std::optional<LoadedFrame> before;
    Progress progress("compare", frames->size());
    for (const uint32_t number : *frames) {
        auto loaded = diagnostics.empty() ? loader.frame(number) : std::nullopt;
        if (!loaded) return std::nullopt;
        add_frame(loader, *loaded, *info, sums);
        if (before && before->number + 1 == number && before->counted.size() == loaded->counted.size())
            add_step_in_time(*loaded, *before, sums.flicker);
        if (step && number == step->frame + sums.remainders.size())
            sums.remainders.push_back(step_remainder(*step, loaded->view()));
        before = std::move(loaded);
        progress.step();
    }
    if (!diagnostics.empty()) return std::nullopt;
    Comparison out = conclude(sums);
    out.frames = *frames;
    out.seeds = loader.folders().size();
    out.truth = *info;
    return out;
}

}  // namespace penumbra
