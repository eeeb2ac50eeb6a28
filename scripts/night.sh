#!/usr/bin/env bash
# Rooms that nobody has seen (the family night of docs/scenes.md): effective rays per pixel of pipelines in each, and their geometric mean
# over the first one's. Truths are kept in out/night.
#   scripts/night.sh specular 100..139 relax reflections         in motion after 17 frames, three seeds, 128x72, truth of 4096 rays
#   scripts/night.sh diffuse 100..115 relax_indirect indirect
#   scripts/night.sh lamps 100..123 light_sigma light_shadows light      each lamp by itself, frame 15 of 160x90, truth of 1024 rays
# PRESET (release) may be set; VK_DRIVER_FILES chooses the driver.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
[[ $# -ge 3 && $1 =~ ^(specular|diffuse|lamps)$ && $2 =~ ^([0-9]+)\.\.([0-9]+)$ ]] || { sed -n '2,7s/^# \?//p' "$0" >&2; exit 2; }
exec python3 - "$PWD/build/${PRESET:-release}" "$1" "${BASH_REMATCH[1]}" "${BASH_REMATCH[2]}" "${@:3}" <<'PYTHON'
import hashlib, json, math, os, shutil, subprocess, sys, tempfile

build, signal, first, last, pipelines = sys.argv[1], sys.argv[2], int(sys.argv[3]), int(sys.argv[4]), sys.argv[5:]
lamps = signal == "lamps"
frame, size, rays, seeds = (15, "160x90", "1024", [0]) if lamps else (16, "128x72", "4096", [1, 2, 3])
folder = "out/night"


def run(program, *arguments):
    done = subprocess.run([f"{build}/{program}", *arguments], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"night.sh: {program} {' '.join(arguments)}\n{done.stdout}{done.stderr}")
    return done.stdout


# Made once for the shot and what is asked of it, and whole or not there. After a change of `reference`, remove the folder.
def truth_of(shot, of):
    seen = hashlib.sha256(repr((of, size, frame, rays)).encode())
    for file in shot, shot.removesuffix(".shot.json") + ".glb":
        seen.update(open(file, "rb").read())
    truth = f"{folder}/truth/{seen.hexdigest()[:16]}"
    if not os.path.exists(truth):
        os.makedirs(f"{folder}/truth", exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder) as made:
            run("app/penumbra", "reference", *of, "--shot", shot, "--size", size, "--frames", f"{frame}..{frame}", "--rays", rays, "--out", f"{made}/truth")
            shutil.move(f"{made}/truth", truth)
    return truth


# None where there is nothing to be worth anything: no penumbra.
def n_eff(shot, pipeline, of):
    truth = truth_of(shot, of)
    images = [f"{folder}/{pipeline}_{seed}" for seed in seeds]
    for image, seed in zip(images, seeds):
        run("app/penumbra", "render", pipeline, *(of if lamps else []), "--shot", shot, "--size", size, "--frames", f"0..{frame}", "--every",
            str(frame), "--no-jitter", "--seed", str(seed), "--out", image)
    also = [word for image in images[1:] for word in ("--also", image)]
    said = json.loads(run("app/penumbra", "compare", *([] if lamps else of), images[0], truth, "--frames", f"{frame}..{frame}", *also, "--json"))
    return said["n_eff"]["value"]


def geometric(values):
    return math.exp(sum(map(math.log, values)) / len(values))


rows = []
print("| room | " + " | ".join(pipelines) + " |\n|---|" + "---|" * len(pipelines))
for seed in range(first, last + 1):
    run("host/penumbra_make_tuning_shots", "--family", "night", "--seed", str(seed), "--out", folder)
    shot = f"{folder}/night_{seed}.shot.json"
    for of in [["--light", lamp] for lamp in json.load(open(shot))["lights"]] if lamps else [["--signal", signal]]:
        found = [n_eff(shot, pipeline, of) for pipeline in pipelines]
        if None in found:
            continue
        rows.append(found)
        print(f"| {seed}{' ' + of[-1] if lamps else ''} | " + " | ".join(f"{v:.4g}" for v in found) + " |", flush=True)
if rows:
    print(f"| geometric mean of {len(rows)} | " + " | ".join(f"{geometric(column):.4g}" for column in zip(*rows)) + " |")
    print("| over the first | " + " | ".join(f"{geometric([row[i] / row[0] for row in rows]):.3g}" for i in range(len(pipelines))) + " |")
PYTHON
