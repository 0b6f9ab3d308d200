// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

// Pages of the commands for jobs and nights: example, explanation and exit codes.
namespace panelcal::pages {

inline constexpr std::string_view kInit = R"(Examples
  $ panelcal init --template usb-camera-grbl --name "garage mill" --device /dev/ttyACM0 \
      --camera v4l2:/dev/video2 --um-per-px 18
  machine.toml written, and camera.cal.json with a scale that is assumed; lines with "assumed" are to
  be measured, its head says how
  $ panelcal init --template folder camera.cal.json -o bench.toml
  $ panelcal init --template usb-camera-linuxcnc --camera-offset-mm 52.3,-8.1 \
      --camera-offset-sigma-um 15 --safe-z-mm -2 camera.cal.json

Writes a machine.toml that every command takes at once, each key behind a line of help. At a terminal
it asks for the kind of machine where --template does not say it.

What was not measured is marked "assumed", with the command that measures it. Assumed numbers are
as unsure as they look: until the camera and the spindle-camera offset are calibrated, [tolerance]
holds the jobs. Without CALIBRATION a camera.cal.json is written beside it: a camera that looks
straight down, its scale by --um-per-px known to 2 %, its rotation to 50 mrad.

No file is replaced.

Templates
  usb-camera-linuxcnc  a mill or router with LinuxCNC, and a USB camera
  usb-camera-grbl      a mill or router with GRBL, grblHAL or FluidNC, and a USB camera
  gige-cnc7            a drilling machine that reads Excellon CNC-7, and a GigE Vision camera
  folder               pictures in folders, without a machine

Exit codes
  0 done; 2 bad input or usage, or a file is there already; 3 the disk or the environment failed)";

inline constexpr std::string_view kDoctor = R"(Examples
  $ panelcal doctor -m datasets/demo/machine.toml
  ok        machine.toml: "demo driller", read with all that it names
  ...
  ready: 0 failing, 1 warning
  $ panelcal doctor -m machine.toml --camera v4l2:/dev/video0 --devices

Looks at machine.toml and at everything that it names, and says in a line each what is well, what is
missing or stale, what was only assumed, and what would fail tonight, with what to do about it:
machine.toml held against itself, calibrations and their dates, the smallest error that any hole can
have against [tolerance], programs of commands, the ledger, the reports' folder, the disk, the night
that comes (a dry run).

Nothing moves and nothing is written. --devices also opens and closes the camera, which takes a
picture, and the control, which has to be ready: switched on, homed, idle. Only while no other
program uses them: opening GRBL's serial device resets it, and LinuxCNC gives its control to the
newest client.

States
  ok         nothing is to be done
  warning    jobs and nights run, and a person should know
  fails      a job or a night would fail or be held
  not tried  the line says what would try it

Files
  --json FILE is a document by share/schema/doctor.schema.json.

Exit codes
  0 nothing fails; 1 something does; 2 bad input or usage; 3 the environment failed)";

inline constexpr std::string_view kCheck = R"(Example
  $ panelcal check datasets/demo/panel.exc -m datasets/demo/machine.toml
  datasets/demo/panel.exc: Excellon, metric 3.3, trailing zeros kept (line 9: METRIC,TZ)
  7 tools, 990 holes, 21 targets in 7 series, no errors, no warnings

Prints problems like a compiler: FILE:LINE:COLUMN: error[CODE]: PROBLEM: TEXT; expected REMEDY
States how it reads numbers, and why. Finds, without a machine: blocks that are not allowed where
they stand, series that never complete, M52 that does not match M50, coincident or collinear
fiducials, unused tools, missing feeds, coordinates of a suspicious size, and with [machine]
travel_low_mm and travel_high_mm moves outside the travel. In SIEB & MEYER programs also brackets
that do not close, contours without T0, holes in forbidden areas, surfaces that are not
measured, and peck strokes that end too high; every probe is taken to find the surface where it is
expected. A file without its end (M30 or M00, the tool table) is an error; --accept-unterminated
takes an Excellon file that stops behind a complete line. Without PROGRAM only the machine file and
the calibrations it names are checked. --json writes the findings as one object (docs/formats/facts.md),
also where there are errors.

