// SPDX-License-Identifier: MIT
// Requests of the C interface. Pointers lead to texts and lists that end, as they must; everything else is
// what the bytes say: sizes of structs, counts, flags, texts that are no names.
#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <stdexcept>
#include <string>
#include <vector>

#include "penumbra/penumbra.h"
#include "tests/fuzz/targets.h"

namespace penumbra::test {
namespace {

class Maker {
  public:
    explicit Maker(Bytes bytes) : bytes_(bytes) {}

    uint32_t number() {
        uint32_t value = 0;
        const size_t count = std::min<size_t>(4, bytes_.size());
        if (count) std::memcpy(&value, bytes_.data(), count);
        bytes_ = bytes_.subspan(count);
        return value;
    }
    // Mostly small, so that lists stay short.
    uint32_t few() { return number() % 5; }

    const char* text() {
        constexpr const char* known[] = {"raw.json",   "depth",   "d32",
                                         "visibility", "moves",   "nodes.trace.params.step=2",
                                         "",           "extends", "no such thing"};
        const uint32_t choice = number() % 12;
        if (choice < std::size(known)) return known[choice];
        if (choice == 9) return nullptr;
        const size_t wanted = number() % 64, length = std::min(wanted, bytes_.size());
        texts_.emplace_back(reinterpret_cast<const char*>(bytes_.data()), length);
        bytes_ = bytes_.subspan(length);
        return texts_.back().c_str();
    }

    const char* const* list(uint32_t count) {
        std::vector<const char*>& out = lists_.emplace_back();
        for (uint32_t i = 0; i < count; ++i) out.push_back(text());
        return out.data();
    }

    // What is left, as a text that ends.
    const char* rest() {
        texts_.emplace_back(reinterpret_cast<const char*>(bytes_.data()), bytes_.size());
        return texts_.back().c_str();
    }

  private:
    Bytes bytes_;
    std::deque<std::string> texts_;
    std::deque<std::vector<const char*>> lists_;
};

// The size that the struct has, or one of a caller that is older, newer or mistaken, but no larger than the
// memory is.
template <class Struct>
uint32_t size_of(Maker& make) {
    const uint32_t any = make.number();
    return any % 4 ? static_cast<uint32_t>(sizeof(Struct)) : any % (sizeof(Struct) + 1);
}

}  // namespace

void fuzz_c_api(Bytes bytes) {
    Maker make(bytes);
    std::array<penumbra_fact, 4> facts{};
    std::array<penumbra_input, 4> inputs{};
    penumbra_plan_request request{};
    request.struct_size = size_of<penumbra_plan_request>(make);
    request.width = make.number() % 3 ? make.number() % 4096 : make.number();
    request.height = make.number() % 3 ? make.number() % 4096 : make.number();
    request.fact_count = make.few();
    request.input_count = make.few();
    const uint32_t fact_size = size_of<penumbra_fact>(make), input_size = size_of<penumbra_input>(make);
    for (penumbra_fact& fact : facts) fact = {fact_size, make.number(), make.text()};
    for (penumbra_input& input : inputs)
        input = {input_size,           make.number() % 2,    make.text(),      make.text(),
                 make.number() % 4096, make.number() % 4096, make.number() % 8};
    request.facts = facts.data();
    request.inputs = inputs.data();
    request.settings = make.list(request.setting_count = make.few());
    request.features = make.list(request.feature_count = make.few());
    request.captures = make.list(request.capture_count = make.few());
    request.host_images = make.list(request.host_image_count = make.few());
    request.share_transients = make.number() % 2;
    request.hand_on_history = make.number() % 2;
    request.jitters = make.number() % 5 ? make.number() % 4 : make.number();
    const bool own_text = make.number() % 2;
    request.file = own_text ? "any.json" : PENUMBRA_SOURCE_DIR "/pipelines/raw.json";
    request.text = own_text ? make.rest() : nullptr;
    penumbra_error error{};
    error.struct_size = size_of<penumbra_error>(make);
    penumbra_plan* plan = nullptr;
    const penumbra_code code = penumbra_plan_create(&request, &plan, &error);
    if (code == PENUMBRA_INTERNAL) throw std::logic_error(std::string("a defect: ") + error.text);
    if ((code == PENUMBRA_OK) != (plan != nullptr))
        throw std::logic_error("the code says otherwise than the plan");
    penumbra_plan_info info{};
    info.struct_size = size_of<penumbra_plan_info>(make);
    static_cast<void>(penumbra_plan_read(plan, &info, nullptr));
    for (uint32_t i = 0; plan && i <= penumbra_plan_slot_count(plan); ++i) {
        penumbra_slot slot{};
        slot.struct_size = size_of<penumbra_slot>(make);
        static_cast<void>(penumbra_plan_slot(plan, i, &slot, nullptr));
        const uint32_t frame[2] = {make.number(), make.number()};
        uint32_t extent[2];
        static_cast<void>(
            penumbra_plan_extent(plan, slot.name ? slot.name : make.text(), frame, extent, nullptr));
    }
    penumbra_plan_destroy(plan);
}

}  // namespace penumbra::test
