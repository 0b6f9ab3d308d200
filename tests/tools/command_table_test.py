#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Every row of the command tables names a test file that exists and shows the command."""

import re
import sys
from pathlib import Path

TABLES = [
    ("EXCELLON", "program/excellon/text/commands.def", "tests/program/excellon"),
    ("SIEB_MEYER", "program/sieb_meyer/text/commands.def", "tests/program/sieb_meyer"),
]


def test_file(root, folder, test):
    """Tests of what both languages share stand in another folder of tests/program."""
    found = sorted((root / folder).rglob(f"{test}.cc"))
    return next(iter(found or sorted((root / "tests/program").rglob(f"{test}.cc"))), None)


def problems_of(root, name, table, folder):
    """Also how many commands and words the table has."""
    text = (root / table).read_text()
    commands = re.findall(rf"^{name}_COMMAND\(\w+, '(\w)', (\d+), .*?\"(\w+_test)\", .+\)$", text,
                          re.MULTILINE)
    words = re.findall(rf"^{name}_WORD\(\"(.*?)\", \w+, .*\"(\w+)\"\)$", text, re.MULTILINE)
    problems = []
    for letter, number, test in commands:
        file = test_file(root, folder, test)
        if not file:
            problems.append(f"{letter}{number}: there is no {test}")
        elif not re.search(rf"{letter}0?{number}(?!\d)", file.read_text()):
            problems.append(f"{letter}{number}: {test} does not show it")
    for form, test in words:
        if not test_file(root, folder, test):
            problems.append(f"{form}: there is no {test}")
    if not commands or not words:
        problems.append(f"{table} has no rows")
    print(f"{table}: {len(commands)} commands, {len(words)} words")
    return problems


def main():
    root = Path(sys.argv[1])
    problems = [problem for table in TABLES for problem in problems_of(root, *table)]
    for problem in problems:
        print(problem)
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
