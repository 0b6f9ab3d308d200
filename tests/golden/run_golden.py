#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs golden cases against a panelcal binary; README.md here says what a case consists of.

    run_golden.py PANELCAL CASE              prints a diff and exits 1 if something differs
    run_golden.py PANELCAL --update CASE...  shows each case's diff, and asks whether to take it
"""
import os
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from golden_case import CaseError, load  # noqa: E402
from golden_compare import differences  # noqa: E402
from golden_run import run  # noqa: E402


def main(arguments):
    wants_update = "--update" in arguments
    panelcal, *cases = [word for word in arguments if word != "--update"] or [None]
    if not cases or len(cases) > 1 and not wants_update:
        sys.exit(__doc__)
    try:
        if wants_update:
            from golden_update import update
            return update(panelcal, cases)
        case = load(cases[0])
        found = differences(case, run(panelcal, case))
    except CaseError as problem:
        sys.exit(str(problem))
    print("".join(found), end="")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
