// SPDX-License-Identifier: MIT
#include "app/view/live.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "app/light_truth.h"
#include "app/outputs.h"
#include "app/pipeline_file.h"
#include "host/metrics/mask_error.h"

namespace penumbra::viewer {
namespace {

constexpr uint32_t truth_side = 2;  // rays of a round: its square
constexpr const char* mask_name = "visibility";

// What stands for plain rays and for a published denoiser.
const char* pipeline_beside(Beside beside, bool near_light) {
    if (beside == Beside::published) return near_light ? "light_sigma" : "fidelityfx";
    return near_light ? "light_raw" : "raw";
}

bool same(const Stance& a, const Stance& b) {
    return a.camera.position == b.camera.position && a.camera.target == b.camera.target &&
           a.camera.up == b.camera.up && a.sun.to_sun == b.sun.to_sun && a.moment == b.moment;
}

bool puts_out(const Stage& stage, const std::string& name) {
    return std::ranges::any_of(stage.session->plan().outputs,
                               [&](const PlanOutput& output) { return output.name == name; });
}

}  // namespace

Live::Live(Device& device, Shot shot, StageWish wish)
    : device_(device), shot_(std::move(shot)), wish_(std::move(wish)), flight_(shot_) {}

std::array<uint32_t, 2> Live::size() const {
    return {std::max(wish_.size[0] / divisor_, 1u), std::max(wish_.size[1] / divisor_, 1u)};
}

// Nothing, and error() says why.
std::unique_ptr<Stage> Live::make(const StageWish& wish) {
    Diagnostics diagnostics;
    warnings_.clear();
    StageWish scaled = wish;
    scaled.size = size();
    auto stage = open_stage({device_, shot_, scene_, told_}, scaled, diagnostics, warnings_);
    error_ = diagnostics.text();
    return stage;
}

bool Live::restage(const StageWish& wish) {
    auto stage = make(wish);
    if (!stage) return false;
    const std::string light_before = main_ ? main_->session->host().light_name() : "";
    main_ = std::move(stage);
    wish_ = wish;
    costs_ = {};
    const std::vector<std::string> lost = turn_again(*main_->session, main_->controls, turned_);
    for (const std::string& name : lost) turned_.erase(name);
    if (!lost.empty())
        error_ += fmt::format("{} {} no longer there, or of another type or range: as the pipeline says\n",
                              fmt::join(lost, ", "), lost.size() > 1 ? "are" : "is");
    if (const auto names = resources_of(*main_);
        !wish_.shown.empty() && std::ranges::find(names, wish_.shown) == names.end()) {
        error_ += fmt::format("{} has no \"{}\" any more\n", main_->pipeline.name, wish_.shown);
        wish_.shown.clear();
    }
    watch();
    choose_jitter();
    if (beside_ != Beside::nothing && !puts_out(*main_, mask_name)) {
        error_ += fmt::format("{} puts out no \"{}\" to be compared\n", main_->pipeline.name, mask_name);
        compare(Beside::nothing);
    }
    if (beside_ != Beside::nothing && main_->session->host().light_name() != light_before) remake_beside();
    return true;
}

// After whatever it was made of: errors that there were already stay.
void Live::remake_beside() {
    std::string before = std::exchange(error_, "");
    if (!make_beside()) beside_ = Beside::nothing;
    error_ = before + error_;
    choose_jitter();
}

// The truth is of pixels' centres, and so are the frames that it judges.
void Live::choose_jitter() {
    main_->session->set_jitter(plan().jitter && !wants_truth());
}

bool Live::open(const Told& told) {
    told_ = told;
    const bool good = restage(wish_);
    told_ = nullptr;  // the first stage is waited for, the next ones are asked for while a picture is seen
    return good;
}

void Live::watch() {
    files_.watch(main_->files, {wish_.node_folders.begin(), wish_.node_folders.end()});
}

void Live::choose_pipeline(const std::string& name) {
    if (name == wish_.pipeline) return;
    StageWish wish = wish_;
    wish.pipeline = name;
    wish.settings.clear();  // they were for the other one
    wish.shown.clear();
    const Turned before = std::exchange(turned_, {});
    if (!restage(wish)) turned_ = before;
}

void Live::show(const std::string& resource) {
    const auto names = resources_of(*main_);
    if (!resource.empty() && std::ranges::find(names, resource) == names.end()) {
        error_ =
            fmt::format("{} has no \"{}\"{}", main_->pipeline.name, resource, did_you_mean(resource, names));
        return;
    }
    StageWish wish = wish_;
    wish.shown = resource;
    if (resource.empty() || is_host_image(main_->pipeline, resource) || puts_out(*main_, resource))
        wish_ = wish;  // it is there in any case
    else
        restage(wish);
    if (wish_.shown == resource) compare(Beside::nothing);
}

void Live::compare(Beside beside) {
    if (beside == beside_) return;
    if (beside != Beside::nothing && !puts_out(*main_, mask_name)) {
        error_ = fmt::format("{} puts out no \"{}\" to be compared", main_->pipeline.name, mask_name);
        return;
    }
    const Beside before = std::exchange(beside_, beside);
    if (!make_beside()) {
        beside_ = before;
        const std::string error = error_;
        make_beside();
        error_ = error;
    }
    choose_jitter();
}

// What the right side is made of.
bool Live::make_beside() {
    other_.reset();
    truth_.reset();
    truth_session_.reset();
    if (beside_ == Beside::nothing) return true;
    if (!wants_truth()) {
        StageWish wish = wish_;
        wish.pipeline = pipeline_beside(beside_, main_->session->host().light() != nullptr);
        wish.settings.clear();
        wish.node_folders.clear();
        wish.shown.clear();
        other_ = make(wish);
        return other_ != nullptr;
    }
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    Shot shot = shot_;
    shot.size = size();
    diagnose_thrown("the truth", diagnostics, [&] {
        const StandaloneHost& host = main_->session->host();
        truth_session_ = host.light() ? open_light_truth(device_, shot, host.light_name(), diagnostics,
                                                         warnings, false, &scene_)
                                      : open_truth(device_, shot, diagnostics, warnings, false, &scene_);
    });
    if (!truth_session_) error_ = diagnostics.text();
    return truth_session_ != nullptr;
}

void Live::reduce(uint32_t divisor) {
    const uint32_t before = std::exchange(divisor_, std::clamp(divisor, 1u, 8u));
    if (divisor_ == before) return;
    if (!restage(wish_)) {
        divisor_ = before;
        return;
    }
    remake_beside();
}

void Live::turn_control(size_t index, const ParamValue& value) {
    Control& control = main_->controls.at(index);
    if (!turn(*main_->session, control, value)) {
        error_ = fmt::format("{} does not take this value", control.name());
        return;
    }
    if (control.changed())
        turned_[control.name()] = value;
    else
        turned_.erase(control.name());
}

void Live::reload_changed() {
    if (!files_.changed()) return;
    if (restage(wish_)) {
        ++reloads_;
        return;
    }
    std::set<std::filesystem::path> files =
        files_of_pipeline(main_->pipeline.file);  // it may extend others now
    files.insert(main_->files.begin(), main_->files.end());
    files_.watch(std::move(files), {wish_.node_folders.begin(), wish_.node_folders.end()});
}

void Live::record(bool on) {
    if (on && !recording_) {
        record_ = {};
        recorded_s_ = 0;
    }
    recording_ = on;
}

void Live::frame(const FlightInput& input, double truth_ms) {
    flight_.steer(input);
    const Stance now = flight_.stance();
    still_ = index_ > 0 && same(now, stance_);
    stance_ = now;
    if (recording_) {
        if (!record_.empty()) recorded_s_ += input.seconds;
        record_.add(now, recorded_s_);
    }
    for (Stage* stage : {main_.get(), other_.get()}) {
        if (!stage) continue;
        stage->session->steer(index_, now);
        const FrameCost cost = stage->session->run_frame(index_, stage->fresh);
        stage->fresh = false;
        if (stage != main_.get()) continue;
        held_ = cost.held;
        if (!held_) count_costs(cost);
    }
    if (wants_truth()) work_on_truth(truth_ms);
    ++index_;
    flight_.tick();
}

void Live::work_on_truth(double milliseconds) {
    if (!still_) {
        truth_.reset();
        return;
    }
    if (!truth_) {
        truth_session_->steer(index_, stance_);
        truth_session_->run_frame(index_, true);
        const Session& session = *truth_session_;
        truth_ = std::make_unique<TruthRounds>(
            session.host().light() ? light_pixels(session, index_) : sun_pixels(session, index_),
            session.plan().extent, truth_side, session.seed());
    }
    truth_->work(milliseconds);
}

void Live::count_costs(const FrameCost& cost) {
    std::vector<PassCost> now;
    for (size_t p = 0; p < plan().passes.size(); ++p) {
        const PlanPass& pass = plan().passes[p];
        if (pass.kind == PassKind::capture) continue;
        now.push_back({pass.node, pass.type, cost.passes[p].ms, cost.pass_cpu_ms[p]});
    }
    costs_.add(std::move(now), cost.cpu_ms);
}

std::string Live::shown() const {
    return wish_.shown.empty() ? plan().outputs.back().name : wish_.shown;
}

Picture Live::picture() const {
    if (beside_ == Beside::nothing) {
        const std::string name = shown();
        return picture_of(is_captured(*main_->session, name) ? captured_image(*main_->session, name)
                                                             : host_image(device_, *main_->session, name));
    }
    const PlanarImage image = captured_image(*main_->session, mask_name);
    const std::vector<float>& left = image.planes.front().values;
    const auto [width, height] = size();
    const Picture mine = mask_picture(width, height, left);
    if (other_) {
        const PlanarImage other = captured_image(*other_->session, mask_name);
        return split(mine, mask_picture(width, height, other.planes.front().values), split_share);
    }
    std::vector<float> known(left.size()), truth(left.size());
    if (truth_) {
        truth = truth_->truth().visibility;
        for (size_t p = 0; p < known.size(); ++p) known[p] = truth_->knows(static_cast<uint32_t>(p / width));
    }
    return split(mine,
                 beside_ == Beside::truth ? mask_picture(width, height, truth, known)
                                          : error_picture(width, height, left, truth, known),
                 split_share);
}

std::optional<Judgement> Live::judgement() const {
    if (main_->fresh || !truth_ || truth_->rounds() == 0) return std::nullopt;
    const Truth truth = truth_->truth();
    const PlanarImage image = captured_image(*main_->session, mask_name);
    std::vector<uint8_t> counted;
    for (const float rays : truth.rays) counted.push_back(rays > 0);
    ComparedFrame frame{size()[0], size()[1], truth.visibility, counted, {}, truth.rays};
    frame.seeds.emplace_back(image.planes.front().values);
    const MaskMetrics metrics = metrics_of(measure(frame));
    return Judgement{truth_->rounds() * truth_side * truth_side, metrics.n_eff, metrics.rmse_all};
}

}  // namespace penumbra::viewer
