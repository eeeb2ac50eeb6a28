/* SPDX-License-Identifier: MIT */
/* Triangles to the tree that penumbra's shaders trace rays through, for C (C99) and for whatever calls C: of
   the library penumbra_bvh. What things mean stands in penumbra/bvh.h; structs, codes and threads are as in
   penumbra/penumbra.h, which is not needed for this, nor is Vulkan. */
#ifndef PENUMBRA_PENUMBRA_BVH_H
#define PENUMBRA_PENUMBRA_BVH_H

#include <stdint.h>

#include "penumbra/code.h"
#include "penumbra/export.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct penumbra_bvh penumbra_bvh;

typedef struct penumbra_bvh_error {
    uint32_t struct_size;
    penumbra_code code; /* PENUMBRA_OK, _USAGE, _OUT_OF_MEMORY or _INTERNAL */
    char text[256];
} penumbra_bvh_error;

typedef struct penumbra_bvh_request {
    uint32_t struct_size;
    uint32_t triangle_count; /* at most 2^30; none is a tree that no ray meets */
    const float* triangles;  /* nine numbers each: x, y, z of three corners; not kept */
    const uint32_t* objects; /* one per triangle: different ones may move apart; null: all move as one */
    uint32_t neighbours;     /* 1: with penumbra_bvh_info.neighbours, for pipelines with `beams` */
} penumbra_bvh_request;

PENUMBRA_API penumbra_code penumbra_bvh_create(const penumbra_bvh_request* request, penumbra_bvh** bvh,
                                               penumbra_bvh_error* error);
/* Null is nothing. */
PENUMBRA_API void penumbra_bvh_destroy(penumbra_bvh* bvh);

/* The tree's own memory, in which nothing moves: a refit writes to it. */
typedef struct penumbra_bvh_info {
    uint32_t struct_size;
    uint32_t node_count, leaf_count; /* one at least */
    uint32_t skipped_count;
    /* Twelve words each, three texels of VK_FORMAT_R32G32B32A32_UINT: the slots scene.nodes, scene.leaves. */
    const uint32_t *nodes, *leaves;
    const uint32_t* neighbours; /* four words per leaf: the slot neighbours; null: not asked for */
    /* Four words per leaf: which corner, triangle * 3 + 0..2, each of its vertices is; null: no triangle is
       usable. */
    const uint32_t* corners;
    const uint32_t* skipped; /* triangles that are not usable, ascending */
} penumbra_bvh_info;

PENUMBRA_API penumbra_code penumbra_bvh_read(const penumbra_bvh* bvh, penumbra_bvh_info* info,
                                             penumbra_bvh_error* error);

typedef struct penumbra_bvh_refitted {
    uint32_t struct_size;
    uint32_t fits; /* 0: nothing was written, since this shape cannot hold them: make another tree */
    uint32_t node_count, leaf_count;
    /* What was written, to be copied to the device: numbers of nodes and leaves, ascending; the tree's, until
       the next refit. */
    const uint32_t *nodes, *leaves;
    uint32_t neighbours_changed; /* 1: any of them */
} penumbra_bvh_refitted;

/* As many triangles, in the same order, where they are now. Neighbours that came apart are none any more, and
   are again when they are back; of parts that came together only another tree knows. Out of memory it may
   have moved a part: make another tree. */
PENUMBRA_API penumbra_code penumbra_bvh_refit(penumbra_bvh* bvh, const float* triangles,
                                              uint32_t triangle_count, penumbra_bvh_refitted* refitted,
                                              penumbra_bvh_error* error);

#ifdef __cplusplus
}
#endif

#endif
