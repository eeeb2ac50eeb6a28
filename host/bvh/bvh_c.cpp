// SPDX-License-Identifier: MIT
// The tree for C: bvh.h behind a handle, with errors as values and structs that are read and written by their
// sizes.
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <stdexcept>
#include <string>

#include "host/bvh/bvh.h"
#include "host/bvh/penumbra_bvh.h"

using namespace penumbra;

struct penumbra_bvh {
    Bvh tree;
    Refitted written;
    std::vector<Texel> built, neighbours;  // leaf_neighbours() of the tree as it was built; as they are now
};

namespace {

[[noreturn]] void misuse(const std::string& text) {
    throw std::invalid_argument(text);
}

// To the last member of the first version of a struct, which stays here whatever is added behind it.
template <class T>
constexpr size_t first_size = ~size_t{0};
#define PENUMBRA_FIRST(type, last) \
    template <>                    \
    constexpr size_t first_size<type> = offsetof(type, last) + sizeof(type::last)
PENUMBRA_FIRST(penumbra_bvh_error, text);
PENUMBRA_FIRST(penumbra_bvh_request, neighbours);
PENUMBRA_FIRST(penumbra_bvh_info, skipped);
PENUMBRA_FIRST(penumbra_bvh_refitted, neighbours_changed);
#undef PENUMBRA_FIRST

template <class T>
T& given(T* pointer, const char* what) {
    if (!pointer) misuse(std::string(what) + " is null");
    return *pointer;
}

template <class T>
uint32_t size_of(const T* from, const char* what) {
    const uint32_t size = given(from, what).struct_size;
    if (size < first_size<T>)
        misuse(std::string(what) + ".struct_size is no size of this struct; is it set?");
    return size;
}

template <class T>
void write(T* to, T own, const char* what) {
    own.struct_size = size_of(to, what);
    std::memcpy(static_cast<void*>(to), &own, std::min<size_t>(own.struct_size, sizeof own));
}

penumbra_code report(penumbra_bvh_error* error, penumbra_code code, const char* text) {
    if (error && error->struct_size >= first_size<penumbra_bvh_error>) {
        error->code = code;
        const size_t length = std::min(std::strlen(text), sizeof error->text - 1);
        std::memcpy(error->text, text, length);
        error->text[length] = '\0';
    }
    return code;
}

template <class F>
penumbra_code guarded(penumbra_bvh_error* error, F&& function) noexcept {
    try {
        function();
        return report(error, PENUMBRA_OK, "");
    } catch (const std::invalid_argument& e) {
        return report(error, PENUMBRA_USAGE, e.what());
    } catch (const std::bad_alloc&) {
        return report(error, PENUMBRA_OUT_OF_MEMORY, "no memory");
    } catch (const std::exception& e) {
        return report(error, PENUMBRA_INTERNAL, e.what());
    } catch (...) {
        return report(error, PENUMBRA_INTERNAL, "something that is no exception was thrown");
    }
}

std::span<const Triangle> triangles_of(const float* numbers, uint32_t count) {
    static_assert(sizeof(Triangle) == 9 * sizeof(float));
    if (count > 1u << 30) misuse("triangle_count is beyond 2^30");
    if (count) given(numbers, "triangles");
    return {reinterpret_cast<const Triangle*>(numbers), count};
}

// Of a list of texels or of four corners; null where it is empty.
const uint32_t* words(const std::vector<std::array<uint32_t, 4>>& list) {
    return list.empty() ? nullptr : list.front().data();
}

}  // namespace

penumbra_code penumbra_bvh_create(const penumbra_bvh_request* request, penumbra_bvh** bvh,
                                  penumbra_bvh_error* error) {
    return guarded(error, [&] {
        given(bvh, "bvh") = nullptr;
        penumbra_bvh_request r{};
        std::memcpy(&r, request, std::min<size_t>(size_of(request, "request"), sizeof r));
        const auto triangles = triangles_of(r.triangles, r.triangle_count);
        auto made = std::make_unique<penumbra_bvh>();
        made->tree = build_bvh(triangles, {r.objects, r.objects ? r.triangle_count : 0});
        if (r.neighbours) {
            if (made->tree.corners.size() >= 1u << 28) misuse("neighbours: the tree has 2^28 leaves or more");
            made->built = made->neighbours = leaf_neighbours(made->tree);
        }
        *bvh = made.release();
    });
}

void penumbra_bvh_destroy(penumbra_bvh* bvh) {
    delete bvh;
}

penumbra_code penumbra_bvh_read(const penumbra_bvh* bvh, penumbra_bvh_info* info, penumbra_bvh_error* error) {
    return guarded(error, [&] {
        const penumbra_bvh& b = given(bvh, "bvh");
        const Bvh& t = b.tree;
        write(info,
              {0, uint32_t(t.nodes.size() / 3), uint32_t(t.leaves.size() / 3), uint32_t(t.skipped.size()),
               words(t.nodes), words(t.leaves), words(b.neighbours), words(t.corners), t.skipped.data()},
              "info");
    });
}

penumbra_code penumbra_bvh_refit(penumbra_bvh* bvh, const float* triangles, uint32_t triangle_count,
                                 penumbra_bvh_refitted* refitted, penumbra_bvh_error* error) {
    return guarded(error, [&] {
        penumbra_bvh& b = given(bvh, "bvh");
        size_of(refitted, "refitted");  // before anything is written
        if (!refit(b.tree, triangles_of(triangles, triangle_count), &b.written))
            return write(refitted, {}, "refitted");
        const bool changed =
            !b.built.empty() && refit_neighbours(b.tree, b.written.leaves, b.built, b.neighbours);
        write(refitted,
              {0, 1, uint32_t(b.written.nodes.size()), uint32_t(b.written.leaves.size()),
               b.written.nodes.data(), b.written.leaves.data(), changed},
              "refitted");
    });
}
