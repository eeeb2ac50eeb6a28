// SPDX-License-Identifier: MIT
// Numbers out of a glTF accessor: any component type, normalised integers, strides and sparse overrides
// (glTF 2.0, section 3.6.2), with every range checked against the buffer that it reads.
#pragma once

#include <tiny_gltf.h>

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <stdexcept>
#include <vector>

namespace penumbra {

// The file breaks the format; what() says how. Stays inside the loader, which turns it into a diagnostic.
class GltfError : public std::runtime_error {
  public:
    using std::runtime_error::runtime_error;
};

// The bytes of a buffer view, checked to lie inside its buffer. Throws GltfError.
std::span<const std::byte> view_bytes(const tinygltf::Model& file, int view);

// What a model may take in memory, which is spent before it is allocated. A few bytes can stand for gigabytes
// (a sparse accessor, many primitives on one buffer), and no sane file repeats what it holds a thousand
// times.
class ReadBudget {
  public:
    // `file_bytes` in all files of the model. Throws std::invalid_argument as input_limit() does.
    explicit ReadBudget(uint64_t file_bytes);
    void spend(uint64_t bytes);  // throws GltfError where that is too much
    uint64_t left() const { return left_; }

  private:
    uint64_t left_, file_bytes_;
    bool by_file_;  // the file's size is the narrower bound
};

bool are_finite(std::span<const float> numbers);

// Reads each accessor once, however many primitives share it.
class AccessorReader {
  public:
    AccessorReader(const tinygltf::Model& file, ReadBudget& budget) : file_(file), budget_(budget) {}

    // `width` floats per element, tightly packed; valid as long as the reader. Throws GltfError.
    const std::vector<float>& floats(int accessor, int width);

    // Unsigned scalars. Throws GltfError.
    std::vector<uint32_t> indices(int accessor);

  private:
    std::vector<float> read_floats(int accessor, int width);

    const tinygltf::Model& file_;
    ReadBudget& budget_;
    std::map<int, std::vector<float>> floats_;  // by accessor
};

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
