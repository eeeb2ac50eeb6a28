// SPDX-License-Identifier: MIT
#include "app/view/snapshot.h"

#include <nlohmann/json.hpp>

#include "host/json_dump.h"

namespace penumbra::viewer {

std::string snapshot_text(const Live& live, const std::map<std::string, std::array<float, 2>>& places,
                          double frames_per_second) {
    using Json = nlohmann::ordered_json;
    const auto list = [](const glm::dvec3& v) { return Json::array({v.x, v.y, v.z}); };
    Json json;
    json["pipeline"] = live.wish().pipeline;
    Json& settings = json["settings"] = live.wish().settings;
    for (const Control& control : live.stage().controls)
        if (control.changed()) settings.push_back(setting_of(control));
    json["size"] = live.size();
    json["resource"] = live.shown();
    json["beside"] = beside_names[static_cast<size_t>(live.beside())];
    const Stance& stance = live.stance();
    json["camera"] = {{"position", list(stance.camera.position)},
                      {"target", list(stance.camera.target)},
                      {"up", list(stance.camera.up)}};
    json["to_sun"] = list(stance.sun.to_sun);
    json["moment"] = stance.moment;
    json["judgement"] = nullptr;
    if (const auto judged = live.judgement()) {
        json["judgement"] = {{"rays", judged->rays}, {"n_eff", nullptr}, {"rmse", nullptr}};
        if (judged->n_eff) json["judgement"]["n_eff"] = *judged->n_eff;
        if (judged->rmse) json["judgement"]["rmse"] = *judged->rmse;
    }
    json["error"] = live.error();
    json["reloads"] = live.reloads();
    json["frames_per_second"] = frames_per_second;
    json["cpu_ms"] = live.cpu_ms();
    json["places"] = places;
    return json_dump(json, 2) + "\n";
}

}  // namespace penumbra::viewer
