#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""From a KiCad board to corrected holes: fiducials out of F.Cu's Gerber file, one alignment, and the plated
and the unplated holes where the panel has them.

A newcomer comes from those files to programs of a GRBL in five commands, and edits no file.

    align_kicad_test.py PANELCAL ROOT
"""
import json
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from aligned_panel import Panel, distance_in_sigmas, prepare
from demo_job import drilled, run
from gcode_test import cuts, walk

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


ISOLATION = "G21 G90\nG0 Z5\nG0 X80 Y-130\nG1 Z-0.1 F100\nG1 X220 Y-50\nG0 Z5\nM2\n"
LONGEST_ERROR_MM = 0.01  # of the fit, at 10 um per pixel


def newcomer(panelcal, folder, stem, pads, panel):
    """docs/howto/align.md, with pictures that were taken before, in the order of the pads."""
    # The shop: its pictures of this panel, its camera, what a CAM system wrote.
    (folder / "pads.exc").write_text("M48\nMETRIC,TZ\nVER,1\n%\nG34,1\n" + "".join(
        f"G36X{x:.3f}Y{y:.3f}\n" for x, y in pads) + "M30\n")
    run(panelcal, "synth", "pads.exc", "-m", "machine.toml", "-o", "pictures", cwd=folder)
    home = folder / "home"
    home.mkdir()
    for name in (f"{stem}-F_Cu.gbr", f"{stem}-PTH.drl", f"{stem}-NPTH.drl", "camera.cal.json"):
        shutil.copy(folder / name, home)
    (home / "isolation.ngc").write_text(ISOLATION)
    for words in (
            ("init", "--template", "usb-camera-grbl", "--camera-offset-mm", "50,3", "--camera-offset-sigma-um", "5",
             "camera.cal.json"),
            ("align", f"{stem}-F_Cu.gbr", "-m", "machine.toml", "--images", "../pictures", "-o", "board.align.json"),
            ("run", f"{stem}-PTH.drl", "-m", "machine.toml", "--align", "board.align.json", "-o", "pth.ngc"),
            ("run", f"{stem}-NPTH.drl", "-m", "machine.toml", "--align", "board.align.json", "-o", "npth.ngc"),
            ("align", "apply", "isolation.ngc", "-m", "machine.toml", "--align", "board.align.json", "-o", "moved.ngc")):
        run(panelcal, *words, cwd=home)
    for kind in ("PTH", "NPTH"):
        wanted = [panel.actual(hole) for hole in holes_of(home / f"{stem}-{kind}.drl")]
        told = [place[:2] for word, place in cuts(walk(home / f"{kind.lower()}.ngc", "grbl")) if word == "down"]
        for a, b in zip(told, wanted, strict=True):
            assert max(abs(u - v) for u, v in zip(a, b)) < LONGEST_ERROR_MM, (kind, a, b)
    assert "G1 X" in (home / "moved.ngc").read_text()


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
        newcomer(panelcal, folder, stem, [m["nominal"] for m in alignment["measurements"]], panel)
        print(f"{n} holes")
        assert n > 200, n
    return 0


if __name__ == "__main__":
    sys.exit(main())
