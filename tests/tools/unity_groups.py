#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""unity_groups.py MAX FILE...: splits test files into groups that can be compiled as one.

Tests may use a name such as kSigma_mm in every file, so a group takes no two files that define the
same name in an anonymous namespace. Prints a group a line, its files between semicolons.
"""
import pathlib
import sys

from unique_names_test import names_of

# Each of these makes another name of its arguments.
MACROS = ("TEST", "TEST_F", "TEST_P", "INSTANTIATE_TEST_SUITE_P", "TYPED_TEST", "RC_GTEST_PROP",
          "RC_GTEST_FIXTURE_PROP")


def may_join(names, group):
    """No name of a file means something else in the group."""
    for name, (alias, _) in names.items():
        if name in group and (alias is None or alias != group[name]):
            return False
    return True


def main():
    max_size = int(sys.argv[1])
    groups = []  # [files, name -> alias]
    for file in sys.argv[2:]:
        names = {n: d for n, d in names_of(pathlib.Path(file).read_text()).items() if n not in MACROS}
        for files, known in groups:
            if len(files) < max_size and may_join(names, known):
                break
        else:
            files, known = [], {}
            groups.append([files, known])
        files.append(file)
        known.update({name: alias for name, (alias, _) in names.items()})
    for files, _ in groups:
        print(";".join(files))


if __name__ == "__main__":
    main()
