#!/usr/bin/env bash
# Judges settings and constants on the tuning shots (docs/scenes.md), which no report shows: effective samples per pixel, root
# mean square error and CPU milliseconds of the mask, per shot and in the mean.
#   scripts/tune.sh                                    pipelines/shadows_fast.json as it is
#   scripts/tune.sh 'few: --constant FEWEST=1.5' 'wide: --set nodes.gather.params.radius=5' 'covered: pipelines/covered.json'
#   scripts/tune.sh --constants [NAME...]              halves and doubles the numbers of docs/constants.md, with the pipeline that each
#                                                      table there names, and writes there what that does (all of them, or those named)
#   scripts/tune.sh --values                           reads the values there from the files; changes nothing else
# A contender is NAME: OPTIONS, where an option is another pipeline, `--constant NAME=VALUE` (of docs/constants.md, also one of a
# shader) or one of `penumbra render`'s, as --set or --nodes. The pipeline as it is comes first and is what ratios are over.
# Columns: first = frame 0, without a past; moving = frames 4 to 28 (--constants: 8, 16, 24), harmonic mean; still = frame 31 of the
# same shot with nothing that moves. Over shots: geometric mean. CPU milliseconds: of all passes but the guides.
# FOLDER (scenes/tuning; held-out shots of another seed lie in one of yours), SHOTS (a pattern, '*'), SIZE (320x180), SEEDS ("0"),
# RAYS (512, of the reference, which is kept in out/tuning), PIPELINE (pipelines/shadows_fast.json; of --constants, instead of those that the
# tables name), OPTIONS (for all contenders), TABLE (docs/constants.md), JOBS (2, of --constants, which measures no time), PRESET (release) and PENUMBRA may be set; VK_DRIVER_FILES
# chooses the driver.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
preset=${PRESET:-release}
make=build/$preset/host/penumbra_make_tuning_shots
for shot in scenes/tuning/*.shot.json; do
    if [[ ! -f ${shot%.shot.json}.glb || $make -nt ${shot%.shot.json}.glb ]]; then
        "$make" --out scenes/tuning >/dev/null
        break
    fi
done
exec python3 - "$@" <<'PYTHON'
import concurrent.futures, glob, hashlib, json, math, os, re, shlex, shutil, subprocess, sys, tempfile

preset = os.environ.get("PRESET", "release")
penumbra = os.environ.get("PENUMBRA", f"build/{preset}/app/penumbra")
size, rays = os.environ.get("SIZE", "320x180"), os.environ.get("RAYS", "512")
base_pipeline = os.environ.get("PIPELINE", "pipelines/shadows_fast.json")
table_file = os.environ.get("TABLE", "docs/constants.md")
seeds = os.environ.get("SEEDS", "0").split()
every, last, still_frame = (8, 24, 31) if "--constants" in sys.argv else (4, 28, 31)
apart = {"guides", "capture"}  # passes that make no mask
folder_of_shots = os.environ.get("FOLDER", "scenes/tuning")
shots = sorted(os.path.basename(f)[:-len(".shot.json")] for f in glob.glob(f"{folder_of_shots}/" + os.environ.get("SHOTS", "*") + ".shot.json"))
if not shots:
    sys.exit("tune.sh: no shot is left; SHOTS is a pattern of names in " + folder_of_shots)
exact = 1e4  # what an error below the truth's own counts as


def run(*command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{shlex.join(command)}\n{done.stdout}{done.stderr}")
    return done.stdout


# The table of constants. Its first columns are name, file and value. A name is that of a constant or of a node's parameter
# (node.parameter), or a piece of the shader's text with the number in [[ ]]. A line "Measured with `FILE.json`" above a table names the
# pipeline that its numbers are halved and doubled in.
COLUMNS = ["first", "moving", "still"]


class Constant:
    def __init__(self, line, pipeline=None):
        self.pipeline = pipeline
        self.cells = [c.strip() for c in re.split(r"(?<!\\)\|", line.strip())[1:-1]]
        self.name, self.file, self.value = (c.strip("`").replace("\\|", "|") for c in self.cells[:3])

    def is_parameter(self):
        return self.file.endswith(".json")

    def is_measured(self):
        return len(self.cells) == 7

    def path(self):
        return ("nodes/" if self.is_parameter() else "shaders/") + self.file

    def pattern(self):
        if "[[" in self.name:
            before, number, after = re.fullmatch(r"(.*)\[\[(.*)\]\](.*)", self.name).groups()
            return re.compile("(" + re.escape(before) + r")([^\s,;()]+?)(" + (re.escape(after) or r"(?![\w.])") + ")")
        return re.compile(r"(\b" + re.escape(self.name) + r"(?:\[\w*\])? = )((?:[^,;(]|\([^)]*\))+)([,;])")

    def now(self):
        text = open(self.path()).read()
        if self.is_parameter():
            return json.dumps(json.loads(text)["params"][self.name.split(".", 1)[1]]["default"])
        found = self.pattern().findall(text)
        if len(found) != 1:
            sys.exit(f"tune.sh: {table_file}: {self.name} is found {len(found)} times in {self.path()}, not once")
        return found[0][1]

    def whole(self):
        if self.is_parameter():
            return json.load(open(self.path()))["params"][self.name.split(".", 1)[1]]["type"] in ("int", "uint")
        return re.fullmatch(r"\d+u?", self.now()) is not None

    def times(self, factor):
        now = self.now()
        if self.whole():
            number = max(1, round(int(now.rstrip("u")) * factor))
            return str(number) + ("u" if now.endswith("u") else "")
        if self.is_parameter():
            return repr(float(now) * factor)
        array = re.fullmatch(r"(float\[\w*\])\((.*)\)", now)
        if array:
            return f"{array[1]}({', '.join(f'{factor} * ({x.strip()})' for x in array[2].split(','))})"
        return f"{factor} * ({now})"

    def change(self, copy, value):
        text = open(copy).read()
        open(copy, "w").write(self.pattern().sub(lambda m: m[1] + value + m[3], text))


def constants():
    rows, pipeline = [], None
    for line in open(table_file):
        said = re.match(r"Measured with `([^`]*\.json)`", line)
        pipeline = said[1] if said else pipeline
        if re.match(r"\| `", line) and len(Constant(line).cells) > 3:  # a table of other things has no more
            rows.append(Constant(line, os.environ.get("PIPELINE", pipeline)))
            if rows[-1].is_measured() and rows[-1].pipeline is None:
                sys.exit(f'tune.sh: {table_file}: no line "Measured with `FILE.json`" comes before the table with {rows[-1].name}')
    return rows


# The files that a shader includes, itself included, as paths below shaders/.
def included(file):
    found, ahead = set(), [file]
    while ahead:
        at = ahead.pop()
        if at not in found and os.path.exists(f"shaders/{at}"):
            found.add(at)
            ahead += re.findall(r'^#include "(.*)"', open(f"shaders/{at}").read(), re.M)
    return found


# Fills a folder with copies of the pipeline's node types that have one of these constants, changed, and says what to tell
# `render`. The copies have names of their own, for a type that ships is not to be replaced.
def changed_nodes(folder, pipeline, changes):
    options = ["--nodes", folder]
    for group in os.listdir("shaders"):
        shutil.copytree(f"shaders/{group}", f"{folder}/{group}")
    for constant, value in changes:
        constant.change(f"{folder}/{constant.file}", value)
    for table in glob.glob(f"build/{preset}/nodes/tables/*.bin"):
        shutil.copy(table, folder)
    for name, node in flattened(pipeline).items():
        kind = node["type"]
        for declaration in glob.glob(f"nodes/*/{kind}.json"):
            shader = f"{os.path.basename(os.path.dirname(declaration))}/{kind}.comp"
            if included(shader).isdisjoint(constant.file for constant, _ in changes):
                continue
            body = json.load(open(declaration))
            body["node"], body["shader"] = f"{kind}_changed", f"{kind}_changed.comp"
            json.dump(body, open(f"{folder}/{kind}_changed.json", "w"))
            shutil.copy(f"shaders/{shader}", f"{folder}/{kind}_changed.comp")
            for constant, value in changes:
                if constant.file == shader:
                    constant.change(f"{folder}/{kind}_changed.comp", value)
            options += ["--set", f'nodes.{name}.type="{kind}_changed"']
    if "--set" not in options:
        raise RuntimeError(f"{pipeline} has no node with {', '.join(c.name for c, _ in changes)}, so nothing changes")
    return options


