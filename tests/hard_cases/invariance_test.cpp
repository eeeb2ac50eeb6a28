// SPDX-License-Identifier: MIT
// Metric 12, invariances that need no reference: a scene, its camera and its sun turned together, mirrored,
// or with their axes renamed are the same scene. The converged picture must not change (RMSE within 1/255).
// The noise does, since the points of the sun are taken in a frame of their own: of the denoised picture the
// statistics must agree, N_eff within 2 % beyond what the seeds leave open. Naive: one phase for both
// coordinates of the sun's disc, whose error depends on the direction of an edge in that frame. Scale and
// translation are cases 1, 2 and 9 (coordinates_test.cpp).
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "tests/hard_cases/hard_cases.h"

namespace penumbra::test {
namespace {

const double allowed = std::log(1.02);

struct Turn {
    const char* name;
    glm::dmat3 matrix;
    bool mirrors() const { return glm::determinant(matrix) < 0; }
};

glm::dmat3 rotation(double deg, const glm::dvec3& axis) {
    return glm::dmat3(glm::rotate(glm::dmat4(1), glm::radians(deg), axis));
}

// A mirrored solid is wound the other way round, or its outside would be its inside.
Shape turned(Shape shape, const Turn& turn) {
    for (glm::vec3& p : shape.positions) p = glm::vec3(turn.matrix * glm::dvec3(p));
    if (turn.mirrors())
        for (size_t i = 0; i < shape.indices.size(); i += 3)
            std::swap(shape.indices[i], shape.indices[i + 1]);
    return shape;
}

// Nothing touches the floor and the sun is large, so that no penumbra is narrower than some pixels: of one
// that is, a few pixels' luck would decide a picture's N_eff.
Shot turned_shot(const Turn& turn) {
    Shot shot = scene_shot(std::string("turned ") + turn.name,
                           {{"floor", turned(ground(8, 8, 4, 4), turn)},
                            {"block", turned(box({-1.4, 0.9, -1.2}, {-0.3, 1.2, -0.1}), turn)},
                            {"bar", turned(rod({-3, 1.5, 0}, {3, 1.5, 0.5}, 0.15, 12), turn)}},
                           {128, 72});
    for (CameraKey& key : shot.camera) {
        key.position = turn.matrix * key.position;
        key.target = turn.matrix * key.target;
        key.up = turn.matrix * key.up;
    }
    shot.sun_angular_radius_deg = 6;
    for (SunKey& key : shot.sun) key.to_sun = turn.matrix * key.to_sun;
    return shot;
}

// As the unturned camera sees it: a camera's axes stay right-handed, so a mirrored scene has its left at its
// right.
std::vector<float> seen_unturned(std::vector<float> image, const Turn& turn, uint32_t width) {
    if (turn.mirrors())
        for (size_t row = 0; row < image.size(); row += width)
            std::reverse(image.begin() + std::ptrdiff_t(row), image.begin() + std::ptrdiff_t(row + width));
    return image;
}

// Mean over seeds of the summed squared errors of a frame, and the deviation of that mean.
struct Error {
    double mean = 0, deviation = 0;
};

Error error_of(const Shot& shot, const std::vector<float>& truth, const RunOptions& options) {
    constexpr uint32_t seeds = 12, last = 31;
    ShotRun run("one_ray", shot, options);
    double sum = 0, squares = 0;
    for (uint32_t seed = 0; seed < seeds; ++seed) {
        run.session().set_param("seed", seed);
        const double error = 1 / n_eff(run.up_to(last), truth);  // from a reset on
        sum += error;
        squares += error * error;
    }
    const double mean = sum / seeds;
    return {mean, std::sqrt((squares / seeds - mean * mean) / (seeds - 1))};
}

// How far the logarithm of N_eff moved, and how far it may have by chance (three deviations).
struct Change {
    double found = 0, open = 0;
};

Change change(const Error& from, const Error& to) {
    return {std::log(from.mean / to.mean),
            3 * std::hypot(from.deviation / from.mean, to.deviation / to.mean)};
}

TEST_F(HardCase, ATurnedOrMirroredSceneIsTheSameScene) {
    const Turn as_it_is{"not", glm::dmat3(1)};
    const std::vector<Turn> turns = {
        {"yzx", glm::dmat3(0, 0, 1, 1, 0, 0, 0, 1, 0)},  // even permutations of the axes: rotations
        {"zxy", glm::dmat3(0, 1, 0, 0, 0, 1, 1, 0, 0)},
        {"yxz", glm::dmat3(0, 1, 0, 1, 0, 0, 0, 0, 1)},  // an odd one: a mirror
        {"-x", glm::dmat3(-1, 0, 0, 0, 1, 0, 0, 0, 1)},
        {"-z", glm::dmat3(1, 0, 0, 0, 1, 0, 0, 0, -1)},
        {"about y", rotation(37, {0, 1, 0})},
        {"at random", rotation(71, {0.5, -0.3, 0.8})},
    };
    const RunOptions published{.settings = {"nodes.trace.params.sampling=published"}};
    const Shot shot = turned_shot(as_it_is);
    const std::vector<float> truth = truth_of(shot, 0, 196).visibility;
    const Error ours = error_of(shot, truth, {}), naive = error_of(shot, truth, published);
    double naive_beyond = 0;
    for (const Turn& turn : turns) {
        SCOPED_TRACE(turn.name);
        const Shot other = turned_shot(turn);
        ASSERT_GT(other.sun[0].to_sun.y, 0);  // the one axis with a meaning: below it, no frame is traced
        const std::vector<float> there = truth_of(other, 0, 196).visibility;
        const double apart = rms(truth, seen_unturned(there, turn, shot.size[0]));
        const Change moved = change(ours, error_of(other, there, {}));
        const std::string what = std::string("metric 12, turned: ") + turn.name;
        figure((what + ", RMSE of the converged picture").c_str(), NAN, apart);
        figure((what + ", three deviations of log N_eff (naive), its change (ours)").c_str(), moved.open,
               moved.found);
        EXPECT_LT(apart, 1.0 / 255);
        EXPECT_LT(std::abs(moved.found) - moved.open, allowed);
        if (turn.name != std::string_view("-z")) continue;
        const Change of_naive = change(naive, error_of(other, there, published));
        naive_beyond = std::abs(of_naive.found) - of_naive.open;
        figure((what + ", the same of one phase: change (naive), three deviations (ours)").c_str(),
               of_naive.found, of_naive.open);
    }
    EXPECT_GT(naive_beyond, 10 * allowed);
}

}  // namespace
}  // namespace penumbra::test
