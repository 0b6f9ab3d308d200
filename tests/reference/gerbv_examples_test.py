#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""gerbv's example drill files, of six CAM systems: panelcal and the second reading of Excellon programs have the same
holes, tools and rout moves.

    gerbv_examples_test.py PANELCAL

Each file has something that the manual does not have, and that the second reading refuses. Its text is put right here,
line for line, by what the file itself or its system says; panelcal reads the files as they are.
"""
import dataclasses
import json
from pathlib import Path
import re
import subprocess
import sys
import tempfile
import unittest

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

from excellon import read_program  # noqa: E402
from excellon_compare import Difference, compare, font  # noqa: E402

SKIPPED = 77
EXAMPLES = Path('/usr/share/doc/gerbv/examples')
PANELCAL = None
GLYPHS = font()


ORCAD_HEADER = 'M48\nINCH,TZ\n%\n'


def replace(text, old, new):
    """Where the file has it, and with as many lines."""
    assert text.count(old) == 1 and old.count('\n') == new.count('\n'), (old, text[:200])
    return text.replace(old, new)


def ekf2(text):
    """Two headers, of Mentor. M72 is the manual's inch; six digits of boards of 7 inches end with zeros that count.
    T0 is no tool of the manual, and no hole of these files is of it."""
    text = replace(text, 'G90\nM72\nM48\nT0C0.006\n', 'M48\nINCH,TZ\n\n\n')
    return replace(text, '%\nG90\nM72\nM48\n%\n', '\n\n\n\n%\n')


def jj1(text):
    """Comments ahead of the header; T00 puts the tool away."""
    comments, program = text.split('M48\n')
    text = 'M48' + '\n' * (comments.count('\n') + 1) + program
    return replace(replace(text, 'T00\nM30 \n', '\nM30\n'), 'M71\n', '\n')


def veribest(text):
    """M71 is millimetres. All numbers are whole micrometres with trailing zeros: the board is 100 mm wide."""
    head, rest = text.split('M48\n')
    assert head.count('\n') == 2
    rest = rest[:rest.index('M30\n')] + 'M30\n'
    return 'M48\nMETRIC,TZ\n\n' + replace(replace(rest, 'T00\n', '\n'), 'M71\n', '\n')


def protel(text):
    """A comment ahead of the header. F00 and S00 say nothing."""
    head, rest = text.split('M48\n')
    assert head.count('\n') == 1
    return 'M48\n\n' + rest.replace('F00S00', '')


def orcad(text):
    """No header: tools in inch, and numbers of six digits with all their zeros."""
    return ORCAD_HEADER + replace(text, '%\n', '\n')


def pcb(text):
    """F00 and S00 say nothing."""
    return text.replace('F00S00', '')


# How each is put right, and how many holes it has: its lines with coordinates.
FILES = {'ekf2/drill0.exc': (ekf2, 2704), 'ekf2/drill1.exc': (ekf2, 16), 'amacro-ref/jj1.drl': (jj1, 0),
         'nollezappare/ThruHolePlated.ncd': (veribest, 94), 'protel-pnp/SE_SG_IF_V2.TXT': (protel, 427),
         'orcad/thruhole.tap': (orcad, 13), 'hellboard/hellboard.plated-drill.cnc': (pcb, 360),
         'numpres/numpres.pcb.output_unplated-drill.grb': (pcb, 0)}
# T0 is a drill of 0.006 inch there; the manual's T0 is no tool. INCH without digits is 00.0000 by the manual, in which
# the holes of the last file overlap: it is in 00.000, as the board's own coordinates have it.
T0_IS_NO_TOOL = 'error[tool-missing]: hole or rout move before the first tool: T0'
REFUSED = {'ekf2/drill20.exc': (T0_IS_NO_TOOL,), 'ekf2/drill30.exc': (T0_IS_NO_TOOL,),
           'numpres/numpres.pcb.output_plated-drill.grb': ('error[format-ambiguous]', 'inch 2.3, trailing zeros')}


def text_of(name):
    """Line ends and NUL characters are no part of a line."""
    return (EXAMPLES / name).read_bytes().decode('latin-1').replace('\r', '').replace('\0', '')


def panelcal_reads(name):
    with tempfile.TemporaryDirectory() as folder:
        machine = Path(folder) / 'machine.toml'
        machine.write_text('')
        return subprocess.run([PANELCAL, 'run', EXAMPLES / name, '-m', machine, '-o', '-', '--to', 'jsonl', '--slots', 'keep'],
                              capture_output=True, text=True, timeout=60, check=False)


def manual_reads(name):
    put_right, _ = FILES[name]
    text = put_right(text_of(name))
    operations = read_program(text).operations
    if text.startswith(ORCAD_HEADER):
        n_added = ORCAD_HEADER.count('\n')
        return [dataclasses.replace(operation, line=operation.line - n_added) for operation in operations]
    return operations


class Examples(unittest.TestCase):
    def test_both_readings_have_the_same_operations(self):
        for name, (_, n_holes) in FILES.items():
            with self.subTest(name):
                done = panelcal_reads(name)
                self.assertEqual(done.returncode, 0, done.stderr)
                operations = manual_reads(name)
                self.assertEqual(sum(operation.kind == 'hole' for operation in operations), n_holes)
                compare(operations, done.stdout, False, GLYPHS)

    def test_what_the_manual_does_not_explain_is_refused(self):
        for name, reasons in REFUSED.items():
            with self.subTest(name):
                done = panelcal_reads(name)
                self.assertEqual(done.returncode, 2)
                for reason in reasons:
                    self.assertIn(reason, done.stderr)

    def test_a_moved_hole_is_noticed(self):
        for name, (_, n_holes) in FILES.items():
            if n_holes == 0:
                continue
            output, operations = panelcal_reads(name).stdout, manual_reads(name)
            lines = output.splitlines()
            i = next(i for i, line in enumerate(lines) if '"op":"drill"' in line)
            moved = json.loads(lines[i])
            moved['nominal'][0] += 0.001
            with self.assertRaises(Difference, msg=name):
                compare(operations, '\n'.join(lines[:i] + [json.dumps(moved)] + lines[i + 1:]), False, GLYPHS)

    def test_no_text_drill_file_is_left_out(self):
        """Files whose lines are tools and coordinates of this language."""
        found = set()
        for path in EXAMPLES.rglob('*'):
            if path.is_file():
                text = text_of(path.relative_to(EXAMPLES))
                if re.search(r'^T0*\d+[FSC.\d]*C[.\d]+', text, re.MULTILINE) and re.search('^M30', text, re.MULTILINE):
                    found.add(str(path.relative_to(EXAMPLES)))
        self.assertEqual(found, {*FILES, *REFUSED})


if __name__ == '__main__':
    if not EXAMPLES.is_dir():
        print('SKIP: gerbv is not installed (tools/packages.txt, extra)')
        sys.exit(SKIPPED)
    PANELCAL = Path(sys.argv[1]).resolve()
    unittest.main(argv=sys.argv[:1])
