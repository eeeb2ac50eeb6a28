/* SPDX-License-Identifier: MIT */
/* Penumbra for C (C11) and for whatever calls C: plans, programs and views behind opaque handles. What things
   mean stands in the C++ headers of the same names (plan.h, device.h, view.h); here is what C adds.

   Every struct but penumbra_camera, which lies in another, begins with its size, which the caller sets:
   sizeof(struct) of the header that it was compiled with. Members are only ever added at the end; those that
   an older caller does not have are taken as 0. Arrays are of the caller's structs: all elements have the
   size that the first one says.

   Functions that can fail return a penumbra_code and fill in `error`, where they take one, which may be
   null. Nothing throws across this header. Different objects may be used from different threads at once,
   one object by one at a time; plans and programs, once made, by any number. */
#ifndef PENUMBRA_PENUMBRA_H
#define PENUMBRA_PENUMBRA_H

#include <stddef.h>
#include <stdint.h>
#include <vulkan/vulkan_core.h>

#include "penumbra/code.h"
#include "penumbra/export.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct penumbra_nodes penumbra_nodes;
typedef struct penumbra_plan penumbra_plan;
typedef struct penumbra_program penumbra_program;
typedef struct penumbra_view penumbra_view;
typedef struct penumbra_transients penumbra_transients;

typedef struct penumbra_error {
    uint32_t struct_size;
    penumbra_code code;
    VkResult result; /* what Vulkan said, if it was asked */
    /* Slot, pass, resource or function; of a pipeline the first mistake's file:line:column. */
    char place[256];
    char text[2048]; /* of a pipeline every mistake, a line each; cut off where it is longer */
} penumbra_error;

/* PENUMBRA_VERSION_TEXT of the library. */
PENUMBRA_API const char* penumbra_version(void);

/* --- The caller's device ------------------------------------------------------------------------------ */

typedef struct penumbra_memory_request {
    uint32_t struct_size;
    VkMemoryPropertyFlags properties;
    VkMemoryRequirements need;
    VkBool32 mapped, linear;
    const char* what;
    VkBool32 readback;
} penumbra_memory_request;

typedef struct penumbra_memory_block {
    uint32_t struct_size;
    VkDeviceMemory memory;
    VkDeviceSize offset;
    void* mapped;
    void* user;
} penumbra_memory_block;

typedef struct penumbra_device {
    uint32_t struct_size;
    uint32_t queue_family;
    VkInstance instance;
    VkPhysicalDevice physical;
    VkDevice device;
    PFN_vkGetInstanceProcAddr get_instance_proc_addr;
    /* Both, or neither: vkAllocateMemory. */
    VkResult (*allocate)(void* user, const penumbra_memory_request* request, penumbra_memory_block* block);
    void (*release)(void* user, const penumbra_memory_block* block);
    void* memory_user;
    uint32_t debug_utils; /* whether VK_EXT_debug_utils is enabled, for names of objects and passes; else 0 */
} penumbra_device;

/* --- Node types --------------------------------------------------------------------------------------- */

/* A pass of a node of the caller's, while its callback runs, on the thread that records the view. */
typedef struct penumbra_call penumbra_call;
typedef void (*penumbra_record)(const penumbra_call* call);

/* Those that ship, to which others may be added. Plans made with it stay. */
PENUMBRA_API penumbra_code penumbra_nodes_create(penumbra_nodes** nodes, penumbra_error* error);
PENUMBRA_API void penumbra_nodes_destroy(penumbra_nodes* nodes);
/* One that the caller records: `declaration` is JSON, with "host": true. */
PENUMBRA_API penumbra_code penumbra_nodes_add(penumbra_nodes* nodes, const char* declaration,
                                              penumbra_record record, penumbra_error* error);
/* Those of a folder, NAME.json with a shader beside each, which is compiled when a plan needs it: of the
   library penumbra_glsl. `cache`: a folder for what has been compiled; null: the default one, "": none. */
