#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""From a KiCad board to corrected holes: fiducials out of F.Cu's Gerber file, one alignment, and the plated
and the unplated holes where the panel has them.

    align_kicad_test.py PANELCAL ROOT
"""
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from aligned_panel import Panel, distance_in_sigmas, prepare
from demo_job import drilled, run

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
from facts import checked  # noqa: E402

SKIPPED = 77
ROOT = Path(__file__).parents[2]
BOARD = Path("/usr/share/kicad/demos/pic_programmer/pic_programmer.kicad_pcb")
SYSTEM_PYTHON = "/usr/bin/python3"


def holes_of(path):
    """By the text of KiCad's decimal files."""
    places = []
    for line in path.read_text().splitlines():
        if line.startswith("X"):
            x, y = line[1:].split("G85")[0].split("Y")
            places.append((float(x), float(y)))
    return places


def main():
    panelcal = str(Path(sys.argv[1]).resolve())
    has_kicad = subprocess.run([SYSTEM_PYTHON, "-c", "import pcbnew"], capture_output=True).returncode == 0
    if not has_kicad or not BOARD.exists():
        print("SKIP: kicad or kicad-demos is not installed (tools/packages.txt, extra)")
        return SKIPPED
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        panel = Panel(5)
        prepare(folder, panel)
        exported = subprocess.run([SYSTEM_PYTHON, Path(__file__).with_name("kicad_fiducials.py"), BOARD, folder],
                                  check=True, capture_output=True, text=True, timeout=120)
        fiducials = json.loads(exported.stdout.splitlines()[-1])
        stem = BOARD.stem
        run(panelcal, "align", f"{stem}-F_Cu.gbr", "-m", "machine.toml", "--machine-driver", "sim", "-o",
            "board.align.json", cwd=folder)
        alignment = json.loads((folder / "board.align.json").read_text())
        assert "FiducialPad,Global" in alignment["pads"], alignment["pads"]
        seen = sorted(m["nominal"] for m in alignment["measurements"])
        for a, b in zip(seen, sorted(fiducials), strict=True):
            assert max(abs(u - v) for u, v in zip(a, b)) < 1e-6, (seen, fiducials)
        n = 0
        for kind in ("PTH", "NPTH"):
            run(panelcal, "run", f"{stem}-{kind}.drl", "-m", "machine.toml", "--align", "board.align.json", "-o",
                "out.jsonl", cwd=folder)
            holes = drilled(folder / "out.jsonl")
            written = holes_of(folder / f"{stem}-{kind}.drl")
            assert [tuple(h["nominal"]) for h in holes] == written, (kind, len(holes), len(written))
            assert all(distance_in_sigmas(hole, panel) < 5 for hole in holes)
            n += len(holes)
            said = run(panelcal, "check", f"{stem}-{kind}.drl", "--json", "check.json", cwd=folder).stdout
            plating = "plated" if kind == "PTH" else "unplated"
            assert f"\n{plating} holes of layers 1 to 2: T1 " in said and "ComponentDrill" in said, said
            stated = checked(json.loads((folder / "check.json").read_text()), ROOT)["job"]["attributes"]
            assert stated["file_function"].endswith(f",1,2,{kind}") and stated["tools"], stated
        print(f"{n} holes")
        assert n > 200, n
    return 0


if __name__ == "__main__":
    sys.exit(main())
