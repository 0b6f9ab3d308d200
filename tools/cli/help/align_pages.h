// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

// Pages of `panelcal align` and of the commands below it: example, explanation and exit codes.
namespace panelcal::pages {

inline constexpr std::string_view kAlign = R"(Example
  $ panelcal align board-F_Cu.gbr -m machine.toml --camera v4l2:/dev/video0 -o board.align.json
  $ panelcal run board-PTH.drl -m machine.toml --align board.align.json -o pth.ngc
  $ panelcal run board-NPTH.drl -m machine.toml --align board.align.json -o npth.ngc

Looks at the pads, fits them as `panelcal run` fits a series of targets, holds the fit against
[gates], and keeps it: measurements, fit with covariance, gates, who and when, and the content of
machine.toml and the calibrations it names. A fit that a gate refuses is kept too, and nothing is
drilled by it (docs/howto/align.md).

PADS is one of
  "5,5;95,5;95,75;5,75"  places in mm, relative to work zero
  board-F_Cu.gbr         a Gerber file: flashes with the X2 attribute FiducialPad, those of the
                         panel, else Global, else Local; without attributes round flashes of
                         --diameter
  board-top.pos          a placement file (KiCad's .pos, CSV with a header): references FID1, FID2
  board.exc              a part program: the series of targets that it measures for the panel
  board-PTH.drl --auto 4 a part program: four of its holes, those that determine all others best

Exit codes
  0 measured, and the fit may be drilled by; 1 a pad was not found, or a gate refuses the fit; 2 bad
  input or usage; 3 a device, the disk or the environment failed)";

inline constexpr std::string_view kAlignVerify = R"(Example
  $ panelcal align verify board.align.json -m machine.toml --camera v4l2:/dev/video0

Looks again at the two pads that lie farthest apart. If they are where they were, up to the noise of
looks and stage (chi square, one false alarm in 1,000), the alignment counts from now: the check is
added to the file. If not, or if one is not found, that is added, and nothing is drilled by the
alignment any more.

With --images or --measurements the two have seq 0 and 1.

Exit codes
  0 the panel lies still; 1 it has moved, a pad was not found, or the alignment was held before;
  2 bad input or usage; 3 a device, the disk or the environment failed)";

inline constexpr std::string_view kAlignShow = R"(Example
  $ panelcal align show board.align.json -m machine.toml

Says what was measured, when and by whom, what the fit found, and whether `panelcal run --align` would
take it now. --json and --report have the facts of the measurement, as those of `panelcal run`.

Exit codes
  0 it is in force; 1 it is held, too old, or the panel has moved; 2 bad input or usage, or another
  machine's)";

}  // namespace panelcal::pages
