/* SPDX-License-Identifier: MIT */
/* A host in C with nodes of its own: one that it records, and one whose GLSL is compiled when the program
 * runs. */
#ifndef TESTS_C_NODES_H
#define TESTS_C_NODES_H

#include "penumbra/penumbra.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct c_host {
    penumbra_device device;
    const char* folder; /* of the other node */
    VkCommandBuffer (*begin)(void);
    void (*submit_and_wait)(void);
    PFN_vkCmdClearColorImage clear;
} c_host;

/* What went wrong; null: all is well. */
const char* run_c_nodes(c_host* host);

#ifdef __cplusplus
}
#endif

#endif
