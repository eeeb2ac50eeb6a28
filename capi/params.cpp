// SPDX-License-Identifier: MIT
// Passes' parameters: what there are, and setting and reading them.
#include <charconv>
#include <cmath>
#include <limits>

#include "capi/shared.h"
#include "graph/interface.h"

using namespace penumbra;
using namespace penumbra::c;

namespace {

static_assert(PENUMBRA_PARAM_BOOL == static_cast<int>(ParamType::boolean) &&
              PENUMBRA_PARAM_INT == static_cast<int>(ParamType::integer) &&
              PENUMBRA_PARAM_UINT == static_cast<int>(ParamType::uint) &&
              PENUMBRA_PARAM_FLOAT == static_cast<int>(ParamType::real) &&
              PENUMBRA_PARAM_VEC2 == static_cast<int>(ParamType::vec2) &&
              PENUMBRA_PARAM_VEC3 == static_cast<int>(ParamType::vec3) &&
              PENUMBRA_PARAM_VEC4 == static_cast<int>(ParamType::vec4) &&
              PENUMBRA_PARAM_ENUM == static_cast<int>(ParamType::enumeration));

uint32_t count_of(const Param& param) {
    return layout_of(param.type).size / sizeof(float);
}

std::array<double, 2> range_of(const Param& param) {
    const auto within = [&](double least, double greatest) -> std::array<double, 2> {
        if (!param.range) return {least, greatest};
        return {std::max(least, (*param.range)[0]), std::min(greatest, (*param.range)[1])};
    };
    constexpr double infinite = std::numeric_limits<double>::infinity();
    switch (param.type) {
        case ParamType::boolean:
            return {0, 1};
        case ParamType::integer:
            return within(std::numeric_limits<int32_t>::min(), std::numeric_limits<int32_t>::max());
        case ParamType::uint:
            return within(0, std::numeric_limits<uint32_t>::max());
        case ParamType::enumeration:
            return {0, double(param.values.size()) - 1};
        default:
            return within(-infinite, infinite);
    }
}

std::string range_text(const Param& param) {
    const auto text = [](double number) {
        char digits[32];
        return std::string(digits, std::to_chars(digits, std::end(digits), number).ptr);
    };
    const auto [least, greatest] = range_of(param);
    if (std::isinf(least)) return "takes finite numbers";
    return "takes " + text(least) + " to " + text(greatest) + (param.unit.empty() ? "" : " " + param.unit);
}

const PlanPass& pass_named(const Plan& plan, const char* node) {
    if (const PlanPass* pass = plan.pass(named(node, "node"))) return *pass;
    std::vector<std::string> known;
    for (const PlanPass& p : plan.passes) known.push_back(p.node);
    misuse("node", "no node \"" + std::string(node) + "\" runs in this plan" + did_you_mean(node, known));
}

size_t param_named(const PlanPass& pass, const char* param) {
    const std::string_view name = named(param, "param");
    for (size_t i = 0; i < pass.params.size(); ++i)
        if (pass.params[i].param.name == name) return i;
    std::vector<std::string> known;
    for (const PlanParam& p : pass.params) known.push_back(p.param.name);
    misuse("param", pass.node + " has no dynamic parameter \"" + param + "\"" + did_you_mean(name, known));
}

std::vector<double> numbers_of(const Param& param, const ParamValue& value) {
    if (const auto* list = std::get_if<std::vector<float>>(&value)) return {list->begin(), list->end()};
    if (const auto* name = std::get_if<std::string>(&value))
        return {double(std::ranges::find(param.values, *name) - param.values.begin())};
    if (const bool* flag = std::get_if<bool>(&value)) return {*flag ? 1.0 : 0.0};
    if (const float* real = std::get_if<float>(&value)) return {double(*real)};
    if (const int32_t* integer = std::get_if<int32_t>(&value)) return {double(*integer)};
    return {double(std::get<uint32_t>(value))};
}

// What no conversion loses anything of; NaN is no number.
template <class T>
T whole(const Param& param, double value) {
    if (!(value >= double(std::numeric_limits<T>::min()) && value <= double(std::numeric_limits<T>::max())) ||
        value != std::trunc(value))
        misuse(param.name, "takes a whole number of 32 bits");
    return static_cast<T>(value);
}

ParamValue param_of(const Param& param, const double* values, uint32_t count) {
    const uint32_t wanted = count_of(param);
    if (count != wanted || !values) misuse(param.name, "takes " + std::to_string(wanted) + " numbers");
    switch (param.type) {
        case ParamType::boolean:
            return values[0] != 0;
        case ParamType::integer:
            return whole<int32_t>(param, values[0]);
        case ParamType::uint:
            return whole<uint32_t>(param, values[0]);
        case ParamType::real:
            return static_cast<float>(values[0]);
        case ParamType::enumeration: {
            const uint32_t index = whole<uint32_t>(param, values[0]);
            if (index >= param.values.size()) misuse(param.name, "has no value of this index");
            return param.values[index];
        }
        default:
            return std::vector<float>(values, values + count);
    }
}

// As a view has them, into the caller's room for `*count`; `values` may be null.
void read_param(const HostPassContext& context, const char* param, double* values, uint32_t* count) {
    const Param& p = context.pass->params[param_named(*context.pass, param)].param;
    const std::vector<double> numbers = numbers_of(p, *context.param(p.name));
    uint32_t& room = given(count, "count");
    if (values && room < numbers.size())
        misuse("count", p.name + " has " + std::to_string(numbers.size()) + " numbers");
    room = static_cast<uint32_t>(numbers.size());
    if (values) std::ranges::copy(numbers, values);
}

}  // namespace

