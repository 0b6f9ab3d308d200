#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""KiCad's demo boards in 32 combinations of KiCad's export options: panelcal, the second reading of Excellon programs
and the boards' own pads and vias have the same holes.

    kicad_test.py PANELCAL [--share 1] [unittest options]

--share N  each board in every N-th combination (up to the 8th), another board in others; all combinations occur
"""
import argparse
from collections import Counter, defaultdict
import itertools
import json
from pathlib import Path
import random
import subprocess
import sys
import tempfile
import unittest

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

SKIPPED = 77
OPTIONS = argparse.Namespace(panelcal=None, share=1)
# Of 14 boards, each in others: all combinations, and all kinds of holes.
MOST_SHARE = 8
# Doubles and six decimals, on top of half of a file's last digit.
RESOLUTION_MM = 1e-5
# Hits are looked for in cells of this size and those around it: wider than any rounding.
CELL_MM = 0.01


def skip(why):
    print('SKIP:', why, '(tools/packages.txt, extra)')
    sys.exit(SKIPPED)


try:
    import pcbnew
except ImportError:
    skip('kicad is not installed')
if not pcbnew.Version().startswith('6.'):
    skip(f'kicad 6 is needed, whose Python interface kicad_boards.py uses; found {pcbnew.Version()}')

from excellon import Refused, read_program
from excellon_compare import Difference, compare, font
from kicad_boards import DEMOS, ZEROS, Hole, combinations, demo_boards

GLYPHS = font()


def panelcal_reads(path):
    """panelcal's operations as JSON Lines. KiCad's files state their format: none is guessed."""
    machine = path.parent / 'machine.toml'
    machine.write_text('')
    done = subprocess.run([OPTIONS.panelcal, 'run', path, '-m', machine, '-o', '-', '--to', 'jsonl', '--slots', 'keep',
                           '--uncorrected', '--log-level', 'warning'], capture_output=True, text=True, timeout=60)
    if done.returncode:
        raise Difference(f'panelcal refuses: {done.stderr}')
    if '[format-' in done.stderr:
        raise Difference(f'panelcal guesses the format: {done.stderr}')
    return done.stdout


def manual_reads(path):
    """Operations of the second reading. T0 at KiCad's ends is no tool of the manual, so that it refuses it."""
    return read_program(path.read_text().replace('\nT0\nM30\n', '\n\nM30\n')).operations


def drilled(output):
    """The holes of panelcal's operations, mm; an oval one is a slot, or a rout from the place before it."""
    holes, diameter, at = [], None, None
    for operation in map(json.loads, output.splitlines()):
        kind = operation['op']
        if kind == 'tool':
            diameter = operation.get('diameter')
        elif kind == 'drill':
            holes.append(Hole(diameter, operation['nominal'], operation['nominal']))
        elif kind == 'slot':
            holes.append(Hole(diameter, operation['nominal'], operation['nominal_end']))
        elif kind == 'rout':
            holes.append(Hole(diameter, at, operation['nominal']))
        if kind in ('position', 'rout'):
            at = operation['nominal']
    return holes


def cell_of(hole):
    return tuple(round((hole.start[axis] + hole.end[axis]) / 2 / CELL_MM) for axis in (0, 1))


def is_same(a, b, reach_mm):
    """The same tool at the same place; an oval hole may be cut from either end."""
    def near(p, q):
        return max(abs(p[0] - q[0]), abs(p[1] - q[1])) <= reach_mm
    return abs(a.diameter - b.diameter) <= reach_mm and ((near(a.start, b.start) and near(a.end, b.end)) or
                                                        (near(a.start, b.end) and near(a.end, b.start)))


def without_each_other(found, wanted, reach_mm):
    """(found, wanted) holes that are left when each has taken one of the other side."""
    cells, extra = defaultdict(list), []
    for hole in wanted:
        cells[cell_of(hole)].append(hole)
    for hole in found:
        x, y = cell_of(hole)
        near = [(cells[at], other) for at in itertools.product((x - 1, x, x + 1), (y - 1, y, y + 1)) if at in cells
                for other in cells[at] if is_same(hole, other, reach_mm)]
        if near:
            cell, other = near[0]
            cell.remove(other)
        else:
            extra.append(hole)
    return extra, [hole for cell in cells.values() for hole in cell]


def check_board(output, wanted, options):
    extra, missing = without_each_other(drilled(output), wanted, options.step_mm() / 2 + RESOLUTION_MM)
    if extra or missing:
        raise Difference(f'{len(extra)} holes that the board has not: {extra[:3]}; '
                         f'{len(missing)} of the board that are missing: {missing[:3]}')


def chosen(i_board):
    """The board's share of the combinations, which is another one for the next board."""
    order = random.Random(1).sample(list(combinations()), 32)
    return order[i_board % OPTIONS.share::OPTIONS.share]


