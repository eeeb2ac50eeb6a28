#!/usr/bin/env bash
# Installs what is missing, builds everything, and runs the tests: on the default Vulkan driver, then on Debian 12's own Mesa
# 22.3.6, unless that is the default one, and on SwiftShader what a driver may change.
#
#   ./test.sh                       what is asked in every run
#   ./test.sh --all                 everything, on both of Mesa's drivers
#   ./test.sh -R Pack               arguments for ctest: one driver is enough for somebody at work on something
#
# With PENUMBRA_ALL_DRIVERS=1 a driver that is not there is a failure.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

if [[ $# -gt 1 && " $* " == *" --all "* ]]; then
    echo "test: --all stands alone: beside it there are no arguments for ctest" >&2
    exit 2
fi
scripts/setup.sh --test
# ctest runs everything at an option that it does not know. (Read whole: grep ends at its first find, which a pipe fails by.)
known=$(ctest --help)
for option in "$@"; do
    if [[ $option == -* && $option != --all && $option != -j* ]] && ! grep -qE -- "(^|[ ,|])${option%%=*}([ ,=]|\$)" <<<"$known"; then
        echo "test: neither ctest nor this script has an option $option" >&2
        exit 2
    fi
done
scripts/build.sh release
scripts/scenes.sh release

# Two tests run at once, so that one thread each is enough for a driver that computes on the CPU, and a tenth quicker.
export LP_NUM_THREADS=${LP_NUM_THREADS:-1}
asked() { ctest --preset release --no-tests=error -j2 "$@" || failed=1; }
failed=0
if [[ $# -gt 0 && $* != --all ]]; then
    asked "$@"
    exit $failed
fi

# Longer than ten seconds each, and none of them the only one that kills a mutant of tests/source_mutants.txt.
long='Allocation\.EachMayFailInC|Accuracy\.Published|SubgroupsOf|HardCase\.ATurnedOr|HardCase\.ASunOnAnAxis|HardCase\.TheNoiseTile'
long+='|LightsBudget\.IsKeptByAll|ShadowsOfShots\.StandingStill|ReportMeasure\.(AnInterrupted|AMaskWithout)'
long+='|Drivers\.NumbersOfThreads|Denoise\.TakesRaysForSome|SchemaAndLoader\.AgreeOnWrong|CoverageTwin\.OnShippedScenes'
long+='|Recall\.ChangesWho|RadianceReport\.BruteForce|Explain\.DrawsThePixel|Denoise\.WithAllThatIsKnown'
long+='|ReportMeasure\.RowsAreWhat|CoverTwinOf\.WideSuns|CoverCases\.TwoRunsAnd|HardCase\.ASlowPan|ViewWindow\.HandsReach'
long="^($long)|/HistoryGpu\..*_(down|still)|/SoakRun\.|/Determinism\..*/lit"
# On a second driver, whose images Drivers.TwoVersionsAgree holds to the first one's: that every pipeline runs with nothing for
# validation to say, but for presets, which have the nodes of others; and what reads the tree of triangles.
second='/ValidatedPipeline\.|/RowStores\.|^(BvhGpu|CoverCases|CoverLights|CoverWatertight|CoverTwinOf|TraceBackend|TraceBackendRun|Transmit)\.'
few=(-E "$long") of_second=(-R "$second" -E "$long|/ValidatedPipeline\..*_(fast|best|still)")
if [[ $* == --all ]]; then few=() of_second=(); fi

# Before any test, since some compare two drivers; what fails here is said below.
scripts/mesa22.sh >/dev/null || true
echo "test: on the default Vulkan driver"
asked "${few[@]}"

version=$(dpkg-query -W -f '${Version}' mesa-vulkan-drivers 2>/dev/null || true)
if [[ $version == 22.3.6* && -n ${PENUMBRA_ALL_DRIVERS:-} ]]; then
    echo "test: FAILED, since the installed driver is Mesa 22.3.6 and no newer one was to be had" >&2
    failed=1
elif [[ $version == 22.3.6* ]]; then
    echo "test: the installed driver is Mesa 22.3.6 already, so there is no second one to test on"
elif manifest=$(scripts/mesa22.sh); then
    echo "test: on Mesa 22.3.6"
    VK_DRIVER_FILES=$manifest asked -L gpu "${of_second[@]}"
else
    echo "test: FAILED, since no test ran on Mesa 22.3.6" >&2
    failed=1
fi
# With a cache of their own: Mesa's would hand out shaders of 8 lanes.
echo "test: classifiers with subgroups of 4 lanes"
LP_NATIVE_VECTOR_WIDTH=128 MESA_SHADER_CACHE_DIR="$PWD/.cache/mesa_4_lanes" asked -R '^(Cascades|Beams|BeamsOn|Lanes)\.'
# SwiftShader is slow and its compiler unbounded: what its coarse grid could spoil, and the denoiser, under a limit of memory (docs/gpu.md).
if manifest=$(scripts/swiftshader.sh); then
    echo "test: on SwiftShader"
    ulimit -v 8000000
    VK_DRIVER_FILES=$manifest asked -L gpu -R '(^|/)RayStart\.|(^|/)CoverTwin\..*/(colonnade|trees)|^TerrainStart\.TheTruthFinds|^GBufferTest\.DepthIs|(^|/)BvhGpu\.|^Gather\.|^Denoise\.(ComesFrom|DoesNotShow|Believes|Leaves)'
else
    echo "test: FAILED, since no GPU test ran on SwiftShader" >&2
    failed=1
fi
exit $failed
