// SPDX-License-Identifier: MIT
// What has to be known of, or done to, a glTF file's JSON before tinygltf reads it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "host/images/input_limit.h"

namespace penumbra {

// Before a binary glTF's JSON.
inline constexpr uint64_t glb_head_bytes = 20;

// Of a document's own text, which becomes up to a few hundred times as much in tinygltf's structs.
inline uint64_t largest_document() {
    return input_limit() / 128;
}

// Of a binary glTF the JSON chunk, of any other text all of it. What a header says beyond the file's end is
// for the parser to refuse.
std::string_view document_of(std::string_view file);

// Makes of a .gltf's or .glb's bytes what tinygltf takes: with a byte of data in every buffer that
// EXT_meshopt_compression has as a place for decoded bytes alone, without the indices of primitives that
// Draco holds, whose accessors have no data, and with a type of data that it knows in data URIs, which have
// no more bytes than their buffer. Bytes that are no glTF stay as they are. Returns how many bytes there are
// of each buffer that is a file of its own, in the order in which tinygltf reads them: it refuses a longer
// file, so no more is read of one. And what wrong_member() says of its JSON.
struct ReadableGltf {
    std::vector<uint64_t> lengths;
    std::string wrong;
};
ReadableGltf make_readable(std::vector<unsigned char>& bytes);

// "1.0" of a file of that version, whose scenes and meshes are objects instead of lists; nothing where it may
// be 2.0.
std::string old_version(const std::vector<unsigned char>& bytes);

// A URI's text, which has %20 where a name has a space.
std::string percent_decoded(const std::string& uri);

}  // namespace penumbra
