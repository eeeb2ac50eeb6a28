// SPDX-License-Identifier: MIT
#include "host/models/gltf_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/gtc/type_ptr.hpp>

namespace penumbra {
namespace {

using Path = AnimationChannel::Path;
using Interpolation = AnimationChannel::Interpolation;

std::optional<Path> path_of(const std::string& name) {
    if (name == "translation") return Path::translation;
    if (name == "rotation") return Path::rotation;
    if (name == "scale") return Path::scale;
    if (name == "weights") return Path::weights;
    return std::nullopt;
}

Interpolation interpolation_of(const std::string& name) {
    if (name == "STEP") return Interpolation::step;
    if (name == "CUBICSPLINE") return Interpolation::cubic;
    if (name.empty() || name == "LINEAR") return Interpolation::linear;
    throw GltfError(fmt::format("there is no interpolation \"{}\"", name));
}

AnimationChannel read_channel(AccessorReader& accessors, ReadBudget& budget,
                              const tinygltf::AnimationSampler& sampler, Path path, int node,
                              size_t targets) {
    AnimationChannel out;
    out.node = node;
    out.path = path;
    out.interpolation = interpolation_of(sampler.interpolation);
    const int width = path == Path::weights ? 1 : path == Path::rotation ? 4 : 3;
    const std::vector<float>&times = accessors.floats(sampler.input, 1),
          &values = accessors.floats(sampler.output, width);
    budget.spend((times.size() + values.size()) * sizeof(float));  // many channels may share one sampler
    out.times = times;
    out.values = values;
    const size_t per_key = (path == Path::weights ? targets : static_cast<size_t>(width)) *
                           (out.interpolation == Interpolation::cubic ? 3 : 1);
    if (out.times.empty() || out.values.size() != out.times.size() * per_key)
        throw GltfError(fmt::format("{} keys have {} numbers, not {} each", out.times.size(),
                                    out.values.size(), per_key));
    if (!are_finite(out.times) || !are_finite(out.values)) throw GltfError("keys are not finite");
    return out;
}

}  // namespace

size_t targets_of(const Model& model, int mesh) {
    size_t count = 0;
    if (mesh >= 0)
        for (const Part& part : model.meshes[static_cast<size_t>(mesh)].parts)
            count = std::max(count, part.targets.size());
    return count;
}

void read_animations(const tinygltf::Model& file, AccessorReader& accessors, ReadBudget& budget,
                     const std::vector<int>& model_node, Model& model, const GltfTell& tell) {
    for (const tinygltf::Animation& animation : file.animations) {
        Animation& out = model.animations.emplace_back();
        out.name = animation.name;
        for (const tinygltf::AnimationChannel& channel : animation.channels) {
            if (channel.target_node < 0) {
                tell("animations of what is no node (KHR_animation_pointer) are not played");
                continue;
            }
            const int mesh = element(file.nodes, channel.target_node, "node").mesh;
            const int node = model_node[static_cast<size_t>(channel.target_node)];
            const auto path = path_of(channel.target_path);
            if (!path) {
                tell(fmt::format("animations of \"{}\" are not played", channel.target_path));
                continue;
            }
            if (node < 0) continue;
            if (model.nodes[static_cast<size_t>(node)].matrix) {
                tell("animations of nodes with a matrix are not played");
                continue;
            }
            try {
                const size_t count = *path == Path::weights ? targets_of(model, mesh) : 0;
                AnimationChannel read =
                    read_channel(accessors, budget, element(animation.samplers, channel.sampler, "sampler"),
                                 *path, node, count);
                // Two keys at one time are a jump, which files have though the format has none.
                if (read.times.front() < 0 || !std::ranges::is_sorted(read.times)) {
                    tell(
                        fmt::format("animation \"{}\": keys whose times do not rise from 0 on are not played",
                                    animation.name));
                    continue;
                }
                out.channels.push_back(std::move(read));
            } catch (const GltfError& error) {
                throw GltfError(fmt::format("animation \"{}\": {}", animation.name, error.what()));
            }
            out.duration_s = std::max(out.duration_s, double(out.channels.back().times.back()));
        }
    }
}

void read_skins(const tinygltf::Model& file, AccessorReader& accessors, const std::vector<int>& model_node,
                Model& model, const GltfTell& tell) {
    for (const tinygltf::Skin& skin : file.skins) {
        Skin& out = model.skins.emplace_back();
        for (const int joint : skin.joints) {
            element(file.nodes, joint, "node");
            out.joints.push_back(model_node[static_cast<size_t>(joint)]);
        }
        if (std::ranges::find(out.joints, -1) != out.joints.end()) {
            tell(fmt::format("skin \"{}\" has joints outside of the scene: its meshes are in their rest pose",
                             skin.name));
            out.joints.clear();
            continue;
        }
        out.inverse_bind.assign(out.joints.size(), glm::dmat4(1));
        if (skin.inverseBindMatrices < 0) continue;
        const std::vector<float>& numbers = accessors.floats(skin.inverseBindMatrices, 16);
        if (numbers.size() < out.joints.size() * 16)
            throw GltfError(
                fmt::format("skin \"{}\" has fewer inverse bind matrices than joints", skin.name));
        if (!are_finite(std::span(numbers).first(out.joints.size() * 16)))
            throw GltfError(
                fmt::format("skin \"{}\" has inverse bind matrices that are not finite", skin.name));
        for (size_t i = 0; i < out.joints.size(); ++i)
            out.inverse_bind[i] = glm::dmat4(glm::make_mat4(&numbers[16 * i]));
    }
}

void check_joints(const Model& model) {
    for (const Node& node : model.nodes) {
        if (node.skin < 0) continue;
        const size_t joints = model.skins[static_cast<size_t>(node.skin)].joints.size();
        for (const Part& part : model.meshes[static_cast<size_t>(node.mesh)].parts)
            for (size_t i = 0; i < part.joints.size(); ++i)
                for (int k = 0; k < 4; ++k)
                    if (part.weights[i][k] > 0 && part.joints[i][static_cast<size_t>(k)] >= joints)
                        throw GltfError(fmt::format("node \"{}\": a vertex is moved by joint {} of {}",
                                                    node.name, part.joints[i][static_cast<size_t>(k)],
                                                    joints));
    }
}

}  // namespace penumbra
