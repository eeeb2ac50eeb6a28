// SPDX-License-Identifier: MIT
// One budget of rays over several lights: all of them together keep it, it goes where a shadow matters, and
// what the lights shine is nearer to the truth than with a budget of each. And what a light more does to the
// others' pasts.
#include <bit>
#include <cmath>
#include <set>

#include "app/pipeline_file.h"
#include "tests/gpu_test.h"
#include "tests/shipped.h"
#include "tests/shot_run.h"
#include "tests/view_run.h"

namespace penumbra::test {
namespace {

const std::vector<std::string> apart = {"nodes.pilots.in.pooled=null", "nodes.allot.in.pooled=null",
                                        "nodes.survey.in.tile_lux=null", "nodes.survey.in.lux_of_all=null"};

constexpr std::array<uint32_t, 2> frame_size{128, 72};

// lights/interior, under these lights alone.
Shot room_under(const std::set<std::string>& lights) {
    Shot shot = shot_named("lights/interior");
    std::erase_if(shot.lights, [&](const auto& light) { return !lights.contains(light.first); });
    return shot;
}

CheckedPipeline pipeline_for(const Shot& shot, const std::string& pipeline,
                             const std::vector<std::string>& settings) {
    Diagnostics diagnostics;
    auto loaded =
        load_pipeline(std::filesystem::path(PENUMBRA_SOURCE_DIR) / "pipelines" / (pipeline + ".json"),
                      settings, diagnostics);
    if (loaded) name_lights(*loaded, shot, "", diagnostics);
    auto checked = loaded ? check(*loaded, shipped_nodes(), diagnostics) : std::nullopt;
    if (!checked) throw std::runtime_error(diagnostics.text());
    return std::move(*checked);
}

class LightsRun {
  public:
    LightsRun(const Shot& shot, const std::string& pipeline, const std::vector<std::string>& settings,
              const std::vector<std::string>& captures, const Facts& facts = {}) {
        SessionOptions options;
        options.size = frame_size;
        options.captures = captures;
        options.jitter = false;
        options.facts = facts;
        session_ = open_session(pipeline_for(shot, pipeline, settings), shot, options);
    }
    void frame(uint32_t index) { session_->run_frame(index, index == 0); }
    const Session& session() const { return *session_; }
    const View& view() const { return session_->view(); }
    std::vector<float> green(const std::string& name) const {
        return captured_planes(view(), name.c_str()).at(1);
    }

