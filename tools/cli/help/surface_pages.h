// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

// Pages of `panelcal surface`.
namespace panelcal::pages {

inline constexpr std::string_view kSurface = R"(Example
  $ panelcal surface fit heightmap.csv -o map.json --report map.html
  $ panelcal surface query map.json 12.5,40
  (12.500, 40.000)           1.6021 mm +- 2.31 um  measured

A map has a sigma for every height, and marks the heights that are not measured. Each part has its
own page: `panelcal surface fit --help`; docs/howto/surface.md shows a whole job.

Exit codes
  0 done; 1 a map refuses the request; 2 bad input or usage; 3 the disk or the environment
  failed)";

inline constexpr std::string_view kSurfaceFit = R"(Example
  $ panelcal surface fit probes.jsonl -o map.json --report map.html
  $ panelcal surface fit printer.cfg --profile default -o map.json
  $ panelcal surface fit octoprint.log --mesh-mm 15,15,205,205 -o map.json
  $ panelcal surface fit table.csv --unit inch -o map.json

PROBES are told from their text: panelcal's readings, RepRapFirmware's heightmap.csv, LinuxCNC's log
of PROBEOPEN, bCNC's .probe, OpenCNCPilot's .hmap, Klipper's printer.cfg, Moonraker's bed_mesh,
consoles of Marlin (G29 T0, G29 V4, M420 V) and of GRBL ([PRB:x,y,z:1]), Candle's .map, and tables of
x, y and z (docs/formats/height_files.md). "read" names the format, unit and zero of each. GRBL's
work zero is taken off where the console states it (WCO, or G54, G92 and TLO of $#); a Marlin mesh
whose console states no places needs --mesh-mm.

Outliers among the probes are left out and named; up to 15 probes are judged one by one, and where
a wild one cannot be told from a bend of the board, "why" says so. The model is a plane where
scatter explains all that it misses, else a Gaussian process: bow and twist and a random bending,
averaged over rough and smooth kinds and many lengths by how well each explains the probes. Sigma,
at every place, counts the scatter of the probes, the bending between them, and what those kinds
disagree in. Stated scatter is believed: what the probes miss more is bending, and widens sigma.

Places between the probes but far from all of them are "filled", places outside of their hull
"extrapolated", at most --max-extrapolation-mm far; pictures hatch both. Missing probes of a grid
stay missing. The sigma of a probe is that of its file, else --sigma-um: probe one place ten times
to measure it. Without either 5 um are assumed, and corrected by what the probes miss. Several files
are one panel, in the same coordinates.

--zones names the parts of the table that have a surface of their own, clamps and cut-outs, and the
border of the panel (docs/formats/zones.md). --voids-of names the program that was drilled or routed
already, with the panel as it lies now: every hole, slot and contour is a void as wide as its tool.
--program-format is the --format of `panelcal check` for it; --format here is that of the probes.
A probe that lies in a void, or is so near that its tip may touch it, or lies in no zone, does not
count and is named. A tool without a diameter is refused: the size of its voids is not known.
  $ panelcal surface fit probes.jsonl --voids-of drill.exc -m machine.toml -o map.json

-o is the map (docs/formats/surface_map.md), --report a page of heights, sigmas, residuals and the
surface in space, on which voids are blank. --json writes the same as facts; - is standard output.

Exit codes
  0 a map was made; 1 too many probes do not fit the others; 2 the probes make no map, or bad usage;
  3 the disk failed)";

inline constexpr std::string_view kSurfaceQuery = R"(Example
  $ panelcal surface query map.json 12.5,40 -3,0
  $ panelcal surface query map.json --program job.exc -m machine.toml --json heights.json
  $ panelcal surface query map.json --grid 11x7

Each line has the place, the height and its sigma, and whether it is measured, filled or
extrapolated. Places farther outside of the probes than the map allows are refused: they get no
height, and the exit code is 1. --json FILE has a column for x_mm, y_mm, height_mm, sigma_um and so
on (docs/formats/surface.md); - is standard output, in place of the lines. The source of a height is
measured, filled, extrapolated, void or refused. In a void the height is predicted from the probes
about it, and the void is named; a map of zones names the zone of each place, and refuses places in
none.

Exit codes
  0 done; 1 a place was refused; 2 bad input or usage)";

inline constexpr std::string_view kSurfaceDiff = R"(Example
  $ panelcal surface diff before.json after.json --report change.html

