# SPDX-License-Identifier: Apache-2.0
"""What the tests of the Python module share: the demo's job, and the real program beside it."""
import os
import pathlib
import subprocess

import pytest

import panelcal

ROOT = pathlib.Path(__file__).resolve().parents[2]
DEMO = ROOT / "datasets" / "demo"
CLOCK = "2026-11-21T13:45:00"


def run_panelcal(*words, check=True):
    """Standard output of the real program."""
    done = subprocess.run([os.environ["PANELCAL"], *map(str, words)], capture_output=True, text=True)
    assert not check or done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="session")
def demo():
    return DEMO


@pytest.fixture(scope="session")
def machine():
    return panelcal.read_machine(DEMO / "machine.toml")
