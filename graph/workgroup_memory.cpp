// SPDX-License-Identifier: MIT
// Types and constants of a module come before its functions, each before what uses it: one pass over them, in
// which arrays get the length that their specialisation constants give them. Numbers of instructions are
// those of the SPIR-V specification, 3.42.
#include "graph/workgroup_memory.h"

#include <algorithm>
#include <optional>
#include <unordered_map>
#include <vector>

namespace penumbra {
namespace {

using Value = std::vector<uint32_t>;  // a scalar, or the components of a vector

struct Type {
    uint64_t size = 4, alignment = 4;
    uint32_t points_to = 0;
};

uint64_t round_up(uint64_t value, uint64_t to) {
    return (value + to - 1) / to * to;
}

// Of unsigned and signed numbers of 32 bits; what divides by nothing is nothing.
std::optional<uint32_t> computed(uint32_t operation, uint32_t a, uint32_t b, uint32_t c) {
    const auto sa = static_cast<int32_t>(a), sb = static_cast<int32_t>(b);
    const bool divides = b != 0 && !(sa == INT32_MIN && sb == -1);
    switch (operation) {
        case 113:
        case 114:
        case 124:
            return a;  // UConvert, SConvert, Bitcast
        case 126:
            return 0 - a;  // SNegate
        case 128:
            return a + b;
        case 130:
            return a - b;
        case 132:
            return a * b;
        case 134:
            return b ? a / b : 0;
        case 135:
            return divides ? static_cast<uint32_t>(sa / sb) : 0;
        case 137:
            return b ? a % b : 0;
        case 138:
        case 139: {  // SRem; SMod, which has the sign of b
            const int32_t rest = divides ? sa % sb : 0;
            return static_cast<uint32_t>(operation == 139 && rest && (rest < 0) != (sb < 0) ? rest + sb
                                                                                            : rest);
        }
        case 164:
        case 170:
            return a == b;
        case 165:
        case 171:
            return a != b;
        case 166:
            return a || b;
        case 167:
            return a && b;
        case 168:
            return !a;
        case 169:
            return a ? b : c;
        case 172:
            return a > b;
        case 173:
            return sa > sb;
        case 174:
            return a >= b;
        case 175:
            return sa >= sb;
        case 176:
            return a < b;
        case 177:
            return sa < sb;
        case 178:
            return a <= b;
        case 179:
            return sa <= sb;
        case 194:
            return b < 32 ? a >> b : 0;
        case 195:
            return static_cast<uint32_t>(sa >> std::min(b, 31u));
        case 196:
            return b < 32 ? a << b : 0;
        case 197:
            return a | b;
        case 198:
            return a ^ b;
        case 199:
            return a & b;
        case 200:
            return ~a;
    }
    return std::nullopt;
}

class Module {
  public:
    explicit Module(std::span<const uint32_t> constants) : constants_(constants) {}
    uint64_t bytes = 0;

    // `i`: the instruction's words.
    void read(uint32_t operation, std::span<const uint32_t> i) {
        switch (operation) {
            case 20:
                types_[i[1]] = {};
                break;  // Bool
            case 21:
            case 22:
                types_[i[1]] = {i[2] / 8, i[2] / 8};
                break;  // Int, Float
            case 23: {  // Vector
                const Type& of = types_[i[2]];
                types_[i[1]] = {of.size * i[3], of.size * (i[3] == 3 ? 4 : i[3])};
                break;
            }
            case 24:
                types_[i[1]] = array_of(types_[i[2]], i[3]);
                break;  // Matrix
            case 28:
                types_[i[1]] = array_of(types_[i[2]], scalar(i[3]));
                break;  // Array
            case 30:
                types_[i[1]] = structure(i.subspan(2));
                break;
            case 32:
                types_[i[1]] = {8, 8, i[3]};
                break;  // Pointer
            case 41:
            case 48:
                set(i[2], {1});
                break;  // true
            case 42:
            case 49:
                set(i[2], {0});
                break;  // false
            case 43:
            case 50:
                set(i[2], {i[3]});
                break;
            case 44:
            case 51:
                composite(i);
                break;
            case 52:
                compute(i);
                break;
            case 59:  // Variable
                if (constexpr uint32_t workgroup = 4; i[3] == workgroup) {
                    const Type& of = types_[types_[i[1]].points_to];
                    bytes = round_up(bytes, of.alignment) + of.size;
                }
                break;
            case 71:  // Decorate
                if (constexpr uint32_t spec_id = 1; i[2] == spec_id) numbers_[i[1]] = i[3];
                break;
        }
    }

  private:
    static Type array_of(const Type& of, uint64_t length) {
        return {round_up(of.size, of.alignment) * length, of.alignment};
    }
    Type structure(std::span<const uint32_t> members) {
        Type made{0, 1};
        for (const uint32_t member : members) {
            const Type& of = types_[member];
            made.size = round_up(made.size, of.alignment) + of.size;
            made.alignment = std::max(made.alignment, of.alignment);
        }
        made.size = round_up(made.size, made.alignment);
        return made;
    }
    uint32_t scalar(uint32_t id) const {
        const auto value = values_.find(id);
        return value != values_.end() && value->second.size() == 1 ? value->second[0] : 0;
    }
    void set(uint32_t id, Value value) {
        const auto number = numbers_.find(id);
        if (number != numbers_.end() && number->second < constants_.size())
            value = {constants_[number->second]};
        values_[id] = std::move(value);
    }
    void composite(std::span<const uint32_t> i) {
        Value parts;
        for (const uint32_t part : i.subspan(3)) parts.push_back(scalar(part));
        values_[i[2]] = std::move(parts);
    }
    // Component by component; what is neither an integer of 32 bits nor a truth value stays unknown, and no
    // array is as long as that.
    void compute(std::span<const uint32_t> i) {
        constexpr uint32_t shuffle = 79, extract = 81;
        const uint32_t operation = i[3];
        const auto operand = [&](size_t at) { return at < i.size() ? values_[i[at]] : Value{}; };
        const auto at = [](const Value& v, size_t k) { return k < v.size() ? v[k] : 0u; };
        const Value a = operand(4), b = operand(5), c = operand(6);
        Value result;
        if (operation == extract) {
            if (i.size() == 6) result = {at(a, i[5])};
        } else if (operation == shuffle) {
            for (size_t k = 6; k < i.size(); ++k)
                result.push_back(i[k] < a.size() ? a[i[k]] : at(b, i[k] - a.size()));
        } else {
            for (size_t k = 0; k < a.size(); ++k)
                if (const auto value = computed(operation, at(a, k), at(b, k), at(c, k)))
                    result.push_back(*value);
        }
        values_[i[2]] = std::move(result);
    }

    std::span<const uint32_t> constants_;
    std::unordered_map<uint32_t, Type> types_;
    std::unordered_map<uint32_t, Value> values_;
    std::unordered_map<uint32_t, uint32_t> numbers_;  // of specialisation constants, by id
};

}  // namespace

uint64_t workgroup_bytes(std::span<const uint32_t> spirv, std::span<const uint32_t> constants) {
    constexpr uint32_t function = 54;
    Module module(constants);
    for (size_t at = 5; at < spirv.size();) {
        const uint32_t operation = spirv[at] & 0xffff, words = spirv[at] >> 16;
        if (operation == function || words == 0 || words > spirv.size() - at) break;
        module.read(operation, spirv.subspan(at, words));
        at += words;
    }
    return module.bytes;
}

}  // namespace penumbra