Compares the probes of the later map with the earlier map's prediction: an offset, a tilt, bow and
twist, and the rest. Each is a change if the chance that scatter alone makes it as large is below
0.01. The page of --report and the last two lines compare the maps themselves, over the area that both
probed. The probes need not stand at the same places. --zone selects one zone of maps of several
zones.

Exit codes
  0 done, whether anything changed or not; 2 bad input or usage)";

inline constexpr std::string_view kSurfacePlan = R"(Example
  $ panelcal surface plan --program job.exc -m machine.toml --tolerance-um 10 \
      --amplitude-mm 0.1 --length-mm 80 --probe-sigma-um 3 -o probes.csv --report plan.html
  $ panelcal surface plan map.json --tolerance-um 10
  $ panelcal surface plan map.json --afresh --program job.exc -m machine.toml --tolerance-um 10

Finds few places to probe, after which the map's sigma is at most --tolerance-um at every place of
the program, or all over the area: --area, else the rectangle of the program's places, else what MAP
spans. How the panel bends comes from a MAP, or from you: --amplitude-mm is the standard deviation
of its bending about a plane, --length-mm the distance over which it changes. The probes of MAP
count as done already, but with --afresh, for another panel of its kind. --zone selects one zone of
a map of several zones; the plan has no probe whose tip would touch a void of MAP.

-o lists the places as bare X and Y (.csv). --report is a page with the sigma that the map will have;
--json has the figures, the places and the plan's inputs.

Printed are the places in a short order to visit, the worst sigma with them, and how many probes a
regular grid would need. The plan holds if the panel bends as assumed: fit its map, and look at its
sigma.

A tolerance below the scatter of a single probe is refused: only errors that average out could keep
it, and it is not known that they do.

Exit codes
  0 a plan was made, or nothing is missing; 1 the tolerance cannot be kept, and nothing was written;
  2 bad input or usage)";

inline constexpr std::string_view kSurfaceExport = R"(Example
  $ panelcal surface export map.json --grid 11x7 -o heightmap.csv
  $ panelcal surface export map.json --grid 21x15 --fill --zero 0,0 -o board.probe
  $ panelcal surface export map.json --format linuxcnc -o probes.txt

Writes what RepRapFirmware (heightmap), bCNC (bcnc), OpenCNCPilot (opencncpilot) and LinuxCNC's
users (linuxcnc) read, or panelcal's own readings (probes). Grids are sampled from the map over the
rectangle of its probes; without --grid the last two hold the probes themselves.

A node far from all probes stays missing, unless --fill predicts it; outside of the probes nothing
is predicted. A grid with missing nodes has no form for bCNC and is refused. Printed is what these
files have no place for: the worst sigma of a node, and how far straight lines from node to node,
which is how those programs go, are off the map. --zero gives heights from where that program's Z is
0.

Exit codes
  0 done; 2 bad input or usage; 3 the disk failed)";

inline constexpr std::string_view kSurfaceApply = R"(Example
  $ panelcal surface apply map.json isolation.ngc -o levelled.ngc
  $ panelcal surface apply map.json drill.ngc -o levelled.ngc --zero 10,10 --max-sigma-um 15

The tool follows the board: to Z comes the map's height at X, Y. Lines and arcs (which become
helices) below the safe height are cut into as few pieces as keep the tool within
--height-tolerance-um of the map; a ramp or helix through the safe height is cut there first; every
hole of a drilling cycle gets its own Z and R; steps (G91) lead to the surface and back. Feeds,
comments and everything above the safe height stay as written.

Heights count from where the map has its 0. If the tool's Z was set to 0 on the board afterwards,
--zero states where that was; a map of heights above the table needs it. A levelled program has a
comment that states so, and is refused here: it would be levelled twice.

Across a void (surface fit --voids-of) the tool goes at the height that is predicted there. A move
outside of all zones is refused, and so is one from zone to zone where the surface steps by more
than a twentieth of --height-tolerance-um.

Understood are programs of LinuxCNC, GRBL and their kind: G0 to G3 in the XY plane, G73, G81 to G83,
G85, G86, G89, G20, G21, G90, G91. Commands that leave the place of the tool unknown are refused,
with line and column: cycles in G91, subprograms, variables that X, Y, Z, I, J or R depend on, lines
behind a slash or behind M2, offsets that change on the way, moves from an unknown place (behind M6,
G28), a safe height that the board reaches, and places that the map does not.

Exit codes
  0 done; 1 the map is less sure than --max-sigma-um, and nothing was written; 2 bad input or usage;
  3 the disk failed)";

}  // namespace panelcal::pages
