// SPDX-License-Identifier: Apache-2.0
#include "tools/surface/help.h"

#include <algorithm>
#include <array>
#include <utility>

namespace panelcal {
namespace {

using Footer = std::pair<std::string_view, std::string_view>;

constexpr auto kSurfaceFooters = std::to_array<Footer>({
    {"surface", R"(Example
  $ panelcal surface fit heightmap.csv -o map.json --plot map.svg
  $ panelcal surface query map.json 12.5,40
  (12.500, 40.000)           1.6021 mm +- 2.31 um  measured

A map knows how sure it is of every height and which heights nobody measured. Each part has its own
page: `panelcal surface fit --help`; docs/howto/surface.md shows a whole job.

Exit codes
  0 done; 1 a map refuses what was asked; 2 bad input or usage; 3 the disk or the environment
  failed)"},
    {"surface fit", R"(Example
  $ panelcal surface fit probes.jsonl -o map.json --plot map.svg --report map.html

Probes that do not fit the others are left out and named; the others decide by what they foretell of
each other: a plane where it is not clearly worse, else a Gaussian process (a smooth random bending on
top of bow and twist), unless a thin plate, or on a complete grid one that goes through every probe,
foretells more. None of them overshoots far from its probes without saying so: sigma, at every place, counts the scatter of the probes and how much the panel bends
between them. "residuals" is how far the probes are from the surface; if that is much more than they
are said to scatter, sigma grows with it.

Places between the probes that none of them vouches for are "filled", places outside of their hull
"extrapolated", at most --max-extrapolation-mm far; pictures hatch both. Missing probes of a grid are
never made up. The scatter of a probe is what its file says, else --sigma-um: probe one place ten
times to know it. Several files are taken as one panel, in the same coordinates.

--zones says which parts of the table have a surface of their own, where clamps and cut-outs are, and
where the panel ends (docs/formats/zones.md). --voids-of says which program was drilled or routed
already, lying as the panel lies now: every hole, slot and contour is a void as wide as its tool. A
probe that lies in a void, or is so near that its tip may touch it, or lies in no zone, makes no
surface and is named. A tool without a diameter is refused: what it left is not known.
  $ panelcal surface fit probes.jsonl --voids-of drill.exc -m machine.toml -o map.json

-o is the map (docs/formats/surface_map.md), --plot a picture of contours and sigmas, --report the
same as a page with tables; both leave voids white.

Exit codes
  0 a map was made; 1 too many probes do not fit the others; 2 the probes make no map, or bad usage;
  3 the disk failed)"},
    {"surface query", R"(Example
  $ panelcal surface query map.json 12.5,40 -3,0
  $ panelcal surface query map.json --program job.exc -m machine.toml --json > heights.jsonl
  $ panelcal surface query map.json --grid 11x7

Each line has the place, the height and its sigma, and whether it is measured, filled or
extrapolated. Places farther outside of the probes than the map allows are refused: they get no
height, and the exit code says so. --json: one object a line, lengths in mm:
  {"place":[12.5,40],"height":1.6021,"sigma":0.00231,"source":"measured","outside":0}
of a program also "line", "tool", "path". "source" is measured, filled, extrapolated, void or
refused. In a void the height is what the probes about it foretell, and "void" names it; a map of
zones says which "zone" a place lies in, and refuses places in none.

Exit codes
  0 done; 1 a place was refused; 2 bad input or usage)"},
    {"surface diff", R"(Example
  $ panelcal surface diff before.json after.json --plot change.svg

Compares the probes of the later map with what the earlier one foretells of them: an offset, a tilt,
bow and twist, and what is left. Each is judged by the chance that the scatter of the probes does as
much by itself; below 0.01 it is called a change. The picture and the last two lines compare the maps
themselves, over what both probed. The probes need not stand at the same places. Of maps of several
zones --zone says which one is compared.

Exit codes
  0 done, whether anything changed or not; 2 bad input or usage)"},
    {"surface plan", R"(Example
  $ panelcal surface plan --program job.exc -m machine.toml --tolerance-um 10 \
      --amplitude-mm 0.1 --length-mm 80 --probe-sigma-um 3 -o probes.csv --plot plan.svg
  $ panelcal surface plan map.json --tolerance-um 10
  $ panelcal surface plan map.json --afresh --program job.exc -m machine.toml --tolerance-um 10

Finds few places to probe, after which the map's sigma is at most --tolerance-um at every place of
the program, or all over the area: --area, else the rectangle of the program's places, else what MAP
spans. How the panel bends is what a MAP found, or what you say: --amplitude-mm is the standard
deviation of its bending about a plane, --length-mm the distance over which it changes. The probes of
MAP count as done already, but with --afresh, for another panel of its kind. Of a map of several
zones --zone says which one is planned for; nothing is probed where the tip would touch a void of
MAP.

-o lists the places: .csv as bare X and Y, .json with the figures and what the plan was made from.

Printed are the places in a short order to visit, the worst sigma with them, and how many probes a
regular grid would need. What is planned holds if the panel bends as it is believed to: fit its map,
and look at its sigma.

A tolerance below the scatter of a single probe is refused: only errors that average out could keep
it, and nobody knows that they do.

Exit codes
  0 a plan was made, or nothing is missing; 1 the tolerance cannot be kept, and nothing was written;
  2 bad input or usage)"},
    {"surface export", R"(Example
  $ panelcal surface export map.json --grid 11x7 -o heightmap.csv
  $ panelcal surface export map.json --grid 21x15 --fill --zero 0,0 -o board.probe
  $ panelcal surface export map.json --format linuxcnc -o probes.txt

Writes what RepRapFirmware (heightmap), bCNC (bcnc), OpenCNCPilot (opencncpilot) and LinuxCNC's users
(linuxcnc) read, or panelcal's own readings (probes). Grids are sampled from the map over the
rectangle of its probes; without --grid the last two hold the probes themselves.

A node that no probe vouches for stays missing, unless --fill foretells it; outside of the probes
nothing is foretold. bCNC knows no missing nodes and is refused them. What these files do not say is
printed: the worst sigma of a node, and how far straight lines from node to node, which is how those
programs go, are off the map. --zero gives heights from where that program's Z is 0.

Exit codes
  0 done; 2 bad input or usage; 3 the disk failed)"},
    {"surface apply", R"(Example
  $ panelcal surface apply map.json isolation.ngc -o levelled.ngc
  $ panelcal surface apply map.json drill.ngc -o levelled.ngc --zero 10,10 --max-sigma-um 15

The tool follows the board: to Z comes the map's height at X, Y. Lines and arcs (which become
helices) below the safe height are cut into as few pieces as keep the tool within
--height-tolerance-um of the map; a ramp or helix through the safe height is cut there first; every
hole of a drilling cycle gets its own Z and R; steps (G91) lead to the surface and back. Feeds,
comments and everything above the safe height stay as written.

Heights count from where the map has its 0. If the tool's Z was set to 0 on the board afterwards,
--zero says where that was; a map of heights above the table needs it. What was levelled says so in
comments, and is refused here: it would be levelled twice.

Across a void (surface fit --voids-of) the tool goes at the height that is foretold there. A move
outside of all zones is refused, and so is one from zone to zone where the surface steps by more than
a twentieth of --height-tolerance-um.

Understood are programs of LinuxCNC, GRBL and their kind: G0 to G3 in the XY plane, G73, G81 to G83,
G85, G86, G89, G20, G21, G90, G91. Refused, with line and column, is whatever would leave open where
the tool is: cycles in G91, subprograms, variables, lines behind a slash or behind M2, offsets that
change on the way, moves that nobody knows the beginning of (behind M6, G28), a safe height that the
board reaches, and places that the map does not.

Exit codes
  0 done; 1 the map is less sure than --max-sigma-um, and nothing was written; 2 bad input or usage;
  3 the disk failed)"},
});

}  // namespace

std::string_view surface_footer(std::string_view command) {
  const auto found = std::ranges::find(kSurfaceFooters, command, &Footer::first);
  return found == kSurfaceFooters.end() ? std::string_view() : found->second;
}

}  // namespace panelcal