An Excellon program that does not state its number format is read as nc_param.txt beside it says, or
[program] units, zeros and digits of machine.toml, or as its numbers can only be meant: a warning
says why. Where they can be meant in two ways that is an error, and --format inch,tz,2.4 decides.
Digits of nc_param.txt and [program] hold behind INCH and METRIC alone as well, with a warning.
A SIEB & MEYER program is in the numbers that its %%5000 names; %% alone and %%5001 to %%5010 leave
them to the same keys, and --format rules over both.

The machine file is held against itself: each row that [coupon] promises, the mark, the plate and the
rectangle of [nightly.surface] within travel, and all that each calibration of [nightly] needs. With
[camera] a program's vision tools must be defined, and its targets be seen within travel by the
camera, which stands by camera_offset_mm beside the spindle. All problems are printed at once.

Exit codes
  0 nothing wrong (warnings allowed); 2 errors)";

inline constexpr std::string_view kSurvey = R"(Example
  $ panelcal survey datasets/demo/panel.exc -m datasets/demo/machine.toml | head -1
  {"seq":0,"line":24,"command":"G36","tool":1,"nominal":[6,6],"expected":[6,6],"path":[]}

One JSON object a line, in the order of execution; lengths in mm, relative to work zero. Targets
that depend on earlier ones are listed where a perfect panel has them. Lines with "probe" in place
of "seq" ask for the height of the surface (docs/formats/probes.md), lines with "focus" for an
autofocus.

Exit codes
  0 done; 2 errors in the program or the machine file)";

inline constexpr std::string_view kNightly = R"(Example
  $ panelcal nightly -m machine.toml --dry-run
  $ panelcal nightly -m machine.toml

One night of a machine that calibrates itself: lock, ledger, warm-up, self-test; then each
calibration that [nightly] lists is measured, held against its gates and against the nights before,
recorded in the ledger, and installed if it passes; if not, the one before it stays in force, where
that can still be trusted. Prints five lines: may the machine drill and until when, what became of
each calibration, what changed since last week, the self-test, what else to know. NIGHT.html and
NIGHT.json in [nightly] reports say all of it (docs/formats/nightly.md).

Killed at any moment, it goes on where it stopped when it is run again; what this night has
calibrated is not measured twice, but with --again. --dry-run moves and writes nothing (but a report
that is asked for). After a hold: docs/howto/nightly.md, which also has the systemd units and a line
for cron. --metrics night.prom writes for Prometheus whether it may drill (docs/howto/metrics.md).

Exit codes
  0 everything was installed; 1 something was refused or a check did not pass; 2 bad input or usage;
  3 a device, the disk or the ledger failed, or another run holds the machine's lock; 129, 130, 143
  SIGHUP, SIGINT or SIGTERM came: what moved was halted first, and the page says "interrupted")";

inline constexpr std::string_view kPlan = R"(Example
  $ panelcal plan datasets/demo/panel.exc -m datasets/demo/machine.toml --report plan.html

Predicts, before any measurement, how much of the noise of its targets reaches the worst hole and
where that hole is, for every model that the targets determine; how many holes lie outside of the
targets' hull; whether an outlier would be noticed and named; which further pad of the program
would help most (--add K: which K together), and how; and a short order of visits. It only advises:
nothing is measured and no program is changed (docs/howto/plan.md). Where [vision] model fixes none,
further targets count under the manual's model for their number, which may be a softer one.

"x" counts times the noise of a target, in the direction where it is worst: 1.73 is a panel of
targets in three corners under an affine model, seen from the fourth. "um" is the same for a noise
of --fiducial-sigma-um (2) in the picture, or as --measurements had it, with the machine's own
[uncertainty] at targets; "total" also counts what the machine adds to every hole.

