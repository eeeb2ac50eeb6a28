/* SPDX-License-Identifier: MIT */
#include "tests/c_nodes.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static char problem[4096];
static penumbra_error error = {.struct_size = sizeof error};

#define REQUIRE(condition)                                                                                  \
    do {                                                                                                    \
        if (!(condition)) {                                                                                 \
            snprintf(problem, sizeof problem, "line %d: %s; %.200s: %.3000s", __LINE__, #condition, error.place, error.text); \
            return problem;                                                                                 \
        }                                                                                                   \
    } while (0)

static const char declaration[] =
    "{ \"node\": \"engine\", \"doc\": \"d\", \"host\": true, \"inputs\": {},"
    "  \"outputs\": { \"drawn\": { \"kind\": \"image\", \"format\": \"r32f\" } },"
    "  \"params\": { \"gain\": { \"type\": \"float\", \"default\": 2, \"doc\": \"d\" },"
    "                \"turns\": { \"type\": \"uint\", \"default\": 1, \"doc\": \"d\" },"
    "                \"way\": { \"type\": \"enum\", \"values\": [\"up\", \"down\"], \"default\": \"up\", \"doc\": \"d\" } } }";
static const char pipeline[] =
    "{ \"penumbra\": 1, \"name\": \"c\", \"inputs\": {}, \"outputs\": [\"doubled\"],"
    "  \"nodes\": { \"engine\": { \"type\": \"engine\" }, \"twice\": { \"type\": \"c_twice\" } } }";

/* What a view's frames tell its callback, and what that has found. */
typedef struct seen {
    c_host* host;
    int calls, wrong;
    double gain, turns, way;
    uint32_t frame, width;
} seen;

static void draw(const penumbra_call* call) {
    penumbra_error own = {.struct_size = sizeof own};
    penumbra_call_info info = {.struct_size = sizeof info};
    if (penumbra_call_read(call, &info, &own)) return;
    seen* s = info.user;
    ++s->calls;
    penumbra_output drawn = {.struct_size = sizeof drawn};
    uint32_t count = 1;
    if (penumbra_call_port(call, "drawn", &drawn, &own) || penumbra_call_param(call, "gain", &s->gain, &count, &own) || count != 1)
        ++s->wrong;
    if (penumbra_call_param(call, "turns", &s->turns, &count, &own) || penumbra_call_param(call, "way", &s->way, &count, &own)) ++s->wrong;
    uint32_t none = 0;
    if (penumbra_call_param(call, "gain", &s->gain, &none, &own) != PENUMBRA_USAGE) ++s->wrong;
    if (penumbra_call_port(call, "nosuch", &drawn, &own) != PENUMBRA_USAGE || strcmp(own.place, "nosuch")) ++s->wrong;
    if (penumbra_call_param(call, "nosuch", NULL, &count, &own) != PENUMBRA_USAGE) ++s->wrong;
    if (strcmp(info.node, "engine") || !drawn.image || drawn.layout != VK_IMAGE_LAYOUT_GENERAL) ++s->wrong;
    s->frame = info.frame_index;
    s->width = info.size[0];
    const VkClearColorValue colour = {.float32 = {(float)s->gain}};
    const VkImageSubresourceRange all = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    s->host->clear(info.cmd, drawn.image, VK_IMAGE_LAYOUT_GENERAL, &colour, 1, &all);
}

const char* run_c_nodes(c_host* host) {
    penumbra_nodes* nodes = NULL;
    REQUIRE(penumbra_nodes_create(&nodes, &error) == PENUMBRA_OK);
    REQUIRE(penumbra_nodes_add(nodes, "{ \"node\": \"engine\", \"hots\": true }", draw, &error) == PENUMBRA_PIPELINE);
    REQUIRE(strstr(error.text, "did you mean \"host\"?"));
    REQUIRE(penumbra_nodes_add(nodes, declaration, NULL, &error) == PENUMBRA_USAGE);
    REQUIRE(penumbra_nodes_add(nodes, declaration, draw, &error) == PENUMBRA_OK);
    REQUIRE(penumbra_nodes_add(nodes, declaration, draw, &error) == PENUMBRA_USAGE);
    REQUIRE(penumbra_nodes_add_folder(nodes, "nosuch", "", &error) == PENUMBRA_PIPELINE);
    REQUIRE(penumbra_nodes_add_folder(nodes, host->folder, "", &error) == PENUMBRA_OK);

    const char* const captures[] = {"doubled"};
    penumbra_plan_request request = {.struct_size = sizeof request,
                                     .width = 24,
                                     .height = 16,
                                     .file = "c.json",
                                     .text = pipeline,
                                     .device = &host->device,
                                     .captures = captures,
                                     .capture_count = 1};
    penumbra_plan* plan = NULL;
    REQUIRE(penumbra_plan_create(&request, &plan, &error) == PENUMBRA_PIPELINE); /* those that ship do not have it */
    request.nodes = nodes;
    REQUIRE(penumbra_plan_create(&request, &plan, &error) == PENUMBRA_OK);
    uint32_t count = 77;
    REQUIRE(penumbra_plan_unmet(plan, &host->device, &count, NULL, &error) == PENUMBRA_OK && count == 0);
    request.width = 1u << 20; /* for no device: a real one's table would refuse it */
    request.device = NULL;
    request.height = 1;
    penumbra_plan* huge = NULL;
    REQUIRE(penumbra_plan_create(&request, &huge, &error) == PENUMBRA_PIPELINE);
    request.width = 16384; /* lavapipe's limit; those of others are larger */
    REQUIRE(penumbra_plan_create(&request, &huge, &error) == PENUMBRA_OK);
    penumbra_requirement missing = {.struct_size = sizeof missing};
    count = 1;
    REQUIRE(penumbra_plan_unmet(huge, &host->device, &count, &missing, &error) == PENUMBRA_OK);
    penumbra_plan_destroy(huge);
    penumbra_nodes_destroy(nodes); /* plans stay */

    penumbra_program* program = NULL;
    REQUIRE(penumbra_program_create(&host->device, plan, NULL, &program, &error) == PENUMBRA_OK);
    seen views_see[2] = {{.host = host}, {.host = host}};
    for (int v = 0; v < 2; ++v) {
        const penumbra_view_options options = {.struct_size = sizeof options, .user = &views_see[v]};
        penumbra_view* view = NULL;
        REQUIRE(penumbra_view_create(program, &options, &view, &error) == PENUMBRA_OK);
        const double gain = 5;
        if (v) REQUIRE(penumbra_view_set_param(view, "engine", "gain", &gain, 1, &error) == PENUMBRA_OK);
        const double none[] = {NAN, -1, 1.5, 4294967296.0, INFINITY};
        for (int i = 0; i < 5; ++i)
            REQUIRE(penumbra_view_set_param(view, "engine", "turns", &none[i], 1, &error) == PENUMBRA_USAGE &&
                    penumbra_view_set_param(view, "engine", "way", &none[i], 1, &error) == PENUMBRA_USAGE);
        const double turns = 4294967295.0, way = 1, beyond = 2;
        REQUIRE(penumbra_view_set_param(view, "engine", "turns", &turns, 1, &error) == PENUMBRA_OK);
        REQUIRE(penumbra_view_set_param(view, "engine", "way", &way, 1, &error) == PENUMBRA_OK);
        REQUIRE(penumbra_view_set_param(view, "engine", "way", &beyond, 1, &error) == PENUMBRA_USAGE);
        for (uint32_t f = 0; f < 3; ++f) {
            penumbra_frame frame = {.struct_size = sizeof frame, .index = f, .size = {24 - 8 * f, 16 - f}};
            static const double clip[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0};
            memcpy(frame.camera.clip_from_view, clip, sizeof clip);
            memcpy(frame.previous.clip_from_view, clip, sizeof clip);
            for (int k = 0; k < 9; k += 4) frame.camera.world_from_view[k] = frame.previous.world_from_view[k] = 1;
            REQUIRE(penumbra_view_record(view, host->begin(), &frame, NULL, 0, &error) == PENUMBRA_OK);
            host->submit_and_wait();
            REQUIRE(views_see[v].calls == (int)f + 1 && views_see[v].wrong == 0);
            REQUIRE(views_see[v].turns == 4294967295.0 && views_see[v].way == 1);
            REQUIRE(views_see[v].gain == (v ? 5 : 2) && views_see[v].frame == f && views_see[v].width == 24 - 8 * f);
            const void* data = NULL;
            size_t size = 0;
            REQUIRE(penumbra_view_captured(view, "doubled", &data, &size, &error) == PENUMBRA_OK);
            REQUIRE(size == 24 * 16 * sizeof(float));
            REQUIRE(((const float*)data)[24 * (15 - f) + 23 - 8 * f] == (v ? 10 : 4)); /* the frame's last pixel */
        }
        penumbra_frame larger = {.struct_size = sizeof larger, .size = {25, 16}};
        REQUIRE(penumbra_view_record(view, host->begin(), &larger, NULL, 0, &error) == PENUMBRA_USAGE);
        REQUIRE(strstr(error.text, "25x16") && strstr(error.text, "up to 24x16"));
        host->submit_and_wait();
        penumbra_view_destroy(view);
    }
    penumbra_program_destroy(program);
    penumbra_plan_destroy(plan);
    return NULL;
}
