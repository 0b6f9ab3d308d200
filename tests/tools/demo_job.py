# SPDX-License-Identifier: Apache-2.0
"""What the tests of the demo job share."""

import json
import subprocess
from pathlib import Path


def run(panelcal, *arguments, cwd=None, expect=0, input=None):
    """Runs panelcal; fails the test with its messages if the exit code is another one."""
    result = subprocess.run([panelcal, *map(str, arguments)], cwd=cwd, capture_output=True, text=True,
                            input=input)
    if result.returncode != expect:
        raise SystemExit(f"{arguments}: exit {result.returncode}, expected {expect}\n{result.stderr}")
    return result


def demo_arguments(root):
    demo = Path(root) / "datasets/demo"
    return [demo / "panel.exc", "-m", demo / "machine.toml"]


def drilled(path):
    """The drill operations of a JSON Lines output."""
    with open(path) as file:
        return [op for op in map(json.loads, file) if op["op"] == "drill"]
