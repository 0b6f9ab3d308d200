#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks that no wording of a diagnostic stands in two cases, so that who rewords it changes one.

    wording_is_pinned_once.py
"""
import sys
from collections import defaultdict

from golden_wording import diagnostics, template


def main():
    places = defaultdict(list)
    for line in diagnostics():
        if line.message is not None:
            places[line.code, template(line.message)].append(line.case)
    problems = [f"{code}: the wording stands in {', '.join(cases)}; shorten all but one to "
                f"PLACE: SEVERITY[{code}]\n  {wording}"
                for (code, wording), cases in sorted(places.items()) if len(cases) > 1]
    print("\n".join(problems), end="\n" if problems else "")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
