#!/usr/bin/env bash
# Measures the tables of docs/performance.md anew: what stands between `<!-- bench [mesa22] ARGUMENTS -->` and
# `<!-- end -->` is replaced by what `penumbra bench ARGUMENTS` prints, on the default driver or, where it says mesa22, on
# the one that scripts/mesa22.sh has fetched. The document changes once all of them are measured.
#   scripts/performance.sh
# PENUMBRA may name another program.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
export PENUMBRA=${PENUMBRA:-build/release/app/penumbra} DOCUMENT=docs/performance.md
python3 - <<'PYTHON'
import os, re, shlex, subprocess, sys
document = os.environ["DOCUMENT"]
text = open(document).read()

def measured(match):
    words = shlex.split(match[1])
    environment = dict(os.environ)
    if words[0] == "mesa22":
        words = words[1:]
        driver = os.path.abspath(".cache/mesa22/lvp_icd.json")
        if not os.path.exists(driver):
            sys.exit(f"performance.sh: no {driver}; scripts/mesa22.sh fetches it")
        environment["VK_DRIVER_FILES"] = driver
    table = subprocess.run([os.environ["PENUMBRA"], "bench", *words], env=environment, check=True,
                           stdout=subprocess.PIPE, text=True).stdout
    return f"<!-- bench {match[1]} -->\n{table}<!-- end -->"

text, tables = re.subn(r"<!-- bench (.*?) -->\n.*?<!-- end -->", measured, text, flags=re.S)
if tables == 0:
    sys.exit(f"performance.sh: {document} has no place for a table")
with open(document + ".new", "w") as new:
    new.write(text)
os.replace(document + ".new", document)
PYTHON
