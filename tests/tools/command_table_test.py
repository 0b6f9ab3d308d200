#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every row of the command table names a test file that exists and shows the command."""

import re
import sys
from pathlib import Path


def main():
    root = Path(sys.argv[1])
    table = (root / "program/excellon/commands.def").read_text()
    rows = re.findall(r"^EXCELLON_COMMAND\(\w+, '(\w)', (\d+), .*\"(\w+)\"\)$", table, re.MULTILINE)
    words = re.findall(r"^EXCELLON_WORD\(\"(.*?)\", \w+, .*\"(\w+)\"\)$", table, re.MULTILINE)
    problems = []
    for letter, number, test in rows:
        file = root / f"tests/program/{test}.cc"
        code = rf"{letter}0?{number}(?!\d)"
        if not file.exists():
            problems.append(f"{letter}{number}: there is no {test}")
        elif not re.search(code, file.read_text()):
            problems.append(f"{letter}{number}: {test} does not show it")
    for form, test in words:
        if not (root / f"tests/program/{test}.cc").exists():
            problems.append(f"{form}: there is no {test}")
    print(f"{len(rows)} commands, {len(words)} words")
    for problem in problems:
        print(problem)
    sys.exit(1 if problems or not rows else 0)


if __name__ == "__main__":
    main()
