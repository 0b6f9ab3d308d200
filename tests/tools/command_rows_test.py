#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What becomes of every row of docs/excellon_commands.md and docs/sieb_meyer_commands.md.

    command_rows_test.py PANELCAL excellon|sieb-meyer [ROW]

Each row of the page that `panelcal help` prints has a case in command_rows/, and the counts at the
page's end are those of the cases. A case is a line

    ROW ;; PROGRAM ;; FATE in .drl ;; FATE in .s5 ;; FATE in .ngc [;; CODES that `check` gives]

with \\n for line ends. What stands between < and > is the command in question: the program runs with
it and without it, or with what stands behind | in its place, each time through `check` and through `run` to the three outputs. HEADER WORD is a
word in an Excellon header. Fates, with expectations from the manuals and docs, not from the output:

    written TEXT       a line of the output, or several that follow each other, because of the command
    executed TEXT      the same, in coordinates or other words of that output
    removed TEXT       the command takes this line out of the output
    asked TEXT         what `survey` asks the camera or the probe for has it because of the command
    lost TEXT          a warning translation-loss names it
    refused CODE TEXT  the output fails with it, and not without the command
    warned CODE TEXT   it is executed or has no effect, and this warning says so
    moot CODE TEXT     the output fails with it, and without the command as well
    nothing: REASON    the output is the same, for this reason