class Contender:
    def __init__(self, text, pipeline=base_pipeline):
        if ":" not in text:
            sys.exit(f"tune.sh: \"{text}\": a contender is NAME: OPTIONS")
        self.name, options = (part.strip() for part in text.split(":", 1))
        self.pipeline, self.options, changes = pipeline, shlex.split(os.environ.get("OPTIONS", "")), []
        words = iter(shlex.split(options))
        for word in words:
            if word == "--constant":
                changes.append(next(words, ""))
            elif word.endswith(".json") and not word.startswith("-") and not self.options[-1:] == ["--set"]:
                self.pipeline = word
            else:
                self.options.append(word)
        known = {}
        for c in constants() if changes else []:
            known[f"{c.file}:{c.name}"] = known[c.name] = c
        in_shaders = []
        for change in changes:
            name, _, value = change.rpartition("=") if "[[" in change else change.partition("=")
            if name not in known or not value:
                sys.exit(f"tune.sh: {self.name}: --constant {change}: {table_file} has no such constant, or no value is given")
            if known[name].is_parameter():
                self.options += parameter(known[name], self.pipeline, value)
            else:
                in_shaders.append((known[name], value))
        if in_shaders:
            self.options += changed_nodes(tempfile.mkdtemp(dir=work), self.pipeline, in_shaders)


