// SPDX-License-Identifier: MIT
// Inline SVG: shapes with classes that the page's style sheet colours, and axes with ticks that a person
// would have chosen.
#pragma once

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace penumbra::report {

struct Xy {
    double x = 0, y = 0;
};

class Svg {
  public:
    // `label` is what a screen reader says of the figure.
    Svg(double width, double height, std::string_view label);

    void line(Xy a, Xy b, std::string_view style);
    void polyline(const std::vector<Xy>& points, std::string_view style);
    void path(std::string_view commands, std::string_view style, std::string_view title = {});
    void rect(Xy corner, Xy size, std::string_view style, std::string_view title = {}, double radius = 0);
    void circle(Xy centre, double radius, std::string_view style, std::string_view title = {});
    enum class Anchor { start, middle, end };
    void text(Xy at, std::string_view text, std::string_view style = {}, Anchor anchor = Anchor::start,
              double turn_deg = 0);
    std::string str() const;  // the whole element
    // A file of its own, on white, for whoever shows it without the page's style sheet.
    std::string file(std::string_view style_sheet) const;

  private:
    void close(std::string_view element, std::string_view title);

    std::string head_, body_;
};

// About how wide the page's font sets a text of `pixels` height.
double text_width(std::string_view text, double pixels = 11);

struct Tick {
    double value = 0;
    std::string label;
};

// A range of values on a line; positions run from 0 to 1.
struct Axis {
    double low = 0, high = 1;
    bool log = false;
    std::vector<Tick> ticks;

    double at(double value) const;
};

// Ticks at 1, 2, 5 times powers of ten that cover all values (of which there may be none).
Axis linear_axis(const std::vector<double>& values, bool from_zero);
// The same on a logarithmic scale, by decades where there are many; values that are not positive are left
// out.
Axis log_axis(const std::vector<double>& values);

// A plot's frame: where the axes stand in the figure, and how values become places.
struct Frame {
    Xy corner{52, 14}, size{440, 240};  // of the inner area
    Axis x, y;

    Xy at(double x_value, double y_value) const;
    // Grid, ticks and titles.
    void draw(Svg& svg, std::string_view x_title, std::string_view y_title) const;
};

}  // namespace penumbra::report
