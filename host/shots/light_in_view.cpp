// SPDX-License-Identifier: MIT
#include "host/shots/light_in_view.h"

#include <glm/geometric.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <glm/mat3x3.hpp>
#include <glm/mat4x4.hpp>

namespace penumbra {

bool may_show(const blocks::Light& light, const Camera& camera) {
    if (!light.on) return false;
    constexpr double side = 1.02;  // of the half picture: more than a pixel of any that is worth the question
    const glm::dvec3 centre(light.centre.v[0], light.centre.v[1], light.centre.v[2]);
    const glm::dvec4 in_view(glm::transpose(glm::make_mat3(camera.world_from_view.data())) * centre, 1);
    const glm::dmat4 rows = glm::transpose(glm::make_mat4(camera.clip_from_view.data()));
    for (const int axis : {0, 1})
        for (const double sign : {1.0, -1.0}) {
            const glm::dvec4 plane = side * rows[3] + sign * rows[axis];  // 0 and more inside
            const double length = glm::length(glm::dvec3(plane));
            // The range is a float that the shader compares with: nobody is at it to the bit.
            if (glm::dot(plane, in_view) < -length * (light.range * 1.0001)) return false;
        }
    return true;
}

}  // namespace penumbra
