#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""share/schema/machine.schema.json and `panelcal check -m` agree on files of machine.toml.

    machine_schema_test.py PANELCAL REPOSITORY

Each text below is a machine.toml; GOOD and BAD follow docs/formats/machine_toml.md.
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import tomllib
import unittest

GOOD = [
    "[vision]\nrotate = 3",
    "[vision]\nmin_score = 1",
    '[vision]\nfour_views = "corners"',
    "[machine]\ntravel_low_mm = [0, 0]\ntravel_high_mm = [600, 500]",
    '[gates]\noffset_mm = "off"',
    "[gates]\nresidual_um = 40",
    '[program]\ndigits = "2.4"\nunits = "inch"',
    "[[depth]]\nnumber = 3\ndepth_mm = 0.8",
    "[[depth]]\ndrill_mm = 0.8\ndepth_mm = 0.8",
    "[coupon]\norigin_mm = [1, 2]",
    "[spindle]\ncamera_offset_mm = [1, 2]\ncamera_offset_date = 2020-11-21T08:00:00",
    "[sim]\nseed = 7\n[sim.table]\nbow_um = [1, 2]",
]
BAD = [
    "[vision]\nrotat = 3",
    "[vison]\nrotate = 3",
    "[vision]\nrotate = 0",
    "[vision]\nrotate = 2.5",
    "[vision]\nmin_score = 1.1",
    '[vision]\nmin_score = "1"',
    '[vision]\nfour_views = "corner"',
    "[vision]\ncama = 1",
    "[machine]\nname = 3",
    "[machine]\ntravel_low_mm = 0\ntravel_high_mm = [600, 500]",
    "[machine]\ntravel_low_mm = [0, 0]\ntravel_high_mm = [600, 500, 1]",
    "[gates]\nresidual_um = 0",
    '[gates]\nresidual_um = "none"',
    "[depth]\nnumber = 3\ndepth_mm = 0.8",
    "[[depth]]\nnumber = 3",
    "[[depth]]\ndepth_mm = 0.8",
    "[coupon]\nrows = 3",
    '[ledger]\nfile = ""',
    "[nightly.settle]\nlimit_um = 2",
    '[program]\nsearch_path = "x"',
]


def is_type(value, name):
    kinds = {"object": dict, "array": list, "string": str, "boolean": bool}
    if name == "null":
        return value is None
    if name in kinds:
        return isinstance(value, kinds[name])
    numbers = int if name == "integer" else (int, float)
    return isinstance(value, numbers) and not isinstance(value, bool)


def accepts(schema, value):
    """The part of JSON Schema that the file uses; an unknown word is an error here."""
    known = {"$schema", "title", "description", "default", "type", "properties", "additionalProperties", "required",
             "anyOf", "const", "enum", "minimum", "exclusiveMinimum", "maximum", "minLength", "items", "minItems",
             "maxItems"}
    if set(schema) - known:
        raise ValueError(f"words that this test does not know: {set(schema) - known}")
    if "type" in schema and not is_type(value, schema["type"]):
        return False
    if "anyOf" in schema and not any(accepts(one, value) for one in schema["anyOf"]):
        return False
    if "const" in schema and value != schema["const"] or "enum" in schema and value not in schema["enum"]:
        return False
    if isinstance(value, dict):
        named = schema.get("properties", {})
        return (set(schema.get("required", [])) <= set(value)
                and (schema.get("additionalProperties", True) or set(value) <= set(named))
                and all(accepts(named[key], one) for key, one in value.items() if key in named))
    if isinstance(value, list):
        return (schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value))
                and all(accepts(schema["items"], one) for one in value))
    if isinstance(value, str):
        return len(value) >= schema.get("minLength", 0)
    if isinstance(value, (int, float)):
        return (value >= schema.get("minimum", value) and value <= schema.get("maximum", value)
                and not value <= schema.get("exclusiveMinimum", value - 1))
    return True


class Schema(unittest.TestCase):
    panelcal = None
    root = None

    def setUp(self):
        self.schema = json.loads((self.root / "share/schema/machine.schema.json").read_text(encoding="ascii"))

    def program_accepts(self, text):
        with tempfile.TemporaryDirectory() as folder:
            (pathlib.Path(folder) / "m.toml").write_text(text)
            call = [self.panelcal, "check", "-m", "m.toml", "--clock", "2026-11-21T08:00:00"]
            run = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False)
        return not re.search(r"error\[(config-value|config-key-unknown|not-supported)\]", run.stderr), run.stderr

    def test_both_accept_what_is_right(self):
        for text in GOOD:
            with self.subTest(text=text):
                self.assertTrue(accepts(self.schema, tomllib.loads(text)))
                self.assertTrue(*self.program_accepts(text))

    def test_both_refuse_what_is_wrong(self):
        for text in BAD:
            with self.subTest(text=text):
                self.assertFalse(accepts(self.schema, tomllib.loads(text)))
                self.assertFalse(*self.program_accepts(text))

    def test_the_examples_are_right(self):
        for name in ("datasets/demo/machine.toml", "examples/nightly/machine.toml"):
            with self.subTest(name=name):
                self.assertTrue(accepts(self.schema, tomllib.loads((self.root / name).read_text(encoding="utf-8"))))

    def test_every_default_keeps_its_range(self):
        def walk(schema, path):
            for key, one in schema.get("properties", {}).items():
                if "default" in one:
                    with self.subTest(key=path + key):
                        self.assertTrue(accepts(one, one["default"]), one)
                walk(one.get("items", one), f"{path}{key}.")
        walk(self.schema, "")


def main():
    Schema.panelcal, Schema.root = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    unittest.main(argv=sys.argv[:1])


if __name__ == "__main__":
    main()