PENUMBRA_API penumbra_code penumbra_nodes_add_folder(penumbra_nodes* nodes, const char* folder,
                                                     const char* cache, penumbra_error* error);

typedef struct penumbra_call_info {
    uint32_t struct_size;
    uint32_t frame_index;
    VkCommandBuffer cmd;
    const char* node;
    void* user; /* penumbra_view_options.user */
    uint32_t size[2];
} penumbra_call_info;

PENUMBRA_API penumbra_code penumbra_call_read(const penumbra_call* call, penumbra_call_info* info,
                                              penumbra_error* error);

/* --- Plans -------------------------------------------------------------------------------------------- */

typedef struct penumbra_fact {
    uint32_t struct_size;
    VkBool32 holds;
    const char* name;
} penumbra_fact;

typedef struct penumbra_input {
    uint32_t struct_size;
    VkBool32 left_out; /* it is optional and not brought */
    const char* name;
    const char* format; /* "d32" */
    uint32_t width, height, layers;
} penumbra_input;

/* What the caller does with an output after a frame, where that is not any stage's read of it (OutputUse). */
typedef struct penumbra_output_use {
    uint32_t struct_size;
    VkBool32 host_image; /* the caller brings an image for it, every frame */
    const char* name;
    VkImageUsageFlags image_usage; /* 0 of each: as plan.h has it */
    VkBufferUsageFlags buffer_usage;
    VkPipelineStageFlags2 stages;
    VkAccessFlags2 access;
} penumbra_output_use;

/* Whether the caller jitters its images (Target::jitters). */
typedef enum penumbra_jitters {
    PENUMBRA_JITTERS_AS_ASKED = 0, /* where penumbra_plan_info.jitter says so */
    PENUMBRA_JITTERS_ALWAYS = 1,
    PENUMBRA_JITTERS_NEVER = 2
} penumbra_jitters;

typedef struct penumbra_plan_request {
    uint32_t struct_size;
    uint32_t width, height;
    const char* file;               /* a pipeline's */
    const char* text;               /* null: as the file has it; else `file` is its name and folder */
    const penumbra_device* device;  /* null: a plan to look at, for no device */
    const char* const* settings;    /* "nodes.filter0.params.step=2" */
    const char* const* features;    /* of those that nodes may need, what is enabled */
    const char* const* captures;    /* resources to copy out every frame, each once */
    const char* const* host_images; /* outputs that the caller brings an image for, every frame */
    const penumbra_fact* facts;     /* none twice; what is not named is true */
    const penumbra_input* inputs;   /* none twice; what is not named is as the pipeline has it */
    uint32_t setting_count, feature_count, capture_count, host_image_count, fact_count, input_count;
    VkBool32 share_transients, hand_on_history;
    const penumbra_nodes* nodes;            /* null: those that ship */
    const penumbra_output_use* output_uses; /* what is not named is read, by any stage */
    uint32_t output_use_count;
    /* What files hold, `file` and those that it extends, until the plan is made; null: there is none of this
     * name. Without it they are read from the disk. */
    const char* (*read)(void* read_user, const char* file);
    void* read_user;
    uint32_t jitters; /* penumbra_jitters */
} penumbra_plan_request;

PENUMBRA_API penumbra_code penumbra_plan_create(const penumbra_plan_request* request, penumbra_plan** plan,
                                                penumbra_error* error);
/* Programs made of it stay. Null is nothing. */
PENUMBRA_API void penumbra_plan_destroy(penumbra_plan* plan);

typedef enum penumbra_slot_kind {
    PENUMBRA_IMAGE = 0,
    PENUMBRA_TEXELS = 1,
    PENUMBRA_BUFFER = 2,
    PENUMBRA_BLOCK = 3,
    PENUMBRA_STRUCTURE = 5
} penumbra_slot_kind;

