#!/usr/bin/env bash
# Installs what is missing, builds everything, and runs the tests: all on the default Vulkan driver, then those labelled gpu again on
# Debian 12's own Mesa 22.3.6, unless that is the default one. Arguments go to the first ctest: `./test.sh -R Pack`.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

scripts/setup.sh --test
scripts/build.sh release
scripts/scenes.sh release

failed=0
echo "test: on the default Vulkan driver"
ctest --preset release --no-tests=error -j2 "$@" || failed=1

# A selection of tests is somebody at work on something: one driver is enough for that.
if [[ $# -eq 0 ]]; then
    version=$(dpkg-query -W -f '${Version}' mesa-vulkan-drivers 2>/dev/null || true)
    if [[ $version == 22.3.6* ]]; then
        echo "test: the installed driver is Mesa 22.3.6 already, so there is no second one to test on"
    elif manifest=$(scripts/mesa22.sh); then
        echo "test: the GPU tests on Mesa 22.3.6"
        VK_DRIVER_FILES=$manifest ctest --preset release --no-tests=error -j2 -L gpu || failed=1
        # The same driver with subgroups of 16, as wide as processors with AVX-512 hold; newer Mesa fails with them.
        if grep -q avx512f /proc/cpuinfo; then
            echo "test: classifiers with subgroups of 16 lanes"
            VK_DRIVER_FILES=$manifest LP_NATIVE_VECTOR_WIDTH=512 ctest --preset release --no-tests=error -j2 \
                -R '^(Cascades|Beams|Verdicts)\.' || failed=1
        fi
    else
        echo "test: FAILED, since the GPU tests did not run on Mesa 22.3.6" >&2
        failed=1
    fi
fi
exit $failed
