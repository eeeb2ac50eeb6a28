// SPDX-License-Identifier: MIT
#include "app/mask_folder.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <charconv>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

#include "app/is_there.h"
#include "app/or_null.h"
#include "app/text_file.h"
#include "host/json_dump.h"
#include "host/shots/shot.h"
#include "penumbra/json_text.h"

namespace penumbra {

namespace fs = std::filesystem;

namespace {

using OrderedJson = nlohmann::ordered_json;

bool read_count(const Json* json, uint32_t& out) {
    if (!json || json->kind != Json::Kind::integer || !std::in_range<uint32_t>(json->integer)) return false;
    out = static_cast<uint32_t>(json->integer);
    return true;
}

bool read_size(const Json* json, std::array<uint32_t, 2>& out) {
    return json && json->kind == Json::Kind::array && json->items.size() == 2 &&
           read_count(&json->items[0], out[0]) && read_count(&json->items[1], out[1]);
}

// All or nothing: numbers of a list, into `out`.
template <class Out>
bool read_numbers(const Json* json, size_t count, Out&& out) {
    if (!json || json->kind != Json::Kind::array || json->items.size() != count) return false;
    for (size_t i = 0; i < count; ++i) {
        if (!json->items[i].is_number()) return false;
        out(i, json->items[i].real);
    }
    return true;
}

bool read_contact(const Json& json, ContactLine& out) {
    return read_numbers(json.find("from"), 2, [&](size_t i, double v) { out.from[i] = v; }) &&
           read_numbers(json.find("to"), 2, [&](size_t i, double v) { out.to[i] = v; }) &&
           read_numbers(json.find("away"), 2, [&](size_t i, double v) { out.away[i] = v; });
}

bool read_frame(const Json& json, ReferenceInfo& info) {
    const Json* contact = json.find("contact");
    uint32_t number = 0;
    if (!read_count(json.find("frame"), number) || !contact) return false;
    ReferenceFrame& frame = info.frames[number];
    if (!read_numbers(json.find("to_sun"), 3, [&](size_t i, double v) { frame.to_sun[int(i)] = v; }))
        return false;
    if (!read_numbers(json.find("jitter"), 2, [&](size_t i, double v) { frame.jitter[i] = v; })) return false;
    return contact->kind == Json::Kind::null || read_contact(*contact, frame.contact.emplace());
}

bool read_info(const Json& json, ReferenceInfo& info) {
    const Json *shot = json.find("shot"), *exact = json.find("exact"), *rays = json.find("rays"),
               *frames = json.find("frames");
    if (!shot || shot->kind != Json::Kind::string || !exact || exact->kind != Json::Kind::boolean)
        return false;
    if (!rays || !(rays->kind == Json::Kind::null || read_count(rays, info.rays.emplace()))) return false;
    if (!frames || frames->kind != Json::Kind::array) return false;
    info.shot = shot->string;
    if (const Json* light = json.find("light"); light && light->kind == Json::Kind::string)
        info.light = light->string;
    info.exact = exact->boolean;
    for (const Json& frame : frames->items)
        if (!read_frame(frame, info)) return false;
    return read_size(json.find("size"), info.size);
}

}  // namespace

void write_reference_info(const fs::path& folder, const ReferenceInfo& info) {
    OrderedJson json = {{"penumbra", 1},
                        {"shot", info.shot},
                        {"size", info.size},
                        {"exact", info.exact},
                        {"rays", or_null(info.rays)}};
    if (!info.light.empty()) json["light"] = info.light;
    json["frames"] = OrderedJson::array();
    for (const auto& [number, frame] : info.frames) {
        OrderedJson& out = json["frames"].emplace_back();
        out = {{"frame", number},
               {"to_sun", {frame.to_sun.x, frame.to_sun.y, frame.to_sun.z}},
               {"jitter", frame.jitter},
               {"contact", nullptr}};
        if (frame.contact)
            out["contact"] = {
                {"from", frame.contact->from}, {"to", frame.contact->to}, {"away", frame.contact->away}};
    }
    write_text(folder / "reference.json", json_dump(json, 2) + "\n");
}

std::optional<ReferenceInfo> read_reference_info(const fs::path& folder, Diagnostics& diagnostics) {
    const auto json = read_json(folder / "reference.json", diagnostics);
    if (!json) return std::nullopt;
    ReferenceInfo info;
    if (read_info(*json, info)) return info;
    diagnostics.add(json->place, "", "not written by `penumbra reference` of this version");
    return std::nullopt;
}

std::optional<RenderedFolder> read_rendered_frames(const fs::path& folder, Diagnostics& diagnostics) {
    const auto json = read_json(folder / "report.json", diagnostics);
    if (!json) return std::nullopt;
    RenderedFolder out;
    const Json *shot = json->find("shot_file"), *frames = json->find("by_frame");
    bool good = shot && shot->kind == Json::Kind::string && frames && frames->kind == Json::Kind::array;
    good = good && read_size(json->find("size"), out.size);
    if (good) {
        out.shot = from_folder(folder, shot->string);
        if (const Json* light = json->find("light")) out.light = light->string;
        for (const Json& frame : frames->items) {
            uint32_t number = 0;
            good = good && read_count(frame.find("frame"), number);
            if (!good) break;
            auto& jitter = out.jitter[number];
            good = read_numbers(frame.find("jitter"), 2, [&](size_t i, double v) { jitter[i] = v; });
        }
    }
    if (good) return out;
    diagnostics.add(json->place, "", "not written by `penumbra render` of this version");
    return std::nullopt;
}

void check_jitter(const fs::path& folder, const fs::path& reference, const ReferenceInfo& info,
                  const std::vector<uint32_t>& frames, Diagnostics& diagnostics) {
    if (!is_there(folder / "report.json", diagnostics)) return;
    const auto rendered = read_rendered_frames(folder, diagnostics);
    if (!rendered) return;
    for (const uint32_t frame : frames) {
        const auto truth = info.frames.find(frame);
        const auto image = rendered->jitter.find(frame);
        if (image == rendered->jitter.end()) continue;
        const auto a = image->second,
                   b = truth == info.frames.end() ? std::array<double, 2>{} : truth->second.jitter;
        if (std::abs(a[0] - b[0]) < 1e-9 && std::abs(a[1] - b[1]) < 1e-9) continue;
        const auto place = [&](const std::array<double, 2>& jitter) {
            return jitter == std::array<double, 2>{}
                       ? "pixel centres"
                       : fmt::format("points {:+.3f}, {:+.3f} pixels beside their centres",
                                     jitter[0] * info.size[0], jitter[1] * info.size[1]);
        };
        diagnostics.add({folder.string(), 0, 0}, "",
                        fmt::format("frame {} shows {}, the reference {} is of {}: make one of the same "
                                    "points with `penumbra reference --like {} --out DIR`, or render with "
                                    "--no-jitter",
                                    frame, place(a), reference.string(), place(b), folder.string()));
        return;
    }
}

namespace {

// What a light's mask may be: an image of its own, or a layer of `masks`.
std::vector<std::string> names_of_mask(const std::string& light) {
    if (light.empty()) return {"visibility"};
    return {"visibility_" + light, "masks." + light};
}

}  // namespace

fs::path visibility_file(const fs::path& folder, uint32_t frame, const std::string& light) {
    fs::path file;
    for (const std::string& mask : names_of_mask(light)) {
        file = folder / fmt::format("{}.{:04}.exr", mask, frame);
        if (std::error_code none; fs::exists(file, none)) break;
    }
    return file;
}

std::optional<FramesByImage> images_in(const fs::path& folder, Diagnostics& diagnostics) {
    constexpr std::string_view ending = ".exr";
    std::error_code failure;
    FramesByImage images;
    for (fs::directory_iterator entry(folder, failure), end; !failure && entry != end;
         entry.increment(failure)) {
        std::string name = entry->path().filename().string();
        if (!name.ends_with(ending)) continue;
        name.resize(name.size() - ending.size());
        const size_t dot = name.rfind('.');
        if (dot == std::string::npos) continue;
        uint32_t frame = 0;
        const char* const last = name.data() + name.size();
        const auto [rest, error] = std::from_chars(name.data() + dot + 1, last, frame);
        if (error == std::errc() && rest == last) images[name.substr(0, dot)].insert(frame);
    }
    if (!failure) return images;
    diagnostics.add({folder.string(), 0, 0}, "", "cannot be listed: " + failure.message());
    return std::nullopt;
}

std::optional<std::vector<uint32_t>> visibility_frames(const fs::path& folder, Diagnostics& diagnostics,
                                                       const std::string& light) {
    const auto images = images_in(folder, diagnostics);
    if (!images) return std::nullopt;
    const std::vector<std::string> masks = names_of_mask(light);
    std::set<uint32_t> frames;
    for (const std::string& mask : masks)
        if (const auto found = images->find(mask); found != images->end())
            frames.insert(found->second.begin(), found->second.end());
    if (!frames.empty()) return std::vector<uint32_t>(frames.begin(), frames.end());
    diagnostics.add({folder.string(), 0, 0}, "",
                    fmt::format("no {}.NNNN.exr in here", fmt::join(masks, ".NNNN.exr and no ")));
    return std::nullopt;
}

}  // namespace penumbra