typedef struct penumbra_slot {
    uint32_t struct_size;
    penumbra_slot_kind kind;
    const char* name; /* the plan's, like all text here */
    VkFormat format;  /* images and texels */
    uint32_t width, height, layers;
    uint32_t bytes; /* blocks; of outputs all but images */
    VkBool32 output, required;
    VkPipelineStageFlags2 stages; /* of the frame's accesses; of an output of the caller's, after it */
    VkAccessFlags2 access;
    /* Of slots that are images or texels: formats that the caller may bring, of an input by
     * penumbra_input.format. Of penumbra_plan_output() none. */
    const char* const* accepted;
    uint32_t accepted_count;
    VkBool32 layered; /* images: a VK_IMAGE_VIEW_TYPE_2D_ARRAY, be it of one layer */
    uint32_t levels;  /* images: mip levels, of an output that is a chain */
    /* Images: what the caller's is to be made for; of an output of the view's own, what it was made for. */
    VkImageUsageFlags usage;
} penumbra_slot;

typedef struct penumbra_plan_info {
    uint32_t struct_size;
    VkBool32 jitter;  /* the caller is to jitter: it said that it does, or a node asks it to */
    uint32_t settles; /* UNCHANGED frames after which no output gets better; UINT32_MAX: never */
    VkBool32 camera;  /* penumbra_frame.camera must be given: a node asks for it */
} penumbra_plan_info;

typedef struct penumbra_pass {
    uint32_t struct_size;
    uint32_t param_count;
    const char *node, *type;     /* of a resource that is copied out: its name, and "capture" */
    const char* const* counters; /* names of penumbra_pass_statistics.counters */
    uint32_t counter_count;
} penumbra_pass;

typedef enum penumbra_param_type {
    PENUMBRA_PARAM_BOOL = 0,
    PENUMBRA_PARAM_INT = 1,
    PENUMBRA_PARAM_UINT = 2,
    PENUMBRA_PARAM_FLOAT = 3,
    PENUMBRA_PARAM_VEC2 = 4,
    PENUMBRA_PARAM_VEC3 = 5,
    PENUMBRA_PARAM_VEC4 = 6,
    PENUMBRA_PARAM_ENUM = 7
} penumbra_param_type;

typedef struct penumbra_param {
    uint32_t struct_size;
    penumbra_param_type type;
    const char *name, *unit, *doc; /* no unit: "" */
    const char* const* values;     /* names of an enum's values, by index */
    uint32_t value_count;
    uint32_t count;    /* numbers that it has */
    double initial[4]; /* that a view begins with: the pipeline's, or the declaration's default */
    double range[2];   /* the least and the greatest of each; infinite: any finite number */
} penumbra_param;

typedef struct penumbra_requirement {
    uint32_t struct_size;
    const char *kind, *name, *why; /* kind: "version" "extension" "feature" "subgroup" "limit" "format" */
    uint64_t value;
} penumbra_requirement;

typedef struct penumbra_memory {
    uint32_t struct_size;
    uint64_t heap_bytes, shared_bytes, persistent_bytes;
} penumbra_memory;

PENUMBRA_API penumbra_code penumbra_plan_read(const penumbra_plan* plan, penumbra_plan_info* info,
                                              penumbra_error* error);
PENUMBRA_API uint32_t penumbra_plan_slot_count(const penumbra_plan* plan);
PENUMBRA_API penumbra_code penumbra_plan_slot(const penumbra_plan* plan, uint32_t index, penumbra_slot* slot,
                                              penumbra_error* error);
/* The pipeline's outputs, which penumbra_view_output() gives by name: of the largest frame. */
PENUMBRA_API uint32_t penumbra_plan_output_count(const penumbra_plan* plan);
PENUMBRA_API penumbra_code penumbra_plan_output(const penumbra_plan* plan, uint32_t index,
                                                penumbra_slot* output, penumbra_error* error);
/* Of an image, a slot or an output, by name: the top left part that a frame uses whose penumbra_frame.size is
   `frame`. */
