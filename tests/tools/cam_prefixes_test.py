#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Drill files of real CAM systems, cut off anywhere: refused, or no hole that the whole file lacks.

usage: cam_prefixes_test.py CAM_PREFIXES
"""

import re
import subprocess
import sys
import tempfile
from pathlib import Path

SKIPPED = 77
SYSTEM_PYTHON = "/usr/bin/python3"
DEMOS = Path("/usr/share/kicad/demos")
EXAMPLES = Path("/usr/share/doc/gerbv/examples")
# Of Mentor, Veribest, Protel, OrCAD, and pcb.
FILES = ["ekf2/drill0.exc", "ekf2/drill1.exc", "ekf2/drill20.exc", "ekf2/drill30.exc",
         "amacro-ref/jj1.drl", "nollezappare/ThruHolePlated.ncd", "protel-pnp/SE_SG_IF_V2.TXT",
         "orcad/thruhole.tap", "hellboard/hellboard.plated-drill.cnc",
         "numpres/numpres.pcb.output_plated-drill.grb"]


def skip(why):
    print("SKIP:", why, "(tools/packages.txt, extra)")
    sys.exit(SKIPPED)


def kicad_files(folder):
    """One file a board, each in another number format than the one before."""
    boards = sorted(DEMOS.rglob("*.kicad_pcb"))
    if not boards:
        skip("kicad-demos is not installed")
    subprocess.run([SYSTEM_PYTHON, Path(__file__).with_name("kicad_export.py"), folder, *boards],
                   check=True, capture_output=True, timeout=300)
    by_board = {}
    for path in sorted(folder.rglob("*.drl")):
        if re.search(r"^X", path.read_text(), re.MULTILINE):
            by_board.setdefault(path.name, []).append(path)
    return [paths[i % len(paths)] for i, paths in enumerate(by_board.values())]


def main():
    cam_prefixes, = sys.argv[1:]
    if not EXAMPLES.is_dir():
        skip("gerbv is not installed")
    if subprocess.run([SYSTEM_PYTHON, "-c", "import pcbnew"], capture_output=True).returncode != 0:
        skip("kicad is not installed")
    with tempfile.TemporaryDirectory() as folder:
        files = [EXAMPLES / name for name in FILES] + kicad_files(Path(folder))
        done = subprocess.run([cam_prefixes, *files], capture_output=True, text=True, timeout=300)
    print(done.stdout, done.stderr)
    # Two examples drill with T0 and are refused as they are. Whose holes the whole files have,
    # reference.gerbv_examples and reference.kicad_boards say.
    n_whole = done.stdout.count(": whole, ")
    print(f"{len(files)} files, {n_whole} of them accepted as a whole")
    sys.exit(0 if done.returncode == 0 and n_whole >= 15 else 1)


if __name__ == "__main__":
    main()
