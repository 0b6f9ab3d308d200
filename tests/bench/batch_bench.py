#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What `panelcal batch` takes, beside the single-threaded `locate` of the same pictures.

    batch_bench.py PANELCAL REPOSITORY [PICTURE_JOBS] [RECORDED_JOBS]

Prints CPU and wall seconds and peak memory of: PICTURE_JOBS (200) jobs of the demo's 21 pictures of 480 x 480, with as many runs of
`locate --threads 1` over each job's pictures in turn with pieces of the batch; and RECORDED_JOBS (10,000) jobs of 1,000 holes.
"""
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

N_SETS = 10
N_HOLES = 1000


def timed(panelcal, folder, *words, expect=0):
    """Wall and CPU seconds, and peak MB, of a call."""
    started = time.monotonic()
    child = subprocess.Popen([panelcal, *map(str, words)], cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    error = child.stderr.read()
    _, status, used = os.wait4(child.pid, 0)
    child.returncode = os.waitstatus_to_exitcode(status)
    assert child.returncode == expect, (words, child.returncode, error)
    return time.monotonic() - started, used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def picture_jobs(panelcal, folder, n_jobs):
    sets = [f"set-{i}" for i in range(N_SETS)]
    for i, name in enumerate(sets):
        timed(panelcal, folder, "synth", "panel.exc", "-m", "machine.toml", "-o", f"{name}/images", "--seed", i + 1)
    rows = ["id,program,machine,images,truth"]
    rows += [f"p{i},panel.exc,machine.toml,{sets[i % N_SETS]}/images,{sets[i % N_SETS]}/images/truth.json" for i in range(n_jobs)]
    (folder / "pictures.csv").write_text("\n".join(rows) + "\n")
    located = [0.0, 0.0]
    for i in range(n_jobs):
        pictures = sorted((folder / sets[i % N_SETS] / "images").glob("*.png"))
        wall, cpu, _ = timed(panelcal, folder, "locate", *pictures, "-m", "machine.toml", "--tool", 1, "--threads", 1)
        located = [located[0] + wall, located[1] + cpu]
        if i == n_jobs // 2:
            batch = timed(panelcal, folder, "batch", "pictures.csv", "-o", "pictures")
    n = os.cpu_count()
    print(f"{n_jobs} jobs x 21 pictures: batch {batch[0]:.1f} s wall, {batch[1]:.1f} s CPU, {batch[2]:.0f} MB; "
          f"locate, one thread: {located[0]:.1f} s wall, {located[1]:.1f} s CPU in sum")
    print(f"  wall x 0.9 x {n} cores / sum of locate: {batch[0] * 0.9 * n / located[0]:.2f}; the same of CPU: {0.9 * batch[1] / located[1]:.2f} (goal 1.00)")


def recorded_jobs(panelcal, folder, n_jobs):
    holes = "".join(f"X{5 + 0.5 * (i % 200):07.3f}Y{5 + 10 * (i // 200):07.3f}\n" for i in range(N_HOLES))
    demo = (folder / "panel.exc").read_text().splitlines(keepends=True)
    # The demo's header and its targets of the panel, with other holes.
    head = demo[:demo.index("%\n") + 1]
    targets = [line for line in demo if line.startswith(("G34", "G36"))][:4]
    (folder / "holes.exc").write_text("".join([*head, *targets, "T1\n", holes, "M30\n"]))
    timed(panelcal, folder, "run", "holes.exc", "-m", "machine.toml", "--machine-driver", "sim", "-o", "holes.drl",
          "--save-measurements", "holes.jsonl")
    rows = ["id,program,machine,measurements"]
    rows += [f"r{i},holes.exc,machine.toml,holes.jsonl" for i in range(n_jobs)]
    (folder / "recorded.csv").write_text("\n".join(rows) + "\n")
    for words in ([], ["--threads", 1]):
        shutil.rmtree(folder / "recorded", ignore_errors=True)
        wall, cpu, memory = timed(panelcal, folder, "batch", "recorded.csv", "-o", "recorded", *words)
        print(f"{n_jobs} recorded jobs of {N_HOLES} holes {' '.join(map(str, words))}: {wall:.1f} s wall, {cpu:.1f} s CPU, {memory:.0f} MB")


def main():
    panelcal, root = sys.argv[1], Path(sys.argv[2]).resolve()
    counts = [int(word) for word in sys.argv[3:]] + [200, 10_000][len(sys.argv) - 3:]
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file in ("panel.exc", "machine.toml", "camera.cal.json"):
            shutil.copy(root / "datasets/demo" / file, folder)
        if counts[1]:
            recorded_jobs(panelcal, folder, counts[1])
        if counts[0]:
            picture_jobs(panelcal, folder, counts[0])


if __name__ == "__main__":
    main()
