#!/usr/bin/env python3
"""Puts the mutants of tests/source_mutants.txt into the sources one by one, builds, and demands that the tests fail.

  scripts/source_mutants.py [WORD...]     those whose line holds one of the words; none: all

Works in a copy of the last commit (build/mutants), so that what is being worked on stays as it is. A mutant lives where its
tests pass; one that does not build counts for nothing and is an error of the list.
"""
import pathlib
import re
import subprocess
import sys

root = pathlib.Path(__file__).resolve().parent.parent
copy = root / "build" / "mutants"


def run(*command, **more):
    return subprocess.run(command, cwd=copy, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **more)


def build(program):
    return run("cmake", "--build", "--preset", "release", "--target", program, "-j2").returncode == 0


def passes(program, tests):
    # Every other test of a run is as good: the first failure ends it.
    result = run(f"build/release/tests/{program}", f"--gtest_filter={tests}", "--gtest_fail_fast", timeout=900)
    ran = re.search(r"\[==========\] (\d+) tests? from .* ran", result.stdout)
    if result.returncode == 0 and (not ran or ran.group(1) == "0"):
        sys.exit(f"{program} has no test {tests}")
    return result.returncode == 0


def mutants():
    for line in (root / "tests/source_mutants.txt").read_text().splitlines():
        if line and not line.startswith("#"):
            fields = [field.replace("\\|", "|") for field in re.split(r"(?<!\\)\|", line)]
            yield [field.strip() for field in fields]


def main():
    chosen = [m for m in mutants() if not sys.argv[1:] or any(word in " ".join(m) for word in sys.argv[1:])]
    if not copy.exists():
        # Whoever removed the build folder left git's note of a copy there.
        subprocess.run(["git", "worktree", "prune"], cwd=root, check=True)
        subprocess.run(["git", "worktree", "add", "--detach", str(copy), "HEAD"], cwd=root, check=True)
    run("git", "checkout", "--force", "--detach", subprocess.check_output(["git", "rev-parse", "HEAD"], cwd=root, text=True).strip())
    if run("cmake", "--preset", "release").returncode:
        sys.exit("the copy cannot be configured")
    for program in sorted({m[3] for m in chosen}):
        if not build(program):
            sys.exit(f"{program} does not build without a mutant")
    if not build("penumbra_make_scenes") or run("scripts/scenes.sh", "release").returncode:
        sys.exit("the copy has no scenes")
    # Before the first mutant: afterwards the programs hold the last one.
    for program, tests in sorted({(m[3], m[4]) for m in chosen}):
        if not passes(program, tests):
            sys.exit(f"{program} {tests} fails without a mutant")
    lived = broken = 0
    for file, old, new, program, tests in chosen:
        path = copy / file
        text = path.read_text()
        if text.count(old) != 1:
            sys.exit(f"{file}: \"{old}\" is there {text.count(old)} times")
        path.write_text(text.replace(old, new))
        try:
            if not build(program):
                broken += 1
                print(f"BROKEN  {file}: does not build with \"{new}\"", flush=True)
                continue
            lives = passes(program, tests)
        except subprocess.TimeoutExpired:
            lives = False
        finally:
            path.write_text(text)
        lived += lives
        print(f"{'LIVES ' if lives else 'killed'}  {file}: {old}  ->  {new}", flush=True)
    print(f"{len(chosen) - lived - broken} of {len(chosen)} killed")
    sys.exit(1 if lived or broken else 0)


main()
