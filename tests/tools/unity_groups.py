#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""unity_groups.py MAX FILE...: splits test files into groups that can be compiled as one.

Tests may use a name such as kSigma_mm in every file, so a group takes no two files that define the
same name in an anonymous namespace. A file that gives a name of a header another meaning stays
alone: after it the header could not be read. Prints a group a line, its files between semicolons.
"""
import pathlib
import re
import sys

from unique_names_test import LIBRARIES, names_of

# Each of these makes another name of its arguments.
MACROS = ("TEST", "TEST_F", "TEST_P", "INSTANTIATE_TEST_SUITE_P", "TYPED_TEST", "RC_GTEST_PROP",
          "RC_GTEST_FIXTURE_PROP")


def group_names(source):
    """Name -> what it is an alias of, or None: what may clash in a group."""
    names = {name: alias for name, (alias, _) in names_of(source).items() if name not in MACROS}
    for path, name in re.findall(r"^ *using (?:::)?([\w:]+)::(\w+);", source, flags=re.M):
        names[name] = f"{path}::{name}"
    return names


def header_names():
    """Types and constants that the headers of the product and of the tests declare."""
    root = pathlib.Path(__file__).resolve().parents[2]
    names = set()
    for folder in (*LIBRARIES, "tests/support"):
        for header in (root / folder).rglob("*.h"):
            names.update(re.findall(r"^(?:(?:struct|class|enum class|using)|inline constexpr [^=({;]*?) *"
                                    r"\b(\w+)\b(?= *[=:{;\[]|$)", header.read_text(), flags=re.M))
    return names


def may_join(names, group):
    """No name of a file means something else in the group."""
    for name, alias in names.items():
        if name in group and (alias is None or alias != group[name]):
            return False
    return True


def main():
    max_size = int(sys.argv[1])
    taken = header_names()
    groups = []  # [files, name -> alias]
    for file in sys.argv[2:]:
        names = group_names(pathlib.Path(file).read_text())
        if any(name in taken for name in names):
            print(file)
            continue
        for files, known in groups:
            if len(files) < max_size and may_join(names, known):
                break
        else:
            files, known = [], {}
            groups.append([files, known])
        files.append(file)
        known.update(names)
    for files, _ in groups:
        print(";".join(files))


if __name__ == "__main__":
    main()
