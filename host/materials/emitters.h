// SPDX-License-Identifier: MIT
// Bodies that shine, as spheres around them: where rays are aimed as well, since those of a lobe find a small
// bright one by chance alone. As shaders/reflections/emitters.glsl reads them, two texels each: centre, which
// is camera-relative, and radius; luminance of what it sheds, the area that it shows, in m2.
#pragma once

#include <cstddef>
#include <glm/glm.hpp>
#include <vector>

#include "host/device/gpu.h"
#include "host/scene/scene.h"

namespace penumbra {

class Emitters {
  public:
    Emitters() = default;  // none
    // A body is what hangs together of a part that shines. Left to the lobes' own rays: what deforms, is cut
    // out or shines by a texture, bodies that fill little of their sphere, as long ones do, and all but the
    // 32 that shed most. `scene` outlives it.
    explicit Emitters(const Scene& scene);

    size_t size() const { return bodies_.size(); }
    // `camera`: without the shot's origin.
    std::vector<Texel> texels(double frame, const glm::dvec3& camera) const;

  private:
    struct Body {
        size_t node;
        glm::dvec3 center;  // in the node's frame, as all lengths
        double radius, area, luminance;
    };

    void add(const Scene& scene, const Instance& instance, const Part& part);

    const Scene* scene_ = nullptr;
    std::vector<Body> bodies_;
};

}  // namespace penumbra
