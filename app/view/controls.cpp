// SPDX-License-Identifier: MIT
#include "app/view/controls.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace penumbra::viewer {
namespace {

template <class T>
T read(const std::vector<std::byte>& push, uint32_t offset) {
    T value{};
    std::memcpy(&value, push.data() + offset, sizeof value);
    return value;
}

ParamValue initial_value(const PlanPass& pass, const PlanParam& p) {
    const auto reals = [&](uint32_t count) {
        std::vector<float> values;
        for (uint32_t i = 0; i < count; ++i) values.push_back(read<float>(pass.push, p.offset + 4 * i));
        return values;
    };
    switch (p.param.type) {
        case ParamType::boolean:
            return read<uint32_t>(pass.push, p.offset) != 0;
        case ParamType::integer:
            return read<int32_t>(pass.push, p.offset);
        case ParamType::uint:
            return read<uint32_t>(pass.push, p.offset);
        case ParamType::real:
            return read<float>(pass.push, p.offset);
        case ParamType::vec2:
            return reals(2);
        case ParamType::vec3:
            return reals(3);
        case ParamType::vec4:
            return reals(4);
        case ParamType::enumeration:
            return p.param.values.at(read<uint32_t>(pass.push, p.offset));
    }
    throw std::logic_error("a parameter of no type");
}

struct AsJson {
    std::string operator()(bool v) const { return v ? "true" : "false"; }
    std::string operator()(int32_t v) const { return fmt::format("{}", v); }
    std::string operator()(uint32_t v) const { return fmt::format("{}", v); }
    std::string operator()(float v) const { return fmt::format("{}", v); }
    std::string operator()(const std::vector<float>& v) const {
        return fmt::format("[{}]", fmt::join(v, ","));
    }
    std::string operator()(const std::string& v) const { return v; }
};

}  // namespace

std::vector<Control> controls_of(const Plan& plan) {
    std::vector<Control> controls;
    for (size_t pass = 0; pass < plan.passes.size(); ++pass) {
        for (size_t i = 0; i < plan.passes[pass].params.size(); ++i) {
            const PlanParam& p = plan.passes[pass].params[i];
            if (p.param.name == "seed") continue;
            const auto same = std::ranges::find_if(controls, [&](const Control& c) {
                return c.node == plan.passes[pass].node && c.param.name == p.param.name;
            });
            if (same != controls.end()) {
                same->places.push_back({pass, i});
                continue;
            }
            const ParamValue value = initial_value(plan.passes[pass], p);
            controls.push_back({p.param, plan.passes[pass].node, {{pass, i}}, value, value});
        }
    }
    return controls;
}

bool turn(Session& session, Control& control, const ParamValue& value) {
    for (const auto& [pass, param] : control.places)
        if (!session.set_param(pass, param, value)) return false;  // all are of one type and range
    control.value = value;
    return true;
}

std::vector<std::string> turn_again(Session& session, std::vector<Control>& controls, const Turned& turned) {
    std::vector<std::string> lost;
    for (const auto& [name, value] : turned) {
        const auto control = std::ranges::find(controls, name, &Control::name);
        if (control == controls.end() || !turn(session, *control, value)) lost.push_back(name);
    }
    return lost;
}

std::string setting_of(const Control& control) {
    return fmt::format("nodes.{}.params.{}={}", control.node, control.param.name,
                       std::visit(AsJson{}, control.value));
}

}  // namespace penumbra::viewer