--report is a page that needs no other file: the leverage over the panel, which follows as targets
are dragged and pads are added, what an outlier would do, the order of visits. --json writes the
same as facts (docs/formats/plan.md); - is standard output, in place of the text.

Exit codes
  0 advice was given, also where targets do not determine their model; 2 bad input or usage; 3 the
  disk or the environment failed)";

inline constexpr std::string_view kRun = R"(Example
  $ panelcal run datasets/demo/panel.exc -m datasets/demo/machine.toml \
      --images datasets/demo/images -o corrected.drl --report report.html

Walks through the program twice. The first walk measures every target and fits every series; each
fit is held against [gates]: residual (100 um), rotation (3 degrees), stretch (2,000 ppm), chi
square (one false alarm in 1,000 jobs) and mirror hold unless machine.toml says another limit or
"off", and the verdict names those that are off. Only if all hold does the second walk write the
corrected program, whole or not at all. The report is written in either case: one page that needs
nothing else and shows the facts that --json writes as one object (docs/formats/facts.md). A program that
measures no target needs no SOURCE, and with one it is refused: it is the wrong program, or its
targets are lost. --uncorrected writes it as it is.

  $ panelcal run board-PTH.drl -m machine.toml --align board.align.json -o pth.ngc

corrects a program without targets by what `panelcal align` has measured: the same fit for each file
of the board. It is refused for another machine.toml or calibration, if a gate holds it, if the panel
was seen more than --valid hours ago (`panelcal align verify`), for a program that asks the camera
itself, and where its holes and the pads do not overlap (docs/howto/align.md).

--turned 90, 180 or 270 declares that the panel lies so on purpose, counter-clockwise about work
zero; rotation and offset are held against [gates] from there. A panel that lies so without being
declared is held. It is for measurements of another vision system: a camera looks for targets where
the program has them.

[tolerance] states how far holes may be off. The second walk then gives each place the probability
of breaking it ("risk"), from the fits' covariance and what [uncertainty], [spindle] and [camera]
state of the machine, and the job its verdict: drill; drill, with a warning (exit 0); or hold (exit
1, and nothing is written, nor sent to standard output). No risk is stated where stage, table or
drill are not stated in [uncertainty], or where the targets refuse the fit; none below 0.001 where
an error of a target may pass unnoticed and break the tolerance: the verdict then names it.

A program that probes the surface (G73, G78, G79) needs --probes, --machine-driver, or --camera with
[machine] probe_command; --force does not help where a surface was not found or is out of tolerance.

--surface MAP.json (of `panelcal surface fit`) gives the board's heights: depths below it (K of G83,
[[depth]]) count from the map at each place, contours are cut to [surface] height_tolerance_um, and
SIEB & MEYER output states heights. The program's own probes stay, and are compared with the map. A
place that the map does not reach, or with a sigma above [surface] max_sigma_um, refuses the job
(docs/howto/surface.md).

G39 and $uvis,calib drill into [coupon], look, and measure with the new spindle-camera offset from
there on; G39,SPOP and similar take the last measured offset. Both hold for this job only;
without a coupon or a drill the order is passed on with a warning.

With a live camera the machine is driven to each target by [machine] driver = "grbl"
(docs/howto/grbl.md), or through stage_command, a program of yours that speaks to its controller
(docs/howto/cameras.md):

  $ panelcal run job.exc -m machine.toml -o corrected.drl \
      --camera 'gige://192.168.1.20?exposure_us=2000&format=mono8'

Cameras  folder:DIR and video:FILE give their pictures in order;
v4l2:/dev/video0?width=1280&height=960, rtsp://HOST/PATH and gige://ADDRESS?packet=1500&exposure_us=..
&gain=..&format=mono8&timeout_ms=1000&retries=20&resend=on|off are live. A USB camera (v4l2) takes
exposure_us, gain, focus, white_balance_k and power_line_hz too (docs/howto/usb_camera.md); one that
keeps its focus or exposure automatic is a warning.

