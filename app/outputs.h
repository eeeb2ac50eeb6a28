// SPDX-License-Identifier: MIT
// Resources of a finished frame to files: DIR/<resource>.<frame>.exr in full precision and .png for the eye.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "app/session.h"
#include "host/image_file.h"

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

// Non-finite and out-of-range texels of one resource over all frames looked at. Visibility lies in [0, 1];
// other resources have no range of their own.
struct TexelCheck {
    uint64_t nan = 0, inf = 0, out_of_range = 0;
};

// Host inputs that can be captured beside the graph's own resources.
bool is_host_image(const std::string& name);

// A captured resource of the frame that has just completed.
PlanarImage captured_image(const Session& session, const std::string& resource);
// A host image (see is_host_image) of that frame.
PlanarImage host_image(Device& device, const Session& session, const std::string& name);

class OutputWriter {
  public:
    OutputWriter(Device& device, std::filesystem::path folder)
        : device_(device), folder_(std::move(folder)) {}

    // Writes one resource of the frame that has just completed.
    void write(const Session& session, const std::string& resource, uint32_t frame);

    const std::vector<WrittenOutput>& written() const { return written_; }
    const std::map<std::string, TexelCheck>& checks() const { return checks_; }

  private:
    Device& device_;
    std::filesystem::path folder_;
    std::vector<WrittenOutput> written_;
    std::map<std::string, TexelCheck> checks_;
};

}  // namespace penumbra
