#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""How often the stated 95 % of calibrations hold the truth, on draws that no code of panelcal made.

    coverage.py PROGRAM [--kind KIND] [--case TEXT] [--draws N] [--seeds S,S,S] [--jobs N] [--check] [--quick]

PROGRAM is calibration_estimates (estimate.cc), built with the tests. Truth, noise and geometry of each kind are in
KIND_draws.py, written from docs/conventions.md and docs/formulation.md; they share no code with panelcal's simulations. A case says
as `refusable` which share of its draws may be refused, 5 % where it says nothing.
"""
import argparse
import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np

import camera_draws
import settle_draws
import spindle_draws
import table_draws
import trial_draws

KINDS = {"spindle-camera": spindle_draws, "camera": camera_draws, "table": table_draws, "settle": settle_draws,
         "focus": trial_draws.Focus}

SIGMAS_95 = 1.959964


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
    """Of n draws of one case what was estimated and what is true; a draw depends on seed and number only."""
    module = KINDS[kind]
    estimator = Program(program)
    answers = []
    for i in range(n):
        rng = np.random.default_rng([seed, i])
        if kind == "settle":
            drawn = module.draw(rng, module.CASES[case], estimator.ask)
        else:
            drawn = module.draw(rng, module.CASES[case])
        answers.append((estimator.ask(kind, drawn[0]), drawn[1], drawn[2] if len(drawn) > 2 else []))
    if estimator.close() != 0:
        raise RuntimeError(f"{program} ended with an error")
    return answers


def holds(kind, answers):
    """Names of what is estimated; for each draw that was not refused whether 95 % hold the truth, and the
    error in sigmas (no number for an interval)."""
    names = KINDS[kind].NAMES + getattr(KINDS[kind], "SPREADS", [])
    inside, errors = [], []
    for found, truth, spreads in answers:
        if "refused" in found:
            continue
        with np.errstate(divide="ignore", invalid="ignore"):
            e = (np.array(found["value"]) - truth) / np.array(found["sigma"])
        low_to_high = [low <= s <= high for s, low, high in zip(spreads, found.get("low", []), found.get("high", []))]
        inside.append(list(np.abs(e) <= SIGMAS_95) + low_to_high)
        errors.append(list(e) + [np.nan] * len(low_to_high))
    return names, np.array(inside, dtype=bool).reshape(-1, len(names)), np.array(errors).reshape(-1, len(names))


def is_within(inside):
    """Whether chance leaves each number's coverage in 92..98 % (three standard deviations)."""
    if not len(inside):
        return False
    slack = 3 * np.sqrt(0.95 * 0.05 / len(inside))
    coverage = inside.mean(axis=0)
    return bool(np.all((coverage > 0.92 - slack) & (coverage < 0.98 + slack)))


def report(kind, case, by_seed):
    """Lines for a person; returns hits and trials."""
    parts = [holds(kind, answers) for answers in by_seed]
    names = parts[0][0]
    inside = np.concatenate([p[1] for p in parts])
    errors = np.concatenate([p[2] for p in parts])
    found = [a[0] for answers in by_seed for a in answers]
    reasons = {}
    for f in found:
        if "refused" in f:
            reasons[f["refused"][:60]] = reasons.get(f["refused"][:60], 0) + 1
    print(f"{kind}: {case}: {len(inside)} of {len(found)} draws" + (f", refused: {reasons}" if reasons else ""))
    for i, name in enumerate(names):
        seeds = ", ".join("%.1f" % (100 * np.mean(p[1][:, i])) for p in parts if len(p[1]))
        chi2 = np.mean(errors[:, i] ** 2) if len(errors) else np.nan
        print("  %-18s %5.1f %% (%s)%s" % (name, 100 * np.mean(inside[:, i]) if len(inside) else np.nan, seeds,
                                           "" if np.isnan(chi2) else "  chi square %.2f" % chi2))
    if "safe" in found[0] or any("safe" in f for f in found):
        more = np.array([f["safe"] - t[0] for answers in by_seed for f, t, _ in answers if "safe" in f])
        print("  safe wait too short in %d of %d, longer than needed by %.1f ms in the median, %.1f at most" % (
            np.sum(more < 0), len(more), 1e3 * np.median(more), 1e3 * more.max()))
    for key in ("form", "open", "excess", "left_out", "aliases", "refusal"):
        values = [f[key] for f in found if f.get(key, "") != ""]
        if values and isinstance(values[0], str):
            print("  %s: %s" % (key, {v: values.count(v) for v in sorted(set(values))}))
        elif values:
            print("  %s: %.3g in the mean, %.3g at most" % (key, np.mean(values), np.max(values)))
    sys.stdout.flush()
    return int(inside.sum()), inside.size


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("program")
    parser.add_argument("--kind", choices=list(KINDS))
    parser.add_argument("--case", default="", help="only cases whose name contains this")
    parser.add_argument("--draws", type=int, default=400)
    parser.add_argument("--seeds", default="1,2,3")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--quick", action="store_true", help="40 draws, one seed, no case that takes minutes")
    parser.add_argument("--check", action="store_true", help="fail outside 92..98 %%, three standard deviations of chance off")
    options = parser.parse_args()
    if options.quick:
        options.draws, options.seeds = 40, "1"
    seeds = [int(s) for s in options.seeds.split(",")]
    is_good = True
    with ThreadPoolExecutor(options.jobs) as pool:
        for kind in [options.kind] if options.kind else KINDS:
            n_held = n_all = 0
            for case in (c for c in KINDS[kind].CASES if options.case in c):
                if options.quick and KINDS[kind].CASES[case].get("is_slow"):
                    continue
                by_seed = list(pool.map(lambda s: run(options.program, kind, case, s, options.draws), seeds))
                held, n = report(kind, case, by_seed)
                n_held, n_all = n_held + held, n_all + n
                all_draws = sum(by_seed, [])
                inside = holds(kind, all_draws)[1]
                refusable = KINDS[kind].CASES[case].get("refusable", 0.05)
                is_good &= is_within(inside) and len(inside) > (1 - refusable) * len(all_draws)
            if n_all:
                print("%s: all %.1f %% of %d\n" % (kind, 100 * n_held / n_all, n_all))
    return 0 if is_good or not options.check else 1


if __name__ == "__main__":
    sys.exit(main())
