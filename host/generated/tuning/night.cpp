// SPDX-License-Identifier: MIT
#include "host/generated/tuning/night.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "host/generated/tuning/families.h"
#include "host/generated/tuning/placing.h"

namespace penumbra::tuning {

namespace {

constexpr glm::dvec3 half_room(4, 1.5, 4);  // metres; its floor is at 0, the camera looks along -z

enum class Ground { room, halls, yard, open_sky };  // halls: a room with a wall across its middle

Material drawn_surface(SceneRandom& random, bool dark) {
    constexpr std::array<float, 7> roughness{0.02f, 0.08f, 0.15f, 0.25f, 0.4f, 0.6f, 0.9f};
    Material out;
    const double bright = dark && random.in(0, 1) < 0.5 ? 0 : 0.9;
    for (size_t i = 0; i < 3; ++i) out.base_color[i] = static_cast<float>(bright * random.in(0, 1));
    out.metallic = random.in(0, 1) < 0.3 ? 1.0f : 0.0f;
    out.roughness = roughness[static_cast<size_t>(random.in(0, roughness.size()))];
    return out;
}

class Room {
  public:
    explicit Room(SceneRandom random) : random_(random), dark_(random_.in(0, 1) < 0.3) {}

    void build(Ground ground) {
        if (ground == Ground::room || ground == Ground::halls)
            walls();
        else
            solid(box({-20, -0.1, -20}, {20, 0, 20}));
        if (ground == Ground::halls) solid(box({-0.05, 0, -half_room.z}, {0.05, 2.2, 1}));
        for (int i = count(3, 9); i > 0; --i) furniture();
        for (int i = count(0, 7); i > 0; --i) body_that_shines();
        for (int i = count(1, 6); i > 0; --i) lamp();
    }

    std::string lamps() const { return lamps_; }
    Model model() {
        ModelBuilder builder(materials_);
        for (size_t i = 0; i < shapes_.size(); ++i)
            builder.solid("solid_" + std::to_string(i), shapes_[i], static_cast<int>(i));
        return builder.take();
    }

  private:
    int count(double low, double end) { return static_cast<int>(random_.in(low, end)); }

    void solid(Shape shape, const Material& material) {
        shapes_.push_back(std::move(shape));
        materials_.push_back(material);
    }
    void solid(Shape shape) { solid(std::move(shape), drawn_surface(random_, dark_)); }

    // Each of another material.
    void walls() {
        constexpr double thick = 0.1;
        for (int axis = 0; axis < 3; ++axis)
            for (const double side : {-1.0, 1.0}) {
                glm::dvec3 half = half_room + thick, middle(0, half_room.y, 0);
                half[axis] = thick;
                middle[axis] += side * (half_room[axis] + thick);
                solid(moved(bar(half), glm::dmat4(1), middle));
            }
    }

    glm::dvec3 drawn(const glm::dvec3& low, const glm::dvec3& high) {
        glm::dvec3 out;
        for (int axis = 0; axis < 3; ++axis) out[axis] = random_.in(low[axis], high[axis]);
        return out;
    }
    glm::dmat4 drawn_heading() { return heading(random_.in(0, glm::pi<double>())); }

    // Two of three stand on the floor.
    void furniture() {
        const glm::dvec3 half = drawn({0.1, 0.1, 0.1}, {0.6, 0.6, 0.6});
        const double lift = random_.in(0, 3) < 1 ? random_.in(0.2, 1.5) : 0;
        const glm::dvec3 place = drawn({-3, half.y + lift, -3.5}, {3, half.y + lift, 1.5});
        solid(moved(bar(half), drawn_heading(), place));
    }

    // A cube of 4 to 50 cm, half of them with a plate above or below, a centimetre away.
    void body_that_shines() {
        const glm::dvec3 place = drawn({-3.5, 0.1, -3.5}, {3.5, 2.8, 2});
        const double half = random_.in(0.02, 0.25), radiance = std::pow(10, random_.in(0, 2.5));
        Material material;
        const float white = random_.in(0, 1) < 0.5 ? 0.0f : 0.5f;
        material.base_color = {white, white, white, 1};
        material.roughness = 0.5f;
        for (float& e : material.emissive)  // rounded, for libraries differ in the last digit of a power
            e = static_cast<float>(std::round(64 * radiance * random_.in(0.3, 1)) / 64);
        const glm::dmat4 turned = drawn_heading();
        solid(moved(bar(glm::dvec3(half)), turned, place), material);
        if (random_.in(0, 1) < 0.5) return;
        const double side = random_.in(0, 1) < 0.5 ? -1 : 1;
        solid(moved(bar({2 * half, 0.01, 2 * half}), turned, place + glm::dvec3(0, side * (half + 0.02), 0)));
    }

