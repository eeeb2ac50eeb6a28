// SPDX-License-Identifier: MIT
#include "host/models/gltf_lights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace penumbra {
namespace {

constexpr const char* extension = "KHR_lights_punctual";
constexpr double most = 1e12;          // candelas; products of two such are still fp32
constexpr double most_metres = 1e6;    // of a radius, as a shot's
constexpr double longest_range = 1e9;  // metres, as a shot's

void read_cone(const tinygltf::SpotLight& cone, const std::string& what, ModelLight& out,
               const GltfTell& tell) {
    const double inner = glm::degrees(cone.innerConeAngle), outer = glm::degrees(cone.outerConeAngle);
    if (!(inner >= 0 && outer > 0))
        throw GltfError(fmt::format("{}a cone from {} to {} degrees", what, inner, outer));
    out.outer_deg = std::min(outer, 90.0);
    out.inner_deg = std::min(inner, out.outer_deg);  // equal: as sharp as Blender's spots without a blend
    constexpr double rounding = 0.01;
    if (outer > out.outer_deg + rounding || inner > out.inner_deg + rounding)
        tell(fmt::format("{}a cone from {:.5g} to {:.5g} degrees is taken as one from {:.5g} to {:.5g}", what,
                         inner, outer, out.inner_deg, out.outer_deg));
}

}  // namespace

// A directional light is the sun's.
void read_light(const tinygltf::Model& file, const tinygltf::Node& node, int self, Model& model,
                const GltfTell& tell) {
    const auto found = node.extensions.find(extension);
    if (found == node.extensions.end()) return;
    const int index = extension_integer(found->second, "light", extension);
    const tinygltf::Light& light = element(file.lights, index, "light");
    ModelLight out;
    out.node = self;
    out.name = !light.name.empty()  ? light.name
               : !node.name.empty() ? node.name
                                    : fmt::format("light_{}", index);
    const std::string what = fmt::format("{}: light \"{}\": ", extension, out.name);
    if (light.type == "directional") {
        if (light.intensity > 0)
            model.suns.push_back(self);
        else
            tell(what + "is directional without an intensity, and no sun");
        return;
    }
    if (light.type != "point" && light.type != "spot")
        throw GltfError(fmt::format("{}no type is named \"{}\"", what, light.type));
    out.spot = light.type == "spot";
    out.intensity = factor(what + "intensity", light.intensity, most, tell);
    // Beyond what a shot may say it ends nowhere, which is what files mean by such numbers.
    const double range = factor(what + "range", light.range, INFINITY, tell);
    out.range = range > longest_range ? 0 : range;
    for (size_t i = 0; i < 3 && light.color.size() == 3; ++i)
        out.color[static_cast<int>(i)] = factor(what + "color", light.color[i], most, tell);
    if (light.extras.IsObject() && light.extras.Has("radius")) {
        const tinygltf::Value& radius = light.extras.Get("radius");
        if (!radius.IsNumber()) throw GltfError(what + "the radius of its extras is not a number");
        out.radius = factor(what + "radius", radius.GetNumberAsDouble(), most_metres, tell);
    }
    if (out.spot) read_cone(light.spot, what, out, tell);
    model.lights.push_back(std::move(out));
}

void name_lights(Model& model) {
    std::set<std::string> own, used;
    for (const ModelLight& light : model.lights) own.insert(light.name);
    std::map<std::string, int> last;  // number of each name
    for (ModelLight& light : model.lights) {
        if (used.insert(light.name).second) continue;
        std::string name = model.nodes[static_cast<size_t>(light.node)].name;
        int& nth = last.try_emplace(light.name, 1).first->second;
        while (name.empty() || own.contains(name) || !used.insert(name).second)
            name = fmt::format("{}_{}", light.name, ++nth);
        light.name = std::move(name);
    }
}

}  // namespace penumbra