PENUMBRA_API penumbra_code penumbra_plan_extent(const penumbra_plan* plan, const char* name,
                                                const uint32_t frame[2], uint32_t extent[2],
                                                penumbra_error* error);
PENUMBRA_API uint32_t penumbra_plan_pass_count(const penumbra_plan* plan);
/* In the order of the frame, as penumbra_view_record_pass() counts them. */
PENUMBRA_API penumbra_code penumbra_plan_pass(const penumbra_plan* plan, uint32_t index, penumbra_pass* pass,
                                              penumbra_error* error);
/* Those that a view may change; a declaration's constant ones are a request's settings alone. */
PENUMBRA_API penumbra_code penumbra_plan_param(const penumbra_plan* plan, uint32_t pass, uint32_t index,
                                               penumbra_param* param, penumbra_error* error);
/* Members of families of instances that have nodes, as lamps: whom penumbra_view_set_awake() names. */
PENUMBRA_API uint32_t penumbra_plan_member_count(const penumbra_plan* plan);
PENUMBRA_API penumbra_code penumbra_plan_member(const penumbra_plan* plan, uint32_t index,
                                                const char** member, penumbra_error* error);
PENUMBRA_API uint32_t penumbra_plan_requirement_count(const penumbra_plan* plan);
PENUMBRA_API penumbra_code penumbra_plan_requirement(const penumbra_plan* plan, uint32_t index,
                                                     penumbra_requirement* requirement,
                                                     penumbra_error* error);
/* Turns a requirement of kind "feature" on in whichever of the caller's structs has a member of that name:
   `chain` and, behind it, VkPhysicalDeviceVulkan11Features to 13Features. An error where none has it, and of
   extensions' features. */
PENUMBRA_API penumbra_code penumbra_enable_feature(const char* name, VkPhysicalDeviceFeatures2* chain,
                                                   penumbra_error* error);
/* Those that the physical device cannot meet; `list` may be null, or has room for `*count`. */
PENUMBRA_API penumbra_code penumbra_plan_unmet(const penumbra_plan* plan, const penumbra_device* device,
                                               uint32_t* count, penumbra_requirement* list,
                                               penumbra_error* error);
PENUMBRA_API penumbra_code penumbra_plan_memory(const penumbra_plan* plan, penumbra_memory* memory,
                                                penumbra_error* error);

/* --- Programs ----------------------------------------------------------------------------------------- */

typedef struct penumbra_program_options {
    uint32_t struct_size;
    size_t pipeline_cache_size;
    const void* pipeline_cache;
} penumbra_program_options;

/* `options` may be null. */
PENUMBRA_API penumbra_code penumbra_program_create(const penumbra_device* device, const penumbra_plan* plan,
                                                   const penumbra_program_options* options,
                                                   penumbra_program** program, penumbra_error* error);
/* Views made of it stay. */
PENUMBRA_API void penumbra_program_destroy(penumbra_program* program);
/* Fills in `size`; with `data`, which has room for `*size` bytes, also that. */
PENUMBRA_API penumbra_code penumbra_program_pipeline_cache(const penumbra_program* program, size_t* size,
                                                           void* data, penumbra_error* error);
/* PENUMBRA_USAGE, and nothing is recorded, where one of them is null. */
PENUMBRA_API penumbra_code penumbra_program_record_uploads(const penumbra_program* program,
                                                           VkCommandBuffer cmd);
PENUMBRA_API penumbra_code penumbra_transients_create(const penumbra_program* program,
                                                      penumbra_transients** transients,
                                                      penumbra_error* error);
/* For views of several programs, all of one device: large enough for each. */
PENUMBRA_API penumbra_code penumbra_transients_create_for(const penumbra_program* const* programs,
                                                          uint32_t count, penumbra_transients** transients,
                                                          penumbra_error* error);