Formats  .jsonl .csv .drl .exc .s5 .sm .ngc .svg, or --to jsonl|csv|excellon|sieb-meyer|gcode|svg;
.svg is a picture of the job. Either language can be written from either; the output names what the
other one has no form for, and nothing is written if a tool would go elsewhere without it.

.drl, .exc, .s5 and .sm have the digits that the control reads: those that the program's header
declares, at most six; where it declares others or none, or writes coordinates with decimal points,
0.001 mm or 0.0001 inch. The rounding is part of sigma and of the verdict. A coordinate that does
not fit is an error. --resolution 0.1 writes tenths of a micrometre, for controls that read more.

.ngc is G-code for LinuxCNC, or by --flavour for GRBL or Marlin, which get moves instead of cycles
and M0 with the tool named. [gcode] of machine.toml states how high the tool moves and, where the
program does not, how deep and how fast it works (docs/formats/gcode.md); a value that is missing in
both is an error:

  $ panelcal run job.exc -m machine.toml --images pictures -o corrected.ngc --flavour grbl

  $ panelcal run job.exc -m machine.toml --measurements m.jsonl --explain L33

explains the holes of line 33: programmed place, copy, scaling, fits with their fiducials and
residuals, work zero, the coordinates that the machine receives, and the uncertainty: an error
budget with sigma, share and the holes that share each error, and its tolerance and risk; of a depth
the height that it counts on, and the same budget. --explain 500 takes the 500th hole or move.
Without -o the job is judged all the same.

panelcal looks for stored patterns and subprograms (M99,NAME) beside the program, then in [program]
search_path. Texts with the date or the time (&D, &T) are drilled with --clock, else with the time
of the run, which the output then names.

A program without its end (M30 or M00, the tool table) may have been cut off, and nothing is written.
--accept-unterminated takes an Excellon program that stops behind a complete line: a warning, a
comment in the output and the report say so.

Pictures of a folder are read and looked at ahead, on --threads threads; what is written does not
depend on their number. If all targets that were seen are too large or too small by one factor, a
line on standard error says by how much; also if all refused series would fit with a camera mirrored
or turned by a quarter.

Exit codes
  0 done, perhaps with warnings; 1 a target was not found, a gate failed or [tolerance] holds the
  job, and no program was written (but see --force); 2 bad input or usage; 3 a device, the disk or
  the environment failed; 129, 130, 143 SIGHUP, SIGINT or SIGTERM came (what moved under --camera
  was halted first))";

inline constexpr std::string_view kTranslate = R"(Example
  $ panelcal translate job.exc -o job.s5
  job.exc:3: warning[translation-loss]: left out of the translation: "ATC,ON" has no form in
  SIEB & MEYER
  Excellon CNC-7 into SIEB & MEYER: 2 holes, 2 rout moves as written, 1 pattern executed at 4
  places, 1 series of targets; 1 thing left out

Writes an Excellon program in SIEB & MEYER's format 5000, or the other way round. Nothing is
measured and nothing corrected ([table] of the machine neither): patterns stay patterns (M25 to M08;
M31 to M30 with M50 to M90), and targets are measured by the other control (G35, G36, G45; G32, G31,
G36). Executed, the translation drills the same holes in the same order and routs the same contours;
only drilled slots (G85) are left to the controls, which space their holes each in its own way:
`panelcal run --slots expand` writes the holes out. Coordinates have the digits that the control
reads: 0.001 mm, or 0.0001 inch where the source is in inches.

