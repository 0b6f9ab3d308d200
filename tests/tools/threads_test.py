#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Bytes of `locate` and `run` do not depend on the number of threads, nor do refusals."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

# ThreadSanitizer ends with this; it is told not to watch libraries that were built without it.
RACE = 66


def run(panelcal, folder, *words):
    environment = dict(os.environ, TSAN_OPTIONS=f"exitcode={RACE} ignore_noninstrumented_modules=1")
    done = subprocess.run([panelcal, *map(str, words)], cwd=folder, env=environment,
                          capture_output=True, check=False)
    assert done.returncode not in (RACE, 3), done.stderr.decode()
    return done.returncode, done.stdout, done.stderr


def outputs(panelcal, root, n_threads, pictures):
    """All bytes that come of `locate`, `locate --suggest` and `run`, by name."""
    demo = root / "datasets/demo"
    out = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        overlay = folder / "seen"
        located = ["locate", *pictures, "-m", demo / "machine.toml", "--threads", n_threads]
        out["locate"] = run(panelcal, folder, *located, "--tool", 1, "--overlay", overlay)
        for png in sorted(overlay.iterdir()):
            out[png.name] = png.read_bytes()
        out["suggest"] = run(panelcal, folder, *located, "--suggest")
        for program in ("panel.exc", "lost.exc"):
            shutil.copy(demo / "panel.exc", folder / program)
        images = folder / "images"
        shutil.copytree(demo / "images", images)
        job = ["run", "panel.exc", "-m", demo / "machine.toml", "--images", "images", "--threads",
               n_threads, "--clock", "2026-11-23T12:00:00"]
        out["run"] = run(panelcal, folder, *job, "-o", "corrected.drl", "--save-measurements",
                         "measured.jsonl")
        out["corrected"] = (folder / "corrected.drl").read_bytes()
        out["measured"] = (folder / "measured.jsonl").read_bytes()
        # A picture that cannot be read ends the job at the same place.
        (images / "0012.png").write_bytes(b"no picture")
        out["damaged"] = run(panelcal, folder, *job, "-o", "none.drl")
        assert out["run"][0] == 0 and out["damaged"][0] == 2, (out["run"], out["damaged"])
    return out


def main():
    panelcal, root = sys.argv[1], Path(sys.argv[2])
    pictures = sorted((root / "datasets/demo/images").glob("*.png"))
    pictures.insert(5, root / "CMakeLists.txt")  # refused, in its place
    alone = outputs(panelcal, root, 1, pictures)
    for n_threads in (2, 5):
        for name, got in outputs(panelcal, root, n_threads, pictures).items():
            assert got == alone[name], f"{name} differs with {n_threads} threads"
    print(f"{len(alone)} outputs are the same with 1, 2 and 5 threads")


if __name__ == "__main__":
    main()
