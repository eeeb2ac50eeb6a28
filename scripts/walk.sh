#!/usr/bin/env bash
# How steady a frame is when the camera walks, swings and cuts: rays per receiver beside the budget, and CPU milliseconds of what
# makes the mask, of every frame of a shot; a row of a Markdown table for each pipeline.
#   scripts/walk.sh shadows hybrid_shadows            # names in pipelines/, or files
# The budget is the pipeline's parameter rays_per_frame, in rays per surface that looks at the sun. Frames without history (the first one, cuts) count for
# the rays and not for the time. SHOT (scenes/walk.shot.json), SIZE (640x360), RUNS (3, pipelines in turn; of each frame the least
# time counts, as other work on the machine only adds) and PENUMBRA may be set; VK_DRIVER_FILES chooses the driver.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec python3 - "$@" <<'PYTHON'
import json, os, statistics, subprocess, sys, tempfile

penumbra = os.environ.get("PENUMBRA", "build/release/app/penumbra")
shot, size = os.environ.get("SHOT", "scenes/walk.shot.json"), os.environ.get("SIZE", "640x360")
runs = int(os.environ.get("RUNS", "3"))
pipelines = sys.argv[1:]
if not pipelines or runs < 1:
    sys.exit("usage: scripts/walk.sh PIPELINE...")


def rendered(pipeline):
    file = pipeline if os.path.exists(pipeline) else f"pipelines/{pipeline}.json"
    with tempfile.TemporaryDirectory() as out:
        done = subprocess.run([penumbra, "render", file, "--shot", shot, "--size", size, "--every", "100000", "--set",
                               'outputs=["visibility"]', "--out", out], capture_output=True, text=True)
        if done.returncode:
            sys.stderr.write(done.stderr)
            sys.exit(done.returncode)
        return json.load(open(f"{out}/report.json"))


reports = {p: [] for p in pipelines}
for _ in range(runs):
    for p in pipelines:
        reports[p].append(rendered(p))

print("| pipeline | budget | rays per receiver, least / median / most | frames over 1 % off | mask, CPU ms, median | least / most of it "
      "| frames over 20 % off |\n|---|---|---|---|---|---|---|")
for p in pipelines:
    budgets = {q["params"]["rays_per_frame"] for q in reports[p][0]["passes"] if "rays_per_frame" in (q["params"] or {})}
    if len(budgets) > 1:
        sys.exit(f"{p}: several budgets: {sorted(budgets)}")
    budget = next(iter(budgets), None)
    # Rays are the same in every run, or the pipeline is not deterministic.
    frames = reports[p][0]["by_frame"]
    for report in reports[p][1:]:
        for a, b in zip(frames, report["by_frame"]):
            if a["rays"] != b["rays"]:
                sys.exit(f"{p}: frame {a['frame']} took {a['rays']} rays in one run and {b['rays']} in another")
    seen = [f for f in frames if f["receivers"]]
    rays = [(f["rays"] or 0) / (f["sunward"] or f["receivers"]) for f in seen]  # without a budget, of all surfaces
    over = "-" if budget is None else f"{sum(abs(r / budget - 1) > .01 for r in rays)} of {len(rays)}"
    least = [min(run["by_frame"][i]["mask_cpu_ms"] for run in reports[p]) for i in range(len(frames))]
    ms = [t for t, f in zip(least, frames) if not f["reset"]]
    middle = statistics.median(ms)
    print(f"| {p} | {'-' if budget is None else format(budget, 'g')} | "
          + (f"{min(rays):.4g} / {statistics.median(rays):.4g} / {max(rays):.4g}" if rays else "-")
          + f" | {over} | {middle:.1f} | {min(ms) / middle:.2f} / {max(ms) / middle:.2f} | "
          f"{sum(abs(t / middle - 1) > .2 for t in ms)} of {len(ms)} |", flush=True)
PYTHON
