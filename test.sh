#!/usr/bin/env bash
# Installs what is missing, builds everything, and runs the tests: all on the default Vulkan driver, then most of those labelled gpu again on
# Debian 12's own Mesa 22.3.6, unless that is the default one, and some of them on SwiftShader. Arguments go to the first ctest: `./test.sh -R Pack`.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

scripts/setup.sh --test
scripts/build.sh release
scripts/scenes.sh release

# Before any test, since some compare two drivers; what fails here is said below.
if [[ $# -eq 0 ]]; then scripts/mesa22.sh >/dev/null || true; fi

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
        # Two things were asked above and are not asked again: what the program does around its frames; and how good images are
        # over many frames, or whether one device gives one twice, since Drivers.TwoVersionsAgree holds images to the newer driver's.
        # `VK_DRIVER_FILES=$(scripts/mesa22.sh) ctest --preset release -j2 -L gpu` asks all.
        around='Cli|CliRender|Drivers|Explain|FirstSteps|FirstUse|RadianceReport|RenderFaults|ReportMeasure|View(Live|Window)'
        judged='Accuracy|Budget|Denoise|Gather|LampGather|LampsAtHits|LightsBudget|LitPicture|RadianceGates|Recall|Shadows|ShadowsOfShots|SparseRays'
        twice='AccuracyGate|AnalyticReference|HistoryGpu|PlanJsonGpu|SizeGpu|SoakRun|ValidatedPipeline|ValidatedShots'
        VK_DRIVER_FILES=$manifest ctest --preset release --no-tests=error -j2 -L gpu -E "^($around|$judged)\.|/($twice)\." || failed=1
        # Both drivers with subgroups of 4, and a cache of their own: Mesa's would hand out shaders of 8.
        echo "test: classifiers with subgroups of 4 lanes"
        four=(env LP_NATIVE_VECTOR_WIDTH=128 MESA_SHADER_CACHE_DIR="$PWD/.cache/mesa_4_lanes"
            ctest --preset release --no-tests=error -j2 -R '^(Cascades|Beams|BeamsOn|Lanes)\.')
        "${four[@]}" || failed=1
        VK_DRIVER_FILES=$manifest "${four[@]}" || failed=1
    else
        echo "test: FAILED, since the GPU tests did not run on Mesa 22.3.6" >&2
        failed=1
    fi
    # SwiftShader is slow and its compiler unbounded: what its coarse grid could spoil, under a limit of memory (docs/gpu.md).
    if manifest=$(scripts/swiftshader.sh); then
        echo "test: GPU tests on SwiftShader"
        (ulimit -v 8000000 && VK_DRIVER_FILES=$manifest ctest --preset release --no-tests=error -j2 -L gpu \
            -R '(^|/)RayStart\.|^GBufferTest\.DepthIs') || failed=1
    else
        echo "test: FAILED, since no GPU test ran on SwiftShader" >&2
        failed=1
    fi
fi
exit $failed
