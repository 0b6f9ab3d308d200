#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""gerbv and panelcal find the same hits and the same bounding boxes in the drill files of every
KiCad demo board, in every number format that KiCad writes."""

import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from demo_job import run

SKIPPED = 77
DEMOS = Path("/usr/share/kicad/demos")
SYSTEM_PYTHON = "/usr/bin/python3"
# gerbv writes inches with four decimals, and diameters with three.
ROUNDING_MM = 0.0026
DIAMETER_ROUNDING_MM = 0.0131
# gerbv takes six digits without LZ or TZ for ten micrometres each (KiCad's comment says otherwise).
GERBV_MISREADS = "_metric_keep_zeros"


def skip(why):
    print("SKIP:", why, "(tools/packages.txt, extra)")
    sys.exit(SKIPPED)


class Job:
    """Hits per diameter in mm, and the box of all coordinates in mm."""

    def __init__(self):
        self.hits = Counter()
        self.low = [float("inf")] * 2
        self.high = [float("-inf")] * 2

    def see(self, point):
        self.low = [min(a, b) for a, b in zip(self.low, point)]
        self.high = [max(a, b) for a, b in zip(self.high, point)]


def as_gerbv_reads(path, folder):
    """From gerbv's own plain output: INCH,TZ with two and four digits."""
    read = folder / "read.drl"
    subprocess.run(["gerbv", "-x", "drill", "-o", read, path], check=True, capture_output=True,
                   timeout=60)
    job, diameters, tool = Job(), {}, None
    for line in read.read_text(errors="replace").splitlines():
        if match := re.match(r"T(\d+)C([\d.]+)", line):
            diameters[match[1]] = float(match[2]) * 25.4
        elif match := re.match(r"T(\d+)", line):
            tool = match[1]
        elif line.startswith("X"):
            job.hits[diameters[tool]] += 1
            for x, y in re.findall(r"X(-?\d+)Y(-?\d+)", line):
                job.see([int(x) * 25.4e-4, int(y) * 25.4e-4])
    return job


def as_panelcal_reads(panelcal, path, machine, folder):
    out = folder / "out.jsonl"
    run(panelcal, "run", path, "-m", machine, "--slots", "keep", "-o", out, "--force")
    job, diameter = Job(), None
    for line in out.read_text().splitlines():
        op = json.loads(line)
        if op["op"] == "tool" and op["tool"] > 0:
            diameter = op["diameter"]
        elif op["op"] in ("drill", "slot"):
            job.hits[diameter] += 1
            job.see(op["nominal"])
            if op["op"] == "slot":
                job.see(op["nominal_end"])
    return job


def in_diameters_of(ours, theirs):
    """Our hits under the other reader's rounded diameters; what it does not have stays apart."""
    hits = Counter()
    for diameter, n in ours.hits.items():
        nearest = min(theirs.hits, key=lambda other: abs(other - diameter))
        is_near = abs(nearest - diameter) < DIAMETER_ROUNDING_MM
        hits[nearest if is_near else diameter] += n
    return hits


def differences(ours, theirs):
    if in_diameters_of(ours, theirs) != theirs.hits:
        yield f"hits {dict(ours.hits)}, gerbv {dict(theirs.hits)}"
    for name in ("low", "high"):
        a, b = getattr(ours, name), getattr(theirs, name)
        if any(abs(x - y) > ROUNDING_MM for x, y in zip(a, b)):
            yield f"{name} corner {a}, gerbv {b}"


def main():
    panelcal, _ = sys.argv[1:]
    if shutil.which("gerbv") is None:
        skip("gerbv is not installed")
    if subprocess.run([SYSTEM_PYTHON, "-c", "import pcbnew"], capture_output=True).returncode != 0:
        skip("kicad is not installed")
    boards = sorted(DEMOS.rglob("*.kicad_pcb"))
    if not boards:
        skip("kicad-demos is not installed")
    n_files, n_hits, failures = 0, 0, []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        exports = folder / "exports"
        exports.mkdir()
        subprocess.run([SYSTEM_PYTHON, Path(__file__).with_name("kicad_export.py"), exports,
                        *boards], check=True, capture_output=True, timeout=300)
        machine = folder / "machine.toml"
        machine.write_text("[machine]\nname = \"any\"\n")
        formats = {}
        for path in sorted(exports.rglob("*.drl")):
            if not re.search(r"^X", path.read_text(), re.MULTILINE):
                continue
            ours = as_panelcal_reads(panelcal, path, machine, folder)
            n_files += 1
            n_hits += ours.hits.total()
            # Every format of a board is the same job, whoever reads it.
            board = re.sub(r"_(metric|inch)_\w+$", "", path.parent.name) + path.stem
            first = formats.setdefault(board, ours)
            failures += [f"{path.parent.name}: {d} (of another format)"
                         for d in differences(ours, first)]
            if path.parent.name.endswith(GERBV_MISREADS):
                continue
            failures += [f"{path.parent.name}: {d}"
                         for d in differences(ours, as_gerbv_reads(path, folder))]
    print(f"{len(boards)} boards, {n_files} drill files, {n_hits} hits")
    for failure in failures:
        print(failure)
    sys.exit(1 if failures or n_hits == 0 else 0)


if __name__ == "__main__":
    main()