The targets of the camera lie 0.5 mm and 0.25 mm from their places, those of Excellon's nested
commands 0.7 mm and 0.35 mm, and the board's surface lies 3 mm above the table.
"""

import collections
import functools
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

DATA = pathlib.Path(__file__).resolve().parent / "command_rows"
OUTPUTS = ("excellon", "sieb-meyer", "gcode")
FOUND_AT_MM = (0.5, 0.25)
FOUND_AT_NESTED_MM = (0.7, 0.35)  # G45, G46 and G48, so that what they add shows
SURFACE_MM = 3
KINDS = ("written", "executed", "removed", "asked", "lost", "refused", "warned", "moot", "nothing:")
DIAGNOSTIC = re.compile(r"(error|warning)\[([a-z-]+)\]: (.*)")
# Who made an output and from what: the command line and the program's digest are in it.
MAKER = re.compile("; ?(made by|command line|sha256).*")
NO_FAULT = {"tool-unused", "feed-missing"}  # of programs as short as these

Case = collections.namedtuple("Case", "row program fates codes line")
Outcome = collections.namedtuple("Outcome", "lines diagnostics fails")


def with_command(program):
    return re.sub(r"<([^|>]*)(\|[^>]*)?>", r"\1", program)


def without_command(program):
    return re.sub(r"<[^|>]*\|?([^>]*)>", r"\1", program)


class Language:
    """A page, its cases, and how a program is made of a case."""

    def __init__(self, name, suffix, tables):
        self.name, self.suffix = name, suffix
        self.tables = tables  # heading of the page: what stands ahead of the first cell in a case

    def whole(self, program):
        if self.name == "sieb-meyer":
            return program if program.startswith("%%") else f"%%5000\n{program}$\nT1D1.S50F2.4\nT2D2.S50F2.4\nT4D.8S50F2.4\n$\n"
        tools = "T1C1.F030S50\nT2C2.F030S50\nT3C.8F030S50\n"
        if program.startswith("HEADER "):
            return f"M48\nMETRIC,TZ\n<{program[len('HEADER '):]}\n>{tools}%\nT1\nX1.Y2.\nM30\n"
        return program if "M48\n" in program else f"M48\nMETRIC,TZ\nCP,2,2.\n{tools}%\n{program}M30\n"

    def cases(self):
        lines = (DATA / f"{self.name.replace('-', '_')}.txt").read_text(encoding="ascii").splitlines()
        for number, line in enumerate(lines, 1):
            if not line or line.startswith("# "):
                continue
            row, program, *fates = line.split(" ;; ")
            program = program.replace("\\n", "\n").replace("\\\\", "\\")
            yield Case(row, self.whole(program), fates[:3], fates[3].split() if fates[3:] else [], number)


EXCELLON = Language("excellon", "drl", {"Body": "", "Header": "", "Format One": "FMAT,1 "})
SIEB_MEYER = Language("sieb-meyer", "s5", {"Program lines": "", "CNC commands": "M49,"})


class Panelcal:
    """Runs programs in a folder that has what they call."""

    def __init__(self, binary, folder):
        self.binary, self.folder = binary, pathlib.Path(folder)
        (self.folder / "PATT").write_text("X1.Y1.\n")
        (self.folder / "SUB.SS5").write_text("@SUB\nX1.Y0\n")
        self.machine = (DATA / "machine.toml").read_text(encoding="ascii")

    def call(self, *arguments):
        return subprocess.run([self.binary, *arguments], cwd=self.folder, capture_output=True, text=True, check=False)

    def store(self, program, suffix):
        name = f"a.{suffix}"
        (self.folder / name).write_text(program)
        machine = self.machine.replace("[vision]\n", "[vision]\nmode = 3\n") if "REQCOMP" in program else self.machine
        (self.folder / "m.toml").write_text(machine)
        return name

    @functools.lru_cache(maxsize=None)
    def check(self, program, suffix):
        name = self.store(program, suffix)
        return outcome(self.call("check", name, "-m", "m.toml"))

    @functools.lru_cache(maxsize=None)
    def survey(self, program, suffix):
        name = self.store(program, suffix)
        return self.call("survey", name, "-m", "m.toml").stdout.splitlines()

    @functools.lru_cache(maxsize=None)
    def run(self, program, suffix, output):
        sources = []
        targets, probes = answers(self.survey(program, suffix))
        name = self.store(program, suffix)
        for option, rows in (("measurements", targets), ("probes", probes)):
            if rows:
                (self.folder / f"{option}.jsonl").write_text("".join(json.dumps(row) + "\n" for row in rows))
                sources += [f"--{option}", f"{option}.jsonl"]
        return outcome(self.call("run", name, "-m", "m.toml", *sources, "-o", "-", "--to", output))


def answers(requests):
    """What the camera and the probe find, in the order of the requests."""
    targets, probes = [], []
    for request in map(json.loads, requests):
        if "seq" in request:
            shift = FOUND_AT_NESTED_MM if request["command"] in ("G45", "G46", "G48") else FOUND_AT_MM
            at = [x + d for x, d in zip(request["nominal"], shift)]
            targets.append(request | {"measured": at, "cov": [1e-6, 0, 1e-6], "status": "found"})
        elif "probe" in request:
            probes.append(request | {"zaxis": 0, "height": SURFACE_MM, "sigma": 0.001, "status": "found"})
    return targets, probes


def outcome(process):
    lines = [line for line in process.stdout.splitlines() if not MAKER.fullmatch(line)]
    if "%%5000" in lines:  # comments stand ahead of it, wrapped
        lines = lines[lines.index("%%5000"):]
    return Outcome(lines, DIAGNOSTIC.findall(process.stderr), process.returncode != 0)


def treatment(heading, cells):
    """works, passed on or refused, as a row of the page says."""
    said = {"Header": 3, "CNC commands": 1}.get(heading)
    if said:
        return {"handled": "works", "obeyed": "works", "passed": "passed on"}.get(cells[said], cells[said])
    return "passed on" if len(cells) > 2 and cells[2].startswith("Passed on") else "works"


def rows_of_page(page, tables):
    """Row, as cases name it, to heading and treatment; and the table of counts at the page's end."""
    rows, counts = {}, {}
    heading = ""
    for line in page.splitlines():
        heading = line[3:] if line.startswith("## ") else heading
        cells = [cell.strip().replace("\\|", "|") for cell in re.split(r"(?<!\\)\|", line)][1:-1]
        if heading in tables and cells and cells[0].startswith("`"):
            rows[tables[heading] + cells[0].strip("`")] = heading, treatment(heading, cells)
        if heading == "Counts" and len(cells) == 5 and cells[1].isdigit():
            counts[cells[0]] = [int(cell) for cell in cells[1:]]
    return rows, counts


def count_of(text, lines):
    wanted = text.split("\\n")
    return sum(lines[at:at + len(wanted)] == wanted for at in range(len(lines)))


def is_named(outcome_, severity, code, text):
    return any(d[:2] == (severity, code) and text in d[2] for d in outcome_.diagnostics)


