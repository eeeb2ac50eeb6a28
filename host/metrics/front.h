// SPDX-License-Identifier: MIT
// What a family of contenders is worth at any cost: the line through those that no other of them beats,
// straight between logarithms of cost and worth. Beyond its ends it goes on with the slope of its last piece,
// and says so.
#pragma once

#include <optional>
#include <vector>

namespace penumbra {

// `worth` is better the larger it is, infinite where there is no error left to see.
struct FrontPoint {
    double cost = 0, worth = 0;
};

// As cheap and as good, and one of the two more so.
bool beats(const FrontPoint& a, const FrontPoint& b);

class Front {
  public:
    // In any order. What has no positive finite cost, or no positive worth (NaN among them), is no point.
    explicit Front(std::vector<FrontPoint> points);

    // Rising in both, the infinitely good one apart.
    const std::vector<FrontPoint>& points() const { return points_; }

    struct Reading {
        double value = 0;
        bool extrapolated = false;
    };
    // Nothing where the line has no piece: at all costs but its own where there is one point.
    std::optional<Reading> worth_at(double cost) const;
    // The least cost of that worth, which may be infinite.
    std::optional<Reading> cost_of(double worth) const;

  private:
    std::vector<FrontPoint> points_;
    std::optional<double> exact_from_;  // the cost from which on the worth is infinite
};

}  // namespace penumbra