  private:
    std::unique_ptr<Session> session_;
};

struct Rays {
    double cast = 0, surfaces = 0;
};

Rays rays_of(const LightsRun& run, const Shot& shot) {
    Rays rays;
    for (const auto& [name, light] : shot.lights) {
        for (const uint32_t word : captured<uint32_t>(run.view(), ("ray_words_" + name).c_str()))
            rays.cast += std::popcount(word);
        for (const uint32_t word : captured<uint32_t>(run.view(), ("ray_bits_" + name).c_str()))
            rays.cast += word == 0 ? 0 : std::bit_width(word) - 1;
        for (const uint32_t word : captured<uint32_t>(run.view(), ("sunward_words_" + name).c_str()))
            rays.surfaces += std::popcount(word);
    }
    return rays;
}

std::vector<std::string> captures_of(const Shot& shot) {
    std::vector<std::string> captures = {"illuminance_" + shot.lights.rbegin()->first};
    for (const auto& [name, light] : shot.lights)
        for (const char* what : {"ray_words_", "ray_bits_", "sunward_words_"})
            captures.push_back(what + name);
    return captures;
}

class LightsBudget : public GpuTest {};

TEST_F(LightsBudget, IsKeptByAllTogetherAndSpentWhereItMatters) {
    const Shot shot = shot_named("lights/interior");
    const std::string sum = "illuminance_" + shot.lights.rbegin()->first;
    LightsRun truth(shot, "lights", {"nodes.cover.params.samples=256", "outputs=[\"illuminance\"]"},
                    {"illuminance"}),
        bare(shot, "lights_shadows", {}, {sum}, {{"casters", false}});
    const auto relative_error = [&](const LightsRun& run) {
        const auto seen = run.green(sum), lux = truth.green("illuminance"), unshadowed = bare.green(sum);
        double error = 0;
        for (size_t i = 0; i < lux.size(); ++i)
            if (unshadowed[i] > 0)
                error += std::pow((double(seen[i]) - double(lux[i])) / double(unshadowed[i]), 2);
        return error;
    };
    const auto keeps = [&](LightsRun& run, uint32_t frame, double share) {
        run.frame(frame);
        const Rays rays = rays_of(run, shot);
        EXPECT_NEAR(rays.cast / rays.surfaces, share, 0.01 * share) << share << ", frame " << frame;
    };
    const std::string a_quarter = "nodes.pilots.params.rays_per_frame=0.25",
                      a_half = "nodes.pilots.params.rays_per_frame=0.5";
    LightsRun quarter(shot, "lights_shadows", {a_quarter}, captures_of(shot));
    for (uint32_t frame = 0; frame < 3; ++frame) keeps(quarter, frame, 0.25);

    std::vector<std::string> settings = apart;
    settings.push_back(a_half);
    LightsRun pooled(shot, "lights_shadows", {a_half}, captures_of(shot)),
        alone(shot, "lights_shadows", settings, {sum});
    double of_pooled = 0, of_alone = 0;  // of one frame it differs by a tenth
    for (uint32_t frame = 0; frame <= 23; ++frame) {
        keeps(pooled, frame, 0.5);
        alone.frame(frame);
        if (frame % 6 != 5) continue;
        truth.frame(frame);
        bare.frame(frame);
        of_pooled += relative_error(pooled);
        of_alone += relative_error(alone);
    }
    EXPECT_LT(of_pooled, 0.98 * of_alone);  // measured: .96
}

// A lamp that shines little beside another gets few rays. Both shine on everything here.
TEST_F(LightsBudget, AFaintLightWaits) {
    const Shot shot = room_under({"bulb", "tube"});
    const auto share_of_tube = [&](double factor) {
        Shot faint = shot;
        for (auto& key : faint.lights.at("tube").keys) key.power *= factor;
        LightsRun run(faint, "lights_shadows", {"nodes.pilots.params.rays_per_frame=0.5"},
                      captures_of(faint));
        for (uint32_t frame = 0; frame < 3; ++frame) run.frame(frame);
        Shot tube = faint;
        tube.lights.erase("bulb");
        return rays_of(run, tube).cast / rays_of(run, faint).cast;
    };
    const double before = share_of_tube(1), after = share_of_tube(1e-3);
    EXPECT_GT(before, 0.3);
    EXPECT_LT(after, 0.15);
    EXPECT_GT(after, 0.001) << "nobody is forgotten";
}

// With few rays most tiles would get less than one of a faint lamp: each gets one now and then.
TEST_F(LightsBudget, NoTileOfAFaintLightWaitsForever) {
    Shot shot = room_under({"bulb", "tube"});
    for (auto& key : shot.lights.at("tube").keys) key.power *= 0.05;
    LightsRun run(shot, "lights_shadows", {"nodes.pilots.params.rays_per_frame=0.05"}, captures_of(shot));
    std::vector<bool> asked;
    std::vector<uint32_t> surfaces;
    for (uint32_t frame = 0; frame < 24; ++frame) {
        run.frame(frame);
        const auto words = captured<uint32_t>(run.view(), "ray_words_tube");
        surfaces = captured<uint32_t>(run.view(), "sunward_words_tube");
        asked.resize(words.size());
        for (size_t tile = 0; tile < words.size(); ++tile) asked[tile] = asked[tile] || words[tile] != 0;
    }
    size_t tiles = 0, waiting = 0;
    for (size_t tile = 0; tile < surfaces.size(); ++tile) {
        tiles += surfaces[tile] != 0;
        waiting += surfaces[tile] != 0 && !asked[tile];
    }
    EXPECT_LT(waiting * 4, tiles);
}

// Its passes would leave words of a past even then. The others get the rays that they would get without it.
TEST_F(LightsBudget, ALightThatIsOffSleeps) {
    Shot shot = room_under({"bulb", "panel"});
    std::vector<LightKey>& keys = shot.lights.at("panel").keys;
    keys = {3, keys.front()};
    for (size_t i = 0; i < keys.size(); ++i) {
        keys[i].frame = static_cast<double>(i + 1);
        keys[i].power = i == 2;  // off in frames 0 to 2, on from 3
    }
    const Shot bulb = room_under({"bulb"});
    const std::vector<std::string> captures{"state_bulb", "state_panel", "visibility_bulb",
                                            "visibility_panel"};
    const auto any = [](const LightsRun& run, const std::string& name) {
        const std::vector<uint32_t> words = captured<uint32_t>(run.view(), name);
        return std::ranges::any_of(words, [](uint32_t word) { return word != 0; });
    };
    LightsRun both(shot, "lights_shadows", {}, captures),
        alone(bulb, "lights_shadows", {}, {"visibility_bulb"});
    std::set<std::string> never_rest;
    for (const PlanPass& pass : both.view().plan().passes)
        if (pass.kind == PassKind::compute && pass.node.ends_with("_panel") && !pass.rests)
            never_rest.insert(pass.node);
    EXPECT_EQ(never_rest, (std::set<std::string>{"count_panel", "pool_panel", "tile_lux_panel"}));
    for (uint32_t frame = 0; frame < 4; ++frame) {
        both.frame(frame);
        alone.frame(frame);
        EXPECT_TRUE(any(both, "state_bulb")) << frame;
        EXPECT_EQ(any(both, "state_panel"), frame == 3) << frame;
        EXPECT_EQ(any(both, "visibility_panel"), frame == 3) << frame;
        if (frame == 3) continue;
        EXPECT_EQ(captured<uint16_t>(both.view(), "visibility_bulb"),
                  captured<uint16_t>(alone.view(), "visibility_bulb"))
            << frame;
    }
    // Whose past cannot begin cleared would reset all others' in the frame in which it wakes: it does not
    // sleep.
    LightsRun wakeful(shot, "lights_shadows", {R"(resources.state={"first": "any"})"}, captures);
    wakeful.frame(0);
    EXPECT_TRUE(any(wakeful, "state_panel"));
}

// Of a plan that hands on history, for a host that has this shot's lights and maybe more.
std::shared_ptr<const Program> program_under(const Shot& shot, const Session& host) {
    const CheckedPipeline pipeline = pipeline_for(shot, "lights_shadows", apart);
    DeviceTable device = device_table(handles_of(gpu()));
    device.features = features_of(gpu());
    CompileOptions options;
    options.captures = pipeline.output_names();
    options.hand_on_history = true;
    Diagnostics diagnostics;
    auto plan = compile(pipeline, standalone_target(pipeline, device, frame_size, host.host().facts()),
                        options, diagnostics);
    if (!plan) throw std::runtime_error(diagnostics.text());
    return std::make_shared<Program>(handles_of(gpu()), std::make_shared<const Plan>(std::move(*plan)));
}

// The host's last frame, through another view.
void record(View& view, const Session& host) {
    Externals externals(view.plan());
    const std::vector<SlotBinding> brought = host.bind_slots();
    for (size_t i = 0; i < brought.size(); ++i)
        if (const std::string& slot = host.plan().slots[i].name; externals.has(slot))
            externals[slot] = brought[i];
    gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, host.frame_description(), externals); });
}

