#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A night of the virtual machine with everything that is tried at a mark, from a cold start; and one
whose disk is full.

    nightly_sim_test.py PANELCAL REPOSITORY
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
MARK = """
[[vision.tool]]
number = 2
shape = "disc"
size_mm = 0.4
"""
CAMERA = 'calibration = "camera.cal.json"\nfocus_range_mm = [-1, 1]\nfocus_mm = 0.1\nlamp = 50\n'
NIGHTLY = """calibrate = ["focus", "light", "settle", "spindle-camera"]
mark_mm = [200, 300]
mark_tool = 2
warm_up_s = 3600
warm_up_limit_um = 2
settle = {longest_s = 0.4}
"""
SIM = """lamp = 50
focus_z_mm = 0.137
focus_depth_mm = 0.2
"""
COUPON = """mark_mm = [200.01, 299.98]
mark_tool = 2
swing_um = 20
swing_hz = 11
cold_um = [40, -20]
warm_up_s = 300
"""


def write_machine():
    text = (EXAMPLE / "machine.toml").read_text()
    for old, new in (('[vision]\n', "[vision]\n"),
                     ('calibration = "camera.cal.json"\n', CAMERA),
                     ('calibrate = ["spindle-camera"]\n', NIGHTLY),
                     ("background = 0.6\ntarget_level = 0.9\n", "background = 0.3\ntarget_level = 0.7\n" + SIM),
                     ("stage_repeatability_um = 1\n", "stage_repeatability_um = 1\n" + COUPON),
                     ('name = "drill 1"\n', 'name = "drill 1"\nsettle_s = 0.5\n')):
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    Path("machine.toml").write_text(text + MARK + "[uncertainty]\nstage_repeatability_um = 1\n")
    shutil.copy(EXAMPLE / "camera.cal.json", "camera.cal.json")


def nightly(day, code, limit=None):
    def no_file_grows():
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, limit))

    done = subprocess.run([PANELCAL, "-q", "nightly", "-m", "machine.toml", "--by", "test", "--clock",
                           f"2026-11-{day:02}T02:00:00Z"], capture_output=True, text=True, timeout=300,
                          preexec_fn=no_file_grows if limit else None)
    assert done.returncode == code, (done.returncode, done.stdout, done.stderr)
    return done


def history(*words):
    return subprocess.run([PANELCAL, "history", *words, "-l", "drill1.ledger"], check=True,
                          capture_output=True, text=True, timeout=60).stdout


def main():
    write_machine()
    done = nightly(1, 0)
    # Standard error is for diagnostics, and there are none.
    assert done.stderr == "", done.stderr
    night = json.loads(Path("reports/2026-10-31.json").read_text())
    assert checked(in_page("reports/2026-10-31.html"), ROOT) == night
    assert [step["kind"] for step in night["steps"]] == ["focus", "light", "settle", "spindle-camera"]
    assert all(step["state"] == "installed" for step in night["steps"]), night["verdict"]
    focus, light, settle, offset = ([axis["new"] for axis in step["axes"]] for step in night["steps"])
    assert abs(focus[0] - 0.137) < 0.02 and light[0] in (60, 70), (focus, light)
    # 20 um exp(-t / 0.05 s) = 1 um.
    sigma = night["steps"][2]["axes"][0]["sigma"]
    assert abs(settle[0] - 0.150) < 5 * sigma < 0.2, (settle, sigma)
    # Warm to 2 um; 5 sigmas of 1.3 um.
    assert abs(offset[0] - 45.012) < 0.0085 and abs(offset[1] + 2.991) < 0.0085, offset
    # 44.7 um exp(-t / 300 s) = 2 um.
    warm_up = night["warm_up"]
    assert warm_up["warm"] and abs(warm_up["fit"]["wait_s"] - 932) < 120, warm_up["text"]
    assert "after a cold start warm up for 1" in night["verdict"], night["verdict"]

    # The ledger cannot grow: said, and nothing that it had is lost.
    before = history("export")
    done = nightly(2, 3, limit=Path("drill1.ledger").stat().st_size)
    assert "error" in done.stderr or "failed" in done.stdout, (done.stdout, done.stderr)
    assert set(before.splitlines()) <= set(history("export").splitlines())
    history("verify")
    nightly(2, 0)
    history("verify")


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        main()