# What to tell `render`; an error where the pipeline has no such node.
def parameter(constant, pipeline, value):
    node = constant.name.split(".")[0]
    nodes = [n for n, body in flattened(pipeline).items() if body.get("type") == node]
    if not nodes:
        raise RuntimeError(f"{pipeline} has no node of type {node}, so {constant.name} changes nothing")
    return [word for n in nodes for word in ("--set", f"nodes.{n}.params.{constant.name.split('.', 1)[1]}={value}")]


def flattened(file):
    body = json.load(open(file))
    nodes = flattened(os.path.join(os.path.dirname(file), body["extends"])) if "extends" in body else {}
    for name, node in body.get("nodes", {}).items():
        if node is None:
            nodes.pop(name, None)
        else:
            nodes[name] = {**nodes.get(name, {}), **node}
    return nodes


def first_keys_only(value):
    if isinstance(value, dict):
        return {k: v[:1] if k == "keys" else first_keys_only(v) for k, v in value.items()}
    return value


# The shot as a file, moving or still.
def shot_file(shot, still):
    if not still:
        return f"{folder_of_shots}/{shot}.shot.json"
    body = first_keys_only(json.load(open(f"{folder_of_shots}/{shot}.shot.json")))
    body["scene"] = os.path.abspath(f"{folder_of_shots}/{shot}.glb")
    file = f"{work}/{shot}.still.shot.json"
    with open(file, "w") as out:
        json.dump(body, out)
    return file


def truth(shot, frame, still):
    seen = hashlib.sha256(open(f"{folder_of_shots}/{shot}.glb", "rb").read() + open(f"{folder_of_shots}/{shot}.shot.json", "rb").read())
    folder = f"out/tuning/{seen.hexdigest()[:16]}-{size}-{rays}-{'still' if still else frame}"
    if not os.path.exists(folder):
        made = tempfile.mkdtemp(dir=work)
        run(penumbra, "reference", "--shot", files[shot, still], "--size", size, "--frames", f"{frame}..{frame}", "--rays", rays, "--out", made)
        os.makedirs("out/tuning", exist_ok=True)
        try:
            shutil.move(made, folder)
        except FileExistsError:
            pass
    return folder


def compared(image, shot, frame, still):
    said = json.loads(run(penumbra, "compare", image, truth(shot, frame, still), "--frames", f"{frame}..{frame}", "--json"))
    value = said["n_eff"]["value"]
    return min(exact, exact if value is None else value), said["rmse"]["all"]


def harmonic(values):
    return len(values) / sum(1 / max(v, 1e-9) for v in values)


def geometric(values):
    return math.exp(sum(math.log(max(v, 1e-9)) for v in values) / len(values))


# {first, moving, still: N_eff; rmse, ms} of a contender on a shot.
def measured(contender, shot):
    values, errors, ms = {c: [] for c in COLUMNS}, [], 0
    for seed in seeds:
        for still in (False, True):
            with tempfile.TemporaryDirectory(dir=work) as image:
                frames = ["--frames", f"{still_frame}..{still_frame}"] if still else ["--frames", f"0..{last}", "--every", str(every)]
                run(penumbra, "render", contender.pipeline, "--shot", files[shot, still], "--size", size, "--seed", seed, *frames,
                    "--no-jitter", "--set", 'outputs=["visibility"]', *contender.options, "--out", image)
                if still:
                    values["still"].append(compared(image, shot, still_frame, True)[0])
                    continue
                for frame in range(0, last + 1, every):
                    n_eff, rmse = compared(image, shot, frame, False)
                    values["first" if frame == 0 else "moving"].append(n_eff)
                    if frame:
                        errors.append(rmse)
                passes = json.load(open(f"{image}/report.json"))["passes"]
                ms = sum(p["cpu_ms"]["median"] for p in passes if p["type"] not in apart)
    found = {c: harmonic(v) for c, v in values.items()}
    return {**found, "rmse": math.sqrt(sum(e * e for e in errors) / len(errors)), "ms": ms}


def over_shots(contender, jobs):
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        return dict(zip(shots, pool.map(lambda shot: measured(contender, shot), shots)))


