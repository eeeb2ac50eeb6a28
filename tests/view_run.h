// SPDX-License-Identifier: MIT
// One view whose host inputs a test fills itself: nodes run alone on images that no renderer would give, with
// the workgroup shapes of either device class. The free functions read what any view captured.
#pragma once

#include <array>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "host/device/gpu.h"
#include "host/images/texels.h"
#include "penumbra/graph.h"

namespace penumbra::test {

// Checked against the shadow nodes; throws with the diagnostics where the text is wrong.
CheckedPipeline shadow_pipeline(std::string_view text);

// The shipped node types and those in tests/nodes.
const NodeSet& test_nodes();

struct ViewRunOptions {
    bool cpu = true;  // which device class's workgroup shapes
    bool alias = true;
    Facts facts;
    bool jitters = false;  // its frames, whatever nodes ask for
    std::optional<uint32_t> poison = 0;
    std::map<std::string, Format>
        formats;                        // of the host images; absent: the first format that the nodes accept
    std::vector<std::string> captures;  // besides the outputs
    std::map<std::string, Extent> arrays;  // host images that are arrays of one layer, with their size
};

class ViewRun {
  public:
    ViewRun(const CheckedPipeline& pipeline, Extent extent, const ViewRunOptions& options);

    // What a host slot holds from the next frame on: an image's or a texel buffer's texels, a buffer's or a
    // block's bytes.
    void set(const std::string& slot, std::span<const std::byte> bytes);
    template <class T>
    void set(const std::string& slot, const std::vector<T>& values) {
        set(slot, std::as_bytes(std::span(values)));
    }

    void frame(const FrameDescription& frame);  // records, submits and waits
    View& view() { return *view_; }

  private:
    struct Input {
        GpuImage image;
        GpuBuffer buffer;
        GpuTexels texels;
    };
    std::unique_ptr<View> view_;
    std::map<std::string, Extent> arrays_;
    std::map<std::string, Input> inputs_;
};

// A camera at `position` that looks along world -z, turned by `yaw_rad` about y, with an infinite reverse-Z
// perspective.
Camera camera_at(std::array<double, 3> position, double yaw_rad, Extent extent);
FrameDescription frame_between(const Camera& previous, const Camera& current, Extent extent, uint32_t index,
                               bool reset);

template <class T>
std::vector<T> captured(const View& view, const std::string& name) {
    const auto bytes = view.captured(name);
    std::vector<T> values(bytes.size() / sizeof(T));
    std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
    return values;
}

// The first planes of a captured image, as numbers.
std::vector<std::vector<float>> captured_planes(const View& view, const std::string& name);

// A pass's counters by name, of the last frame.
std::map<std::string, uint32_t> counters_of(const View& view, const std::string& node);

// How far the device's linear filter may move a coordinate: a CPU device rounds like any arithmetic in single
// precision, others keep as many fractional bits as they say.
double sampler_error_px();

// Numbers as rgba16f texels and back, and the distance between neighbouring fp16 numbers around x (2^-24
// below 2^-14).
std::array<uint16_t, 4> to_half4(const std::array<double, 4>& v);
float from_half(uint16_t bits);
double half_ulp(double x);

}  // namespace penumbra::test
