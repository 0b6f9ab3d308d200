#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Exports the drill files of KiCad boards in every number format. Needs the system's Python, which
has pcbnew.

usage: kicad_export.py OUTPUT BOARD...
"""

import sys
from pathlib import Path

import pcbnew

FORMATS = {
    "decimal": pcbnew.GENDRILL_WRITER_BASE.DECIMAL_FORMAT,
    "suppress_leading": pcbnew.GENDRILL_WRITER_BASE.SUPPRESS_LEADING,
    "suppress_trailing": pcbnew.GENDRILL_WRITER_BASE.SUPPRESS_TRAILING,
    "keep_zeros": pcbnew.GENDRILL_WRITER_BASE.KEEP_ZEROS,
}


def main():
    output, *boards = sys.argv[1:]
    for path in map(Path, boards):
        board = pcbnew.LoadBoard(str(path))
        for metric in (True, False):
            for name, zeros in FORMATS.items():
                folder = Path(output) / f"{path.stem}_{'metric' if metric else 'inch'}_{name}"
                folder.mkdir()
                writer = pcbnew.EXCELLON_WRITER(board)
                writer.SetOptions(False, False, pcbnew.wxPoint(0, 0), True)
                writer.SetRouteModeForOvalHoles(False)  # gerbv reads G85, no routs
                writer.SetFormat(metric, zeros)
                writer.CreateDrillandMapFilesSet(str(folder), True, False)


if __name__ == "__main__":
    main()
