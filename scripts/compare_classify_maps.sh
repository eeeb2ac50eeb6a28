#!/usr/bin/env bash
# What the sun's shadow maps spare, and what they get wrong: the same rays traced with and without a classifier before
# them, on every shipped shot. Prints a table. Environment: SIZE (default 320x180), FRAMES (how many are compared, default 4),
# CASCADE (texels, default 1024), RADII (degrees, default "0.25 1"), SHOTS, PENUMBRA (the program).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
program=${PENUMBRA:-build/release/app/penumbra}
size=${SIZE:-320x180} frames=${FRAMES:-4} cascade=${CASCADE:-1024}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

for shot in ${SHOTS:-colonnade engine fan heightfield lamp trees}; do
    for radius in ${RADII:-0.25 1}; do
        # The shot with another sun, beside the original so that its model is found.
        variant="scenes/.maps_$$.shot.json"
        sed -E "s/(\"angular_radius_deg\": *)[0-9.]+/\1$radius/" "scenes/$shot.shot.json" > "$variant"
        for pipeline in raw hybrid_cascades_raw hybrid_published_raw; do
            "$program" render "pipelines/$pipeline.json" --shot "$variant" --out "$work/$pipeline" --size "$size" \
                --frames "0..$((frames - 1))" --cascade-size "$cascade" > /dev/null 2> "$work/log" || { cat "$work/log" >&2; rm "$variant"; exit 1; }
        done
        rm "$variant"
        python3 - "$work" "$shot" "$radius" <<'PYTHON'
import glob, json, os, sys, zlib, struct
work, shot, radius = sys.argv[1:]

def pixels(path):  # 8-bit greyscale PNG
    data, at, packed = open(path, "rb").read(), 8, b""
    while at < len(data):
        n, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IHDR": w, h, depth, colour = struct.unpack(">IIBB", data[at + 8:at + 18])
        if kind == b"IDAT": packed += data[at + 8:at + 8 + n]
        at += 12 + n
    channels = {0: 1, 2: 3, 4: 2, 6: 4}[colour]
    raw, rows, before = zlib.decompress(packed), [], bytearray(w * channels)
    for y in range(h):
        kind, row = raw[y * (w * channels + 1)], bytearray(raw[y * (w * channels + 1) + 1:(y + 1) * (w * channels + 1)])
        for i in range(len(row)):
            a, b, c = (row[i - channels] if i >= channels else 0), before[i], (before[i - channels] if i >= channels else 0)
            p = a + b - c
            near = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            row[i] = (row[i] + (0, a, b, (a + b) // 2, near)[kind]) & 255
        rows.append(bytes(row[::channels])); before = row
    return b"".join(rows)

def report(name): return json.load(open(f"{work}/{name}/report.json"))
def cpu(r, *types): return sum(p["cpu_ms"]["median"] for p in r["passes"] if p["type"] in types)
raw = report("raw")
base = raw["counts"]["receivers"]
for name in ("hybrid_cascades_raw", "hybrid_published_raw"):
    r, wrong, total = report(name), 0, 0
    for path in glob.glob(f"{work}/raw/visibility.*.png"):
        a, b = pixels(path), pixels(f"{work}/{name}/{os.path.basename(path)}")
        wrong += sum(x != y for x, y in zip(a, b)); total += base
    maps = r["cascades"]["cpu_ms"]
    drawn = f'{maps["drawn"]:.0f}' if maps["drawn"] is not None else "-"
    kept = f'{maps["kept"]:.2f}' if maps["kept"] is not None else "-"
    print(f'| {shot} | {radius} | {name} | {100 * raw["counts"]["rays"] / base:.1f} | {100 * r["counts"]["rays"] / base:.1f} '
          f'| {wrong / total:.1e} | {cpu(raw, "classify", "trace"):.1f} | {cpu(r, "classify", "cascades", "cascade_taps", "trace"):.1f} '
          f'| {cpu(r, "cascade_pyramid"):.1f} | {drawn} | {kept} |', flush=True)
PYTHON
    done
done
