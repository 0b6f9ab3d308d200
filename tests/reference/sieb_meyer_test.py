#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""panelcal and the second reading execute SIEB & MEYER programs alike.

    sieb_meyer_test.py PANELCAL [--programs N] [--seed SEED]

N random programs (default 300) from SEED on, every program of the golden cases and of the fuzzers'
corpus, and a check that the comparison notices errors. README.md here says what is compared.
"""

import argparse
import collections
import json
import pathlib
import re
import sys
import tempfile
import unittest
from unittest import mock

HERE = pathlib.Path(__file__).resolve().parent
sys.path.append(str(HERE.parent / "golden"))

import golden_case  # noqa: E402
from sieb_meyer import Refusal, interpret, operations, read  # noqa: E402
from sieb_meyer.comparison import Comparison, Difference, compare_written, events_of_panelcal  # noqa: E402
from sieb_meyer.programs import Writer  # noqa: E402
from sieb_meyer.running import Panelcal  # noqa: E402

OPTIONS = argparse.Namespace()

# Words that the random programs of one run must contain, each in this number of programs at least.
MIN_PROGRAMS = 3
CONSTRUCTS = {name: re.compile(pattern, re.MULTILINE) for name, pattern in {
    "format 1000": "^%%$", "format 3000": "^%%3000", "format 5000": "^%%5000",
    **{f"G{n}": rf"G{n}(?!\d)" for n in (1, 2, 3, 6, 11, 31, 32, 36, *range(40, 44), *range(45, 51), 70, 71, 73, 74, 75,
                                         *range(80, 86), 88, 89, 90, 91)},
    **{f"M{n}": rf"M{n}(?!\d)" for n in (20, 21, 28, 29, 30, 31, 34, 47, 50, 56, 60, 70, 80, 90, 94, 95, 97, 98, 99)},
    **{f"M60M{n}": f"M60M{n}" for n in (70, 80, 90)},
    **{f"V{n}": rf"(?<!M50)V{n}" for n in (1, 2, 3, 4)}, "M50V2": "M50V2",
    "two sections in one line": "M31M31", "nested sections": r"M30(.|\n)*M31(.|\n)*M31", "offsets without brackets": r"M\d0\n\$",
    "R below zero": r"G[23]R-", "I and J": r"G[23]I", "D": r"D\d", "missing axis": r"^[XY][-.\d]+(G1|G2|G3)?(F\S*)?$",
    "letter alone": r"X[YTG\n]", "no decimal point": r"^X-?\d+Y", "H": r"H\d", "K": r"K\.?\d", "Z": r"Z\.?\d", "labeled": "^/",
    "offsets in a subprogram": "M99,PANEL", "the table leaves a contour": r"M2[89]\n.*T0(G90)?$",
    "comment": r"\(HOLE", "tool change within a section": r"M31\n[^M]*T\d"}.items()}


def compare(program, subprograms, jsonl, setting=None):
    """Counts of compared operations; Difference if the two readings differ."""
    found = interpret(program, subprograms, setting)
    return Comparison(found, events_of_panelcal(jsonl), read(program, setting).diameters_mm).run()


class Programs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.panelcal = Panelcal(OPTIONS.panelcal, folder.name)

    def executed(self, program, subprograms, setting=None):
        """JSON Lines; a program that a side refuses is an error of the writer of programs or of that side."""
        files = {"SUBPROGRAMS.SS5": subprograms} if subprograms else {}
        jsonl, errors = self.panelcal.run(program, files, setting=setting)
        if jsonl is None:
            raise Difference(f"panelcal refuses: {errors}")
        return jsonl

    def test_random_programs_are_executed_alike(self):
        print(f"seeds {OPTIONS.seed} to {OPTIONS.seed + OPTIONS.programs - 1}")
        compared, used = collections.Counter(), collections.Counter()
        for seed in range(OPTIONS.seed, OPTIONS.seed + OPTIONS.programs):
            program, subprograms = Writer(seed).program()
            whole = (program + subprograms).replace("\r\n", "\n").replace("\r", "\n")
            used.update(name for name, pattern in CONSTRUCTS.items() if pattern.search(whole))
            try:
                compared.update(compare(program, subprograms, self.executed(program, subprograms)))
            except (Refusal, Difference) as problem:
                self.fail(f"seed {seed}: {problem}\n{whole}")
        print(f"{OPTIONS.programs} programs, 0 refused: {dict(compared)}")
        if OPTIONS.programs >= 300:
            rare = {name: used[name] for name in CONSTRUCTS if used[name] < MIN_PROGRAMS}
            self.assertEqual(rare, {}, "constructs that too few programs have")

    def test_random_programs_in_other_numbers_are_executed_alike(self):
        """In inch, other digits or with leading zeros, as the control or the operator states them."""
        compared, used = collections.Counter(), collections.Counter()
        for seed in range(OPTIONS.seed, OPTIONS.seed + OPTIONS.programs):
            writer = Writer(seed, others=True)
            program, subprograms = writer.program()
            setting = writer.setting
            used.update([setting.units, setting.zeros, setting.digits, setting.rates, setting.rules, writer.format])
            try:
                compared.update(compare(program, subprograms, self.executed(program, subprograms, setting), setting))
            except (Refusal, Difference) as problem:
                self.fail(f"seed {seed}: {problem}\n{setting}\n{program}{subprograms}")
        print(f"{OPTIONS.programs} programs in other numbers, 0 refused: {dict(compared)}")
        if OPTIONS.programs >= 300:
            self.assertGreaterEqual(min(used.values()), OPTIONS.programs / 60, used)

    def test_written_programs_say_what_the_json_lines_say(self):
        """panelcal's own .s5 output, read by the second reading."""
        compared = 0
        for number in range(OPTIONS.programs // 2):
            seed = OPTIONS.seed + number
            writer = Writer(seed, others=number % 2 == 1)
            program, subprograms = writer.program()
            if re.search("G3[26]|G73", program + subprograms):
                continue  # stays a program that measures
            files = {"SUBPROGRAMS.SS5": subprograms} if subprograms else {}
            written, errors = self.panelcal.run(program, files, "sieb-meyer", writer.setting)
            self.assertIsNotNone(written, f"seed {seed}: {errors}")
            try:
                jsonl = self.executed(program, subprograms, writer.setting)
                compare_written(interpret(written), events_of_panelcal(jsonl, splits=True))
                compared += 1
            except (Refusal, Difference) as problem:
                self.fail(f"seed {seed}: {problem}\n{written}")
        print(f"{compared} written programs compared, 0 refused")
        self.assertGreaterEqual(compared, OPTIONS.programs // 5)

    def test_programs_of_the_repository_are_executed_alike(self):
        results = collections.Counter()
        for name, program, subprograms in repository_programs():
            jsonl, _ = self.panelcal.run(program, subprograms)
            try:
                interpret(program, "".join(subprograms.values()))
                accepted = True
            except Refusal:
                accepted = False
            results[accepted, jsonl is not None] += 1
            if accepted and jsonl is not None:
                try:
                    compare(program, "".join(subprograms.values()), jsonl)
                except Difference as difference:
                    self.fail(f"{name}: {difference}")
        print(f"{results.total()} programs of the repository: {results[True, True]} compared, {results[False, True]} only "
              f"panelcal accepts, {results[True, False]} only the second reading, {results[False, False]} refused by both")
        self.assertGreaterEqual(results[True, True], 75)
        # The second reading refuses what the manual leaves open (FV, SA, FA, M58, ...); panelcal, files that
        # are cut off, measurements that are missing and programs of too many operations.
        self.assertLessEqual(results[False, True], 30)
        self.assertLessEqual(results[True, False], 26)


def repository_programs():
    """(name, program, subprogram files) of golden cases and of the fuzzers' corpora."""
    tests = HERE.parent
    for path in sorted((tests / "golden").rglob("*.case")):
        inputs = golden_case.all_inputs(golden_case.parse(str(path), path.read_bytes()))
        inputs = {name: content.decode("latin-1") for name, content in inputs.items()}
        subprograms = {name: text for name, text in inputs.items() if name.upper().endswith(".SS5")}
        for name, text in inputs.items():
            if name.endswith((".s5", ".sm")):
                yield f"{path}: {name}", text, subprograms
    for folder in ("corpus/sieb_meyer", "fixed"):
        for path in sorted((tests / "fuzz" / folder).glob("*.sm5")):
            yield str(path), path.read_bytes().decode("latin-1"), {}


# ---- errors that the comparison must notice: records of JSON Lines in, changed records or None out


def holes(records, found):
    lines = {operation.line for operation in found if operation.kind == "hole"}
    others = {operation.line for operation in found if operation.kind not in ("hole", "retract")}
    return [i for i, r in enumerate(records) if r["op"] == "drill" and r["line"] in lines - others]


def first(records, wanted):
    return next((i for i, record in enumerate(records) if wanted(record)), None)


def moved(index, key, axis, by):
    def change(records, found):
        i = index(records, found)
        if i is not None:
            records[i][key][axis] += by
        return i is not None
    return change


def set_to(index, key, value):
    def change(records, found):
        i = index(records, found)
        if i is not None:
            records[i][key] = value(records[i][key])
        return i is not None
    return change


def last_hole(records, found):
    return (holes(records, found) or [None])[-1]


def last_rout(records, found):
    return next((i for i in reversed(range(len(records))) if records[i]["op"] == "rout"
                 and any(o.line == records[i]["line"] and o.kind == "line" for o in found)), None)


def an_arc(records, found):
    arcs = {operation.line for operation in found if operation.kind == "arc"}
    return first(records, lambda r: r["op"] == "rout" and r["kind"] != "line" and r["line"] in arcs)


def drop(records, found):
    i = last_hole(records, found)
    if i is not None:
        del records[i]
    return i is not None


def repeat(records, found):
    i = last_hole(records, found)
    if i is not None:
        records.insert(i, dict(records[i]))
    return i is not None


def swap(records, found):
    single = set(holes(records, found)) - {i for i, r in enumerate(records)
                                           if any(o.pattern and o.line == r["line"] for o in found)}
    i = next((i for i in single if i + 1 in single and records[i]["nominal"] != records[i + 1]["nominal"]), None)
    if i is not None:
        records[i]["nominal"], records[i + 1]["nominal"] = records[i + 1]["nominal"], records[i]["nominal"]
    return i is not None


def has_depth(key):
    return lambda records, found: next((i for i in holes(records, found) if key in records[i]), None)


ERRORS = {
    "a hole 1 um to the right": moved(last_hole, "nominal", 0, 0.001),
    "a hole 1 um down": moved(last_hole, "nominal", 1, -0.001),
    "a hole left out": drop,
    "a hole drilled twice": repeat,
    "two holes in the other order": swap,
    "another tool": set_to(last_hole, "tool", lambda tool: tool + 1),
    "the end of a straight line 1 um away": moved(last_rout, "nominal", 0, 0.001),
    "another feed": set_to(last_rout, "feed", lambda feed: feed * 1.01),
    "the center of an arc 1 um away": moved(an_arc, "center", 1, 0.001),
    "an arc the other way": set_to(an_arc, "kind", lambda kind: "ccw" if kind == "cw" else "cw"),
    "Z 1 um lower": set_to(has_depth("z"), "z", lambda z: z - 0.001),
    "K 1 um deeper": set_to(has_depth("depth"), "depth", lambda depth: depth + 0.001),
}
# A placement command whose effect is left out -> the matrix that it then has.
PLACEMENTS = {"M70": ({70}, (1, 0, 0, 1)), "M80": ({80}, (1, 0, 0, 1)), "M90": ({90}, (1, 0, 0, 1)), "M60": ({60}, (1, 0, 0, 1)),
              "M60M70": ({60, 70}, (0, -1, 1, 0)), "M60M80": ({60, 80}, (0, -1, 1, 0)), "M60M90": ({60, 90}, (0, -1, 1, 0))}
PROGRAMS_WITH_ERRORS = 60


class Errors(Programs):
    """Not the tests of Programs again: what they rely on."""

    test_random_programs_are_executed_alike = None
    test_random_programs_in_other_numbers_are_executed_alike = None
    test_programs_of_the_repository_are_executed_alike = None
    test_written_programs_say_what_the_json_lines_say = None

    def test_the_comparison_notices_every_error(self):
        made = collections.Counter()
        for seed in range(PROGRAMS_WITH_ERRORS):
            program, subprograms = Writer(seed).program()
            jsonl = self.executed(program, subprograms)
            found = interpret(program, subprograms)
            compare(program, subprograms, jsonl)
            for name, change in ERRORS.items():
                records = [json.loads(line) for line in jsonl.splitlines()]
                if not change(records, found):
                    continue
                made[name] += 1
                text = "".join(json.dumps(record) + "\n" for record in records)
                with self.assertRaises(Difference, msg=f"seed {seed}: {name}"):
                    compare(program, subprograms, text)
        print(f"errors made: {dict(made)}")
        for name in ERRORS:
            self.assertGreaterEqual(made[name], 5, name)

    def test_the_comparison_notices_a_placement_that_is_not_obeyed(self):
        for name, (commands, matrix) in PLACEMENTS.items():
            program = f"%%5000\nX10.Y20.T1M31\nX30.Y25.\nX1.Y2.{name}M30\n$\nT1D1.F2.\n$\n"
            jsonl = self.executed(program, "")
            compare(program, "", jsonl)
            with mock.patch.dict(operations.MATRICES, {frozenset(commands): matrix}):
                with self.assertRaises(Difference, msg=name):
                    compare(program, "", jsonl)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("panelcal", type=lambda name: str(pathlib.Path(name).resolve()))
    parser.add_argument("--programs", type=int, default=300)
    parser.add_argument("--seed", type=int, default=0)
    parser.parse_args(namespace=OPTIONS)
    unittest.main(argv=sys.argv[:1], verbosity=2)


if __name__ == "__main__":
    main()