    // Of any kind; one in three goes half a metre, one in four has an end to its light.
    void lamp() {
        const glm::dvec3 place = drawn({-3.5, 0.3, -3.5}, {3.5, 2.9, 2.5});
        const glm::dvec3 facing = glm::normalize(drawn({-1, -1.5, -1}, {1, 0.1, 1}));
        const glm::dvec3 along = glm::normalize(glm::cross(facing, drawn({-1, 0.1, -1}, {1, 1, 1})));
        const double size = between(0.01, 0.4, random_), width = size * between(1, 8, random_);
        const double candelas = between(20, 2000, random_);
        std::string shape, turn;
        switch (static_cast<int>(random_.in(0, 6))) {
            case 0:
                shape = fmt::format(R"("kind": "point", "intensity": {:.3f})", candelas);
                break;
            case 1:
                shape = fmt::format(R"("kind": "sphere", "radius": {:.4f}, "luminance": {:.3f})", size,
                                    candelas / (size * size));
                break;
            case 2:
                shape = fmt::format(R"("kind": "disc", "radius": {:.4f}, "luminance": {:.3f})", size,
                                    candelas / (size * size));
                turn = facing_text(facing);
                break;
            case 3:
                shape = fmt::format(
                    R"("kind": "rectangle", "width": {:.4f}, "height": {:.4f}, "luminance": {:.3f})", width,
                    size, candelas / (width * size));
                turn = facing_text(facing) + along_text(along);
                break;
            case 4:
                shape =
                    fmt::format(R"("kind": "tube", "length": {:.4f}, "radius": {:.4f}, "luminance": {:.3f})",
                                width, 0.2 * size, candelas / (width * size));
                turn = along_text(along);
                break;
            default: {
                const double inner = random_.in(0, 25), outer = random_.in(26, 70);
                shape = fmt::format(
                    R"("kind": "spot", "radius": {:.4f}, "inner_deg": {:.2f}, "outer_deg": {:.2f}, "intensity": {:.3f})",
                    size, inner, outer, candelas);
                turn = facing_text(facing);
            }
        }
        if (random_.in(0, 4) < 1) shape += fmt::format(R"(, "range": {:.3f})", random_.in(1.5, 8));
        std::string keys = fmt::format(R"({{ "frame": 0, "position": {}{} }})", vector_text(place), turn);
        if (random_.in(0, 3) < 1)
            keys += fmt::format(R"(, {{ "frame": {}, "position": {}{} }})", frames - 1,
                                vector_text(place + drawn(glm::dvec3(-0.3), glm::dvec3(0.3))), turn);
        lamps_ += fmt::format("{}    \"lamp_{}\": {{ {}, \"keys\": [{}] }}", lamps_.empty() ? "" : ",\n",
                              lamp_count_++, shape, keys);
    }

    static std::string facing_text(const glm::dvec3& v) { return ", \"direction\": " + vector_text(v); }
    static std::string along_text(const glm::dvec3& v) { return ", \"along\": " + vector_text(v); }

    SceneRandom random_;
    bool dark_;  // half of the surfaces are black
    std::vector<Shape> shapes_;
    std::vector<Material> materials_;
    std::string lamps_;
    int lamp_count_ = 0;
};

}  // namespace

NightScene make_night_scene(uint32_t seed) {
    const std::string name = std::string(night_family) + "_" + std::to_string(seed);
    SceneRandom random(pcg(seed ^ 0x9167u));
    const auto ground = static_cast<Ground>(seed % 4);
    const double x = random.in(-2.5, 2.5), z = random.in(2, 3.8), step = random.in(-1, 1);
    Room room(random);
    room.build(ground);
    NightScene out{name, room.model(), {}};
    snap(out.model);
    const std::string sky = ground == Ground::open_sky ? R"("down": [0.1, 0.1, 0.1], "up": [0.3, 0.4, 0.6])"
                                                       : R"("down": [0, 0, 0], "up": [0, 0, 0])";
    const std::string camera =
        fmt::format(R"(      {{ "frame": 0, "position": {}, "target": [0, 0.8, -1] }},
      {{ "frame": {}, "position": {}, "target": {} }})",
                    vector_text({x, 1.6, z}), frames - 1, vector_text({x + 0.5 * step, 1.65, z - 0.15}),
                    vector_text({0.15 * step, 0.8, -1}));
    out.shot =
        shot_head(name + ".glb", camera) +
        fmt::format(
            R"(  "sun": {{ "angular_radius_deg": 0.2665, "keys": [{{ "frame": 0, "to_sun": [0.3, -1, 0.2] }}] }},
  "environment": {{ {} }},
  "lights": {{
{}
  }},
  "origin": [0, 0, 0],
  "seed": 0
}}
)",
            sky, room.lamps());
    return out;
}

}  // namespace penumbra::tuning