PENUMBRA_API void penumbra_transients_destroy(penumbra_transients* transients);
PENUMBRA_API uint64_t penumbra_transients_bytes(const penumbra_transients* transients);

/* --- Views -------------------------------------------------------------------------------------------- */

typedef struct penumbra_view_options {
    uint32_t struct_size;
    uint32_t frames_in_flight; /* 0: 2 */
    VkBool32 no_timestamps, tables_uploaded;
    const penumbra_transients* transients;
    const penumbra_view* heir_of; /* whose history the first frame takes over */
    void* user;                   /* for callbacks of the caller's nodes */
} penumbra_view_options;

PENUMBRA_API penumbra_code penumbra_view_create(const penumbra_program* program,
                                                const penumbra_view_options* options, penumbra_view** view,
                                                penumbra_error* error);
PENUMBRA_API void penumbra_view_destroy(penumbra_view* view);

typedef struct penumbra_camera {
    double position[3];
    double world_from_view[9]; /* columns: right, up, back */
    double clip_from_view[16]; /* columns; unjittered, Vulkan clip (y down) */
    double near_m;
} penumbra_camera;

/* DEPTH_AT_CENTRES: computed at each pixel's very centre; a rasteriser interpolates it for a point nearby.
   UNCHANGED: but for the jitter and the index, all that the caller brings is as it was in the frame
   recorded before, so that camera and previous are one. */
enum {
    PENUMBRA_FRAME_RESET = 1,
    PENUMBRA_FRAME_ORTHOGRAPHIC = 2,
    PENUMBRA_FRAME_DEPTH_AT_CENTRES = 4,
    PENUMBRA_FRAME_UNCHANGED = 8
};

typedef struct penumbra_frame {
    uint32_t struct_size;
    uint32_t index;                   /* counts recorded frames, in steps of 1 */
    penumbra_camera camera, previous; /* of this frame and of the one recorded before */
    double jitter[2], prev_jitter[2]; /* uv by which the picture was moved right and down (frame_block.h) */
    uint32_t size[2];                 /* pixels, at most the plan's */
    float dt_s;
    uint32_t flags;
    uint32_t sub_pixel_bits; /* of the rasteriser that drew the depth; 0: of the view's own device */
} penumbra_frame;

typedef struct penumbra_handover {
    uint32_t struct_size;
    VkImageAspectFlags aspects; /* 0: the slot's format's. Of an image with depth and stencil set both */
    VkImage image;              /* all its layers and mip levels are handed over, whatever the view shows */
    VkPipelineStageFlags2 stages_before, stages_after;
    VkAccessFlags2 access_before, access_after;
    VkImageLayout layout_before, layout_after; /* 0: VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL */
    /* VK_QUEUE_FAMILY_IGNORED: the frame's. To be set by every host: 0 is a family like any other, not
     * "none". */
    uint32_t family_before, family_after;
} penumbra_handover;

typedef struct penumbra_external {
    uint32_t struct_size;
    VkImageLayout layout; /* while the frame reads it; 0: VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL */
    const char* name;     /* of the slot; none twice */
    VkImageView image;
    VkBufferView texels;
    VkBuffer buffer;
    VkDeviceSize offset, range; /* range 0: VK_WHOLE_SIZE */
    VkAccelerationStructureKHR structure;
    const penumbra_handover* handover; /* null: the caller orders its accesses */
} penumbra_external;

PENUMBRA_API penumbra_code penumbra_view_record(penumbra_view* view, VkCommandBuffer cmd,
                                                const penumbra_frame* frame,
                                                const penumbra_external* externals, uint32_t external_count,
                                                penumbra_error* error);

/* The same in parts, for passes in separate command buffers of one queue: begin, every pass in order, end. */
PENUMBRA_API penumbra_code penumbra_view_begin(penumbra_view* view, VkCommandBuffer cmd,
                                               const penumbra_frame* frame,
                                               const penumbra_external* externals, uint32_t external_count,
                                               penumbra_error* error);
