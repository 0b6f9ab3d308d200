#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Nights that probe the table of the virtual machine: they install, notice, are gone back from, and
take a map by hand.

    surface_night_test.py PANELCAL REPOSITORY
"""
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

PANELCAL = str(Path(sys.argv[1]).resolve())
ROOT = Path(sys.argv[2]).resolve()
sys.path.insert(0, str(ROOT / "tests" / "support"))
from facts import checked, in_page  # noqa: E402

EXAMPLE = ROOT / "examples" / "nightly"
KEY = ("--machine", "drill 1", "--kind", "surface", "--subject", "table")
SURFACE = """
[nightly.surface]
file = "table.json"
low_mm = [100, 50]
high_mm = [295, 250]
columns = 6
rows = 5

[sim.table_surface]
height_mm = 0.2
slope_ppm = [80, -30]
bow_um = 20
bow_center_mm = [200, 150]
bow_radius_mm = 150
noise_um = 3
since = 2026-11-03T12:00:00
slope_ppm_per_day = [15, 0]
chip_mm = [180, 100]
chip_radius_mm = 8
chip_depth_um = 300
chip_since = 2026-11-09T00:00:00
"""


def panelcal(*words, code=0, limit=None):
    def no_file_grows():
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    done = subprocess.run([PANELCAL, *words], capture_output=True, text=True, timeout=120,
                          preexec_fn=no_file_grows if limit else None)
    assert done.returncode == code, (words, done.returncode, done.stdout, done.stderr)
    return done


def night(day, code=0, *words, limit=None):
    return panelcal("-q", "nightly", "-m", "machine.toml", "--by", "test", "--clock",
                    f"2026-11-{day:02}T02:00:00Z", *words, code=code, limit=limit)


def history(*words):
    return panelcal("history", *words, "-l", "drill1.ledger").stdout


def surfaces():
    return json.loads(history("list", "--kind", "surface", "--json", "-"))["entries"]


def figures(entry):
    return {one["name"]: one["value"] for one in entry["parameters"]}


def main():
    text = (EXAMPLE / "machine.toml").read_text()
    text = text.replace('calibrate = ["spindle-camera"]', 'calibrate = ["surface"]')
    Path("machine.toml").write_text(text + SURFACE)
    shutil.copy(EXAMPLE / "camera.cal.json", "camera.cal.json")
    panelcal("check", "-m", "machine.toml")

    night(1)
    night(2)
    record = checked(in_page("reports/2026-10-31.html"), ROOT)
    first, second = surfaces()
    assert first["verdict"] == second["verdict"] == "installed", (first, second)
    # The middle, (200, 150): 0.2 + 80e-6 200 - 30e-6 150; an edge is 100 mm from it.
    assert abs(figures(first)["offset"] - 0.2115) < 0.005, figures(first)
    assert abs(figures(first)["tilt_x"] - 0.008) < 0.005, figures(first)
    assert "change_rms" not in figures(first) and figures(second)["change_rms"] < 0.005

    # Of two surfaces the difference is that of their maps.
    said = history("diff", str(first["id"]), str(second["id"]))
    assert "not seen to change" in said, said
    for entry, file in ((first, "a.json"), (second, "b.json")):
        history("show", str(entry["id"]), "--result", "-o", file)
    alone = panelcal("surface", "diff", "a.json", "b.json").stdout
    assert alone.splitlines()[1:] == said.splitlines()[-len(alone.splitlines()) + 1:], (alone, said)
    as_json = json.loads(history("diff", str(first["id"]), str(second["id"]), "--json", "-"))
    assert as_json["difference"]["surface"]["changed"] is False, as_json
    history("plot", *KEY, "--parameter", "tilt_x", "--report", "tilt.html")
    assert len(checked(in_page("tilt.html"), ROOT)["entries"]) == 2
    assert panelcal("surface", "query", "table.json", "200,150").stdout

    # The disk is full: said, and nothing that the ledger had is lost.
    before = history("export").splitlines()
    night(3, 3, limit=Path("drill1.ledger").stat().st_size)
    assert set(before) <= set(history("export").splitlines())
    history("verify")
    night(3)

    # Back to the night before: the next run writes its map.
    history("rollback", *KEY, "--reason", "a swarf")
    assert "was rolled back since" in night(3, 1).stdout
    assert Path("table.json").read_text() == Path("b.json").read_text()

    # The tilt that grows since then shows, and then the chip is one place too many.
    for day in range(4, 9):
        night(day)
    grown = figures(surfaces()[-1])["tilt_x"] - figures(second)["tilt_x"]
    assert abs(grown - 0.0015 * 4.6) < 0.005, grown
    assert "changed: by scatter alone" in history("diff", str(second["id"]), str(surfaces()[-1]["id"]))
    said = night(10, 1).stdout
    assert "the probe at column 2 row 1" in said and "do not drill" in said, said

    # A person has looked, and takes that map.
    refused = surfaces()[-1]
    assert refused["verdict"] == "refused" and figures(refused)["change_greatest"] < -0.28, refused
    history("show", str(refused["id"]), "--result", "-o", "tonight.json")
    said = panelcal("calibrate", "surface", "tonight.json", "-m", "machine.toml", "--install", "--by", "test",
                    "--reason", "chip at the edge", "--clock", "2026-11-10T08:00:00Z").stdout
    assert "left out: column 2 row 1" in said and "installed, ledger entry" in said, said
    # The same map; each notes the entry before its own.
    table, tonight = (json.loads(Path(name).read_text()) for name in ("table.json", "tonight.json"))
    assert table.pop("ledger") != tonight.pop("ledger") and table == tonight
    night(11)
    history("verify")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        main()
