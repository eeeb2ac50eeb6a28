// SPDX-License-Identifier: MIT
// Plans with one thing wrong: a dependency dropped, an activation dropped, unordered or unseen, a lifetime
// cut by a pass. What holds plans to their word has to notice each of them.
#pragma once

#include <string>
#include <vector>

#include "penumbra/plan.h"

namespace penumbra::test {

enum class Fault : uint8_t {
    dependency_dropped,     // before a pass; its activations stay
    clear_unordered,        // between a pass's clears and its shader
    end_dropped,            // before the host reads outputs
    activation_dropped,     // the image keeps its last layout
    activation_unordered,   // does not wait for what used the memory before
    activation_unseen,      // not visible to the first use
    lifetime_short,         // ends a pass early, in a plan whose memory stays as it is
    lifetime_short_packed,  // the same, and the memory is given to others
};
const char* name_of(Fault fault);

struct Mutant {
    Fault fault;
    std::string what;  // "filter0, parity 1"
    Plan plan;
};

// Every mutant of the plan, of both parities. `device` is what the plan was compiled for.
std::vector<Mutant> mutants(const Plan& plan, const DeviceTable& device);

}  // namespace penumbra::test
