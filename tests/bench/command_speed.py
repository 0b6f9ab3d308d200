#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Speed and memory of whole commands, as a person types them, against two peers of the same run.

Writes a plain Excellon program and a tiny one that differs only in its holes. A round runs each
command on both and takes the difference of their processor times, so that starting the process does
not count; the floor (std::from_chars on every number of the file) and libgerbv's load of the same
file are measured in the same round. The result is the median over the rounds of each ratio.

  command_speed.py PANELCAL COMMAND_FLOOR [--holes N] [--rounds N] [--memory-holes N]
"""

import argparse
import os
import random
import statistics
import subprocess
import sys
import tempfile

SEED = 20261121
TINY_HOLES = 3
HEAD = "M48\nMETRIC,TZ\nT1C0.8\nT2C1.0\nT3C1.2\n%\n"
TARGETS_MM = [(10, 10), (490, 10), (10, 590)]
MACHINE = '[machine]\nname = "bench"\n\n[vision]\nrotate = 3\nmodel = "rigid"\n'


def write_program(path, n_holes, has_targets):
    """15 bytes a hole, three tools; piece by piece, so that this process stays small."""
    draw = random.Random(SEED).randrange
    change = n_holes // 3 + 1
    with open(path, "w", encoding="ascii") as file:
        file.write(HEAD)
        if has_targets:
            file.write("G34,1\n")
            for x, y in TARGETS_MM:
                file.write(f"G36X{1000 * x:06}Y{1000 * y:06}\n")
        for i in range(n_holes):
            if i % change == 0:
                file.write(f"T{1 + i // change}\n")
            file.write(f"X{draw(1000000):06}Y{draw(1000000):06}\n")
        file.write("M30\n")


def write_measurements(path):
    """A panel that is shifted, and turned by 1 mrad; each target is seen within 1 um."""
    first_line = HEAD.count("\n") + 2
    with open(path, "w", encoding="ascii") as file:
        for i, (x, y) in enumerate(TARGETS_MM):
            measured = f"[{x - 1e-3 * y + 0.3},{y + 1e-3 * x - 0.2}]"
            file.write(f'{{"seq":{i},"line":{first_line + i},"command":"G36","tool":1,'
                       f'"nominal":[{x},{y}],"expected":[{x},{y}],"path":[],'
                       f'"measured":{measured},"cov":[1e-6,0,1e-6],"status":"found"}}\n')


class Usage:
    """What a process took: processor seconds and peak MB."""

    def __init__(self, command, output=None):
        if output is not None and os.path.exists(output):
            os.remove(output)
        with subprocess.Popen(command, stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE) as child:
            errors = child.stderr.read()
            _, status, usage = os.wait4(child.pid, 0)
            child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode != 0:
            sys.exit(f"{' '.join(command)} failed with {child.returncode}:\n{errors.decode()}")
        self.user_s = usage.ru_utime
        self.cpu_s = usage.ru_utime + usage.ru_stime
        self.peak_mb = usage.ru_maxrss * 1024 / 1e6


class Row:
    def __init__(self, name, words, program, suffix=None, goal=None):
        self.name = name
        self.words = words
        self.program = program
        self.suffix = suffix
        self.goal = goal
        self.user_s = []
        self.cpu_s = []
        self.n_bytes = 0

    def run(self, panelcal, folder, size):
        command = [panelcal, self.words[0], f"{folder}/{self.program}-{size}.drl"] + self.words[1:]
        output = None
        if self.suffix:
            output = f"{folder}/out{self.suffix}"
            command += ["-o", output]
        usage = Usage(command, output)
        if output:
            self.n_bytes = os.path.getsize(output)
        return usage

    def measure(self, panelcal, folder):
        tiny = self.run(panelcal, folder, "tiny")
        large = self.run(panelcal, folder, "large")
        self.user_s.append(large.user_s - tiny.user_s)
        self.cpu_s.append(large.cpu_s - tiny.cpu_s)


def peers(floor, path):
    """Seconds that the floor and libgerbv take; libgerbv may be missing."""
    words = subprocess.run([floor, path], check=True, capture_output=True, text=True).stdout.split()
    return float(words[0]), None if words[1] == "missing" else float(words[1])


def median_ratio(seconds, peer_seconds):
    return statistics.median(a / b for a, b in zip(seconds, peer_seconds))


def rows_of(folder):
    machine = ["-m", f"{folder}/machine.toml"]
    measured = ["run"] + machine + ["--measurements", f"{folder}/measurements.jsonl"]
    return [
        Row("check, no targets", ["check"], "plain", goal=2.0),
        Row("check", ["check"], "targets", goal=2.0),
        Row("run -o x.drl, no targets", ["run"] + machine, "plain", ".drl", 4.0),
        Row("run -o x.drl", measured, "targets", ".drl", 4.0),
        Row("run -o x.csv, no targets", ["run"] + machine, "plain", ".csv", 4.0),
        Row("run -o x.csv", measured, "targets", ".csv", 4.0),
        Row("run -o x.jsonl", measured, "targets", ".jsonl"),
    ]


def print_speed(rows, floors, gerbv, n_holes):
    print(f"{'':<26}{'user ns/hole':>13}{'+ system':>10}{'/ floor':>9}{'+ system':>10}"
          f"{'/ libgerbv':>12}{'MB out':>8}  goal")
    print(f"{'floor: from_chars':<26}{statistics.median(floors) / n_holes * 1e9:>13.1f}")
    if gerbv:
        print(f"{'libgerbv loads':<26}{statistics.median(gerbv) / n_holes * 1e9:>13.1f}"
              f"{'':>10}{median_ratio(gerbv, floors):>9.1f}")
    for row in rows:
        by_gerbv = f"{median_ratio(row.cpu_s, gerbv):.2f}" if gerbv else "missing"
        print(f"{row.name:<26}{statistics.median(row.user_s) / n_holes * 1e9:>13.1f}"
              f"{statistics.median(row.cpu_s) / n_holes * 1e9:>10.1f}"
              f"{median_ratio(row.user_s, floors):>9.2f}{median_ratio(row.cpu_s, floors):>10.2f}"
              f"{by_gerbv:>12}{row.n_bytes / 1e6:>8.1f}"
              f"  {'' if row.goal is None else f'<= {row.goal} floors'}")


def print_memory(rows, panelcal, folder, n_holes):
    print(f"\npeak MB, {n_holes} holes{'':<8}{'file':>8}{'peak':>8}{'beside the file':>17}{'tiny':>8}")
    for row in rows:
        file_mb = os.path.getsize(f"{folder}/{row.program}-large.drl") / 1e6
        tiny = row.run(panelcal, folder, "tiny").peak_mb
        peak = row.run(panelcal, folder, "large").peak_mb
        print(f"{row.name:<28}{file_mb:>8.1f}{peak:>8.1f}{peak - file_mb:>17.1f}{tiny:>8.1f}")


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("panelcal")
    parser.add_argument("floor", help="the target command_floor")
    parser.add_argument("--holes", type=int, default=10**6)
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--memory-holes", type=int, default=10**7, help="0: memory is left out")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        with open(f"{folder}/machine.toml", "w", encoding="ascii") as file:
            file.write(MACHINE)
        write_measurements(f"{folder}/measurements.jsonl")

        def write_programs(n_large):
            for name, has_targets in (("plain", False), ("targets", True)):
                write_program(f"{folder}/{name}-tiny.drl", TINY_HOLES, has_targets)
                write_program(f"{folder}/{name}-large.drl", n_large, has_targets)

        rows = rows_of(folder)
        if args.rounds > 0:
            write_programs(args.holes)
            floors, gerbv = [], []
            for _ in range(args.rounds):
                floor_s, gerbv_s = peers(args.floor, f"{folder}/plain-large.drl")
                floors.append(floor_s)
                if gerbv_s is not None:
                    gerbv.append(gerbv_s)
                for row in rows:
                    row.measure(args.panelcal, folder)
            print(f"{args.holes} holes, {os.path.getsize(f'{folder}/plain-large.drl') / 1e6:.1f} MB, "
                  f"medians of {args.rounds} rounds")
            print_speed(rows, floors, gerbv, args.holes)
        if args.memory_holes > 0:
            write_programs(args.memory_holes)
            print_memory(rows, args.panelcal, folder, args.memory_holes)


if __name__ == "__main__":
    main()
