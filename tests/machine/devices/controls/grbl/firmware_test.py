#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""panelcal run drives and probes with GRBL 1.1h and grblHAL themselves, and stops them at faults.

    firmware_test.py PANELCAL REPOSITORY [--jobs N] [--probes N] [--faults N]

PANELCAL_GRBL names the folder of the programs grblhal_sim and grbl_sim; without it the test is left
out. The issue's figures are --jobs 5 --probes 25 --faults 200, on a computer that has nothing else to do.
"""
import argparse
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from math import gcd
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))
from firmware import Firmware, Line  # noqa: E402

SKIPPED = 77
DEVICE_PROBLEM = 3
SURFACE_MM = -3.0
N_FAULTY_PROBES = 1     # of a job that is disturbed
Z0_MM = -5.4            # so that the surface is 1.6 mm high
STEP_MM = 1 / 250
REPORT_MM = 0.0011
KEYS = """driver = "grbl"
{address}
homing = "none"
safe_z_mm = -1
settle_s = 0.001
move_limit_s = 60
probe_feed_mm_min = 120
probe_from_mm = -2.5
probe_to_mm = {to_mm}
probe_z0_mm = %s
""" % Z0_MM
BOARD = """[surface]
height_mm = 1.6
tolerance_mm = 2
"""


def probing_program(n_probes):
    places = [(5 + 4 * (i % 5), 5 + 4 * (i // 5)) for i in range(n_probes)]
    lines = [f"X{x}.Y{y}.G73L{1 + i % 9}" for i, (x, y) in enumerate(places)]
    return "\n".join(["%%5000", "G71K.4", *lines, "L1", "X25.Y25.T1", "G70", "$", "T1D1.F2.", "$", ""])


class Bench:
    def __init__(self, options, folder):
        self.options, self.folder = options, Path(folder)
        self.programs = Path(os.environ["PANELCAL_GRBL"])

    def panelcal(self, words, limit_s=600):
        return subprocess.run([self.options.panelcal, *map(str, words)], cwd=self.folder, text=True,
                              capture_output=True, timeout=limit_s)

    def firmware(self, kind):
        return Firmware(kind, self.programs, tempfile.mkdtemp(dir=self.folder))

    def write_machine(self, line, demo=False, to_mm=-6.5):
        keys = KEYS.format(address=line.address, to_mm=to_mm)
        text = f"[machine]\n{keys}\n{BOARD}"
        if demo:
            source = Path(self.options.repository) / "datasets" / "demo"
            text = (source / "machine.toml").read_text().replace("[machine]\n", "[machine]\n" + keys)
            # The pictures were taken where they were asked for, and the machine goes by steps.
            text = text.replace("stage_repeatability_um = 0", "stage_repeatability_um = 3")
            shutil.copy(source / "camera.cal.json", self.folder)
            shutil.copy(source / "panel.exc", self.folder)
        (self.folder / "machine.toml").write_text(text)

    def probe(self, n_probes):
        (self.folder / "out.jsonl").unlink(missing_ok=True)
        (self.folder / "probing.sm").write_text(probing_program(n_probes))
        return self.panelcal(["run", "probing.sm", "-m", "machine.toml", "--camera", "folder:pictures",
                              "-o", "out.jsonl", "--save-probes", "probes.jsonl"])


def check(condition, words):
    if not condition:
        raise AssertionError(words)


def jobs(bench, kind, n_jobs):
    """The demo job: 21 looks each. Returns the moves and the largest distance from where it was sent."""
    firmware = bench.firmware(kind)
    moves, worst_mm = 0, 0.0
    images = Path(bench.options.repository) / "datasets" / "demo" / "images"
    try:
        for _ in range(n_jobs):
            line = Line(firmware, is_serial=kind == "grbl")
            bench.write_machine(line, demo=True)
            run = bench.panelcal(["run", "panel.exc", "-m", "machine.toml", "--camera",
                                  f"folder:{images}", "-o", "out.drl"])
            moves += line.n_moves
            sent = re.search(r"X([-0-9.]+)Y([-0-9.]+)F", line.last_jog)
            line.close()
            check(run.returncode == 0, run.stderr)
            check("21 found" in run.stderr + run.stdout, run.stderr)
            state, at = firmware.resting_place()
            off = max(abs(float(sent[1]) - at[0]), abs(float(sent[2]) - at[1]))
            check(state == "Idle" and off <= STEP_MM / 2 + REPORT_MM, f"{state} {at} {sent}")
            worst_mm = max(worst_mm, off)
    finally:
        firmware.close()
    return moves, worst_mm


def probes(bench, n_probes):
    """Returns the number of touches; each height is the Z of its [PRB:...] from z0 on."""
    firmware = bench.firmware("grblhal")
    try:
        line = Line(firmware, SURFACE_MM)
        bench.write_machine(line)
        run = bench.probe(n_probes)
        line.close()
        check(run.returncode == 0, run.stderr)
        readings = [json.loads(text) for text in (bench.folder / "probes.jsonl").read_text().splitlines()]
        readings = [r for r in readings if "height" in r]
        check(len(readings) == n_probes == line.n_probes, f"{len(readings)} of {line.n_probes}")
        for reading, z_mm in zip(readings, line.touches(), strict=True):
            # The key that trips the probe follows a report, so that the probe goes on a little.
            check(z_mm <= SURFACE_MM, f"touched at {z_mm}")
            check(abs(reading["height"] + Z0_MM - z_mm) < 1e-9, f"{reading} {z_mm}")
        state, at = firmware.resting_place()
        check(state == "Idle" and abs(at[2] + 1) <= STEP_MM, f"{state} {at}")
        check("G90" in firmware.ask("$G"), "G91 was left behind")
        return len(readings)
    finally:
        firmware.close()


# Faults: what happens at a message, in place of its answer, and what the diagnostic has to name.
def lose(line, _part):
    line.close_peer()
    return b""


def garble(line, _part):
    line.say(b"<Id\x02le|MP\x03os:1,2\r\n")
    return b""


def refuse(line, _part):
    line.say(b"error:20\r\n")
    return b""


def real_time(byte):
    return lambda _line, part: part + byte


def press(key):
    def fault(line, part):
        line.firmware.key(key)
        return part
    return fault


COMMON = {
    "connection lost": (lose, "lost connection"),
    "wrong reply": (garble, "answers"),
    "order refused": (refuse, "error:20"),
    "reset": (real_time(b"\x18"), "reset|ALARM:3"),
    "feed hold": (real_time(b"!"), "Hold|stopped at"),
    "door": (real_time(b"\x84"), "Door|stopped at|does not move on"),
}
HAL_ONLY = {"emergency stop": (press("e"), "ALARM:10|Alarm|reset")}


def stand_still(firmware, line, name):
    """After the failure at most the move in hand went on: no order followed but those that stop."""
    firmware.resting_place()
    moving = [part for part in line.after_fault if part.startswith(b"$J=") or b"G38" in part]
    if name == "connection lost":
        check(not moving, f"{name}: {moving}")


def one_fault(bench, kind, name, fault, cause, at):
    """Returns "stopped", or "without effect" where the job went on to its end."""
    firmware = bench.firmware(kind)
    try:
        line = Line(firmware, SURFACE_MM if kind == "grblhal" else None, fault, at)
        bench.write_machine(line)
        run = bench.probe(N_FAULTY_PROBES)
        line.close()
        stand_still(firmware, line, name)
        check("internal" not in run.stderr, run.stderr)
        if run.returncode == 0 or (kind == "grbl" and "ALARM:5" in run.stderr):
            check(line.n_messages >= at or name != "connection lost", f"{name} at {at}: nothing was lost")
            return "without effect"
        check(run.returncode == DEVICE_PROBLEM, f"{name} at {at}: {run.returncode} {run.stderr}")
        check(re.search(cause, run.stderr), f"{name} at {at}: {run.stderr}")
        check(not (bench.folder / "out.jsonl").exists(), "an output of a job that failed")
        return "stopped"
    finally:
        firmware.close()


def faults(bench, n_faults, part=0, n_parts=1):
    """At messages all over the job, each fault in turn on each firmware; a part of these trials."""
    kinds = {**COMMON, **HAL_ONLY}
    plan = []
    for kind in ("grblhal", "grbl"):
        firmware = bench.firmware(kind)
        line = Line(firmware, SURFACE_MM if kind == "grblhal" else None)
        bench.write_machine(line)
        bench.probe(N_FAULTY_PROBES)
        line.close()
        firmware.close()
        # The first messages wake the control up: what comes then is passed over.
        plan += [(kind, name, at) for at in range(4, line.n_messages)
                 for name in (kinds if kind == "grblhal" else COMMON)]
    # Coprime steps pass through the whole plan.
    step = next(n for n in range(len(plan) // 3, len(plan)) if gcd(n, len(plan)) == 1)
    outcomes = Counter()
    for i in range(part, n_faults, n_parts):
        kind, name, at = plan[i * step % len(plan)]
        outcomes[kind, name, one_fault(bench, kind, name, *kinds[name], at)] += 1
    return outcomes


def tripped(bench):
    """A probe that is tripped before it moves, and one that never trips."""
    for key, to_mm, cause in (("p", -6.5, "tripped before it moves"), ("", -2.9, "ALARM:5")):
        firmware = bench.firmware("grblhal")
        try:
            if key:
                firmware.key(key)
                time.sleep(0.2)
            line = Line(firmware)
            bench.write_machine(line, to_mm=to_mm)
            run = bench.probe(1)
            line.close()
            check(run.returncode == DEVICE_PROBLEM and cause in run.stderr, run.stderr)
            check((line.n_moves == 0) == bool(key), f"{line.n_moves} moves")
        finally:
            firmware.close()


def interrupted(bench, kind):
    """A signal in a move: the jog is cancelled on its way."""
    firmware = bench.firmware(kind)
    try:
        line = Line(firmware)
        bench.write_machine(line)
        text = probing_program(1).replace("X5.Y5.", "X180.Y180.")
        (bench.folder / "probing.sm").write_text(text)
        process = subprocess.Popen([bench.options.panelcal, "run", "probing.sm", "-m", "machine.toml",
                                    "--camera", "folder:pictures", "-o", "out.jsonl"], cwd=bench.folder,
                                   text=True, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL)
        until = time.monotonic() + 60
        while not (line.last_jog and "X180" in line.last_jog) and time.monotonic() < until:
            time.sleep(0.02)
        time.sleep(0.3)
        process.send_signal(signal.SIGTERM)
        error = process.communicate(timeout=60)[1]
        line.close()
        _, at = firmware.resting_place()
        check(at[0] < 180, f"it went on to {at}: {error}")
        check("the machine stands at" in error, error)
    finally:
        firmware.close()


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("panelcal")
    parser.add_argument("repository")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--probes", type=int, default=3)
    parser.add_argument("--faults", type=int, default=6)
    options = parser.parse_args()
    if not os.environ.get("PANELCAL_GRBL"):
        print("SKIP: PANELCAL_GRBL does not name the folder of grblhal_sim and grbl_sim")
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(options, folder)
        (bench.folder / "pictures").mkdir()
        for kind in ("grblhal", "grbl"):
            moves, worst_mm = jobs(bench, kind, options.jobs)
            print(f"{kind}: {moves} moves, at most {1000 * worst_mm:.1f} um from the place", flush=True)
            interrupted(bench, kind)
            print(f"{kind}: stopped by a signal", flush=True)
        print(f"grblhal: {probes(bench, options.probes)} probes", flush=True)
        tripped(bench)
        outcomes = faults(bench, options.faults)
        for (kind, name, outcome), n in sorted(outcomes.items()):
            print(f"{kind}: {name}: {n} {outcome}")
        print(f"{sum(outcomes.values())} faults")
    return 0


if __name__ == "__main__":
    sys.exit(main())
