#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""One alignment serves every file of a board: the holes of programs without targets fall where the panel
has them, whatever the pads come from, and it is refused where it does not hold.

    align_test.py PANELCAL ROOT
"""
import json
import math
import sys
import tempfile
from pathlib import Path

from aligned_panel import (NPTH, PADS, PTH, SIGMA_LIMIT_UM, Panel, distance_in_sigmas, machine_text,
                           prepare)
from demo_job import drilled, run

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
from facts import checked, in_page  # noqa: E402

# With targets of its own: what `panelcal run` alone makes of the same pictures.
ROUT = "M48\nMETRIC\nT1C2.0F100\n%\nT1\nG00X10.0Y10.0F50\nM15\nG01X70.0Y10.0\nG03X70.0Y20.0A5.0\nM16\nG05\nM30\n"
SIEB_MEYER = "%%5000\nX10.Y10.T1\nX30.Y20.\n$\nT1D0.8F2.S60.\n$\n"
ROOT = Path(__file__).parents[2]
JOB = ("M48\nMETRIC,TZ\nVER,1\nT1C0.8F100\n%\nG34,1\n"
       + "".join(f"G36X{x:.3f}Y{y:.3f}\n" for x, y in PADS) + "T1\n")
GERBER = """%TF.FileFunction,Copper,L1,Top*%
%FSLAX46Y46*%
%MOMM*%
%LPD*%
G01*
%TA.AperFunction,ComponentPad*%
%ADD10C,1.000000*%
%TD*%
%TA.AperFunction,FiducialPad,Global*%
%ADD11C,1.000000*%
%TD*%
D10*
X40000000Y20000000D03*
D11*
"""
POSITIONS = """### Footprint positions - created on Sat ###
## Unit = mm, Angle = deg.
## Side : All
# Ref     Val       Package       PosX       PosY       Rot  Side
C1        100n      C_0402     40.0000    20.0000    0.0000  top
"""
GCODE = "G21\nG90\nG0 Z5.000\nG0 X1.0 Y2.0\nG1 Z-0.1 F100\nG1 X5.0 Y2.0\nM5\nM2\n"


def align(panelcal, folder, pads, *arguments, expect=0, machine="machine.toml", output="board.align.json"):
    return run(panelcal, "align", pads, "-m", machine, *arguments, "-o", output, "--by", "Ada", cwd=folder,
               expect=expect)


def run_aligned(panelcal, folder, program, *arguments, expect=0, machine="machine.toml"):
    return run(panelcal, "run", program, "-m", machine, "--align", "board.align.json", *arguments, cwd=folder,
               expect=expect)


def refused(result, *words):
    for word in words:
        assert word in result.stderr, (word, result.stderr)


def edited(folder, change):
    path = folder / "board.align.json"
    document = json.loads(path.read_text())
    change(document)
    path.write_text(json.dumps(document))


def holes_fall_where_the_panel_has_them(panelcal, folder):
    panel = Panel(0)
    prepare(folder, panel)
    run(panelcal, "synth", "pads.exc", "-m", "machine.toml", "-o", "images", cwd=folder)
    align(panelcal, folder, ";".join(f"{x},{y}" for x, y in PADS), "--images", "images", "--panel", "7",
          "--report", "align.html", "--json", "align.json")
    assert in_page(folder / "align.html") == checked(json.loads((folder / "align.json").read_text()), ROOT)
    for program, n in (("pth.drl", len(PTH)), ("npth.drl", len(NPTH))):
        run_aligned(panelcal, folder, program, "-o", "out.jsonl", "--json", "facts.json")
        holes = drilled(folder / "out.jsonl")
        assert len(holes) == n
        for hole in holes:
            assert distance_in_sigmas(hole, panel) < 5, hole
            assert max(hole["sigma"]) * 1e3 < SIGMA_LIMIT_UM, hole
        facts = checked(json.loads((folder / "facts.json").read_text()), ROOT)
        assert facts["verdict"]["word"] == "drill" and len(facts["targets"]) == len(PADS), facts["verdict"]
        assert "board.align.json" in facts["source"], facts["source"]
    # The same pictures under a program that has the targets itself.
    (folder / "job.exc").write_text(JOB + "".join(f"X{x:.3f}Y{y:.3f}\n" for x, y in PTH) + "M30\n")
    run(panelcal, "run", "job.exc", "-m", "machine.toml", "--images", "images", "-o", "job.jsonl", cwd=folder)
    run_aligned(panelcal, folder, "pth.drl", "-o", "out.jsonl")
    for mine, other in zip(drilled(folder / "out.jsonl"), drilled(folder / "job.jsonl")):
        for key in ("nominal", "actual", "sigma"):
            assert all(math.isclose(a, b, abs_tol=1e-9) for a, b in zip(mine[key], other[key])), (mine, other)
    # Routs and the other language.
    (folder / "rout.drl").write_text(ROUT)
    (folder / "holes.s5").write_text(SIEB_MEYER)
    for program, kind, n in (("rout.drl", "rout", 2), ("holes.s5", "drill", 2)):
        run_aligned(panelcal, folder, program, "-o", "out.jsonl")
        moves = [op for op in map(json.loads, (folder / "out.jsonl").read_text().splitlines()) if op["op"] == kind]
        assert len(moves) == n and all(distance_in_sigmas(move, panel) < 5 for move in moves), moves
    shown = run(panelcal, "align", "show", "board.align.json", "-m", "machine.toml", "--json", "show.json",
                cwd=folder).stdout
    assert "in force" in shown and "panel 7" in shown and "by Ada" in shown, shown
    assert json.loads((folder / "show.json").read_text())["series"][0]["is_accepted"]


def pads_may_come_from_any_file(panelcal, folder):
    prepare(folder, Panel(1))
    run(panelcal, "synth", "pads.exc", "-m", "machine.toml", "-o", "images", cwd=folder)
    (folder / "F_Cu.gbr").write_text(
        GERBER + "".join(f"X{round(x * 1e6)}Y{round(y * 1e6)}D03*\n" for x, y in PADS) + "M02*\n")
    (folder / "old.gbr").write_text(
        (folder / "F_Cu.gbr").read_text().replace("%TA.AperFunction,FiducialPad,Global*%", "")
        .replace("ADD11C,1.000000", "ADD11C,2.000000"))
    (folder / "top.pos").write_text(POSITIONS + "".join(
        f"FID{i + 1}  Fiducial  Fiducial_1mm  {x:.4f} {y:.4f} 0.0000 top\n" for i, (x, y) in enumerate(PADS)))
    (folder / "holes.drl").write_text(
        "M48\nMETRIC\nT1C0.8\n%\nT1\n"
        + "".join(f"X{x:.3f}Y{y:.3f}\n" for x, y in [(40, 30), *PADS, (50, 35)]) + "M30\n")
    fits = []
    for pads, more in ((";".join(f"{x},{y}" for x, y in PADS), []), ("pads.exc", []), ("F_Cu.gbr", []),
                       ("old.gbr", ["--diameter", "2"]), ("top.pos", []), ("holes.drl", ["--auto", "4"])):
        align(panelcal, folder, pads, "--images", "images", *more)
        fits.append(json.loads((folder / "board.align.json").read_text()))
    for other in fits[1:]:
        assert [m["nominal"] for m in other["measurements"]] == [list(map(float, p)) for p in PADS], other
        assert other["fit"] == fits[0]["fit"], (other["pads"], other["fit"])
    assert fits[4]["names"] == ["FID1", "FID2", "FID3", "FID4"], fits[4]["names"]
    refused(align(panelcal, folder, "old.gbr", "--images", "images", expect=2), "1 mm (1), 2 mm (4)")
    refused(align(panelcal, folder, "pth.drl", "--images", "images", expect=2), "--auto")


def is_refused_where_it_does_not_hold(panelcal, folder):
    prepare(folder, Panel(2))
    pads = ";".join(f"{x},{y}" for x, y in PADS)
    align(panelcal, folder, pads, "--machine-driver", "sim", "--save-measurements", "pads.jsonl")
    kept = (folder / "board.align.json").read_bytes()
    for name, text, words in (
            ("own.exc", JOB + "X20.0Y20.0\nM30\n", ["own.exc:7", "without --align"]),
            ("cancels.drl", "M48\nMETRIC\nT1C0.8F100\n%\nT1\nX20.0Y20.0\nG37\nX30.0Y20.0\nM30\n",
             ["cancels.drl:8", "drops the correction"]),
            ("cancels.s5", SIEB_MEYER.replace("X10.", "G30\nX10."), ["cancels.s5:3", "drops the correction"]),
            ("far.drl", "M48\nMETRIC\nT1C0.8F100\n%\nT1\nX120.0Y-80.0\nX150.0Y-60.0\nM30\n",
             ["(120.000, -80.000) to (150.000, -60.000)", "(5.000, 5.000) to (75.000, 55.000)"])):
        (folder / name).write_text(text)
        refused(run_aligned(panelcal, folder, name, "-o", "out.jsonl", expect=2), *words)
        assert not (folder / "out.jsonl").exists()
    (folder / "other.toml").write_text((folder / "machine.toml").read_text() + "# changed\n")
    refused(run_aligned(panelcal, folder, "pth.drl", "-o", "out.jsonl", machine="other.toml", expect=2),
            "another machine file")

    edited(folder, lambda d: d.update(time="2020-01-01T00:00:00Z"))
    refused(run_aligned(panelcal, folder, "pth.drl", "-o", "late.jsonl", expect=1), "align verify", "limit 4 hours")
    run_aligned(panelcal, folder, "pth.drl", "-o", "late.jsonl", "--valid", "900000")
    edited(folder, lambda d: d["fit"]["translation_mm"].__setitem__(0, d["fit"]["translation_mm"][0] + 1e-4))
    refused(run_aligned(panelcal, folder, "pth.drl", "-o", "o.jsonl", "--valid", "900000", expect=2),
            "calibration-invalid")
    # A pad that lies 0.3 mm off breaks the residual's limit, and the alignment says so for ever.
    lines = (folder / "pads.jsonl").read_text().splitlines()
    moved = json.loads(lines[1])
    moved["measured"][0] += 0.3
    (folder / "pads.jsonl").write_text("\n".join([lines[0], json.dumps(moved), *lines[2:]]) + "\n")
    refused(align(panelcal, folder, pads, "--measurements", "pads.jsonl", expect=1), "held")
    refused(run_aligned(panelcal, folder, "pth.drl", "-o", "o.jsonl", expect=1), "held")
    assert not (folder / "o.jsonl").exists()
    (folder / "board.align.json").write_bytes(kept)
    edited(folder, lambda d: d.update(pannel="7"))
    refused(run_aligned(panelcal, folder, "pth.drl", "-o", "o.jsonl", expect=2), '"pannel"', '"panel"')


def verify_renews_what_lies_still(panelcal, folder):
    prepare(folder, Panel(3))
    pads = ";".join(f"{x},{y}" for x, y in PADS)
    align(panelcal, folder, pads, "--machine-driver", "sim")
    edited(folder, lambda d: d.update(time="2020-01-01T00:00:00Z"))
    run_aligned(panelcal, folder, "pth.drl", "-o", "out.jsonl", expect=1)
    verify = ["align", "verify", "board.align.json", "-m", "machine.toml", "--by", "Ada"]
    said = run(panelcal, *verify, "--machine-driver", "sim", cwd=folder).stdout
    assert "lies where it lay" in said, said
    run_aligned(panelcal, folder, "pth.drl", "-o", "out.jsonl")
    checks = json.loads((folder / "board.align.json").read_text())["checks"]
    # The two that lie farthest apart.
    assert len(checks) == 1 and checks[0]["pads"] == [1, 3] and checks[0]["is_accepted"], checks

    # A clock that goes wrong writes nothing.
    board = folder / "board.align.json"
    kept = board.read_bytes()
    edited(folder, lambda d: d.update(time="2100-01-01T00:00:00Z", checks=[]))
    future = board.read_bytes()
    refused(run(panelcal, *verify, "--machine-driver", "sim", cwd=folder, expect=2), "after this computer's time")
    assert board.read_bytes() == future
    # The panel is taken away: the pictures show none of its pads.
    board.write_bytes(kept)
    (folder / "two.exc").write_text("M48\nMETRIC,TZ\nVER,1\n%\n$uvis,alg,0,2\nG34,1\n" + "".join(
        f"G36X{PADS[i][0]:.3f}Y{PADS[i][1]:.3f}\n" for i in (0, 2)) + "M30\n")
    (folder / "taken.toml").write_text(machine_text(Panel(3).moved(5)).replace(
        "[vision]", '[vision]\nmodel = "similarity"'))
    run(panelcal, "synth", "two.exc", "-m", "taken.toml", "-o", "taken", cwd=folder, expect=1)
    refused(run(panelcal, *verify, "--images", "taken", cwd=folder, expect=1), "pad 1 at nominal")
    refused(run_aligned(panelcal, folder, "pth.drl", "-o", "out2.jsonl", expect=1),
            "pad 1 was not found when Ada looked again")
    board.write_bytes(kept)

    # The panel is pushed by 30 um: the pictures are another machine's, where it lies there.
    (folder / "pushed.toml").write_text(machine_text(Panel(3).moved(0.03)).replace(
        "[vision]", '[vision]\nmodel = "similarity"'))
    run(panelcal, "synth", "two.exc", "-m", "pushed.toml", "-o", "pushed", cwd=folder)
    refused(run(panelcal, *verify, "--images", "pushed", cwd=folder, expect=1), "the panel has moved")
    refused(run_aligned(panelcal, folder, "pth.drl", "-o", "out2.jsonl", expect=1), "the panel had moved")
    run(panelcal, "align", "show", "board.align.json", "-m", "machine.toml", cwd=folder, expect=1)


def gcode_gets_one_answer(panelcal, folder):
    prepare(folder, Panel(4))
    (folder / "isolation.ngc").write_text(GCODE)
    for command in (["check", "isolation.ngc"], ["run", "isolation.ngc", "-m", "machine.toml", "-o", "o.drl"]):
        said = run(panelcal, *command, "--log-level", "warning", cwd=folder, expect=2).stderr
        assert said.splitlines()[0].startswith("isolation.ngc:1:1: error[not-a-program]"), said
        assert said.count("error[") == 1 and "G-code" in said, said


def main():
    panelcal = str(Path(sys.argv[1]).resolve())
    for check in (holes_fall_where_the_panel_has_them, pads_may_come_from_any_file,
                  is_refused_where_it_does_not_hold, verify_renews_what_lies_still, gcode_gets_one_answer):
        with tempfile.TemporaryDirectory() as folder:
            check(panelcal, Path(folder))


if __name__ == "__main__":
    main()
