// SPDX-License-Identifier: MIT
// The truth where no closed form is: how many of many directions to the sun's disc are free, from the very
// point that a pixel shows. Everything is in double precision and nothing starts off the surface: a start
// that is lifted by what a rasteriser's rounding needs (half of 1/256 pixel) looks past whatever stands
// within that height, and at a contact that is most of what there is.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

#include "host/bvh/bvh.h"
#include "host/scene/scene.h"
#include "host/scene/scene_alpha.h"
#include "host/scene/scene_translucents.h"

namespace penumbra {

// A pixel's view ray in the tree's frame: origin + view depth * direction.
struct ViewRay {
    glm::dvec3 origin{0}, direction{0, 0, -1};
    double pixel_m = 0, pixel_m_per_m = 0;  // what a pixel spans there: constant, and per metre of view depth
    double grid_px = 0x1p-9;  // half a step of the rasteriser's grid, by which it moves outlines
};

struct SurfacePoint {
    glm::dvec3 at{0}, normal{0, 1, 0};  // in the tree's frame; unit, towards the viewer
    uint32_t triangle = 0;              // of Scene::triangles()
    // What stands between it and the viewer, so near before it that the rasteriser must have moved its
    // outline aside: seen through, it hides nothing of a light either.
    std::vector<uint32_t> seen_through;
};

// Directions to a sun of `angular_radius` radians, one in each of side x side strata of equal area.
struct SunStrata {
    glm::dvec3 to_sun{0, 1, 0};  // unit
    double angular_radius = 0;
    uint32_t side = 32;
    uint32_t seed = 0;  // shifts every direction inside its stratum
};

// A scene's triangles at one moment.
class CountedVisibility {
  public:
    CountedVisibility(const Scene& scene, double frame);

    // What a rasteriser showed at `view_depth` with this normal: the triangle that lies there, and the point
    // of it that the view ray meets. A rasteriser moves outlines by a part of a pixel, so the ray may pass
    // beside the triangle; the point is then the triangle's nearest. None where no triangle is within
    // eight half steps of the grid, or two as they lie on the surface.
    std::optional<SurfacePoint> shown(const ViewRay& ray, double view_depth, const glm::dvec3& normal) const;

    // The share of directions that neither point into the point's own surface nor meet another triangle.
    // Triangles in the plane of the point hide nothing, and none that it is seen through.
    double visibility(const SurfacePoint& point, const SunStrata& sun) const {
        return seen(point, sun).visibility;
    }

    // That, and the mean over all directions of what arrives: nothing of those that are not free, of others
    // the product of the transmittances of what they meet. Translucent triangles in the plane of the point
    // colour nothing.
    struct Seen {
        double visibility = 0;
        glm::dvec3 transmittance{0};
    };
    Seen seen(const SurfacePoint& point, const SunStrata& sun) const;

    bool has_translucent() const { return translucents_.has_value(); }

  private:
    // Triangles in a tree.
    struct Tree {
        std::vector<Triangle> triangles;
        Bvh bvh;

        // visit(index) of every triangle in boxes that touches(box) says it touches.
        template <class Touches, class Visit>
        void walk(const Touches& touches, Visit&& visit) const;
        // Those that may stand before a part of the sun, from the point.
        std::vector<uint32_t> before(const SurfacePoint& point, const SunStrata& sun) const;
    };

    Tree opaque_;
    std::optional<SceneAlpha> alpha_;
    Tree translucent_;
    std::optional<SceneTranslucents> translucents_;
    // Per triangle of Scene::triangles(): 0 if both its sides are drawn, else 1, or -1 where a mirror has
    // turned its winding.
    std::vector<int8_t> front_;
    bool is_drawn(uint32_t triangle, const glm::dvec3& winding, const glm::dvec3& view_direction) const {
        return front_[triangle] * glm::dot(winding, view_direction) <= 0;
    }
    // Per translucent triangle which of Scene::triangles() it is, where its opaque texels are drawn.
    std::vector<std::optional<uint32_t>> drawn_;
};

}  // namespace penumbra
