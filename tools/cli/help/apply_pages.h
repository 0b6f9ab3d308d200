// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

// Pages of what moves G-code.
namespace panelcal::pages {

inline constexpr std::string_view kAlignApply = R"(Example
  $ panelcal align apply isolation.ngc -m machine.toml --align board.align.json -o moved.ngc
  $ panelcal align apply outline.ngc -m machine.toml --align board.align.json -o moved.ngc \
      --surface map.json --max-sigma-um 15

Moves a G-code program (of pcb2gcode, FlatCAM and others) to where the board lies: X and Y of every
move become the place at which `panelcal run --align` would drill. Z, feeds, tools, comments and
all other words stay as written.

Both X and Y are written where either stood. Arcs stay arcs where the board is turned and shifted;
where it is stretched so much that the tool would be off by more than --tolerance-um, they are cut
into arcs and lines. Steps (G91) lead from actual place to actual place. G92 and G52 stay as they are,
and what follows counts from where they put the zero. Subprograms and repetitions with numbers (o...
sub, call, repeat) are written out where they are called. Lines in the machine's own coordinates
(G53, G28, G30) stay, and are counted.

With --surface the tool then follows the board, as with `panelcal surface apply`: the map's X and Y
are those of the machine, where the probe stood.

Understood are programs of LinuxCNC, GRBL and their kind: G0 to G3 in the XY plane, G73, G81 to G83,
G85, G86, G89, G20, G21, G90, G91. Refused, with line and column, is what leaves open where the tool
goes: variables and expressions that X, Y, Z, I, J or R depend on (F and S may), X without Y and steps
from an unknown place, G10, another work zero behind a move, cutter compensation (G41, G42), probing,
lines behind a slash or behind M2; and a program whose places do not overlap those of the pads, or
lie shifted against them.

Exit codes
  0 done; 1 the alignment is held or too old, or a place is less sure than --max-sigma-um; 2 bad input
  or usage; 3 the disk failed. Nothing is written but with 0.)";

inline constexpr std::string_view kFilter = R"(Example
  In the INI file of LinuxCNC:
  [FILTER]
  PROGRAM_EXTENSION = .drl,.ngc Programs for the aligned board
  drl = panelcal filter -m /home/cnc/machine.toml --align /home/cnc/board.align.json
  ngc = panelcal filter -m /home/cnc/machine.toml --align /home/cnc/board.align.json

  $ panelcal filter -m machine.toml --align board.align.json board-PTH.drl > pth.ngc

A filter program of LinuxCNC: a file that is opened in AXIS or QtDragon comes out as G-code for the
board as it lies. A drill or rout file becomes what `panelcal run --align` writes with [gcode], a
G-code program what `panelcal align apply` writes. Without an alignment that is in force nothing
comes out but the reason, and the exit code is 1: never the program as it was.

--max-sigma-um is of G-code. A drill or rout file is held against [tolerance] of machine.toml.

FILTER_PROGRESS=# goes to standard error if AXIS_PROGRESS_BAR is set.

Exit codes
  0 done; 1 there is no alignment, it is held or too old, the job is held, or a place is less sure
  than --max-sigma-um; 2 bad input or usage; 3 a device or the disk failed)";

}  // namespace panelcal::pages
