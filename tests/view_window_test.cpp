// SPDX-License-Identifier: MIT
// `penumbra view` in a window of a screen without hardware (Xvfb), with clicks and keys as a hand gives them
// (xdotool); looked at through the screenshots that it writes when it is told to.
#include <fcntl.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <glm/glm.hpp>
#include <nlohmann/json.hpp>
#include <thread>

#include "host/images/image_decode.h"
#include "host/shots/shot.h"
#include "tests/cli_run.h"

namespace penumbra::test {
namespace {

using Json = nlohmann::json;
using namespace std::chrono_literals;

// A process of ours, which ends with us.
class Child {
  public:
    Child(const std::vector<std::string>& command, const fs::path& said, const std::string& display,
          int keep = -1) {
        id_ = fork();
        if (id_ != 0) return;
        const int out = open(said.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
        dup2(out, 1);
        dup2(out, 2);
        if (keep >= 0) dup2(keep, 3);
        if (!display.empty()) setenv("DISPLAY", display.c_str(), 1);
        if (chdir(PENUMBRA_SOURCE_DIR) != 0) _exit(127);
        std::vector<char*> arguments;
        for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
        arguments.push_back(nullptr);
        execvp(arguments[0], arguments.data());
        _exit(127);
    }
    ~Child() {
        if (id_ > 0) kill(id_, SIGTERM);
        wait();
    }
    Child(const Child&) = delete;
    Child& operator=(const Child&) = delete;
    bool runs() {
        if (id_ > 0 && waitpid(id_, &status_, WNOHANG) == id_) id_ = 0;
        return id_ > 0;
    }
    int wait() {
        if (id_ > 0) waitpid(id_, &status_, 0);
        id_ = 0;
        return WIFEXITED(status_) ? WEXITSTATUS(status_) : -1;
    }

  private:
    pid_t id_ = 0;
    int status_ = 0;
};

class ViewWindow : public Cli {
  protected:
    void SetUp() override {
        Cli::SetUp();
        int ends[2];
        ASSERT_EQ(pipe(ends), 0);
        screen_ = std::make_unique<Child>(std::vector<std::string>{"Xvfb", "-displayfd", "3", "-screen", "0",
                                                                   "1000x700x24", "-nolisten", "tcp"},
                                          folder_ / "xvfb", "", ends[1]);
        close(ends[1]);
        std::string number;  // Xvfb writes it in pieces, a line in all
        for (char c = 0; read(ends[0], &c, 1) == 1 && c != '\n';) number += c;
        close(ends[0]);
        ASSERT_FALSE(number.empty()) << "no Xvfb: scripts/setup.sh --test installs it; "
                                     << read_file(folder_ / "xvfb");
        display_ = ":" + number;
    }
    void open_view(std::vector<std::string> more) {
        std::vector<std::string> command{PENUMBRA_PROGRAM, "view",     "--size", "160x90",
                                         "--window",       "1000x700", "--out",  (folder_ / "shots").string(),
                                         "--validate"};
        command.insert(command.end(), more.begin(), more.end());
        view_ = std::make_unique<Child>(command, folder_ / "said", display_);
    }
    bool hand(const std::string& gesture) const {
        return std::system(
                   ("DISPLAY=" + display_ + " timeout 60 xdotool " + gesture + " >/dev/null 2>&1").c_str()) ==
               0;
    }
    // Until a frame has been drawn that knows all gestures before: a screenshot is the sign.
    std::string pass_frame() {
        const std::string number = std::to_string(++looks_);
        const fs::path name = folder_ / ("shots/view." + std::string(4 - number.size(), '0') + number);
        EXPECT_TRUE(hand("key F12"));
        for (int i = 0; i < 1200 && !fs::exists(name.string() + ".json") && view_->runs(); ++i)
            std::this_thread::sleep_for(50ms);
        if (!fs::exists(name.string() + ".json"))
            throw std::runtime_error("no screenshot: " + read_file(folder_ / "said"));
        return name.string();
    }
    // What the window shows now; its picture is in picture_. A click is two frames, and what it wishes for is
    // seen in the third.
    void look() {
        pass_frame();
        pass_frame();
        const std::string name = pass_frame();
        const std::string png = read_file(name + ".png");
        picture_ = decode_image(std::as_bytes(std::span(png)), 1u << 30);
        seen_ = Json::parse(read_file(name + ".json"));
    }
    void click(const std::string& place, int button = 1) {
        ASSERT_TRUE(seen_["places"].contains(place)) << place << " is not in the window";
        const auto [x, y] = seen_["places"][place].get<std::array<float, 2>>();
        ASSERT_TRUE(hand("mousemove " + std::to_string(int(x)) + " " + std::to_string(int(y))));
        pass_frame();
        ASSERT_TRUE(hand("click " + std::to_string(button)));
        look();
    }
    void drag(int button) {
        const std::string b = std::to_string(button);
        for (const std::string& gesture : {std::string("mousemove 560 200"), "mousedown " + b,
                                           std::string("mousemove 620 200"), "mouseup " + b}) {
            ASSERT_TRUE(hand(gesture));
            pass_frame();
        }
        look();
    }
    std::array<int, 3> pixel(uint32_t x, uint32_t y) const {
        const uint8_t* p = picture_.rgba.data() + 4 * (size_t{y} * picture_.width + x);
        return {p[0], p[1], p[2]};
    }
    // Pixels of the picture's right half that are neither black nor white nor of the interface.
    size_t greys(uint32_t x0, uint32_t x1) const {
        size_t count = 0;
        for (uint32_t y = 60; y < 380; ++y)
            for (uint32_t x = x0; x < x1; ++x) {
                const auto [r, g, b] = pixel(x, y);
                count += r == g && g == b && r > 8 && r < 247;
            }
        return count;
    }

