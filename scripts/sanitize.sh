#!/usr/bin/env bash
# The tests under address and undefined-behaviour sanitisers, by clang:
#
#   scripts/sanitize.sh [PROGRAM...]     all that are below, or those named
#
# Every run of the tests has a part of it already (tests/sanitized.cmake). Leaks count, but for those of drivers and
# libraries that tests/leaks.supp names.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

scripts/setup.sh --test
scripts/setup.sh --dev
export ASAN_OPTIONS=detect_leaks=1 LSAN_OPTIONS=suppressions=$PWD/tests/leaks.supp:print_suppressions=0
export UBSAN_OPTIONS=print_stacktrace=1
# Left out: what takes minutes under them (searches for packings, every change of every schema's documents), what preloads an
# operator new or Vulkan's functions, where the sanitiser's own come first, what limits the address space, and what asks how much
# is resident, which counts what it keeps of freed memory. The validation layer, Mesa 22 and RADV without
# hardware keep memory that nobody can name any more where the program has unloaded them.
declare -A left_out=(
    [graph_test]='Pack.*:Optimum.*:*HeapIsWithin*:House*:*PlanMutation*:*reflections*:*indirect*'
    [robustness_test]='CliRobustness.AnAllocation*:CliRobustness.AFileThat*:CliRobustness.APlanTakes*'
    [host_test]=''
    [app_test]='SchemaAndLoader.AgreeOnWrongTypes*:*Statics*'
    [graph_gpu_test]='FaultsGpu.ManyGraphs*'
    [rays_test]=''
    [denoiser_test]=''
    [reflections_test]=''
    [app_gpu_test]='RenderFaults*:CliRender.Validate*:ViewWindow.ItEndsByItself*:ViewWindow.HeadlessIs*:Drivers.TwoVersions*'
    [hard_cases_test]=''
)
programs=("$@")
[[ ${#programs[@]} -gt 0 ]] ||
    programs=(graph_test robustness_test host_test app_test graph_gpu_test rays_test denoiser_test reflections_test app_gpu_test hard_cases_test)
cmake --preset sanitize
cmake --build --preset sanitize --target "${programs[@]}"
failed=0
for program in "${programs[@]}"; do
    build/sanitize/tests/"$program" --gtest_brief=1 --gtest_filter="-${left_out[$program]}" || failed=1
done
exit $failed
