#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""docs/howto/threads.md says of every class that <panelcal/panelcal.h> brings what threads may do with it.

    threads_test.py ROOT
"""
import re
import sys
from pathlib import Path

ROOT = Path(sys.argv[1])
INCLUDE = re.compile(r'#include "([^"]+)"')
CLASS = re.compile(r"^class (\w+)(?: final)?(?: :[^{;]*)? \{", re.M)
# Threads may call const methods together as long as nothing changes behind them.
MUTABLE = re.compile(r"^\s*mutable ", re.M)


def public_headers():
    """The front door, and all that it includes."""
    found, todo = {}, ["machine/panelcal.h"]
    while todo:
        name = todo.pop()
        if name not in found:
            found[name] = (ROOT / name).read_text()
            todo += INCLUDE.findall(found[name])
    return found


def main():
    headers = public_headers()
    classes = {name for text in headers.values() for name in CLASS.findall(text)}
    assert len(classes) > 50, classes
    rows = [line.split("|")[1] for line in (ROOT / "docs/howto/threads.md").read_text().splitlines() if line.startswith("|")]
    named = [name for row in rows for name in re.findall(r"`(\w+)`", row)]
    assert len(named) == len(set(named)), f"twice: {sorted(name for name in named if named.count(name) > 1)}"
    assert classes <= set(named), f"docs/howto/threads.md says nothing of {sorted(classes - set(named))}"
    # Interfaces are declared as struct or class elsewhere; what the page names has to exist.
    everything = "\n".join(path.read_text() for room in ("calib", "machine", "program", "surface", "vision")
                           for path in (ROOT / room).rglob("*.h"))
    gone = [name for name in named if not re.search(rf"^(class|struct) {name}\b", everything, re.M)]
    assert not gone, f"docs/howto/threads.md names what is not there: {gone}"
    cached = [name for name, text in headers.items() if MUTABLE.search(text)]
    assert not cached, f"a mutable member makes const methods unsafe: {cached}"


main()
