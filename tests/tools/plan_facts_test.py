#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The facts of `panelcal plan` keep to their schema, and say the same as the text.

    plan_facts_test.py PANELCAL ROOT
"""
import json
import sys
import tempfile
from pathlib import Path

from demo_job import demo_arguments, run

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))
from facts import checked, in_page  # noqa: E402
from json_schema import is_closed  # noqa: E402


def main():
    panelcal, root = sys.argv[1:]
    for name in ("plan", "surface"):
        assert is_closed(json.loads((Path(root) / f"share/schema/{name}.schema.json").read_text())), name
    with tempfile.TemporaryDirectory() as folder:
        file, page = Path(folder) / "plan.json", Path(folder) / "plan.html"
        text = run(panelcal, "plan", *demo_arguments(root), "--add", 2, "--json", file, "--report", page).stdout
        document = checked(json.loads(file.read_text()), root)
        assert in_page(page) == document
        assert page.stat().st_size < 350_000, page.stat().st_size
        alone = run(panelcal, "plan", *demo_arguments(root), "--add", 2, "--json", "-").stdout
        assert json.loads(alone) | {"provenance": 0} == document | {"provenance": 0}
        # datasets/demo: 3 targets of the panel, 6 boards of 3 targets and 165 holes each.
        assert document["places"] == 6 * 165 and document["targets"] == 3 + 6 * 3, document["places"]
        for series in document["series"]:
            for model in series["models"]:
                row = f"{model['model']:<11}{model['dof']:>6}  {model['worst_leverage']:8.2f} {model['worst_um']:8.2f}"
                assert row in text, (row, text)
            n = len(series["candidates"]["x_mm"])
            assert all(len(column) == n for column in series["candidates"].values())
            assert sorted(document["visits"]["free"]) == list(range(document["targets"]))


if __name__ == "__main__":
    main()