class Combinations(unittest.TestCase):
    def test_any_three_options_have_all_their_settings(self):
        rows = [tuple(vars(options).values()) for options in combinations()]
        self.assertEqual(len(set(rows)), 32)
        settings = [ZEROS if column == 1 else (False, True) for column in range(7)]
        for columns in itertools.combinations(range(7), 3):
            wanted = Counter(itertools.product(*(settings[column] for column in columns)))
            found = Counter(tuple(row[column] for column in columns) for row in rows)
            self.assertEqual(set(found), set(wanted), columns)
            self.assertEqual(len(set(found.values())), 1, columns)

    def test_shares_have_all_combinations(self):
        seen = Counter(options for i_board in range(len(BOARDS)) for options in chosen(i_board))
        self.assertEqual(len(seen), 32)


class Boards(unittest.TestCase):
    def test_files_have_the_holes_of_the_board(self):
        """By panelcal, by the second reading, and by the board's pads and vias."""
        counts, failures = Counter(), []
        for i_board, board in enumerate(BOARDS):
            for options in chosen(i_board):
                with tempfile.TemporaryDirectory() as name:
                    for path, wanted in board.export(options, Path(name)):
                        counts.update(files=1, hits=len(wanted), slots=sum(hole.start != hole.end for hole in wanted))
                        try:
                            output = panelcal_reads(path)
                            check_board(output, wanted, options)
                            compare(manual_reads(path), output, False, GLYPHS)
                        except (Difference, Refused, subprocess.TimeoutExpired) as failure:
                            failures.append(f'{path.name}, {options}: {failure!r}')
        print(f'{len(BOARDS)} boards: {dict(counts)}')
        self.assertEqual(len(failures), 0, '\n'.join(failures[:5]))
        self.assertGreaterEqual(counts['files'], 18 * 32 // OPTIONS.share)
        self.assertGreaterEqual(counts['hits'], 3500 * 32 // OPTIONS.share)
        self.assertGreaterEqual(counts['slots'], 10 * 32 // OPTIONS.share)

    def test_mutations_are_found(self):
        """A hole moved by two digits, of another tool, dropped or doubled; a file read upside down or moved by two digits."""
        board = next(board for board in BOARDS if board.name == 'ecc83-pp_v2')
        n_found = Counter()
        for options in combinations():
            if not options.merged or options.minimal:
                continue
            with tempfile.TemporaryDirectory() as name:
                (path, wanted), = board.export(options, Path(name))
                lines = panelcal_reads(path).splitlines()
            hits = [i for i, line in enumerate(lines) if json.loads(line)['op'] in ('drill', 'slot', 'rout')]
            self.assertEqual(len(hits), len(wanted))
            for i in hits[::5]:
                moved = json.loads(lines[i])
                moved['nominal'][0] += 2 * options.step_mm()
                self.mutated(n_found, 'moved', lines[:i] + [json.dumps(moved)] + lines[i + 1:], wanted, options)
                self.mutated(n_found, 'dropped', lines[:i] + lines[i + 1:], wanted, options)
                self.mutated(n_found, 'doubled', lines[:i + 1] + lines[i:], wanted, options)
            tool = next(i for i, line in enumerate(lines) if '"diameter"' in line)
            other = json.loads(lines[tool])
            other['diameter'] += 2 * options.step_mm()
            self.mutated(n_found, 'tool', lines[:tool] + [json.dumps(other)] + lines[tool + 1:], wanted, options)
            turned = [Hole(hole.diameter, *((x, -y) for x, y in (hole.start, hole.end))) for hole in wanted]
            self.mutated(n_found, 'turned', lines, turned, options)
            off_mm = 2 * options.step_mm()
            shifted = [Hole(hole.diameter, *((x, y + off_mm) for x, y in (hole.start, hole.end))) for hole in wanted]
            self.mutated(n_found, 'shifted', lines, shifted, options)
        self.assertEqual({kind: count >= 8 for kind, count in n_found.items()},
                         dict.fromkeys(('moved', 'dropped', 'doubled', 'tool', 'turned', 'shifted'), True))

    def mutated(self, n_found, kind, lines, wanted, options):
        with self.assertRaises(Difference, msg=f'{kind}, {options}'):
            check_board('\n'.join(lines), wanted, options)
        n_found[kind] += 1


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument('panelcal')
    parser.add_argument('--share', type=int, default=OPTIONS.share)
    _, rest = parser.parse_known_args(namespace=OPTIONS)
    if not 1 <= OPTIONS.share <= MOST_SHARE:
        parser.error(f'--share {OPTIONS.share}: 1 to {MOST_SHARE}, as more would leave out combinations')
    OPTIONS.panelcal = str(Path(OPTIONS.panelcal).resolve())
    unittest.main(argv=[sys.argv[0], *rest])


BOARDS = demo_boards()
if not BOARDS:
    skip(f'kicad-demos is not installed: no board in {DEMOS}')

if __name__ == '__main__':
    main()
