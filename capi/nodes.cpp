// SPDX-License-Identifier: MIT
// Node types of the caller, which it records itself, and what their callbacks may ask.
#include "capi/shared.h"
#include "penumbra/shadow_nodes.h"

using namespace penumbra;
using namespace penumbra::c;

penumbra_code penumbra_nodes_create(penumbra_nodes** nodes, penumbra_error* error) {
    return guarded(error, [&] {
        given(nodes, "nodes") = nullptr;
        *nodes = new penumbra_nodes{shadow_nodes()};
    });
}

void penumbra_nodes_destroy(penumbra_nodes* nodes) {
    delete nodes;
}

penumbra_code penumbra_nodes_add(penumbra_nodes* nodes, const char* declaration, penumbra_record record,
                                 penumbra_error* error) {
    return guarded(error, [&] {
        NodeSet& set = given(nodes, "nodes").set;
        if (!record) misuse("record", "is null");
        Mistakes mistakes;
        const auto json = parse_json(named(declaration, "declaration"), "declaration", mistakes.diagnostics);
        const Json* name = json ? json->find("node") : nullptr;
        const auto type =
            json ? parse_node_type(*json, name ? name->string : "", set.domain(), mistakes.diagnostics)
                 : std::nullopt;
        if (!type) throw mistakes;
        if (!type->host) misuse(type->name, "is no node of the host's: its declaration says \"host\": true");
        if (set.find(type->name)) misuse(type->name, "there is a node type of this name");
        NodeEntry entry{.type = *type};
        entry.callback = [record](const HostPassContext& context) {
            const penumbra_call call{context};
            record(&call);
        };
        set.add(std::move(entry));
    });
}

penumbra_code penumbra_call_read(const penumbra_call* call, penumbra_call_info* info, penumbra_error* error) {
    return guarded(error, [&] {
        const HostPassContext& c = given(call, "call").context;
        write(info,
              {0,
               c.frame->frame_index,
               c.cmd,
               c.pass->node.c_str(),
               c.user,
               {c.frame->size.v[0], c.frame->size.v[1]}},
              "info");
    });
}

penumbra_code penumbra_call_port(const penumbra_call* call, const char* port, penumbra_output* bound,
                                 penumbra_error* error) {
    return guarded(error, [&] {
        const HostPassContext& c = given(call, "call").context;
        if (const ResourceHandles* r = c.resource(named(port, "port")))
            return write(bound,
                         {0, r->image, r->view, r->buffer, r->texels, r->bytes, 0, VK_IMAGE_LAYOUT_GENERAL},
                         "bound");
        const SlotBinding* s = c.slot(port);
        if (!s) misuse(port, "nothing is bound to a port of this name");
        write(bound,
              {0, s->handover ? s->handover->image : VK_NULL_HANDLE, s->image, s->buffer, s->texels, s->range,
               s->offset, s->layout, s->structure},
              "bound");
    });
}
