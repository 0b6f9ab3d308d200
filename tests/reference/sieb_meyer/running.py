# SPDX-License-Identifier: Apache-2.0
"""Runs panelcal on a program: its operations as JSON Lines, or why it refuses."""

import json
import pathlib
import subprocess

SURFACE_MM = 1.6


class Panelcal:
    """Runs one command line tool in a folder of its own, with a machine file that states nothing."""

    def __init__(self, tool, folder):
        self.tool = tool
        self.folder = pathlib.Path(folder)
        self.options = []

    def state(self, setting):
        """Writes what the machine file states, and takes the operator's options."""
        lines = []
        self.options = []
        if setting and setting.rules:
            digits = ".".join(map(str, setting.digits))
            self.options = ["--format", f"{setting.units},{setting.zeros.lower()},{digits}"]
        elif setting:
            digits = ".".join(map(str, setting.digits))
            lines += [f'units = "{setting.units}"', f'zeros = "{setting.zeros}"', f'digits = "{digits}"']
        if setting:
            lines.append(f'rates = "{setting.rates}"')
        (self.folder / "machine.toml").write_text("\n".join(["[program]", *lines, ""]))

    def run(self, text, subprograms=None, to="jsonl", setting=None):
        """(output, "") or (None, errors). `subprograms` maps names of files to their text.

        Probes find the surface at SURFACE_MM, and every target is found where the program has it, so
        that corrections move nothing.
        """
        inputs = {"program.s5": text, **(subprograms or {})}
        self.state(setting)
        try:
            for name, content in inputs.items():
                (self.folder / name).write_bytes(content.encode("latin-1"))
            recorded = self.record() if "G3" in text or "G7" in text else []
            done = self.call("run", "--to", to, "-o", "-", "--slots", "keep", "--force",
                             "--clock", "2026-01-01T00:00:00", *recorded)
        finally:
            for name in inputs:
                (self.folder / name).unlink(missing_ok=True)
        if done.returncode:
            errors = [line for line in done.stderr.splitlines() if "error" in line]
            return None, "\n".join(errors or [f"exit {done.returncode}: {done.stderr}"])
        return done.stdout, ""

    def call(self, command, *options):
        # The fuzzers' corpus has programs that never end.
        return subprocess.run([self.tool, command, "program.s5", "-m", "machine.toml", "--max-operations", "20000",
                               *self.options, *options],
                              cwd=self.folder, capture_output=True, text=True, encoding="utf-8", errors="replace", timeout=60)

    def record(self):
        """Writes what the probes and the camera of the program find."""
        probes, targets = [], []
        for request in map(json.loads, self.call("survey").stdout.splitlines()):
            if "probe" in request:
                probes.append({**request, "zaxis": 0, "height": SURFACE_MM, "sigma": 0.002, "status": "found"})
            elif "seq" in request:
                targets.append({**request, "measured": request["nominal"], "cov": [1e-6, 0, 1e-6], "score": 1,
                                "image": "0.png", "status": "found"})
        options = []
        for name, lines in (("probes", probes), ("measurements", targets)):
            if lines:
                (self.folder / f"{name}.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
                options += [f"--{name}", f"{name}.jsonl"]
        return options
