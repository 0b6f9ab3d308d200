#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Names the tests that were skipped, and the reasons.

    skipped_tests.py RESULTS.xml [--strict]

RESULTS.xml is what `ctest --output-junit` wrote. With --strict a skipped test is a failure.
"""
import sys
import xml.etree.ElementTree as ElementTree


def skipped(results):
    """Pairs of a test's name and the last line that it printed, or why CTest did not run it."""
    for case in ElementTree.parse(results).getroot().iter("testcase"):
        note = case.find("skipped")
        if note is None:
            continue
        lines = (case.findtext("system-out") or "").strip().splitlines()
        reason = next((line for line in reversed(lines) if "SKIP" in line.upper()), "")
        yield case.get("name"), reason or note.get("message") or "it was not run"


def main(arguments):
    is_strict = "--strict" in arguments
    paths = [argument for argument in arguments if argument != "--strict"]
    if len(paths) != 1:
        sys.exit(__doc__)
    found = list(skipped(paths[0]))
    for name, reason in found:
        print(f"skipped: {name}: {reason.strip()}")
    if found and is_strict:
        print(f"{len(found)} skipped; every test must run here: install the programs, or give the "
              "permissions, that the lines above name", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
