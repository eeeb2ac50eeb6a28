#!/usr/bin/env bash
# Speed against error of masks in motion, as a Markdown table: per shot and contender CPU milliseconds of what makes the mask (proofs,
# coverage, rays, denoiser) / effective samples per pixel over all receivers of frame FRAME.
#   scripts/compare_coverage.sh
# SHOTS, CONTENDERS (names below), FRAME (15), SIZE (640x360), RAYS (1024, of the reference), RUNS (3, the contenders in turn: of
# each pass the least median counts, as other work on the machine only adds) and PENUMBRA may be set; VK_DRIVER_FILES chooses the
# driver. The last rows of a run say what a native pass cost (tests/native_pass.h).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
exec python3 - "$@" <<'PYTHON'
import json, os, subprocess, sys, tempfile

penumbra = os.environ.get("PENUMBRA", "build/release/app/penumbra")
size, frame = os.environ.get("SIZE", "640x360"), os.environ.get("FRAME", "15")
rays, runs = os.environ.get("RAYS", "1024"), int(os.environ.get("RUNS", "3"))
shots = os.environ.get("SHOTS", "cards colonnade engine fan heightfield lamp trees").split()
samples = lambda n: ["--set", f"nodes.cover.params.samples={n}"]
per_pixel = lambda n: ["--set", f"nodes.trace.params.rays_per_pixel={n}"]
known = {
    "1 ray": ("raw", []),
    "16 rays": ("many_rays", []),
    "64 rays": ("many_rays", per_pixel(64)),
    "published": ("fidelityfx", []),
    "shadows": ("shadows", []),
    "coverage 64": ("covered", samples(64)),
    "coverage 128": ("covered", []),
    "coverage 256": ("covered", samples(256)),
    "hybrid_shadows": ("hybrid_shadows", []),
}
names = [n for n in os.environ.get("CONTENDERS", ",".join(known)).split(",") if n]
unknown = [n for n in names if n not in known]
if unknown:
    sys.exit(f"compare_coverage.sh: no contender {unknown[0]!r}; there are {', '.join(known)}")
counted = "beams cover trace prepare gather drift soften tileclass filter".split()


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(command)}\n{done.stdout}{done.stderr}")
    return done.stdout


print("| shot | " + " | ".join(names) + " |\n|---|" + "---|" * len(names))
with tempfile.TemporaryDirectory() as work:
    for shot in shots:
        file = f"scenes/{shot}.shot.json"
        run(penumbra, "reference", "--shot", file, "--size", size, "--frames", frame, "--rays", rays, "--out", f"{work}/truth")
        cost, error = {}, {}
        for _ in range(runs):
            for name in names:
                pipeline, settings = known[name]
                run(penumbra, "render", f"pipelines/{pipeline}.json", "--shot", file, "--size", size, "--frames", f"{frame}..{frame}",
                    "--no-jitter", "--set", 'outputs=["visibility"]', *settings, "--out", f"{work}/image")
                for p in json.load(open(f"{work}/image/report.json"))["passes"]:
                    if p["type"] in counted:
                        key = name, p["node"]
                        cost[key] = min(cost.get(key, 1e9), p["cpu_ms"]["median"])
                error[name] = json.loads(run(penumbra, "compare", f"{work}/image", f"{work}/truth", "--frames", frame, "--json"))["n_eff"]["value"]
        total = {n: sum(ms for (name, _), ms in cost.items() if name == n) for n in names}
        worth = {n: "exact" if e is None else f"{e:.3g}" for n, e in error.items()}  # no noise beyond the truth's own
        print(f"| {shot} | " + " | ".join(f"{total[n]:.0f} / {worth[n]}" for n in names) + " |", flush=True)
build = os.path.join(os.path.dirname(penumbra), "..")
if os.path.exists(f"{build}/build.ninja"):
    subprocess.run(["ninja", "-C", build, "native_pass_bench"], stdout=sys.stderr)  # built without tests there is none
bench = f"{build}/tests/native_pass_bench"
if os.path.exists(bench):
    print(f"\nA native pass: {float(run(bench, size)):.2f} ms")
PYTHON