    std::string display_;
    std::unique_ptr<Child> screen_, view_;
    int looks_ = 0;
    Json seen_;
    RgbaImage picture_;
};

glm::dvec3 vector(const Json& json) {
    return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()};
}

TEST_F(ViewWindow, HandsReachEverything) {
    open_view({"covered", "--shot", "lamp"});
    ASSERT_TRUE(hand("search --sync --onlyvisible --name 'penumbra view' windowfocus --sync"))
        << read_file(folder_ / "said");
    look();
    EXPECT_EQ(picture_.width, 1000u);
    EXPECT_EQ(picture_.height, 700u);
    EXPECT_EQ(seen_["pipeline"], "covered");

    // Beside raw rays: on the right there is no grey, on the left there is.
    ASSERT_TRUE(hand("key space"));
    click("beside raw");
    ASSERT_EQ(seen_["beside"], "raw") << seen_["error"];
    EXPECT_GT(greys(340, 650), 20u);
    EXPECT_EQ(greys(680, 990), 0u);

    // Another pipeline, chosen from the list.
    click("beside nothing");
    click("pipeline");
    click("pipeline raw");
    EXPECT_EQ(seen_["pipeline"], "raw") << seen_["error"];

    // The left button looks around, the right one moves the sun, a key flies.
    const Json before = seen_;
    drag(1);
    const glm::dvec3 old_ahead = vector(before["camera"]["target"]) - vector(before["camera"]["position"]),
                     ahead = vector(seen_["camera"]["target"]) - vector(seen_["camera"]["position"]);
    EXPECT_GT(glm::length(glm::normalize(old_ahead) - glm::normalize(ahead)), 0.02);
    EXPECT_EQ(seen_["to_sun"], before["to_sun"]);
    const Json looked = seen_;
    drag(3);
    EXPECT_GT(glm::length(vector(looked["to_sun"]) - vector(seen_["to_sun"])), 0.02);
    EXPECT_EQ(seen_["camera"], looked["camera"]);
    const Json sunned = seen_;
    ASSERT_TRUE(hand("key r"));
    look();
    ASSERT_TRUE(hand("key w"));
    look();
    const glm::dvec3 way = vector(seen_["camera"]["position"]) - vector(sunned["camera"]["position"]);
    ASSERT_GT(glm::length(way), 1e-4) << "a short tap flies, too";
    EXPECT_GT(glm::dot(glm::normalize(way), glm::normalize(ahead)), 0.999);

    // The flight is a shot.
    ASSERT_TRUE(hand("key r"));
    const fs::path flight = folder_ / "shots/flight.0001.shot.json";
    for (int i = 0; i < 300 && !fs::exists(flight); ++i) std::this_thread::sleep_for(100ms);
    Diagnostics diagnostics;
    const auto flown = read_shot(flight, diagnostics);
    ASSERT_TRUE(flown) << diagnostics.text();
    EXPECT_TRUE(fs::exists(flown->model)) << flown->model;
    EXPECT_LT(glm::length(flown->camera.front().position - vector(sunned["camera"]["position"])), 1e-3);

    // The dataflow: a click on a resource shows it.
    click("tab dataflow");
    click("resource view_depth");
    EXPECT_EQ(seen_["resource"], "view_depth") << seen_["error"];

    // A key makes the picture coarser.
    ASSERT_TRUE(hand("key minus"));
    look();
    EXPECT_EQ(seen_["size"], (Json{80, 45}));
    EXPECT_EQ(seen_["error"], "");
    EXPECT_TRUE(view_->runs()) << read_file(folder_ / "said");
}

// Validation is on, and what it says is the exit code.
TEST_F(ViewWindow, ItEndsByItselfAndSilently) {
    open_view({"hybrid_shadows", "--shot", "lamp", "--frames", "6"});
    EXPECT_EQ(view_->wait(), 0) << read_file(folder_ / "said");
    EXPECT_EQ(read_file(folder_ / "said"), "");
}

TEST_F(ViewWindow, HeadlessIsTheSamePictureAndMistakesAreSaid) {
    const std::string png = (folder_ / "view.png").string();
    const Result good =
        run("view raw --shot lamp --size 160x90 --window 800x600 --frames 3 --beside truth --rays 16 "
            "--validate --headless " +
            png);
    ASSERT_EQ(good.code, 0) << good.err;
    const Json json = Json::parse(read_file(folder_ / "view.json"));
    EXPECT_EQ(json["beside"], "truth");
    EXPECT_GE(json["judgement"]["rays"], 16);
    EXPECT_NEAR(json["judgement"]["n_eff"].get<double>(), 1, 0.6);
    const std::string failed = in("failed.png");
    expect(run("view raw --shot lamp --size 160x90 --show vis --headless " + failed), 2, "\"vis\"");
    expect(run("view raw --shot lamp --size 160x90 --window 99999x10 --headless " + failed), 2,
           "--window: 99999x10 exceeds the device's largest image");
    expect(run("view rew --shot lamp --headless " + failed), 2, "did you mean \"raw\"?");
    expect(run("view raw --shot lamp --rays 16"), 2, "--headless");
    expect(run("view raw_reflections --shot lamp --size 160x90 --beside truth --headless " + failed), 2,
           "visibility");
    const std::string analytic =
        file("a.shot.json", R"({"penumbra_shot": 1, "scene": {"analytic": "half_plane",
        "penumbra_px": 16}, "sun": {"keys": [{"frame": 0, "to_sun": [0.3, 0.2, 1]}]}})");
    expect(run("view raw --shot " + analytic + " --headless " + failed), 2, "analytic");
    EXPECT_FALSE(fs::exists(failed)) << "nothing is left of what failed";
}

// Without a screen there is an error in words.
TEST_F(Cli, AViewWithoutAScreenSaysSo) {
    const std::string command = std::string("env -u DISPLAY -u WAYLAND_DISPLAY '") + PENUMBRA_PROGRAM +
                                "' view raw --shot " PENUMBRA_SOURCE_DIR
                                "/scenes/lamp.shot.json >/dev/null 2>'" +
                                (folder_ / "err").string() + "'";
    EXPECT_NE(std::system(command.c_str()), 0);
    EXPECT_NE(read_file(folder_ / "err").find("--headless"), std::string::npos) << read_file(folder_ / "err");
}

}  // namespace
}  // namespace penumbra::test
