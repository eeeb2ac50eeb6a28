// SPDX-License-Identifier: MIT
// penumbra reference: the true visibility of a shot's frames, each frozen in time. Analytic scenes have it in
// closed form; elsewhere rays are counted.
#include <iostream>

#include "app/commands.h"
#include "app/frame_range.h"
#include "app/light_truth.h"
#include "app/mask_folder.h"
#include "app/outputs.h"
#include "app/progress.h"
#include "app/truth.h"
#include "host/truth/analytic.h"

namespace penumbra {
namespace {

namespace fs = std::filesystem;

void write_truth(const fs::path& folder, const Shot& shot, uint32_t frame, Truth truth) {
    PlanarImage image{shot.size[0], shot.size[1], {}};
    image.planes.push_back({"Y", PlaneType::real, std::move(truth.visibility), {}});
    image.planes.push_back({"receiver", PlaneType::real, std::move(truth.receiver), {}});
    image.planes.push_back({"rays", PlaneType::real, std::move(truth.rays), {}});
    write_exr(visibility_file(folder, frame), image);
    write_png_linear(fs::path(visibility_file(folder, frame)).replace_extension(".png"), image.width,
                     image.height, image.planes[0].values);
}

int write_reference(const ReferenceArguments& arguments, const Shot& shot, const FrameRange& frames) {
    Device device({arguments.device, false});
    Diagnostics diagnostics;
    std::vector<std::string> warnings;
    const auto chosen = choose_light(shot, arguments.light, diagnostics);
    const auto session = !chosen         ? nullptr
                         : chosen->light ? open_light_truth(device, shot, chosen->name, diagnostics, warnings)
                                         : open_truth(device, shot, diagnostics, warnings);
    for (const std::string& warning : warnings) std::cerr << "warning: " << warning << "\n";
    if (!session) {
        std::cerr << diagnostics.text();
        return exit_wrong;
    }
    const fs::path folder = arguments.out;
    fs::create_directories(folder);
    fs::remove(folder / "reference.json");  // comes last: a folder that has it is a complete one
    OutputWriter host_images(device, folder);
    {
        Progress progress("reference", frames[1] - frames[0] + 1);
        for (uint32_t frame = frames[0]; frame <= frames[1]; ++frame) {
            if (shot.analytic) {
                session->run_frame(frame, false);  // for the images beside
                write_truth(folder, shot, frame, analytic_truth(shot, frame));
            } else {
                write_truth(folder, shot, frame,
                            chosen->light ? counted_light_truth(*session, frame, arguments.rays)
                                          : counted_truth(*session, frame, arguments.rays));
            }
            for (const char* name : {"depth", "motion", "normal", "albedo"})
                host_images.write(*session, name, frame);
            progress.step();
        }
    }
    ReferenceInfo info{shot.file.string(), shot.size, shot.analytic.has_value(), {}, {}};
    for (uint32_t frame = frames[0]; frame <= frames[1]; ++frame)
        info.frames[frame] = {sun_at(shot, frame).to_sun,
                              shot.analytic ? analytic_contact(shot, frame) : std::nullopt};
    if (!info.exact) info.rays = rays_cast(arguments.rays);
    write_reference_info(folder, info);
    return exit_good;
}

}  // namespace

int run_reference(const ReferenceArguments& arguments) {
    Diagnostics diagnostics;
    auto shot = read_shot(arguments.shot, diagnostics);
    if (!shot) {
        std::cerr << diagnostics.text();
        return exit_wrong;
    }
    const auto size = arguments.size.empty() ? std::optional(shot->size) : parse_size(arguments.size);
    const auto frames = parse_frames(arguments.frames, shot->frames);
    if (!size || !frames) return exit_wrong;
    shot->size = *size;
    return write_reference(arguments, *shot, *frames);
}

}  // namespace penumbra
