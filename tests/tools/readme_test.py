#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The README's commands and numbers are true: they are run, and their output is looked for."""

import csv
import re
import sys
import tempfile
from pathlib import Path

from demo_job import demo_arguments, run

SAME_MM = 1e-4  # as far as stops of the camera matter


def rows(pictures):
    with open(pictures / "images.csv", newline="") as file:
        return list(csv.DictReader(file))


def main():
    panelcal, root = sys.argv[1:]
    root = Path(root)
    readme = (root / "README.md").read_text()
    example = (root / "tests/install/consumer/main.cc").read_text().split("\n", 1)[1]
    library = (root / "docs/howto/library.md").read_text()
    assert f"```cpp\n{example}```" in library, "the library's example is not tests/install/consumer/main.cc"
    demo = root / "datasets/demo"
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        said = run(panelcal, "run", *demo_arguments(root), "--images", demo / "images", "--truth",
                   demo / "images/truth.json", "--report", folder / "report.html", "-o",
                   folder / "corrected.drl").stderr
        shown = re.search(r"```\n\$ tools/demo.sh\n\.\.\.\n(.*?)```", readme, re.S)[1]
        for line in shown.splitlines():
            if line.strip() in ("", "...") or "written to" in line:
                continue
            assert line in said.splitlines(), f"README shows a line that demo does not print: {line}"

        run(panelcal, "check", demo / "panel.exc")
        survey = run(panelcal, "survey", *demo_arguments(root)).stdout
        assert len(survey.splitlines()) == 21
        located = run(panelcal, "locate", demo / "images/0000.png", "--tool", 1, "-m",
                      demo / "machine.toml").stdout
        assert '"status":"found"' in located
        run(panelcal, "synth", *demo_arguments(root), "-o", folder / "pictures")
        # Not byte for byte: the camera goes where the last fit said, which processors and versions
        # round and weigh differently.
        for ours, bundled in zip(rows(folder / "pictures"), rows(demo / "images"), strict=True):
            assert ours["file"] == bundled["file"] and ours["seq"] == bundled["seq"]
            assert abs(float(ours["x"]) - float(bundled["x"])) < SAME_MM
            assert abs(float(ours["y"]) - float(bundled["y"])) < SAME_MM
        run(panelcal, "run", *demo_arguments(root), "--images", folder / "pictures", "--truth",
            folder / "pictures/truth.json", "-o", folder / "again.csv")
    for command in set(re.findall(r"^panelcal (\w+)", readme, re.M)):
        run(panelcal, "help", command)


if __name__ == "__main__":
    main()
