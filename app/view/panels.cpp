// SPDX-License-Identifier: MIT
// Widgets only wish: what they wish for may make all anew that the frame's other widgets still look at.
#include "app/view/panels.h"

#include <GLFW/glfw3.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace penumbra::viewer {
namespace {

constexpr float left_width = 330, below_height = 250;
constexpr ImGuiWindowFlags fixed = ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoResize |
                                   ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoTitleBar |
                                   ImGuiWindowFlags_NoBringToFrontOnFocus;
constexpr ImGuiWindowFlags overlay = ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoInputs |
                                     ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoFocusOnAppearing;

void tooltip(const std::string& text) {
    if (text.empty() || !ImGui::IsItemHovered()) return;
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(360);
    ImGui::TextUnformatted(text.c_str());
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
}

// "%.3f m": how a slider prints its value.
std::string number_format(const Param& param, const char* plain) {
    std::string unit = param.unit;
    for (size_t at = 0; (at = unit.find('%', at)) != std::string::npos; at += 2) unit.insert(at, "%");
    return unit.empty() ? plain : fmt::format("{} {}", plain, unit);
}

}  // namespace

Area Panels::room() const {
    const ImVec2 whole = ImGui::GetIO().DisplaySize;
    if (hidden_) return {0, 0, whole.x, whole.y};
    return {left_width, 0, std::max(whole.x - left_width, 1.0f), std::max(whole.y - below_height, 1.0f)};
}

Area Panels::picture_area(const Live& live) const {
    return fitted(room(), live.size()[0], live.size()[1]);
}

void Panels::mark(const std::string& name) {
    const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
    places_[name] = {(low.x + high.x) / 2, (low.y + high.y) / 2};
}

Asked Panels::build(Live& live, FlightInput& input, std::span<const int> went_down) {
    Asked asked;
    places_.clear();
    wishes_.clear();
    if (!hidden_) {
        left(live);
        below(live);
    }
    caption(live);
    messages(live);
    mouse(live, input);
    keys(live, went_down, asked);
    for (const auto& wish : wishes_) wish(live);
    return asked;
}

void Panels::left(const Live& live) {
    ImGui::SetNextWindowPos({0, 0});
    ImGui::SetNextWindowSize({left_width, ImGui::GetIO().DisplaySize.y});
    ImGui::Begin("left", nullptr, fixed);
    ImGui::SetNextItemWidth(-1);
    const bool open =
        ImGui::BeginCombo("##pipeline", live.wish().pipeline.c_str(), ImGuiComboFlags_HeightLargest);
    mark("pipeline");
    if (open) {
        for (const std::string& name : pipelines_) {
            if (ImGui::Selectable(name.c_str(), name == live.wish().pipeline))
                wishes_.emplace_back([name](Live& l) { l.choose_pipeline(name); });
            if (ImGui::IsItemVisible()) mark("pipeline " + name);
        }
        ImGui::EndCombo();
    } else {
        tooltip(live.stage().pipeline.doc);
    }
    beside_buttons(live);
    const auto [width, height] = live.size();
    ImGui::Text("%ux%u", width, height);
    ImGui::SameLine();
    if (ImGui::SmallButton("coarser (-)")) wishes_.emplace_back([](Live& l) { l.reduce(l.divisor() + 1); });
    mark("coarser");
    ImGui::SameLine();
    if (ImGui::SmallButton("finer (=)") && live.divisor() > 1)
        wishes_.emplace_back([](Live& l) { l.reduce(l.divisor() - 1); });
    mark("finer");
    ImGui::Separator();
    controls(live);
    ImGui::End();
}

void Panels::beside_buttons(const Live& live) {
    ImGui::TextUnformatted("beside it");
    for (size_t i = 0; i < beside_names.size(); ++i) {
        if (i % 3 != 0) ImGui::SameLine();
        const auto beside = static_cast<Beside>(i);
        if (ImGui::RadioButton(beside_names[i], live.beside() == beside))
            wishes_.emplace_back([beside](Live& l) { l.compare(beside); });
        mark(std::string("beside ") + beside_names[i]);
    }
}

void Panels::controls(const Live& live) {
    ImGui::BeginChild("parameters");
    std::string node;
    bool open = false;
    for (size_t i = 0; i < live.stage().controls.size(); ++i) {
        const Control& c = live.stage().controls[i];
        if (c.node != node) {
            node = c.node;
            open = ImGui::CollapsingHeader(node.c_str(), ImGuiTreeNodeFlags_DefaultOpen);
        }
        if (open) control(live, i);
    }
    if (live.stage().controls.empty()) ImGui::TextDisabled("no parameter that can be turned");
    ImGui::EndChild();
}

