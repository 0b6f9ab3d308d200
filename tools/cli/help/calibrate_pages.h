// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

// Pages of `panelcal calibrate`.
namespace panelcal::pages {

inline constexpr std::string_view kCalibrate = R"(Example
  $ panelcal calibrate spindle-camera -m drill1.toml --camera gige://192.168.1.20 --install

Each part has its own page: `panelcal calibrate spindle-camera --help`. A calibration that drives
the machine needs SOURCE: --camera URI with [machine] driver or stage_command, or --machine-driver
sim for the virtual machine of [sim]. Only --install puts a calibration in force.

--report writes a page with values, sigmas, verdict and residuals as arrows, and of a table the map
of its error; --json the same as facts (share/schema/calibration.schema.json).

Exit codes
  0 done; 1 the measurements give no calibration, or it was not installed; 2 bad input or usage;
  3 a device, the ledger or the disk failed; 129, 130, 143 SIGHUP, SIGINT or SIGTERM came: what the
  commands of [machine] moved was halted first)";

inline constexpr std::string_view kCalibrateSpindleCamera = R"(Example
  $ panelcal calibrate spindle-camera -m drill1.toml --camera gige://192.168.1.20 --install

Drills the next free rows of [coupon] and looks at each hole from every side that `approaches`
names. The places of the holes determine the offset between spindle and camera, the wander of the
drill from hole to hole, the repeatability of the stage (between looks), and its backlash. Outliers
among the holes are left out and named. The output has the offset with its sigma, the number of
further holes that would halve it, and its change from the present one, in sigmas. --yes answers the
question about entry material.

The rows are used up whatever happens: [coupon] state keeps count, so that no hole is drilled twice.
Put a new coupon on the table when they are, and give it a new name. While the ledger lacks entries
that calibrations or reports note, nothing is drilled: an older copy does not know which rows are.

-o FILE writes the calibration, and nothing else changes. --install appends it to [ledger] file
first and then writes [spindle] calibration from there: if the power fails in between, the next
`calibrate --install` or `nightly` writes the file. Refused, and recorded as refused, is an offset
whose residuals show a trend (the coupon moved, or the camera is turned); --force installs it.
After a change of the camera or of its calibration, calibrate this offset again.

Exit codes
  0 done; 1 too few holes were seen or fit, or it was not installed; 2 bad input or usage; 3 a
  device, the ledger or the disk failed)";

inline constexpr std::string_view kCalibrateCamera = R"(Examples
  $ panelcal calibrate camera -m machine.toml --camera gige://192.168.1.10 --at 120.5,80 --tool 3 \
      --focal-px 11000 -o camera.cal.json --report camera.html
  $ panelcal calibrate camera -m machine.toml --images DIR --tool 3 -o camera.cal.json

The mark of vision tool 3 (a disc, hole or ring; one drilled hole will do) is driven to 5 x 5 places
of the picture, each come to from the same side. Its places in the pictures determine scale,
rotation, tilt, and radial and tangential distortion, with covariance; the bias that tilt and lens
give to circle centres is part of the model. Recorded pictures are one mark's, and x, y of
images.csv say where the axis stood (docs/formats/picture_folder.md); a vision tool in pixels needs
no [camera], so that a camera can be calibrated for the first time.

--form auto takes the softest form that the views determine, and the report names the stiffer one
that would do, or the softer one that more views would show. A tilt shows only if --focal-px states
how near the lens is; with a telecentric lens a tilt and a stretch look alike, and k2, p1 and p2 are
fitted only where an F test shows them.
A plate of dots, with or without AprilTags (--plate, see `panelcal calibrate table --help`), does as
well as one mark; the present [camera] says where its dots are expected.
Parameters that the views do not determine are named and held. If the views scatter more than the
detector and [uncertainty] stage_repeatability_um state, every sigma grows by that factor, and more
where few views estimate it; the misfit of a form that --form takes counts as scatter. Held-out:
every fifth view is predicted from the others, where they determine its place. A view that the
others prove to be an outlier is left out and named.

