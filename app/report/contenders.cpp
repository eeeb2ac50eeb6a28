// SPDX-License-Identifier: MIT
#include "app/report/contenders.h"

#include <fmt/format.h>

#include <algorithm>

#include "app/reference_pipeline.h"
#include "app/report/study.h"
#include "app/session.h"

namespace penumbra::report {
namespace {

namespace fs = std::filesystem;

// Why a pipeline cannot be judged on a shot; nothing where it can.
std::optional<std::string> obstacle(const CheckedPipeline& pipeline) {
    for (const HostInput& input : pipeline.inputs)
        if (!input.optional && !standalone_has_input(input.name))
            return fmt::format("takes \"{}\", which only an engine can bring", input.name);
    const std::vector<std::string> outputs = pipeline.output_names();
    if (std::ranges::find(outputs, "visibility") == outputs.end()) return "puts out no \"visibility\"";
    return std::nullopt;
}

std::optional<CheckedPipeline> checked(const std::optional<Pipeline>& pipeline, const NodeSet& nodes,
                                       Diagnostics& diagnostics) {
    return pipeline ? check(*pipeline, nodes, diagnostics) : std::nullopt;
}

void add_brute_force(Contenders& contenders, const NodeSet& nodes, Diagnostics& diagnostics) {
    for (const uint32_t rays : brute_force_rays) {
        const std::vector<std::string> settings{fmt::format("nodes.trace.params.rays_per_pixel={}", rays)};
        auto pipeline =
            checked(parse_pipeline(raw_pipeline_text, "pipelines/raw.json", settings, diagnostics), nodes,
                    diagnostics);
        if (pipeline)
            contenders.list.push_back(
                {fmt::format("rays_{}", rays), "",
                 fmt::format("{} rays per pixel, not denoised: raw.json --set {}.", rays, settings.front()),
                 rays, std::move(*pipeline)});
    }
}

}  // namespace

fs::path shipped_root() {
    std::error_code none;
    const auto holds_both = [&](const fs::path& folder) {
        return fs::is_directory(folder / "pipelines", none) && fs::is_directory(folder / "scenes", none);
    };
    if (holds_both(".")) return ".";
    fs::path folder = fs::read_symlink("/proc/self/exe", none).parent_path();
    for (; !folder.empty() && folder != folder.root_path(); folder = folder.parent_path())
        if (holds_both(folder)) return fs::proximate(folder, none);
    return {};
}

std::vector<fs::path> shipped_files(const fs::path& root, const std::string& folder,
                                    const std::string& suffix) {
    std::vector<fs::path> files;
    std::error_code failure;
    if (!root.empty())
        for (const auto& entry : fs::directory_iterator(root / folder, failure))
            if (const std::string name = entry.path().filename().string();
                name.ends_with(suffix) && name.find(".schema.") == std::string::npos)
                files.push_back((root == "." ? fs::path(folder) : root / folder) / name);
    std::sort(files.begin(), files.end());
    return files;
}

std::optional<fs::path> shipped_file(const std::string& wanted, const fs::path& root,
                                     const std::string& folder, const std::string& suffix,
                                     Diagnostics& diagnostics) {
    if (fs::is_regular_file(wanted)) return fs::path(wanted);
    std::vector<std::string> names;
    for (const fs::path& file : shipped_files(root, folder, suffix)) {
        std::string name = file.filename().string();
        name.resize(name.size() - suffix.size());
        if (name == wanted) return file;
        names.push_back(name);
    }
    diagnostics.add({}, "--" + folder,
                    fmt::format("\"{}\" is neither a file nor the name of a shipped one{}", wanted,
                                did_you_mean(wanted, names)));
    return std::nullopt;
}

std::optional<Contenders> open_contenders(const std::vector<std::string>& wanted, const fs::path& root,
                                          const NodeSet& nodes, Diagnostics& diagnostics) {
    Contenders contenders;
    std::vector<fs::path> files;
    for (const std::string& name : wanted)
        if (const auto file = shipped_file(name, root, "pipelines", ".json", diagnostics))
            files.push_back(*file);
    if (wanted.empty()) files = shipped_files(root, "pipelines", ".json");
    if (files.empty() && diagnostics.empty())
        diagnostics.add({}, "--pipelines", "none given, and no folder of shipped ones is near the program");
    for (const fs::path& file : files) {
        auto pipeline = checked(load_pipeline(file, {}, diagnostics), nodes, diagnostics);
        if (!pipeline) continue;
        const auto why = obstacle(*pipeline);
        if (why && wanted.empty()) {
            contenders.left_out.push_back({file.generic_string(), *why});
            continue;
        }
        if (why) diagnostics.add({file.string(), 0, 0}, "", *why);
        for (const Contender& other : contenders.list)
            if (other.id == pipeline->name)
                diagnostics.add({file.string(), 0, 0}, "name",
                                fmt::format("\"{}\" is the name of {} too", pipeline->name, other.file));
        contenders.list.push_back({pipeline->name, file.generic_string(), pipeline->doc, {}, *pipeline});
    }
    if (diagnostics.empty()) add_brute_force(contenders, nodes, diagnostics);
    if (!diagnostics.empty()) return std::nullopt;
    return contenders;
}

}  // namespace penumbra::report
