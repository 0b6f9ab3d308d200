#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks the form of all case files: canonical, with fixtures that exist and are used, no copies.

    cases_are_sound.py
"""
import sys
from collections import defaultdict

from golden_case import (CaseError, all_inputs, expected_files, fixture_bytes, fixture_files, load,
                         text_of)
from golden_wording import case_paths, name_of

# Shorter inputs may be repeated: a reader has them before the eyes.
MAX_COPY_BYTES = 200


def problems_of(path, used, copies):
    try:
        case = load(path)
        all_inputs(case)
        expected_files(case)
    except CaseError as problem:
        return [str(problem)]
    for fixture, _ in case.uses:
        used.update(name for name, _ in fixture_files(fixture))
    used.update(case.same.values())
    for data in case.inputs.values():
        if len(data) >= MAX_COPY_BYTES:
            copies[data].append(name_of(path))
    if text_of(case) != path.read_bytes():
        return [f"{path}: not in the form that --update writes (order, blanks or needless escapes)"]
    return []


def main():
    used, copies, problems = set(), defaultdict(list), []
    for path in case_paths():
        problems += problems_of(path, used, copies)
    fixtures = {name: fixture_bytes(name) for name, _ in fixture_files("")}
    problems += [f"fixtures/{name}: no case uses it" for name in sorted(fixtures.keys() - used)]
    contents = defaultdict(list)
    for name, data in sorted(fixtures.items()):
        contents[data].append(name)
    problems += [f"fixtures/{names[0]}: the same as {names[1]}"
                 for names in contents.values() if len(names) > 1]
    problems += [f"{', '.join(cases)}: the same input, which should be a fixture"
                 for data, cases in copies.items() if len(cases) > 1 or data in contents]
    print("\n".join(problems), end="\n" if problems else "")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