PENUMBRA_API penumbra_code penumbra_view_record_pass(penumbra_view* view, VkCommandBuffer cmd, uint32_t pass,
                                                     penumbra_error* error);
PENUMBRA_API penumbra_code penumbra_view_end(penumbra_view* view, VkCommandBuffer cmd, penumbra_error* error);

/* One number for a scalar, 0 or 1 for a bool, an enum's index, or a vector's numbers. */
PENUMBRA_API penumbra_code penumbra_view_set_param(penumbra_view* view, const char* node, const char* param,
                                                   const double* values, uint32_t count,
                                                   penumbra_error* error);
/* As it is now. `values` may be null, or has room for `*count`, which becomes their number. */
PENUMBRA_API penumbra_code penumbra_view_param(const penumbra_view* view, const char* node, const char* param,
                                               double* values, uint32_t* count, penumbra_error* error);

/* Whether the passes of one member of a family of instances run in frames recorded from now on, as all do at
   first; of one that is asleep, as a lamp that is off, what others read is 0, and it wakes without a past
   (View::set_awake in penumbra/view.h). */
PENUMBRA_API penumbra_code penumbra_view_set_awake(penumbra_view* view, const char* member, VkBool32 awake,
                                                   penumbra_error* error);

typedef struct penumbra_output {
    uint32_t struct_size;
    VkImage image; /* of what the caller brings, null without a handover */
    VkImageView view;
    VkBuffer buffer;
    VkBufferView texels;
    VkDeviceSize bytes, offset; /* of the buffer what is bound; VK_WHOLE_SIZE: to its end */
    VkImageLayout layout;       /* of the image: GENERAL, or the one that the caller's is in */
    VkAccelerationStructureKHR structure;
} penumbra_output;

/* What a port of the caller's node is bound to in this frame. */
PENUMBRA_API penumbra_code penumbra_call_port(const penumbra_call* call, const char* port,
                                              penumbra_output* bound, penumbra_error* error);
/* A dynamic parameter as this view has it: penumbra_view_param(). */
PENUMBRA_API penumbra_code penumbra_call_param(const penumbra_call* call, const char* param, double* values,
                                               uint32_t* count, penumbra_error* error);

/* The most recently recorded frame's. */
PENUMBRA_API penumbra_code penumbra_view_output(const penumbra_view* view, const char* name,
                                                penumbra_output* output, penumbra_error* error);
/* What was copied out, once that frame has completed; the view's. */
PENUMBRA_API penumbra_code penumbra_view_captured(const penumbra_view* view, const char* name,
                                                  const void** data, size_t* size, penumbra_error* error);

typedef struct penumbra_pass_statistics {
    uint32_t struct_size;
    const char* node;
    double ms; /* negative: there are no timestamps */
    const uint32_t* counters;
    uint32_t counter_count;
} penumbra_pass_statistics;

/* Of the last frame known to have completed. `count` is the passes'; `passes` may be null, or has room for
   `*count`. `*frame` is UINT64_MAX where none has. */
PENUMBRA_API penumbra_code penumbra_view_completed(const penumbra_view* view, uint64_t* frame,
                                                   uint32_t* count, penumbra_pass_statistics* passes,
                                                   penumbra_error* error);
/* Why the frame that was begun last had no history: "none" (it had), "first_frame", "asked", or
   "not_handed_on" or "woken", of which `resource` says what (else it is empty); the view's text. `resource`
   may be null. */
PENUMBRA_API const char* penumbra_view_reset_reason(const penumbra_view* view, const char** resource);
/* Whether enough UNCHANGED frames have been recorded for the plan's histories to settle: until something
   changes, another frame would not improve the outputs, and none need be recorded. */
PENUMBRA_API VkBool32 penumbra_view_settled(const penumbra_view* view);
PENUMBRA_API uint64_t penumbra_view_bytes(const penumbra_view* view);

#ifdef __cplusplus
}
#endif

#endif