Commands without a form in the other language are named, line by line. Settings, messages to the
machine, dwells and peck parameters are left out with a warning. Commands that decide where or how
deep a tool goes (working planes, measured grids, slots and layers as targets, step slots, M14) are
an error: change the program there, or leave them out with --force and look at the result.
docs/conventions.md has the list of what is carried and refused. Corrections that are stored are
carried over (M50, M51 and M52, in patterns and outside; G39,SAVE and G39,LOAD, by the copies'
numbers and others), and so are nested series of three targets (G46).

With --to a program is written in its own language, with its patterns, targets and probes as they
are: a SIEB & MEYER control then measures in the mode that it is set to, and probes by itself.

Exit codes
  0 done, perhaps with warnings; 1 something that matters would be lost, and nothing was written
  (but see --force); 2 bad input or usage; 3 the disk or the environment failed)";

inline constexpr std::string_view kLocate = R"(Example
  $ panelcal locate datasets/demo/images/0000.png --tool 1 -m datasets/demo/machine.toml

One JSON object a picture: status, centre and covariance in pixels (the centre of the top-left pixel
is 0,0; y down), size, score, number of candidates, what part was seen, blur and noise
(docs/formats/located_targets.md). With a [camera] calibration the lens is taken into account.

  $ panelcal locate a.png --tool 1 -m machine.toml --at 239,241 --radius 60 --overlay seen.png

looks for the centre within 60 px of that place only, and draws the result: the fitted outline
(green if found, red if not), the centre with its uncertainty magnified, and every other candidate
(yellow), by number, with its score and the reason why it does not count. --candidates lists these
as "others" too, in the same order. For several pictures --overlay names a folder, which gets a
NAME.png for each; overlays are PNG and nothing else.

A refusal has the reason of the candidate that is nearest to the target, and says what is there
instead: a mark of another size or polarity, 12 bits in a file of 16. If all targets of several
pictures are too large by one factor, a line on standard error says so.

  $ panelcal locate --suggest board.jpg --overlay seen.png

needs no machine.toml: it lists everything round, square, cross-shaped or tagged, in groups of like
size, the most useful first, as comments, and then a [[vision.tool]] block to paste for each of the
first groups; sizes are in mm with -m and its [camera].

--json FILE writes one document of all pictures, with what could not be read; of --suggest with
every mark (docs/formats/located_targets.md).

--threads looks at several pictures at once; results and their order do not depend on it.

Exit codes
  0 every picture was read, whatever was found in it; 2 a picture or an option is bad; 3 an overlay
  cannot be written)";

inline constexpr std::string_view kSynth = R"(Example
  $ panelcal synth datasets/demo/panel.exc -m datasets/demo/machine.toml -o pictures

Puts the panel of [sim] under the virtual camera, executes the program's measurements on it, and
saves every picture with images.csv. truth.json, which only --truth reads, holds the true places.

  $ panelcal synth --tool 1 --count 100 -m datasets/demo/machine.toml -o samples

Without a program: pictures of one target each, at random places and angles, with the noise, debris
and neighbours of [sim]. Their truth.json (docs/formats/sample_truth.md) says what `panelcal locate`
should find in them.

  $ panelcal synth --sweep sweep.toml -o set
  $ panelcal batch set/manifest.csv -o results
  $ panelcal batch report results -o page.html

A test set as a designed experiment: sweep.toml (docs/formats/sweep.md) names the numbers of [sim]
that differ, and spreads them by a grid, a Latin hypercube or Sobol's sequence:

  machine = "machine.toml"
  program = "panel.exc"
  design = "sobol"
  points = 1000
  [[factor]]
  key = "noise"
  from = 0
  to = 20

Each point has a folder with its truth, and a row of set/manifest.csv, which `panelcal batch` takes
as it is. All cores work; after a kill --resume renders what is missing.

What an earlier synth wrote into the folder, by the digests in its synth.sha256, is removed. A folder
with numbered pictures or lists that are not as synth wrote them is refused.

Exit codes
  0 done; 1 a target could not be measured; 2 bad input; 3 the folder cannot be written)";

}  // namespace panelcal::pages