penumbra_code penumbra_plan_param(const penumbra_plan* plan, uint32_t pass, uint32_t index,
                                  penumbra_param* param, penumbra_error* error) {
    return guarded(error, [&] {
        const PlanPass& p = one_of(given(plan, "plan").plan->passes, pass, "pass", "the plan", "passes");
        const auto& [of, offset] = one_of(p.params, index, "index", p.node, "dynamic parameters");
        const auto names = plan->enums.find(&of);
        const bool is_enum = names != plan->enums.end();
        penumbra_param own{0,
                           static_cast<penumbra_param_type>(of.type),
                           of.name.c_str(),
                           of.unit.c_str(),
                           of.doc.c_str(),
                           is_enum ? names->second.data() : nullptr,
                           is_enum ? static_cast<uint32_t>(names->second.size()) : 0,
                           count_of(of),
                           {},
                           {}};
        const std::span<const std::byte> push(p.push);
        std::ranges::copy(numbers_of(of, value_of(of, push.subspan(offset, layout_of(of.type).size))),
                          own.initial);
        std::ranges::copy(range_of(of), own.range);
        write(param, own, "param");
    });
}

penumbra_code penumbra_view_set_param(penumbra_view* view, const char* node, const char* param,
                                      const double* values, uint32_t count, penumbra_error* error) {
    return guarded(error, [&] {
        View& v = *given(view, "view").view;
        const PlanPass& pass = pass_named(v.plan(), node);
        const size_t index = param_named(pass, param);
        const Param& p = pass.params[index].param;
        if (!v.set_param(static_cast<size_t>(&pass - v.plan().passes.data()), index,
                         param_of(p, values, count)))
            misuse(pass.node + "." + p.name, range_text(p));
    });
}

penumbra_code penumbra_view_param(const penumbra_view* view, const char* node, const char* param,
                                  double* values, uint32_t* count, penumbra_error* error) {
    return guarded(error, [&] {
        const View& v = *given(view, "view").view;
        HostPassContext context;
        context.pass = &pass_named(v.plan(), node);
        context.view = &v.state();
        read_param(context, param, values, count);
    });
}

penumbra_code penumbra_call_param(const penumbra_call* call, const char* param, double* values,
                                  uint32_t* count, penumbra_error* error) {
    return guarded(error, [&] { read_param(given(call, "call").context, param, values, count); });
}
