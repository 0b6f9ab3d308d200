#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""gerbv, an independent reader, finds in the corrected program the hits that panelcal wrote."""

import re
import shutil
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from demo_job import demo_arguments, drilled, run

SKIPPED = 77


def hits_by_tool(path):
    """Coordinates under each tool of a plain Excellon file, tools in order of first use."""
    counts, order, tool = Counter(), [], None
    body = False
    for line in Path(path).read_text(errors="replace").splitlines():
        if line == "%":
            body = True
        elif body and (match := re.match(r"T(\d+)", line)) and int(match[1]) > 0:
            tool = match[1]
            if tool not in order:
                order.append(tool)
        elif body and re.match(r"[XY]", line):
            counts[tool] += 1
    return [counts[tool] for tool in order]


def main():
    panelcal, root = sys.argv[1:]
    if shutil.which("gerbv") is None:
        print("SKIP: gerbv is not installed (tools/packages.txt, extra)")
        sys.exit(SKIPPED)
    images = Path(root) / "datasets/demo/images"
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        for name in ("corrected.drl", "corrected.jsonl"):
            run(panelcal, "run", *demo_arguments(root), "--images", images, "-o", folder / name)
        subprocess.run(["gerbv", "-x", "drill", "-o", folder / "read.drl", folder / "corrected.drl"],
                       check=True, capture_output=True, timeout=60)
        by_tool = Counter(hole["tool"] for hole in drilled(folder / "corrected.jsonl"))
        ours = [by_tool[tool] for tool in sorted(by_tool)]
        read = hits_by_tool(folder / "read.drl")
        print("hits per tool, panelcal:", ours, " gerbv:", read)
        assert sorted(ours) == sorted(read) and sum(ours) == 990


if __name__ == "__main__":
    main()
