#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How often the stated 95 % of calibrations hold the truth, on draws that no code of panelcal made.

    coverage.py PROGRAM [--kind KIND] [--case TEXT] [--draws N] [--seeds S,S,S] [--jobs N] [--check]
"""
import argparse
import json
import subprocess
from concurrent.futures import ThreadPoolExecutor

import numpy as np

import camera_draws
import table_draws
import settle_draws

KINDS = {"camera": camera_draws, "table": table_draws, "settle": settle_draws}


class Program:
    """panelcal's estimates, one draw after the other."""

    def __init__(self, program):
        self.process = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def ask(self, kind, lines):
        self.process.stdin.write(f"draw {kind}\n" + "\n".join(lines) + "\nend\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def close(self):
        self.process.stdin.close()
        return self.process.wait()


def run(program, kind, case, seed, n):
    """Estimates and truths of n draws of one case; a draw depends on the seed and its number only."""
    module = KINDS[kind]
    estimator = Program(program)
    found, truths = [], []
    for i in range(n):
        rng = np.random.default_rng([seed, i])
        if kind == "settle":
            lines, truth = module.draw(rng, module.CASES[case], estimator.ask)
        else:
            lines, truth = module.draw(rng, module.CASES[case])
        found.append(estimator.ask(kind, lines))
        truths.append(truth)
    if estimator.close() != 0:
        raise RuntimeError(f"{program} ended with an error")
    return found, truths


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("--kind")
    parser.add_argument("--case", default="")
    parser.add_argument("--draws", type=int, default=400)
    parser.add_argument("--seeds", default="1,2,3")
    parser.add_argument("--jobs", type=int, default=1)
    options = parser.parse_args()
    seeds = [int(s) for s in options.seeds.split(",")]
    tasks = [(kind, case, seed) for kind in ([options.kind] if options.kind else KINDS)
             for case in KINDS[kind].CASES if options.case in case for seed in seeds]
    with ThreadPoolExecutor(options.jobs) as pool:
        answers = list(pool.map(lambda t: run(options.program, t[0], t[1], t[2], options.draws), tasks))
    for kind in KINDS:
        for case in dict.fromkeys(t[1] for t in tasks if t[0] == kind):
            report(kind, case, [(t[2], a) for t, a in zip(tasks, answers) if t[:2] == (kind, case)])


def report(kind, case, by_seed):
    names = KINDS[kind].NAMES
    n_refused, reasons = 0, {}
    rows = []
    for seed, (found, truths) in by_seed:
        e = []
        for f, truth in zip(found, truths):
            if "refused" in f:
                n_refused += 1
                reasons[f["refused"][:70]] = reasons.get(f["refused"][:70], 0) + 1
                continue
            e.append((np.array(f["value"]) - np.array(truth)) / np.array(f["sigma"]))
        rows.append(np.array(e).reshape(-1, len(names)))
    e = np.concatenate(rows)
    print(f"{kind}: {case}: {len(e)} of {len(e) + n_refused} draws, refused {reasons}")
    for i, name in enumerate(names):
        ok = np.isfinite(e[:, i])
        if not ok.any():
            continue
        inside = [100 * np.mean(np.abs(r[:, i][np.isfinite(r[:, i])]) <= 1.959964) for r in rows if len(r)]
        print("   %-22s %5.1f %% (%s)  mean %+.2f  chi2 %.2f" % (
            name, 100 * np.mean(np.abs(e[ok, i]) <= 1.959964), " ".join("%.1f" % v for v in inside),
            np.mean(e[ok, i]), np.mean(e[ok, i] ** 2)))
    short = [f["safe"] < t[0] for _, (found, truths) in by_seed for f, t in zip(found, truths) if "safe" in f]
    if short:
        extra = [f["safe"] - t[0] for _, (found, truths) in by_seed for f, t in zip(found, truths) if "safe" in f]
        print("    safe wait too short in %d of %d; longer than needed by %.4f s in the median, %.3f at most" % (
            sum(short), len(short), np.median(extra), max(extra)))
    for key in ("form", "excess", "left_out", "open", "refusal", "motion", "aliases", "hz"):
        values = [f[key] for _, (found, _) in by_seed for f in found if key in f]
        if values and isinstance(values[0], str):
            print("   ", key, {v: values.count(v) for v in sorted(set(values))})
        elif values:
            print("   ", key, "mean", np.mean(values), "max", np.max(values))
    return


if __name__ == "__main__":
    main()
