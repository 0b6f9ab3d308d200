#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The schemas of share/schema/ and the program agree on JSON files.

    json_schema_test.py PANELCAL REPOSITORY

Files of the repository are right; each is then spoilt in every key, and both have to refuse it.
"""
import copy
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

from machine_schema_test import accepts

MAPS = ["tests/golden/fixtures/plane-tilted/map.json", "tests/golden/fixtures/voids-map/map.json"]
CAMERAS = ["datasets/demo/camera.cal.json", "tests/golden/fixtures/camera-64-px/camera.cal.json"]
MACHINE = '[camera]\ncalibration = "file.json"\n'


def objects_of(value):
    """All objects in a value, itself included."""
    if isinstance(value, dict):
        yield value
    for one in value.values() if isinstance(value, dict) else value if isinstance(value, list) else []:
        yield from objects_of(one)


def spoilt(value):
    """Copies without one of the keys, with one more, or with one of another type."""
    for i, one in enumerate(objects_of(value)):
        for key in list(one)[:12]:
            for change in ("without", "misspelt", "type"):
                changed = copy.deepcopy(value)
                part = list(objects_of(changed))[i]
                was = part.pop(key)
                if change == "misspelt":
                    part[key + "x"] = was
                if change == "type":
                    part[key] = {"another": "form"}
                yield f"{key} {change}", changed
        if i > 8:
            return


class Schemas(unittest.TestCase):
    panelcal = None
    root = None

    def schema(self, name):
        return json.loads((self.root / f"share/schema/{name}.schema.json").read_text(encoding="ascii"))

    def program_accepts(self, value, call):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "file.json").write_text(json.dumps(value), encoding="ascii")
            (pathlib.Path(folder) / "machine.toml").write_text(MACHINE, encoding="ascii")
            run = subprocess.run([self.panelcal, *call], cwd=folder, capture_output=True, text=True, check=False)
        return run.returncode == 0, run.stderr

    def check(self, names, schema, call, optional):
        for name in names:
            value = json.loads((self.root / name).read_text(encoding="utf-8"))
            with self.subTest(name=name):
                self.assertTrue(accepts(schema, value))
                self.assertTrue(*self.program_accepts(value, call))
            for change, wrong in spoilt(value):
                if change in optional:
                    continue
                with self.subTest(name=name, change=change):
                    self.assertFalse(accepts(schema, wrong))
                    self.assertFalse(*self.program_accepts(wrong, call))

    def test_of_maps(self):
        # Which keys an area needs beside each other no schema says, and zaxis may be absent.
        loose = {f"{key} without" for key in ("zaxis", "line", "polygon", "diameter", "circles", "width", "track",
                                               "outside", "center", "unresolved", "weight")}
        self.check(MAPS, self.schema("surface-map"), ["surface", "query", "file.json", "1,1"], loose)

    def test_of_cameras(self):
        self.check(CAMERAS, self.schema("camera.cal"), ["check", "-m", "machine.toml"], {"ledger without"})


def main():
    Schemas.panelcal, Schemas.root = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1])


if __name__ == "__main__":
    main()