Refused (exit 1, and no calibration is written) is a camera that more than a quarter of the views
were left out of, that is more than 5 um beside held-out views, whose views scatter more than 25
times what was stated, or whose scale or rotation neither the views nor the present [camera]
determine; --force writes it. --install records it in [ledger] file, refused or not,
with the digests of machine.toml, pictures and plate, and then writes [camera] calibration from
there. The spindle-camera offset goes with the camera: calibrate it again then.

With --machine-driver sim the mark is fixed to the virtual table at --at.

Files
  FILE.cal.json   docs/formats/calibration.md; [camera] calibration names it

Exit codes
  0 done; 1 there is no mark at --at, or it is refused; 2 bad input, or too few views show the mark;
  3 a device, the ledger or a file failed)";

inline constexpr std::string_view kCalibrateCameraImport = R"(Examples
  $ panelcal calibrate camera-import camera.yaml --scale-mm-per-px 0.0102 --corner-sigma-um 8 \
      -o camera.cal.json
  $ panelcal calibrate camera-import left.cameramodel --distance-mm 110 --rotation-deg 0.4 \
      --corner-sigma-um 20 -o camera.cal.json

Reads a pinhole with Brown's lens (k1, k2, p1, p2, k3): OpenCV's YAML (camera_matrix and
distortion_coefficients), ROS' camera_info (plumb_bob, or rational_polynomial without k4 to k6) and
mrcal's .cameramodel (LENSMODEL_PINHOLE, LENSMODEL_OPENCV4 to 12 without k4 to s4). Fisheye,
rational, thin prism and splined models are refused by name, and so are pixels that are not square.

Such a lens leads from the ray to the pixel, that of panelcal from the pixel to the ray. k1, k2, p1
and p2 of the calibration are the inverse by least squares over the picture; "lens" says by how much
it misses, and more than --max-lens-error-px is refused.

