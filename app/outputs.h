// SPDX-License-Identifier: MIT
// Resources of a finished frame to files: DIR/<resource>.<frame>.exr in full precision and .png for the eye;
// of what has a layer for each of a shot's lights DIR/<resource>.<light>.<frame>.exr.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "app/session.h"
#include "host/images/image_file.h"

namespace penumbra {

// One written file, as report.json lists it.
struct WrittenOutput {
    std::string resource;
    uint32_t frame = 0;
    std::string file;         // relative to the output folder
    std::string channels;     // "Y", "R,G,B"
    double min = 0, max = 0;  // of the finite values
    uint64_t nonfinite = 0;
    uint64_t hash = 0;  // FNV-1a over the stored texels
};

// Host inputs that can be captured beside the graph's own resources.
std::span<const std::string> host_image_names();
// Whether a name means the host's image: not in a pipeline that makes a resource of this name itself.
bool is_host_image(const CheckedPipeline& pipeline, const std::string& name);
// Whether the graph has captured a resource of this name.
bool is_captured(const Session& session, const std::string& name);

// A captured resource of the frame that has just completed, of one with layers the first.
PlanarImage captured_image(const Session& session, const std::string& resource);
// A host image (see host_image_names) of that frame.
PlanarImage host_image(Device& device, const Session& session, const std::string& name);

// The images that a folder's report.json lists and that nobody has touched since it was written, with their
// times.
using WrittenFrames = std::map<std::filesystem::path, std::filesystem::file_time_type>;
WrittenFrames frames_of_report(const std::filesystem::path& folder);

class OutputWriter {
  public:
    OutputWriter(Device& device, std::filesystem::path folder)
        : device_(device), folder_(std::move(folder)) {}

    // Writes one resource of the frame that has just completed, of one with layers a file for each: what the
    // graph has captured, else the host's image.
    void write(const Session& session, const std::string& resource, uint32_t frame);

    // What such a frame's files are called, without their ending.
    static std::vector<std::string> names(const Session& session, const std::string& resource,
                                          uint32_t frame);

    const std::vector<WrittenOutput>& written() const { return written_; }

    struct Texels;

  private:
    void write(const Texels& texels, const std::string& resource, const std::string& name, uint32_t frame);

    Device& device_;
    std::filesystem::path folder_;
    std::vector<WrittenOutput> written_;
};

}  // namespace penumbra
