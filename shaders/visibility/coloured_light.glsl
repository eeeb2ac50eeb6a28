// SPDX-License-Identifier: MIT
// Whether translucent triangles may stand before a light that is near.
//
// Includer has common/light.glsl, common/camera.glsl and visibility/transmittance.glsl and declares: block scene.

// The cone that holds the light, up to where that ends, meets the box of one. Who is amid it has no such cone, and may.
bool near_light_may_be_coloured(vec3 start, bool wanted) {
    const vec3 way = light.centre + scene.camera_from_origin - start;
    const float bound_m = light_bound_m(), distance2 = dot(way, way), rest = distance2 - bound_m * bound_m;
    if (rest <= 0.0) return wanted;
    const vec3 axis = way * inversesqrt(distance2);
    ConeSlabs slabs = cone_slabs(axis, bound_m * inversesqrt(rest), 0.0);
    slabs.reach = sqrt(distance2) + bound_m;
    return may_meet_translucents(slabs, start, axis, wanted);
}
