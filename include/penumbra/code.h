/* SPDX-License-Identifier: MIT */
/* What a function of the headers for C returns where it can fail. */
#ifndef PENUMBRA_CODE_H
#define PENUMBRA_CODE_H

typedef enum penumbra_code {
    PENUMBRA_OK = 0,
    PENUMBRA_USAGE = 1,         /* the caller's mistake */
    PENUMBRA_UNSUPPORTED = 2,   /* the device lacks something */
    PENUMBRA_OUT_OF_MEMORY = 3, /* of the host, the device, or the caller's allocator */
    PENUMBRA_DEVICE_LOST = 4,
    PENUMBRA_VULKAN = 5,   /* another Vulkan call failed */
    PENUMBRA_PIPELINE = 6, /* the pipeline, or what is said about its target, is wrong */
    PENUMBRA_INTERNAL = 7  /* a defect of penumbra's */
} penumbra_code;

#endif
