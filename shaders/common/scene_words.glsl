// SPDX-License-Identifier: MIT
// Texels of the tree: from texel buffers, which are fetched or loaded, as the device is faster, or, on a device whose texel
// buffers are small, from storage buffers of the same words.
//
// Includer declares: uniform usamplerBuffer scene_nodes, scene_leaves; uniform uimageBuffer scene_loaded_nodes, scene_loaded_leaves;
// buffer scene_nodes_words, scene_leaves_words; const bool HAS_SCENE_NODES .. of each; or defines NO_SCENE_WORDS and has the
// first alone.
#ifndef SCENE_WORDS_GLSL
#define SCENE_WORDS_GLSL

uvec4 scene_node_texel(int texel) {
#ifndef NO_SCENE_WORDS
    if (HAS_SCENE_LOADED_NODES) return imageLoad(scene_loaded_nodes, texel);
    if (!HAS_SCENE_NODES) return scene_nodes_words[texel];
#endif
    return texelFetch(scene_nodes, texel);
}

uvec4 scene_leaf_texel(int texel) {
#ifndef NO_SCENE_WORDS
    if (HAS_SCENE_LOADED_LEAVES) return imageLoad(scene_loaded_leaves, texel);
    if (!HAS_SCENE_LEAVES) return scene_leaves_words[texel];
#endif
    return texelFetch(scene_leaves, texel);
}
#endif
