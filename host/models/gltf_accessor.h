// SPDX-License-Identifier: MIT
// Numbers out of a glTF accessor: any component type, normalised integers, strides and sparse overrides
// (glTF 2.0, section 3.6.2), with every range checked against the buffer that it reads.
#pragma once

#include <tiny_gltf.h>

#include <cstdint>
#include <stdexcept>
#include <vector>

namespace penumbra {

// The file breaks the format; what() says how. Stays inside the loader, which turns it into a diagnostic.
class GltfError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

// `width` floats per element, tightly packed. Throws GltfError.
std::vector<float> read_floats(const tinygltf::Model& file, int accessor, int width);

// Unsigned scalars. Throws GltfError.
std::vector<uint32_t> read_indices(const tinygltf::Model& file, int accessor);

// list.at(index) with an error that names the thing.
template <class T>
const T& element(const std::vector<T>& list, int index, const char* what) {
    if (index < 0 || static_cast<size_t>(index) >= list.size()) {
        throw GltfError(std::string(what) + " " + std::to_string(index) + " does not exist (there are " +
                        std::to_string(list.size()) + ")");
    }
    return list[static_cast<size_t>(index)];
}

}  // namespace penumbra
