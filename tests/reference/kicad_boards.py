# SPDX-License-Identifier: Apache-2.0
"""KiCad's demo boards: their own holes, and their drill files in 32 combinations of KiCad's options.

Needs Debian's own Python, which has pcbnew (packages kicad and kicad-demos, version 6).
"""
from dataclasses import dataclass
import itertools
import math
from pathlib import Path

import pcbnew

DEMOS = Path('/usr/share/kicad/demos')
NM_PER_MM = 1_000_000
# On no grid of a board or a file, so that what is written is rounded.
ORIGIN_NM = (12_345_678, 9_876_543)
ZEROS = ('DECIMAL_FORMAT', 'SUPPRESS_LEADING', 'SUPPRESS_TRAILING', 'KEEP_ZEROS')


@dataclass(frozen=True)
class Options:
    """One setting of the dialogue "Generate Drill Files"."""

    metric: bool  # 3 and 3 digits, else inch with 2 and 4
    zeros: str  # of ZEROS
    merged: bool  # plated and other holes in one file
    mirrored: bool  # y as the board has it, down
    minimal: bool  # a header without comments and FMAT
    routed: bool  # oval holes as routs, else G85
    moved: bool  # coordinates from ORIGIN_NM

    def step_mm(self):
        """Last digit of coordinates and diameters, decimals included."""
        return 1e-3 if self.metric else 25.4e-4

    def __str__(self):
        flags = [name for name in ('merged', 'mirrored', 'minimal', 'routed', 'moved') if getattr(self, name)]
        return ', '.join(['metric' if self.metric else 'inch', self.zeros, *flags])


def combinations():
    """32 of the 256 combinations, in which any three options have every setting of the three.

    An orthogonal array of strength 3: five bits run through all values, and three are sums modulo 2 of them, chosen so
    that no sum of three options or fewer is constant (Hedayat, Sloane, Stufken 1999: Orthogonal Arrays).
    """
    for metric, zeros_high, zeros_low, merged, mirrored in itertools.product((False, True), repeat=5):
        yield Options(metric, ZEROS[2 * zeros_high + zeros_low], merged, mirrored,
                      minimal=metric ^ merged ^ mirrored ^ zeros_high,
                      routed=metric ^ merged ^ zeros_low,
                      moved=metric ^ mirrored ^ zeros_high ^ zeros_low)


@dataclass(frozen=True)
class Hole:
    """A hole of a board, or one that is drilled: a round one has both ends at its centre."""

    diameter: float
    start: tuple
    end: tuple


class Board:
    """A board file, with its holes in nm in the frame of the board: x right, y down."""

    def __init__(self, path):
        self.name = path.stem
        self.board = pcbnew.LoadBoard(str(path))
        self.plated, self.bare = [], []
        for track in self.board.GetTracks():
            if track.Type() == pcbnew.PCB_VIA_T:
                if track.GetViaType() != pcbnew.VIATYPE_THROUGH:
                    raise ValueError(f'{path}: a via that goes not through all layers has a file of its own')
                at = tuple(track.GetPosition())
                self.plated.append(Hole(track.GetDrillValue(), at, at))
        for pad in self.board.GetPads():
            if min(pad.GetDrillSize()) > 0:
                is_bare = pad.GetAttribute() == pcbnew.PAD_ATTRIB_NPTH
                (self.bare if is_bare else self.plated).append(hole_of(pad))

    def export(self, options, folder):
        """[(drill file, the holes that it must have, in mm in the frame of the file)]"""
        writer = pcbnew.EXCELLON_WRITER(self.board)
        origin = ORIGIN_NM if options.moved else (0, 0)
        writer.SetOptions(options.mirrored, options.minimal, pcbnew.wxPoint(*origin), options.merged)
        writer.SetRouteModeForOvalHoles(options.routed)
        writer.SetFormat(options.metric, getattr(pcbnew.GENDRILL_WRITER_BASE, options.zeros))
        writer.CreateDrillandMapFilesSet(str(folder), True, False)
        if options.merged:
            wanted = {f'{self.name}.drl': self.plated + self.bare}
        else:
            wanted = {f'{self.name}-PTH.drl': self.plated, f'{self.name}-NPTH.drl': self.bare}
        found = {path.name for path in folder.iterdir()}
        if found != set(wanted):
            raise ValueError(f'{self.name}, {options}: files {sorted(found)}')

        def in_file(point):
            x, y = (point[axis] - origin[axis] for axis in (0, 1))
            return (x / NM_PER_MM, (y if options.mirrored else -y) / NM_PER_MM)

        def in_mm(hole):
            return Hole(hole.diameter / NM_PER_MM, in_file(hole.start), in_file(hole.end))

        return [(folder / name, list(map(in_mm, holes))) for name, holes in wanted.items()]


def hole_of(pad):
    """An oval hole is that of a tool of its shorter side, along its longer one. Angles turn x to -y (up)."""
    (x, y), (width, height) = pad.GetPosition(), pad.GetDrillSize()
    half = abs(width - height) / 2 if pad.GetDrillShape() == pcbnew.PAD_DRILL_SHAPE_OBLONG else 0
    angle = math.radians(pad.GetOrientation() / 10 + (90 if height > width else 0))
    along = (half * math.cos(angle), -half * math.sin(angle))
    return Hole(min(width, height), (x - along[0], y - along[1]), (x + along[0], y + along[1]))


def demo_boards():
    return [Board(path) for path in sorted(DEMOS.rglob('*.kicad_pcb'))]
