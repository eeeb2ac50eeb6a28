// SPDX-License-Identifier: MIT
// What has been measured of a report, a file per shot and per edge in the report's folder, so that a long run
// may end at any time and go on later. A part is used again only where everything that could change it is the
// same: the program, the device and its driver, the study, the contenders and what they extend, folders of
// nodes, the shot and its scene; and where its images are still there.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "app/report/results.h"
#include "host/shots/shot.h"

namespace penumbra::report {

class Parts {
  public:
    // `results` has the study, the device and the contenders already. Throws FileError where a file of the
    // contenders or the nodes cannot be read.
    Parts(std::filesystem::path folder, const Results& results, const std::vector<std::string>& node_folders);

    // "shot.fan", "edge.16px_+0.25"; a key of all that the part depends on, with the shots as they are on
    // disk.
    struct Name {
        std::string name, key;
    };
    Name name(std::string name, const std::vector<Shot>& shots) const;

    // to_json() of results with this part alone; nothing where there is no such part or its images are gone.
    std::optional<nlohmann::ordered_json> find(const Name& part) const;
    // An older part of this name, and its images, are no longer whole once this one is being measured.
    void forget(const Name& part) const;
    // Whole or not at all.
    void keep(const Name& part, const nlohmann::ordered_json& json) const;

  private:
    std::filesystem::path file(const Name& part) const;
    // find() of a file that is there; throws where it is another's.
    std::optional<nlohmann::ordered_json> whole_part(const Name& part) const;

    std::filesystem::path folder_;
    std::string common_;  // what all parts depend on
};

}  // namespace penumbra::report
