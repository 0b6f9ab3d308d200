#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that the cases hold every diagnostic, each once with its wording, and no other one.

    every_code_has_a_case.py
"""
import re
import sys

from golden_source import source_text
from golden_wording import diagnostics

CATALOGUE = "diagnostic_codes.def"
# Codes that no input can provoke, and why.
EXCEPTIONS = {
    "internal": "panelcal's own mistake; no input may provoke it",
    "interrupted": "needs a signal; signal_test.py has one",
    "out-of-memory": "needs a limit of the system; memory_limit_test.py has one",
    "ledger-busy": "needs another program at the same moment; ledger_file_test.cc has one",
}


def main():
    catalogue = set(re.findall(r'^PANELCAL_DIAGNOSTIC\(\w+, "?([a-z-]+)"?,',
                               source_text(CATALOGUE, "PANELCAL_DIAGNOSTIC("), re.MULTILINE))
    if not catalogue:
        sys.exit(f"{CATALOGUE}: no diagnostic found; has its form changed?")
    lines = diagnostics()
    seen = {line.code for line in lines}
    worded = {line.code for line in lines if line.message is not None}
    problems = [f"{code}: no case" for code in sorted(catalogue - seen - EXCEPTIONS.keys())]
    problems += [f"{code}: no case pins its wording: one of its lines must be whole"
                 for code in sorted(seen - worded)]
    problems += [f"{code}: in a case, but not in the catalogue" for code in sorted(seen - catalogue)]
    problems += [f"{code}: an exception that has a case" for code in sorted(seen & EXCEPTIONS.keys())]
    print("\n".join(problems), end="\n" if problems else "")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
