// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "calib/base/expected.h"
#include "tools/cli/file_options.h"
#include "tools/cli/surface_options.h"

namespace panelcal {

struct CommonOptions {
  bool quiet = false;              ///< errors only on standard error
  std::string log_level = "info";  ///< error, warning, info
};

struct CheckOptions {
  std::string program;  ///< may be empty: then only the machine file is checked
  std::string machine;  ///< may be empty
  std::string clock;    ///< of texts and of calibrations' age: 2026-11-21T13:45:00; empty: now
  std::int64_t max_operations = 1'000'000'000;
  bool accepts_unterminated = false;  ///< an Excellon program without M30
};

struct SurveyOptions {
  std::string program;
  std::string machine;
  std::string clock;
  std::int64_t max_operations = 1'000'000'000;
  bool accepts_unterminated = false;  ///< as CheckOptions
};

struct RunOptions {
  std::string program;
  std::string machine;
  std::string images;          ///< SOURCE: a picture folder
  std::string measurements;    ///< SOURCE: a recorded file
  std::string machine_driver;  ///< SOURCE: sim
  std::string camera;          ///< SOURCE: address of a live camera
  std::string probes;          ///< recorded probe readings
  std::string surface;         ///< a map made before; empty: none
  std::string output;
  std::string format;  ///< empty: from the output's extension
  std::string report;
  std::string save_measurements;
  std::string save_probes;
  std::string clock;
  std::string truth;
  std::string explain;        ///< L14 or 500: see ExplainChoice
  std::string slots;          ///< keep or expand; empty: what suits the format
  std::size_t n_threads = 0;  ///< that look at pictures; 0: one for each processor
  std::int64_t max_operations = 1'000'000'000;
  bool accepts_unterminated = false;  ///< as CheckOptions
  std::optional<int> turned_deg;      ///< absent: as [gates] says
  bool uncorrected = false;           ///< a program without targets is meant
  bool force = false;
};

struct TranslateOptions {
  std::string program;
  std::string machine;  ///< may be empty
  std::string output;
  std::string to;     ///< excellon or sieb-meyer; empty: the other language
  std::string clock;  ///< as CheckOptions
  std::int64_t max_operations = 1'000'000'000;
  bool accepts_unterminated = false;  ///< as CheckOptions
  bool force = false;
};

struct LocateCommandOptions {
  std::vector<std::string> images;
  std::string machine;
  std::optional<int> tool;    ///< there unless it suggests
  std::vector<double> at_px;  ///< x, y of the middle of the searched circle; empty: everywhere
  std::optional<double> radius_px;  ///< of it; there if at_px is
  std::string overlay;              ///< a .png, or a folder of them; empty: none
  bool lists_candidates = false;
  bool suggests = false;      ///< tells what is there instead
  bool json = false;          ///< the suggestion as JSON Lines
  std::size_t n_threads = 0;  ///< 0: one for each processor
};

struct PlanOptions {
  std::string program;
  std::string machine;
  std::string output;        ///< .svg or .html; empty: no picture
  std::string measurements;  ///< of an earlier job, for the noise of its targets; may be empty
  std::string clock;         ///< as CheckOptions
  std::optional<double> fiducial_sigma_um;  ///< noise of a target's picture along each axis
  int n_added = 1;                          ///< further targets to propose together
  bool json = false;
  std::int64_t max_operations = 1'000'000'000;
  bool accepts_unterminated = false;  ///< as CheckOptions
};

struct SynthOptions {
  std::string program;
  std::string machine;
  std::string output;
  std::optional<std::uint64_t> seed;
  std::optional<int> tool;  ///< single targets of this vision tool, instead of a program's
  int count = 100;          ///< of them
  bool accepts_unterminated = false;  ///< as CheckOptions
};

struct HistoryOptions {
  enum class Action : std::uint8_t { List, Show, Diff, RollBack, FreshStart, Export, Plot, Verify };
  Action action = Action::List;
  std::string ledger;
  std::string machine;  ///< these four: empty for all; roll back needs the first three
  std::string kind;
  std::string subject;
  std::string since;  ///< 2026-11-21 or 2026-11-21T08:37:38Z
  std::optional<std::size_t> last;
  std::vector<std::int64_t> ids;   ///< one to show, two to compare
  std::string parameter;           ///< to plot
  std::optional<std::int64_t> to;  ///< entry to go back to; empty: the one before
  std::string reason;
  std::string asked_by;  ///< empty: the user
  std::string output;    ///< empty: standard output
  bool json = false;
  bool result = false;  ///< show the calibration's own bytes
  // diff: what a change does to a job.
  std::string program;       ///< empty: only the parameters are compared
  std::string machine_file;  ///< machine.toml; with a program
  std::string measurements;  ///< of an earlier job: where in the picture targets were seen
  std::string clock;         ///< as CheckOptions
  std::int64_t max_operations = 1'000'000'000;
  bool accepts_unterminated = false;  ///< as CheckOptions
};

struct CalibrateOptions {
  enum class What : std::uint8_t { SpindleCamera, Camera, Table, Surface, Focus, Light, Settle };
  What what = What::SpindleCamera;
  std::string machine;
  std::string machine_driver;  ///< SOURCE: sim
  std::string camera;          ///< SOURCE: address of a live camera
  std::string output;          ///< the calibration's file; empty: none
  std::string clock;           ///< of the record, UTC: 2026-11-21T02:00:00Z; empty: now
  bool json = false;
  bool install = false;
  // spindle-camera
  std::optional<int> spindle;  ///< absent: as [spindle] says
  std::optional<int> station;
  std::string reason;    ///< for the ledger
  std::string asked_by;  ///< empty: the user
  bool yes = false;      ///< no question about entry material
  bool force = false;    ///< install in spite of a significant trend
  // camera, table
  std::string images;              ///< SOURCE: a folder of pictures
  std::string plot;                ///< an SVG of the residuals, of the map; empty: none
  std::string form;                ///< CameraForm, or auto
  std::vector<double> at_mm;       ///< where the mark lies
  std::optional<double> focal_px;  ///< absent: telecentric
  std::optional<double> zoom;
  int tool = 1;               ///< vision tool
  int per_side = 5;           ///< of the lattice of views
  std::string plate;          ///< the plate's file
  std::string measurements;   ///< looks at it
  std::string map;            ///< of the table's surface
  std::vector<double> range;  ///< of focus heights, mm, or of lamp levels; empty: see help
  int n_levels = 10;          ///< of the lamp
  double limit_um = 1;        ///< settle: an error that a picture may still see
  double longest_s = 1;       ///< settle: wait before the last picture of a move
  std::string linuxcnc;       ///< folder for what LinuxCNC understands; empty: none
};

struct NightlyOptions {
  std::string machine;
  std::string report;                   ///< .html; empty: [nightly] reports
  std::string json;                     ///< the same
  std::string clock;                    ///< UTC: 2026-11-21T02:00:00Z; empty: now
  std::string asked_by;                 ///< empty: the user
  std::optional<double> temperature_c;  ///< absent: [nightly] says where it stands
  bool is_dry_run = false;
  bool is_again = false;  ///< calibrate again what this night has calibrated already
};

struct DoneOptions {};  ///< help or version was printed

using CommandOptions = std::variant<DoneOptions,
                                    CheckOptions,
                                    SurveyOptions,
                                    RunOptions,
                                    TranslateOptions,
                                    LocateCommandOptions,
                                    PlanOptions,
                                    SynthOptions,
                                    CalibrateOptions,
                                    NightlyOptions,
                                    HistoryOptions,
                                    SurfaceOptions>;

struct Options {
  CommonOptions common;
  CommandOptions command;
  std::vector<std::string> command_line;  ///< as given, for provenance
  std::string command_name;               ///< "panelcal history export"
  std::vector<FileOption> files;          ///< see file_options.h
};

/// Reads the command line; prints help and version itself.
///
/// Fails  usage
Expected<Options> parse_options(int argc, char** argv);

}  // namespace panelcal