// With a budget of each no light asks what the others do: so the masks of those that were there go on as if
// nothing had happened, and the new one's are those of a first frame and what follows it.
TEST_F(LightsBudget, ALightMoreBeginsAndTheOthersGoOn) {
    LightsRun run(room_under({"bulb", "panel", "tube"}), "lights_shadows", apart, {});
    const Session& host = run.session();
    const auto two = program_under(room_under({"bulb", "tube"}), host),
               three = program_under(room_under({"bulb", "panel", "tube"}), host);
    View before(two, {}), alone(two, {});
    for (uint32_t frame = 0; frame < 4; ++frame) {
        run.frame(frame);
        for (View* view : {&before, &alone}) record(*view, host);
    }
    View heir(three, {.heir_of = &before}), first(three, {});
    for (uint32_t frame = 4; frame < 6; ++frame) {
        run.frame(frame);
        for (View* view : {&alone, &heir, &first}) record(*view, host);
        EXPECT_EQ(heir.reset().reason, Reset::Reason::none);
        EXPECT_EQ(heir.reset().resource, "");
        const auto same = [&](const View& other, const char* mask) {
            return captured<uint8_t>(heir, mask) == captured<uint8_t>(other, mask);
        };
        for (const char* mask : {"visibility_bulb", "visibility_tube"}) {
            EXPECT_TRUE(same(alone, mask)) << mask << ", frame " << frame;
            EXPECT_FALSE(same(first, mask)) << mask << ", frame " << frame << ": it has no past";
        }
        EXPECT_TRUE(same(first, "visibility_panel")) << "frame " << frame;
    }
}

}  // namespace
}  // namespace penumbra::test