Scale and rotation are not in such a file: state them. --corner-sigma-um is what you trust them to,
and becomes their sigma; nothing measured it, as the calibration's provenance says. `panelcal
calibrate camera` measures all of it, with its sigma, from one mark.

Exit codes
  0 done; 2 bad input or usage, or another lens model; 3 the disk failed)";

inline constexpr std::string_view kCalibrateCameraExport = R"(Examples
  $ panelcal calibrate camera-export camera.cal.json --to opencv -o camera.yaml
  $ panelcal calibrate camera-export camera.cal.json --to mrcal --focal-px 11000 -o -

Writes focal length, optical axis and lens as OpenCV's YAML (opencv), ROS' camera_info (ros) or
mrcal's LENSMODEL_OPENCV5 (mrcal). k1, k2, p1, p2 and k3 are the inverse of panelcal's lens by least
squares over the picture; an inverse that misses it by more than --max-lens-error-px is refused, and
so is a camera with a tilt, which no lens model has. Scale and rotation stand in a comment, sigmas in
none. A telecentric camera has no focal length: --focal-px gives it one.

Exit codes
  0 done; 2 bad input or usage, or a camera that no such file can say; 3 the disk failed)";

inline constexpr std::string_view kCalibrateTable = R"(Example
  $ panelcal calibrate table -m machine.toml --plate plate.toml --measurements looks.jsonl \
      -o table.cal.json --report table.html --linuxcnc compensation

Looks at the dots of a plate (docs/formats/calibration.md): pictures (--images; a folder 0, 1, ...
for each pose of the plate), or the measurements of another vision system (--measurements). They
determine the scale of the axes, their squareness and straightness, and a smooth map of the table's
error, each with its sigma. A plate that is not certified calibrates the table too, if it is looked
at as it lies, turned by 90 degrees, and shifted by a dot; the scale is then undetermined. The
output names every parameter that the looks do not determine.

The pose of the plate and the place of the axis identify each dot ([[pose]] of the plate's file, to
a quarter of the pitch), or AprilTags on the plate do ([tags]), which also give the pose. Pictures
whose tags contradict the others are left out and named; if many do, nothing is fitted. The place of
the axis is not checked in pictures without a tag: the output has their number, and at least two
others have to show tags.

machine.toml `[table] calibration = "table.cal.json"` makes panelcal look and drill by the map: it
sends the command that leads to each place. Or the control corrects by it, and [table] is left out;
both would correct twice. In either case the looks have to be at the uncorrected stage.

--linuxcnc writes panelcal.hal (matrixkins coefficients), joint0.comp and joint1.comp (COMP_FILE),
and prints the part of the error that these files cannot hold.

Outliers among the looks are left out and named. Refused (exit 1, and neither FILE nor
LinuxCNC's files are written) is a map that more than a quarter of the looks were left out of, that
is more than 10 um beside held-out looks, or whose looks scatter more than 25 times what was stated;
--force writes it. --install records it in [ledger] file, refused or not, with the digests of
machine.toml, the looks and the plate; then `history diff` and `history export` know it.

Exit codes
  0 done; 1 it is refused; 2 bad input, or looks that determine no table; 3 the ledger failed, or a
  file cannot be written)";

inline constexpr std::string_view kCalibrateSurface = R"(Example
  $ panelcal surface fit probes.jsonl --model gaussian-process -o table.json
  $ panelcal calibrate surface table.json -m machine.toml --install --reason "new backing plate"

Takes a map of the table's own surface, of the bare backing plate or of a reference plate that stays
on the machine, probed by hand or by another machine's probe; places are machine coordinates. Prints
its figures over the area of [nightly.surface], else over its own probes: the height of the middle,
and how high tilt, bow and twist lift an edge or a corner above it, each with its sigma. With
--install also the `surface diff` to the map in force; the map goes into [ledger] file, and from
there into FILE, or into [nightly.surface] file. Later nights are compared with it.

A map that a night refused is installed the same way, after a person has looked:
  $ panelcal history show 12 --result -l drill1.ledger -o tonight.json
  $ panelcal calibrate surface tonight.json -m machine.toml --install --reason "chip at the edge"

Refused (exit 1) is a map whose sigma is above [nightly.surface] sigma_um; --force installs it. A
map of a grid model has no covariance of its errors, and is bad input.

Exit codes
  0 done; 1 it is refused; 2 bad input, or a map that does not reach over the area; 3 the ledger
  failed, or a file cannot be written)";

inline constexpr std::string_view kCalibrateFocus = R"(Example
  $ panelcal calibrate focus -m machine.toml --camera gige://192.168.1.10 --at 120.5,80 --range -2,2

Takes 25 pictures at heights of the focus axis ([machine] focus_command), prints the sharpness of
each and the height of the peak with its sigma, and leaves the axis there.

--install records it in [ledger] file as the one in force, or as refused where there is no peak, and
prints the line for machine.toml, [camera] focus_mm, which a person writes. No file is written.
While machine.toml has another value than the one in force, every further run prints a note.

Exit codes
  0 done; 1 there is no peak in the range; 2 bad input; 3 a device or the ledger failed, or another
  run holds the machine)";

inline constexpr std::string_view kCalibrateLight = R"(Example
  $ panelcal calibrate light -m machine.toml --camera gige://192.168.1.10 --at 120.5,80 --tool 3

Looks at a mark at lamp levels ([machine] lamp_command) and finds the one of best contrast at which
nothing clips; of nearly equal ones the darkest. The lamp is left there. --install records it in
[ledger] file, with a sigma of a step between levels over the root of 12, and prints the line for
machine.toml: [camera] lamp; see `panelcal calibrate focus --help`.

Exit codes
  0 done; 1 no level is usable; 2 bad input; 3 a device or the ledger failed, or another run holds
  the machine)";

inline constexpr std::string_view kCalibrateSettle = R"(Example
  $ panelcal calibrate settle -m machine.toml --camera gige://192.168.1.10 --at 120.5,80 --tool 3

Moves away and back, again and again, and takes a picture after another delay each time. Prints
[machine] settle_s: after that the mark is nearer to where it comes to rest than --limit-um, with
four standard deviations to spare; and whether the stage swings or creeps. Where the pictures allow
more than one swing, all are named and settle_s covers them. --install records the wait
with its sigma in [ledger] file; see `panelcal calibrate focus --help`. The virtual machine stands
still at once, so this needs a real one.

Exit codes
  0 done; 1 the pictures do not determine it; 2 bad input; 3 a device or the ledger failed, or
  another run holds the machine)";

}  // namespace panelcal::pages
