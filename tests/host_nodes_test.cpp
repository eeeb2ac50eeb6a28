// SPDX-License-Identifier: MIT
// Nodes of the host inside the graph: a callback with slots, parameters and the view it runs in; raster
// passes.
#include <cstring>

#include "tests/embedding_host.h"
#include "tests/toy_nodes.h"

namespace penumbra::test {
namespace {

class HostNodesGpu : public GpuTest {};

// A host node sees what it is bound to, its parameter as this view has it, and whose view it is.
TEST_F(HostNodesGpu, AHostNodeIsGivenItsSlotsAndParameters) {
    NodeSet set;
    for (const std::string& name : toy_set().names()) set.add(*toy_set().find(name));
    NodeEntry engine;
    engine.type = parse_toy(R"({ "node": "engine", "doc": "d", "host": true,
      "inputs": { "given": { "kind": "image", "format": "r32f" }, "value": { "kind": "image", "format": "r32f" } },
      "outputs": { "drawn": { "kind": "image", "format": "r32f" } },
      "params": { "gain": { "type": "float", "default": 2, "doc": "d" }, "on": { "type": "bool", "default": true, "doc": "d" } } })",
                            "engine");
    struct Seen {
        float gain = 0;
        const SlotBinding* slot = nullptr;
        VkImage value = VK_NULL_HANDLE;
    };
    engine.callback = [](const HostPassContext& context) {
        auto& seen = *static_cast<Seen*>(context.user);
        seen.gain = std::get<float>(context.param("gain").value());
        seen.slot = context.slot("given");
        seen.value = context.resource("value")->image;
        EXPECT_TRUE(std::get<bool>(context.param("on").value()));
        EXPECT_FALSE(context.param("nosuch"));
        EXPECT_EQ(context.slot("value"), nullptr);
        EXPECT_EQ(context.resource("given"), nullptr);
        VkClearColorValue colour{};
        colour.float32[0] = seen.gain;
        constexpr VkImageSubresourceRange all{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        vkCmdClearColorImage(context.cmd, context.resource("drawn")->image, VK_IMAGE_LAYOUT_GENERAL, &colour,
                             1, &all);
    };
    set.add(std::move(engine));
    const CheckedPipeline pipeline =
        checked(R"("inputs": { "given": { "format": "r32f" } }, "outputs": ["drawn"],
        "nodes": { "fill": { "type": "toy_fill" }, "engine": { "type": "engine" } })",
                set);
    const auto program = std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, capturing(pipeline)));
    Seen seen[2];
    View views[2] = {View(program, {.user = &seen[0]}), View(program, {.user = &seen[1]})};
    ASSERT_TRUE(views[1].set_param("engine", "gain", ParamValue(5.0f)));
    GpuImage given = image_of(VK_FORMAT_R32_SFLOAT, VK_IMAGE_USAGE_SAMPLED_BIT);
    const std::vector<float> zeros(width * height);
    upload_image(gpu(), given, std::as_bytes(std::span(zeros)));
    Externals externals(program->plan());
    externals["given"].image = given.view.get();
    gpu().run([&](VkCommandBuffer cmd) {
        for (View& view : views) view.record(cmd, description(0), externals);
    });
    for (int v = 0; v < 2; ++v) {
        EXPECT_EQ(seen[v].gain, v ? 5.0f : 2.0f);
        EXPECT_EQ(floats(views[v].captured("drawn"))[3], seen[v].gain);
        EXPECT_NE(seen[v].value, VK_NULL_HANDLE);
        ASSERT_TRUE(seen[v].slot);
    }
}

// A raster pass inside the graph: what it draws into is an image of the graph's, read by the next pass.
TEST_F(HostNodesGpu, AHostNodeDrawsIntoAnImageOfTheGraph) {
    NodeSet set;
    for (const std::string& name : toy_set().names()) set.add(*toy_set().find(name));
    NodeEntry engine;
    engine.type = parse_toy(R"({ "node": "engine", "doc": "d", "host": true, "inputs": {},
      "outputs": { "drawn": { "kind": "image", "format": "r32f" } } })",
                            "engine");
    engine.callback = [](const HostPassContext& context) {
        VkRenderingAttachmentInfo attachment{VK_STRUCTURE_TYPE_RENDERING_ATTACHMENT_INFO};
        attachment.imageView = context.resource("drawn")->view;
        attachment.imageLayout = VK_IMAGE_LAYOUT_GENERAL;
        attachment.loadOp = VK_ATTACHMENT_LOAD_OP_CLEAR;
        attachment.storeOp = VK_ATTACHMENT_STORE_OP_STORE;
        attachment.clearValue.color.float32[0] = static_cast<float>(context.frame->frame_index + 3);
        VkRenderingInfo info{VK_STRUCTURE_TYPE_RENDERING_INFO};
        info.renderArea.extent = {width, height};
        info.layerCount = 1;
        info.colorAttachmentCount = 1;
        info.pColorAttachments = &attachment;
        vkCmdBeginRendering(context.cmd, &info);
        // A part of it again, as a draw would.
        VkClearAttachment again{VK_IMAGE_ASPECT_COLOR_BIT, 0, {}};
        again.clearValue.color.float32[0] = 50;
        const VkClearRect corner{{{0, 0}, {5, 5}}, 0, 1};
        vkCmdClearAttachments(context.cmd, 1, &again, 1, &corner);
        vkCmdEndRendering(context.cmd);
    };
    set.add(std::move(engine));
    const CheckedPipeline pipeline =
        checked(R"("outputs": ["blended"], "nodes": { "engine": { "type": "engine" },
        "blend": { "type": "toy_blend", "in": { "value": "drawn", "history": "blended@-1" } } })",
                set);
    View view(std::make_shared<Program>(handles_of(gpu()), plan_of(pipeline, capturing(pipeline))), {});
    float corner = 0, rest = 0;
    for (uint32_t f = 0; f < 3; ++f) {
        gpu().run([&](VkCommandBuffer cmd) { view.record(cmd, description(f), {}); });
        corner = 50 + corner / 2;
        rest = static_cast<float>(f + 3) + rest / 2;
        const std::vector<float> blended = floats(view.captured("blended"));
        EXPECT_EQ(blended[2], corner) << f;
        EXPECT_EQ(blended[width * 7 + 9], rest) << f;
    }
}

}  // namespace
}  // namespace penumbra::test
