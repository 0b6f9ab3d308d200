# SPDX-License-Identifier: Apache-2.0
"""Set a job up: are its targets good enough, and where does each hole go?

    PYTHONPATH=build/release/python /usr/bin/python3 examples/python/job.py
"""
import argparse
import pathlib

import numpy as np

import panelcal

DEMO = pathlib.Path(__file__).resolve().parents[2] / "datasets" / "demo"

arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
arguments.add_argument("--job", type=pathlib.Path, default=DEMO,
                       help="a folder with panel.exc, machine.toml and images")
arguments.add_argument("--small", action="store_true", help="as the tests run it")
folder = arguments.parse_args().job

# The program and the machine, with everything that is wrong in them before anything moves.
machine = panelcal.read_machine(folder / "machine.toml")
program = panelcal.read_program(folder / "panel.exc", machine)
print(program)

# Before a picture is taken: how well do these targets determine the holes?
planned = panelcal.plan(program, machine)
print(f"plan: {len(planned['series'])} kinds of series of targets")

# Measure, fit, hold against the limits, correct.
job = panelcal.correct(program, machine, images=folder / "images", n_threads=0)
print(f"{job.verdict}: {job.facts['verdict']['grounds']}")
if not job.may_be_drilled:
    raise SystemExit(1)

# The holes are arrays: where they go, how far from the drawing, how sure that is.
holes = job.holes
shift_um = 1e3 * np.linalg.norm(holes.actual_mm - holes.nominal_mm, axis=1)
print(f"{len(holes)} holes move by {shift_um.min():.0f} to {shift_um.max():.0f} um, "
      f"sigma up to {1e3 * holes.sigma_mm.max():.2f} um")

# The same job from its measurements alone: another vision system could have made them.
again = panelcal.correct(program, machine, job.measurements, facts=False)
assert np.array_equal(again.holes.actual_mm, holes.actual_mm)
