#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A batch of 10,000,000 pictures on a cluster, computed from parts that are measured here: the table of docs/scaling.md.

    batch_scaling.py PANELCAL REPOSITORY [JOBS] [MANIFEST_ROWS]

Measures, in CPU seconds, which other programs on the computer hardly change: JOBS (100) jobs of 21 pictures in one process and in
four shards, the merge of their stores, and how long a shard takes that finds one job to do in a manifest of MANIFEST_ROWS (100,000).
"""
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from batch_bench import timed

N_PICTURES = 10_000_000
PER_JOB = 21
N_SETS = 10
N_SHARDS = 4
CORES = (2, 16, 64, 256, 1024)
CLOCK = ("--clock", "2026-11-28T00:00:00")


def n_bytes(*paths):
    return sum(file.stat().st_size for path in paths for file in ([path] if path.is_file() else path.rglob("*")) if file.is_file())


def prepare(panelcal, root, folder, n_jobs):
    for file in ("panel.exc", "machine.toml", "camera.cal.json"):
        shutil.copy(root / "datasets/demo" / file, folder)
    sets = [f"set-{i}" for i in range(N_SETS)]
    for i, name in enumerate(sets):
        timed(panelcal, folder, "synth", "panel.exc", "-m", "machine.toml", "-o", f"{name}/images", "--seed", i + 1)
    rows = ["id,program,machine,images,truth"]
    rows += [f"p{i},panel.exc,machine.toml,{sets[i % N_SETS]}/images,{sets[i % N_SETS]}/images/truth.json" for i in range(n_jobs)]
    (folder / "jobs.csv").write_text("\n".join(rows) + "\n")
    return n_bytes(*(folder / name / "images" for name in sets)) / N_SETS / PER_JOB


def measure(panelcal, root, n_jobs, n_rows):
    found = {}
    n = n_jobs * PER_JOB
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        found["read_bytes"] = prepare(panelcal, root, folder, n_jobs)
        _, whole, found["memory_mb"] = timed(panelcal, folder, "batch", "jobs.csv", "-o", "whole", *CLOCK, "--threads", 1)
        found["picture_s"] = whole / n
        found["written_bytes"] = n_bytes(folder / "whole/jobs") / n
        found["store_bytes"] = n_bytes(folder / "whole/store.sqlite") / n
        shards = [timed(panelcal, folder, "batch", "jobs.csv", "-o", "parts", *CLOCK, "--threads", 1, "--shard", f"{i}/{N_SHARDS}")[1]
                  for i in range(1, N_SHARDS + 1)]
        found["split"] = sum(shards) / whole
        merged = timed(panelcal, folder, "batch", "merge", "parts")[1]
        shown = timed(panelcal, folder, "batch", "show", "parts")[1]
        # Both end with the facts of the whole batch.
        found["merge_s"] = max(0.0, merged - shown) / n
        found["facts_s"] = shown / n
        (folder / "large.csv").write_text("id,program,machine,measurements\n" + "".join(
            f"r{i},panel.exc,machine.toml,none.jsonl\n" for i in range(n_rows)))
        _, cpu, memory = timed(panelcal, folder, "batch", "large.csv", "-o", "large", *CLOCK, "--threads", 1, "--shard", f"1/{min(n_rows, 5000)}",
                               "--sample", 1)
        found["row_s"] = cpu / n_rows
        found["row_bytes"] = max(0.0, memory - found["memory_mb"]) * 2**20 / n_rows
    return found


def duration(seconds):
    if seconds < 60:
        return f"{seconds / 60:.1f} min"
    return f"{seconds / 3600:.1f} h" if seconds >= 3600 else f"{seconds / 60:.0f} min"


def main():
    panelcal, root = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2]).resolve()
    n_jobs, n_rows = ([int(word) for word in sys.argv[3:]] + [100, 100_000][len(sys.argv) - 3:])
    found = measure(panelcal, root, n_jobs, n_rows)
    n_all_jobs = N_PICTURES / PER_JOB
    commit = subprocess.run(["git", "-C", root, "rev-parse", "--short", "HEAD"], capture_output=True, text=True, check=False).stdout.strip()
    print(f"commit {commit}, {os.cpu_count()} processors, {n_jobs} jobs x {PER_JOB} pictures, manifest of {n_rows:,} rows\n")
    print("| measured | |\n| --- | --- |")
    print(f"| CPU of a picture in a job, one thread | {1e3 * found['picture_s']:.2f} ms |")
    print(f"| CPU of four shards over that of one process | {found['split']:.2f} |")
    print(f"| read for a picture | {found['read_bytes'] / 1e3:.0f} kB |")
    print(f"| written for a picture, programs and facts | {found['written_bytes'] / 1e3:.2f} kB |")
    print(f"| store for a picture | {found['store_bytes'] / 1e3:.2f} kB |")
    print(f"| CPU of the merge for a picture | {1e6 * found['merge_s']:.1f} us |")
    print(f"| CPU of the facts of all for a picture | {1e6 * found['facts_s']:.1f} us |")
    print(f"| CPU of each shard for a row of the manifest | {1e6 * found['row_s']:.1f} us |")
    print(f"| memory of each shard for a row of the manifest | {found['row_bytes'] / 1e3:.2f} kB |")
    print(f"| memory of a shard besides | {found['memory_mb']:.0f} MB |\n")
    merge = N_PICTURES * (found["merge_s"] + found["facts_s"])
    start = n_all_jobs * found["row_s"]
    print(f"{N_PICTURES:,} pictures in {n_all_jobs:,.0f} jobs: {N_PICTURES * found['picture_s'] / 3600:.1f} core hours; "
          f"{N_PICTURES * found['read_bytes'] / 1e9:.0f} GB read, {N_PICTURES * found['written_bytes'] / 1e9:.1f} GB written, "
          f"store {N_PICTURES * found['store_bytes'] / 1e9:.1f} GB\n")
    print("| cores, a shard each | pictures | start of a shard | merge and facts, one core | in all | share of the ideal | disk, read |")
    print("| --- | --- | --- | --- | --- | --- | --- |")
    for cores in CORES:
        work = N_PICTURES * found["picture_s"] / cores
        total = work + start + merge
        print(f"| {cores:,} | {duration(work)} | {duration(start)} | {duration(merge)} | {duration(total)} | {work / total:.0%} | "
              f"{N_PICTURES * found['read_bytes'] / work / 1e6:,.0f} MB/s |")
    memory = found["memory_mb"] + n_all_jobs * found["row_bytes"] / 2**20
    print(f"\nmemory of a shard: {memory:,.0f} MB")


if __name__ == "__main__":
    main()
