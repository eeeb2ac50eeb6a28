// SPDX-License-Identifier: MIT
//   record_inputs PIPELINE WIDTH HEIGHT FRAMES FOLDER
// PIPELINE is a name in pipelines/. See recording.h.
#include <cstdlib>
#include <iostream>

#include "tests/gpu_test.h"
#include "tests/recording.h"
#include "tests/shipped.h"

int main(int argc, char** argv) {
    using namespace penumbra::test;
    if (argc != 6) {
        std::cerr << "usage: record_inputs PIPELINE WIDTH HEIGHT FRAMES FOLDER\n";
        return 2;
    }
    try {
        const auto number = [&](int i) { return static_cast<uint32_t>(std::stoul(argv[i])); };
        record_plaza(shipped_pipeline(argv[1]), {number(2), number(3)}, number(4), argv[5]);
    } catch (const std::exception& e) {
        std::cerr << "record_inputs: " << e.what() << "\n";
        return 1;
    }
    for (const std::string& message : gpu().messages()) std::cerr << message << "\n";
    return gpu().message_count() ? 1 : 0;
}