void Panels::control(const Live& live, size_t index) {
    const Control& c = live.stage().controls[index];
    const auto wish = [&](ParamValue value) {
        wishes_.emplace_back([index, value = std::move(value)](Live& l) { l.turn_control(index, value); });
    };
    ImGui::PushID(static_cast<int>(index));
    ImGui::SetNextItemWidth(150);
    const char* name = c.param.name.c_str();
    const auto& range = c.param.range;
    constexpr ImGuiSliderFlags inside = ImGuiSliderFlags_AlwaysClamp;
    switch (c.param.type) {
        case ParamType::boolean: {
            bool v = std::get<bool>(c.value);
            if (ImGui::Checkbox(name, &v)) wish(v);
            break;
        }
        case ParamType::integer: {
            int v = std::get<int32_t>(c.value);
            const std::string format = number_format(c.param, "%d");
            if (range ? ImGui::SliderInt(name, &v, static_cast<int>((*range)[0]),
                                         static_cast<int>((*range)[1]), format.c_str(), inside)
                      : ImGui::DragInt(name, &v, 0.2f, 0, 0, format.c_str()))
                wish(int32_t{v});
            break;
        }
        case ParamType::uint: {
            uint32_t v = std::get<uint32_t>(c.value);
            const std::string format = number_format(c.param, "%u");
            const uint32_t low = range ? static_cast<uint32_t>((*range)[0]) : 0,
                           high = range ? static_cast<uint32_t>((*range)[1]) : 0;
            if (range
                    ? ImGui::SliderScalar(name, ImGuiDataType_U32, &v, &low, &high, format.c_str(), inside)
                    : ImGui::DragScalar(name, ImGuiDataType_U32, &v, 0.2f, nullptr, nullptr, format.c_str()))
                wish(v);
            break;
        }
        case ParamType::real: {
            float v = std::get<float>(c.value);
            const std::string format = number_format(c.param, "%.4g");
            // Of a range of several powers of ten the low end would be a pixel wide.
            const bool wide = range && (*range)[0] > 0 && (*range)[1] / (*range)[0] > 1000;
            if (range ? ImGui::SliderFloat(name, &v, static_cast<float>((*range)[0]),
                                           static_cast<float>((*range)[1]), format.c_str(),
                                           inside | (wide ? ImGuiSliderFlags_Logarithmic : 0))
                      : ImGui::DragFloat(name, &v, std::max(std::abs(v), 0.01f) / 100, 0, 0, format.c_str()))
                wish(v);
            break;
        }
        case ParamType::vec2:
        case ParamType::vec3:
        case ParamType::vec4: {
            auto v = std::get<std::vector<float>>(c.value);
            const float low = range ? static_cast<float>((*range)[0]) : 0,
                        high = range ? static_cast<float>((*range)[1]) : 0;
            const std::string format = number_format(c.param, "%.4g");
            if (ImGui::DragScalarN(name, ImGuiDataType_Float, v.data(), static_cast<int>(v.size()), 0.01f,
                                   range ? &low : nullptr, range ? &high : nullptr, format.c_str(),
                                   range ? inside : 0))
                wish(v);
            break;
        }
        case ParamType::enumeration: {
            const auto& now = std::get<std::string>(c.value);
            if (ImGui::BeginCombo(name, now.c_str())) {
                for (const std::string& value : c.param.values)
                    if (ImGui::Selectable(value.c_str(), value == now)) wish(value);
                ImGui::EndCombo();
            }
            break;
        }
    }
    if (ImGui::IsItemVisible()) mark("parameter " + c.name());
    tooltip(c.param.doc);
    if (c.changed()) {
        ImGui::SameLine();
        if (ImGui::SmallButton("reset")) wish(c.initial);
        mark("reset " + c.name());
        tooltip("--set " + setting_of(c));
    }
    ImGui::PopID();
}

void Panels::below(const Live& live) {
    const ImVec2 whole = ImGui::GetIO().DisplaySize;
    ImGui::SetNextWindowPos({left_width, whole.y - below_height});
    ImGui::SetNextWindowSize({std::max(whole.x - left_width, 1.0f), below_height});
    ImGui::Begin("below", nullptr, fixed);
    if (ImGui::BeginTabBar("tabs")) {
        const auto tab = [&](const char* name, const std::function<void()>& content) {
            const bool open = ImGui::BeginTabItem(name);
            mark(std::string("tab ") + name);
            if (!open) return;
            ImGui::BeginChild(name, {0, 0}, false, ImGuiWindowFlags_HorizontalScrollbar);
            content();
            ImGui::EndChild();
            ImGui::EndTabItem();
        };
        tab("time", [&] { costs(live); });
        tab("memory", [&] { memory(live); });
        tab("dataflow", [&] { dataflow(live); });
        tab("keys", [&] { help(); });
        ImGui::EndTabBar();
    }
    ImGui::End();
}

void Panels::help() const {
    for (const char* line :
         {"W A S D, Q E: fly; shift: five times as fast; wheel: the speed that is kept",
          "left button in the picture: look around; right button: the sun; at the line: the split",
          "space: play the shot; Home: back to its start",
          "1 .. 5: what is beside it: nothing, raw, published, the truth, the error",
          "- =: a coarser or a finer picture; H: the picture alone", "0: what the pipeline puts out",
          "R: record the flight, and write it as a shot; F12: a screenshot"})
        ImGui::BulletText("%s", line);
}

