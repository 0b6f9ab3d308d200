#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that every diagnostic stands in some case's expected.err, and that no case has another one.

    every_code_has_a_case.py
"""
import re
import sys
from pathlib import Path

GOLDEN = Path(__file__).resolve().parent
CATALOGUE = GOLDEN.parent.parent / "calib" / "base" / "diagnostic_codes.def"

# Codes that no input can provoke, and why.
EXCEPTIONS = {
    "internal": "panelcal's own mistake; no input may provoke it",
    "ledger-busy": "needs another program at the same moment; tests/calib/ledger/ledger_file_test.cc has one",
}


def main():
    catalogue = set(re.findall(r'^PANELCAL_DIAGNOSTIC\(\w+, "?([a-z-]+)"?,',
                               CATALOGUE.read_text(), re.MULTILINE))
    if not catalogue:
        sys.exit(f"{CATALOGUE.name}: no diagnostic found; has its form changed?")
    seen = set()
    for path in GOLDEN.glob("*/*/expected.err"):
        text = path.read_text(encoding="utf-8", errors="replace")
        seen.update(re.findall(r"\b(?:error|warning)\[([a-z-]+)\]", text))
    problems = [f"{slug}: no case" for slug in sorted(catalogue - seen - EXCEPTIONS.keys())]
    problems += [f"{slug}: in a case, but not in the catalogue" for slug in sorted(seen - catalogue)]
    problems += [f"{slug}: an exception that has a case" for slug in sorted(seen & EXCEPTIONS.keys())]
    print("\n".join(problems), end="\n" if problems else "")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