def mean(results, column):
    return geometric([r[column] for r in results.values()])


def cell(r):
    return f"{r['first']:.3g} / {r['moving']:.3g} / {r['still']:.3g} / {1000 * r['rmse']:.1f} / {r['ms']:.1f}"


def judge(contenders):
    print("N_eff first / moving / still / RMSE moving in thousandths / CPU ms\n")
    print("| shot | " + " | ".join(c.name for c in contenders) + " |\n|---|" + "---|" * len(contenders))
    every_result = {c.name: {} for c in contenders}
    for shot in shots:
        for c in contenders:
            every_result[c.name][shot] = measured(c, shot)
        print(f"| {shot} | " + " | ".join(cell(every_result[c.name][shot]) for c in contenders) + " |", flush=True)
    means = {n: {k: mean(r, k) for k in [*COLUMNS, "rmse", "ms"]} for n, r in every_result.items()}
    print("| mean | " + " | ".join(cell(means[c.name]) for c in contenders) + " |")
    first = every_result[contenders[0].name]
    for c in contenders[1:]:
        said = []
        for column in COLUMNS:
            ratio = means[c.name][column] / means[contenders[0].name][column]
            worst, at = min((geometric([every_result[c.name][s][column] / first[s][column] for s in shots if s.rsplit("_", 1)[0] == f]), f)
                            for f in {s.rsplit("_", 1)[0] for s in shots})
            said.append(f"{column} {100 * ratio - 100:+.1f} % (worst family: {at} {100 * worst - 100:+.1f} %)")
        print(f"\n{c.name} over {contenders[0].name}: " + ", ".join(said))


# Of each constant the three means' change, at half and at double.
def sensitivity(names):
    rows, jobs = constants(), int(os.environ.get("JOBS", "2"))
    for name in names:
        if name not in [r.name for r in rows if r.is_measured()]:
            sys.exit(f"tune.sh: {table_file} has no such row with columns for half and double: {name}")
    bases = {}
    families = sorted({s.rsplit("_", 1)[0] for s in shots})
    for row in rows:
        if not row.is_measured() or names and row.name not in names:
            continue
        if row.pipeline not in bases:
            bases[row.pipeline] = over_shots(Contender("base:", row.pipeline), jobs)
            means = ", ".join(f"{c} {mean(bases[row.pipeline], c):.4g}" for c in COLUMNS)
            print(f"{row.pipeline} as it is: {means}", flush=True)
        base, said = bases[row.pipeline], []
        for factor in (0.5, 2.0):
            value = row.times(factor)
            if row.whole() and value == row.now():
                said.append("-")
                continue
            try:
                found = over_shots(Contender("changed: " + shlex.join(["--constant", f"{row.file}:{row.name}={value}"]), row.pipeline), jobs)
            except RuntimeError as error:
                said.append("not possible")
                print(f"{row.name}={value}: {error}", file=sys.stderr)
                continue
            said.append(" / ".join(f"{100 * mean(found, c) / mean(base, c) - 100:+.1f}" for c in COLUMNS))
            ratio = {f: geometric([found[s]["moving"] / base[s]["moving"] for s in shots if s.rsplit("_", 1)[0] == f]) for f in families}
            worst, best = min(families, key=ratio.get), max(families, key=ratio.get)
            print(f"{row.name} = {value}: {said[-1]} %; moving: {worst} {100 * ratio[worst] - 100:+.1f} %, {best} {100 * ratio[best] - 100:+.1f} %",
                  flush=True)
        write_row(row, said)


def write_row(row, said):
    lines = open(table_file).read().split("\n")
    for i, line in enumerate(lines):
        if re.match(r"\| `", line) and (Constant(line).name, Constant(line).file) == (row.name, row.file):
            cells = row.cells[:2] + [f"`{row.now()}`"] + (row.cells[3:5] + said if said else row.cells[3:])
            lines[i] = re.sub(r"\|  (?=\|)", "| ", "| " + " | ".join(cells) + " |")
    with open(table_file, "w") as out:
        out.write("\n".join(lines))


arguments = sys.argv[1:]
if arguments == ["--values"]:
    for row in constants():
        write_row(row, [])
    sys.exit()
with tempfile.TemporaryDirectory() as work:
    files = {(shot, still): shot_file(shot, still) for shot in shots for still in (False, True)}
    try:
        if arguments[:1] == ["--constants"]:
            sensitivity(arguments[1:])
        else:
            judge([Contender("base:")] + [Contender(text) for text in arguments])
    except RuntimeError as error:
        sys.exit(f"tune.sh: {error}")
PYTHON
