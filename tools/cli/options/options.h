// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "calib/base/expected.h"
#include "program/walk/reading_terms.h"
#include "tools/cli/options/align_options.h"
#include "tools/cli/options/apply_options.h"
#include "tools/cli/options/calibrate_options.h"
#include "tools/cli/options/file_options.h"
#include "tools/cli/options/history_options.h"
#include "tools/cli/options/init_options.h"
#include "tools/cli/options/surface_options.h"

namespace panelcal {

struct CommonOptions {
  bool quiet = false;              ///< errors only on standard error
  std::string log_level = "info";  ///< error, warning, info
};

struct CheckOptions {
  std::string program;  ///< may be empty: then only the machine file is checked
  std::string machine;  ///< may be empty
  FactsFiles facts;
  std::string clock;  ///< of texts and of calibrations' age: 2026-11-21T13:45:00; empty: now
  std::int64_t max_operations = kUsualMaxOperations;
  ReadingTerms reading;
};

struct DoctorOptions {
  std::string machine;
  std::string camera;  ///< its address; empty: that of [nightly]
  bool opens_devices = false;
  FactsFiles facts;
  std::string clock;  ///< UTC: 2026-11-21T02:00:00Z; empty: now
};

struct SurveyOptions {
  std::string program;
  std::string machine;
  std::string clock;
  std::int64_t max_operations = kUsualMaxOperations;
  ReadingTerms reading;
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
  std::string align;           ///< the panel was measured before; empty: it was not
  double valid_hours = 4;      ///< of `align`
  std::string output;
  std::string format;   ///< empty: from the output's extension
  std::string flavour;  ///< of G-code; empty: as the machine's file says
  FactsFiles facts;
  std::string save_measurements;
  std::string save_probes;
  std::string clock;
  std::string truth;
  std::string explain;                  ///< L14 or 500: see ExplainChoice
  std::string slots;                    ///< keep or expand; empty: what suits the format
  std::optional<double> resolution_um;  ///< of coordinates in a program; absent: the control's
  std::size_t n_threads = 0;            ///< that look at pictures; 0: one for each processor
  std::int64_t max_operations = kUsualMaxOperations;
  ReadingTerms reading;
  std::optional<int> turned_deg;  ///< absent: as [gates] says
  bool uncorrected = false;       ///< a program without targets is meant
  bool force = false;
};

struct TranslateOptions {
  std::string program;
  std::string machine;  ///< may be empty
  std::string output;
  std::string to;     ///< excellon or sieb-meyer; empty: the other language
  std::string clock;  ///< as CheckOptions
  std::int64_t max_operations = kUsualMaxOperations;
  ReadingTerms reading;
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
  bool suggests = false;  ///< tells what is there instead
  FactsFiles facts;
  std::size_t n_threads = 0;  ///< 0: one for each processor
};

struct PlanOptions {
  std::string program;
  std::string machine;
  FactsFiles facts;
  std::string measurements;  ///< of an earlier job, for the noise of its targets; may be empty
  std::string clock;         ///< as CheckOptions
  std::optional<double> fiducial_sigma_um;  ///< noise of a target's picture along each axis
  int n_added = 1;                          ///< further targets to propose together
  std::int64_t max_operations = kUsualMaxOperations;
  ReadingTerms reading;
};

struct SynthOptions {
  std::string program;
  std::string machine;
  std::string output;
  std::optional<std::uint64_t> seed;
  std::optional<int> tool;    ///< single targets of this vision tool, instead of a program's
  int count = 100;            ///< of them
  std::string sweep;          ///< an experiment's file, instead of program, tool and machine
  bool resume = false;        ///< go on with its set
  std::size_t n_threads = 0;  ///< of a sweep; 0: one for each processor
  ReadingTerms reading;
};

struct BatchOptions {
  std::string manifest;  ///< or:
  std::string pattern;   ///< of folders, a job each
  std::string output;    ///< the folder of the results
  std::string machine;   ///< of jobs that name none
  std::string format;    ///< empty: from each output's extension, or the program's language
  std::string clock;     ///< of jobs that name none; empty: now
  std::string only;      ///< failed or held: these jobs once more; empty: those not done yet
  std::string engine = "local";  ///< local, slurm or parallel
  std::string shard;             ///< "3/8": only these jobs; empty: all
  std::string metrics;           ///< for Prometheus; empty: none
  std::string store;             ///< the address of a database besides; empty: none
  FactsFiles facts;
  std::size_t n_sampled = 0;   ///< 0: all
  std::size_t n_threads = 0;   ///< 0: one for each processor; of a shard one
  std::int64_t n_shards = 0;   ///< of other engines than local; 0: the usual number
  std::int64_t n_retries = 3;  ///< of a shard that ended before it was done
  bool resume = false;
  bool keeps_places = false;
};

/// Of `batch report`, `batch show`, `batch merge` and `batch push`.
struct BatchReportOptions {
  std::string results;
  FactsFiles facts;
  std::string metrics;  ///< of merge
  std::string store;    ///< of push
};

struct NightlyOptions {
  std::string machine;
  FactsFiles facts;                     ///< empty ones: [nightly] reports
  std::string clock;                    ///< UTC: 2026-11-21T02:00:00Z; empty: now
  std::string asked_by;                 ///< empty: the user
  std::string metrics;                  ///< for Prometheus; empty: none
  std::optional<double> temperature_c;  ///< absent: [nightly] says where it stands
  bool is_dry_run = false;
  bool is_again = false;  ///< calibrate again what this night has calibrated already
};

struct ServeOptions {
  std::string machine;
  std::string images;          ///< SOURCE, as of run
  std::string machine_driver;  ///< SOURCE
  std::string camera;          ///< SOURCE
  std::string address = "127.0.0.1:8330";
  std::string jobs;         ///< a folder; empty: jobs beside the machine file
  std::string token_file;   ///< empty: no token is asked for
  std::string certificate;  ///< PEM; empty: without TLS
  std::string key;          ///< PEM
  std::vector<std::string> host_names;
  bool allows_plain_http = false;
};

using CommandOptions = std::variant<CheckOptions,
                                    SurveyOptions,
                                    RunOptions,
                                    TranslateOptions,
                                    LocateCommandOptions,
                                    PlanOptions,
                                    SynthOptions,
                                    BatchOptions,
                                    BatchReportOptions,
                                    CalibrateOptions,
                                    NightlyOptions,
                                    ServeOptions,
                                    HistoryOptions,
                                    ApplyOptions,
                                    SurfaceOptions,
                                    AlignOptions,
                                    InitOptions,
                                    DoctorOptions>;

struct Answer;
struct CommandContext;

struct Options {
  CommonOptions common;
  CommandOptions command;
  /// Executes it; null: help or the version was printed.
  Expected<Answer> (*run)(CommandContext& context) = nullptr;
  std::vector<std::string> command_line;  ///< as given, for provenance
  std::string command_name;               ///< "panelcal history export"
  std::vector<FileOption> files;          ///< see file_options.h
};

}  // namespace panelcal
