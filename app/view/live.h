// SPDX-License-Identifier: MIT
// What the view shows, without a window: a shot that is flown through while a pipeline runs on it, beside
// another pipeline or the truth. Whatever is wished for and cannot be had is an error in words, and what ran
// before goes on.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "app/truth.h"
#include "app/view/cost_mean.h"
#include "app/view/file_watch.h"
#include "app/view/flight.h"
#include "app/view/flight_record.h"
#include "app/view/picture.h"
#include "app/view/stage.h"

namespace penumbra::viewer {

// What is on the right of the split.
enum class Beside { nothing, raw, published, truth, error };
inline constexpr std::array<const char*, 5> beside_names{"nothing", "raw", "published", "truth", "error"};

// How good the mask is where the truth is known.
struct Judgement {
    uint32_t rays = 0;  // per pixel, of the truth so far
    std::optional<double> n_eff, rmse;
};

class Live {
  public:
    // `shot` is no analytic scene. Nothing runs before open().
    Live(Device& device, Shot shot, StageWish wish);

    // The first stage; false, with error() in words, where it cannot be had. `told`: what is being done.
    bool open(const Told& told = {});

    // Wishes. What reads files or makes device objects is done at once, so that error() says what came of it.
    void choose_pipeline(const std::string& name);
    void show(const std::string& resource);  // empty: the pipeline's last output
    void compare(Beside beside);
    void reduce(uint32_t divisor);  // of the inner resolution, 1 .. 8
    void turn_control(size_t index, const ParamValue& value);
    // Where a file that the pipeline, its nodes or their shaders were read from has changed.
    void reload_changed();

    // One frame, and where nothing moves and a truth is wanted, up to `truth_ms` of work on it.
    void frame(const FlightInput& input, double truth_ms);
    Picture picture() const;

    // Of the flight, from the shot's first frame on.
    void record(bool on);
    bool records() const { return recording_; }
    const FlightRecord& recorded() const { return record_; }

    Flight& flight() { return flight_; }
    const Shot& shot() const { return shot_; }
    const StageWish& wish() const { return wish_; }
    const Stage& stage() const { return *main_; }
    const Plan& plan() const { return main_->session->plan(); }
    const std::vector<PassCost>& costs() const { return costs_.passes(); }
    double cpu_ms() const { return costs_.cpu_ms(); }  // of all passes, mean over the last frames
    bool held() const {
        return held_;
    }  // the last frame was not run: nothing had changed, and all had settled
    Beside beside() const { return beside_; }
    std::array<uint32_t, 2> size() const;  // of the frames
    uint32_t divisor() const { return divisor_; }
    std::string shown() const;  // the resource that is seen where nothing is beside it
    bool still() const { return still_; }
    std::optional<Judgement> judgement() const;
    const std::string& error() const { return error_; }
    const std::vector<std::string>& warnings() const { return warnings_; }  // of the scene
    uint32_t reloads() const { return reloads_; }                           // that succeeded

    const Stance& stance() const { return stance_; }  // of the last frame
    uint32_t frames() const { return index_; }        // that have run

    double split_share = 0.5;

  private:
    std::unique_ptr<Stage> make(const StageWish& wish);
    bool restage(const StageWish& wish);
    bool make_beside();
    void remake_beside();
    void watch();
    void count_costs(const FrameCost& cost);
    void work_on_truth(double milliseconds);
    void choose_jitter();
    bool wants_truth() const { return beside_ == Beside::truth || beside_ == Beside::error; }

    Device& device_;
    Shot shot_;
    StageWish wish_;
    Flight flight_;
    KeptScene scene_;
    Told told_;
    std::unique_ptr<Stage> main_, other_;
    std::unique_ptr<Session> truth_session_;
    std::unique_ptr<TruthRounds> truth_;
    Turned turned_;
    FileWatch files_;
    FlightRecord record_;
    bool recording_ = false;
    double recorded_s_ = 0;
    Beside beside_ = Beside::nothing;
    uint32_t divisor_ = 1, index_ = 0, reloads_ = 0;
    Stance stance_;
    bool still_ = false;
    CostMean costs_;
    bool held_ = false;
    std::string error_;
    std::vector<std::string> warnings_;
};

}  // namespace penumbra::viewer
