// SPDX-License-Identifier: MIT
// The interface around the picture, in Dear ImGui: what runs and its parameters on the left, what it costs
// and its dataflow below. It knows what is shown (live.h) and no window.
#pragma once

#include <array>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "app/view/canvas.h"
#include "app/view/live.h"

namespace penumbra::viewer {

// Centres of what can be clicked, in pixels of the window, by name: for programs that click.
using Places = std::map<std::string, std::array<float, 2>>;

// What a frame of the interface asks of whoever runs it.
struct Asked {
    bool screenshot = false, write_record = false;
};

class Panels {
  public:
    // `pipelines`: what can be chosen, the first is the one that was given.
    explicit Panels(std::vector<std::string> pipelines) : pipelines_(std::move(pipelines)) {}

    // Between ImGui::NewFrame() and Render(). `pressed`: GLFW's numbers of the keys that went down. Wishes
    // are carried out at the end of it. `input` gets what the mouse has done in the picture.
    Asked build(Live& live, FlightInput& input, std::span<const int> pressed);

    // Where the picture goes, of these proportions.
    Area picture_area(const Live& live) const;
    const Places& places() const { return places_; }
    std::string said;          // a line about what was written
    std::string picture_note;  // Picture::note of the last one
    double frames_per_second = 0;

  private:
    Area room() const;
    void mark(const std::string& name);
    void left(const Live& live);
    void beside_buttons(const Live& live);
    void controls(const Live& live);
    void control(const Live& live, size_t index);
    void below(const Live& live);
    void costs(const Live& live);
    void memory(const Live& live);
    void dataflow(const Live& live);
    void help() const;
    void caption(const Live& live) const;
    void messages(const Live& live) const;
    void keys(const Live& live, std::span<const int> pressed, Asked& asked);
    void mouse(Live& live, FlightInput& input);

    std::vector<std::string> pipelines_;
    Places places_;
    std::vector<std::function<void(Live&)>> wishes_;
    bool hidden_ = false, drags_split_ = false, drags_picture_ = false;
};

}  // namespace penumbra::viewer