void Panels::caption(const Live& live) const {
    const Area area = room();
    std::string text = fmt::format("{:.1f} frames/s  {:.1f} CPU ms{}", frames_per_second, live.cpu_ms(),
                                   live.held() ? " while anything changes" : "");
    if (live.beside() == Beside::nothing)
        text += "  " + live.shown() + (picture_note.empty() ? "" : ": " + picture_note);
    else
        text += fmt::format("  visibility | {}", beside_names[static_cast<size_t>(live.beside())]);
    if (const auto judged = live.judgement()) {
        text += fmt::format("\nagainst {} rays: N_eff {}, RMSE {}", judged->rays,
                            judged->n_eff ? fmt::format("{:.3g}", *judged->n_eff) : "unknown",
                            judged->rmse ? fmt::format("{:.3g}", *judged->rmse) : "unknown");
    }
    if (live.records()) text += fmt::format("\nrecording: {:.1f} s", live.recorded().seconds());
    if (!said.empty()) text += "\n" + said;
    ImGui::SetNextWindowPos({area.x + 8, area.y + area.height - 8}, ImGuiCond_Always, {0, 1});
    ImGui::SetNextWindowBgAlpha(0.65f);
    ImGui::Begin("caption", nullptr, overlay);
    ImGui::TextUnformatted(text.c_str());
    ImGui::End();
}

void Panels::messages(const Live& live) const {
    if (live.error().empty()) return;
    const Area area = room();
    ImGui::SetNextWindowPos({area.x + 8, 8});
    ImGui::SetNextWindowBgAlpha(0.9f);
    ImGui::PushStyleColor(ImGuiCol_WindowBg, IM_COL32(110, 16, 16, 255));
    ImGui::Begin("error", nullptr, overlay);
    ImGui::PushTextWrapPos(std::max(area.width - 40, 100.0f));
    ImGui::TextUnformatted(live.error().c_str());
    ImGui::TextUnformatted("What ran before goes on.");
    ImGui::PopTextWrapPos();
    ImGui::End();
    ImGui::PopStyleColor();
}

void Panels::keys(const Live& live, std::span<const int> went_down, Asked& asked) {
    if (ImGui::GetIO().WantTextInput) return;
    const auto pressed = [&](int key) { return std::ranges::find(went_down, key) != went_down.end(); };
    for (int i = 0; i < static_cast<int>(beside_names.size()); ++i)
        if (pressed(GLFW_KEY_1 + i))
            wishes_.emplace_back([i](Live& l) { l.compare(static_cast<Beside>(i)); });
    if (pressed(GLFW_KEY_0)) wishes_.emplace_back([](Live& l) { l.show(""); });
    if (pressed(GLFW_KEY_MINUS)) wishes_.emplace_back([](Live& l) { l.reduce(l.divisor() + 1); });
    if (pressed(GLFW_KEY_EQUAL) && live.divisor() > 1)
        wishes_.emplace_back([](Live& l) { l.reduce(l.divisor() - 1); });
    if (pressed(GLFW_KEY_SPACE)) wishes_.emplace_back([](Live& l) { l.flight().play(!l.flight().plays()); });
    if (pressed(GLFW_KEY_HOME)) wishes_.emplace_back([](Live& l) { l.flight().start_over(); });
    if (pressed(GLFW_KEY_H)) hidden_ = !hidden_;
    asked.screenshot = pressed(GLFW_KEY_F12);
    if (pressed(GLFW_KEY_R)) {
        asked.write_record = live.records();
        wishes_.emplace_back([](Live& l) { l.record(!l.records()); });
    }
}

void Panels::mouse(Live& live, FlightInput& input) {
    const ImGuiIO& io = ImGui::GetIO();
    const Area area = picture_area(live);
    const bool inside = !io.WantCaptureMouse && io.MousePos.x >= area.x &&
                        io.MousePos.x < area.x + area.width && io.MousePos.y >= area.y &&
                        io.MousePos.y < area.y + area.height;
    const float line = area.x + static_cast<float>(live.split_share) * area.width;
    if (inside && (ImGui::IsMouseClicked(0) || ImGui::IsMouseClicked(1))) {
        drags_split_ = live.beside() != Beside::nothing && ImGui::IsMouseClicked(0) &&
                       std::abs(io.MousePos.x - line) < 8;
        drags_picture_ = !drags_split_;
    }
    if (!io.MouseDown[0] && !io.MouseDown[1]) drags_split_ = drags_picture_ = false;
    if (drags_split_) live.split_share = std::clamp((io.MousePos.x - area.x) / area.width, 0.0f, 1.0f);
    if (drags_picture_) {
        // A point follows the mouse in the picture's middle.
        const double radians = live.shot().vertical_fov_deg / 180 * 3.14159265358979 / area.height;
        if (io.MouseDown[0]) input.look = {-io.MouseDelta.x * radians, io.MouseDelta.y * radians};
        if (io.MouseDown[1]) input.sun = {io.MouseDelta.x * 0.005, -io.MouseDelta.y * 0.005};
    }
    if (inside && io.MouseWheel != 0) input.faster = std::pow(1.2, io.MouseWheel);
}

}  // namespace penumbra::viewer