class Rows(unittest.TestCase):
    panelcal = None
    language = None
    only = ""

    def cases(self):
        return [case for case in self.language.cases() if self.only in ("", case.row)]

    def test_every_row_of_the_page_has_a_case(self):
        rows, _ = rows_of_page(self.page(), self.language.tables)
        self.assertGreater(len(rows), 100)
        shown = {case.row for case in self.language.cases()}
        self.assertEqual(sorted(set(rows) - shown), [], "rows without a case")
        self.assertEqual(sorted(shown - set(rows)), [], "cases of no row")

    def test_the_page_counts_its_rows(self):
        rows, counts = rows_of_page(self.page(), self.language.tables)
        wanted = collections.defaultdict(collections.Counter)
        for heading, treated in rows.values():
            wanted[heading][treated] += 1
            wanted["all"][treated] += 1
        for heading, treated in wanted.items():
            numbers = [sum(treated.values())] + [treated[name] for name in ("works", "passed on", "refused")]
            self.assertEqual(counts.get(heading), numbers, heading)

    def test_the_page_treats_a_row_as_its_cases_do(self):
        rows, _ = rows_of_page(self.page(), self.language.tables)
        for case in self.cases():
            kinds = {fate.split(" ", 1)[0] for fate in case.fates}
            with self.subTest(row=case.row, line=case.line):
                treated = rows[case.row][1]
                is_refused = all(fate.startswith("refused not-supported ") for fate in case.fates)
                self.assertEqual(treated == "refused", is_refused)
                if treated == "passed on":  # it changes no coordinate
                    self.assertFalse(kinds & {"executed", "removed", "asked", "moot", "nothing:"}, kinds)

    def test_check_says_what_it_should(self):
        for case in self.cases():
            with self.subTest(row=case.row, line=case.line):
                found = self.panelcal.check(with_command(case.program), self.language.suffix)
                codes = {code for _, code, _ in found.diagnostics} - NO_FAULT
                self.assertEqual(codes, set(case.codes), found.diagnostics)
                has_error = any(severity == "error" for severity, _, _ in found.diagnostics)
                self.assertEqual(found.fails, has_error)

    def test_every_command_is_written_executed_or_named(self):
        for case in self.cases():
            self.assertEqual(len(case.fates), len(OUTPUTS), case)
            for output, fate in zip(OUTPUTS, case.fates):
                with self.subTest(row=case.row, line=case.line, output=output, fate=fate):
                    self.expect(case, output, fate)

    def expect(self, case, output, fate):
        kind, text = fate.split(" ", 1)
        self.assertIn(kind, KINDS)
        programs = with_command(case.program), without_command(case.program)
        self.assertNotEqual(*programs)
        having, lacking = (self.panelcal.run(program, self.language.suffix, output) for program in programs)
        if kind in ("refused", "moot", "warned"):
            code, text = text.split(" ", 1)
            self.assertTrue(is_named(having, "warning" if kind == "warned" else "error", code, text), having)
            self.assertEqual(having.fails, kind != "warned", having)
            self.assertEqual(lacking.fails, kind == "moot", lacking)
            return
        self.assertFalse(having.fails, having.diagnostics)
        if kind == "lost":
            self.assertTrue(is_named(having, "warning", "translation-loss", text), having.diagnostics)
            self.assertFalse(is_named(lacking, "warning", "translation-loss", text), lacking.diagnostics)
        elif kind == "asked":
            asked = [self.panelcal.survey(program, self.language.suffix) for program in programs]
            counts = [sum(text in line for line in lines) for lines in asked]
            self.assertGreater(*counts, asked)
        elif kind == "nothing:":
            self.assertEqual(having.lines, lacking.lines)
        else:
            more, less = (having, lacking) if kind != "removed" else (lacking, having)
            counts = [count_of(text, part.lines) for part in (more, less)]
            self.assertGreater(*counts, having.lines)
            self.assertFalse(kind == "removed" and lacking.fails, lacking)

    def page(self):
        return self.panelcal.call("help", self.language.name).stdout


def main():
    binary, name, *only = sys.argv[1:]
    Rows.language = {language.name: language for language in (EXCELLON, SIEB_MEYER)}[name]
    Rows.only = only[0] if only else ""
    with tempfile.TemporaryDirectory() as folder:
        Rows.panelcal = Panelcal(pathlib.Path(binary).resolve(), folder)
        unittest.main(argv=sys.argv[:1])


if __name__ == "__main__":
    main()
