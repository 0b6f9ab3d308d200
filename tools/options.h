// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "panelcal/calib/base/expected.h"

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
};

struct SurveyOptions {
  std::string program;
  std::string machine;
  std::string clock;
  std::int64_t max_operations = 1'000'000'000;
};

struct RunOptions {
  std::string program;
  std::string machine;
  std::string images;          ///< SOURCE: a picture folder
  std::string measurements;    ///< SOURCE: a recorded file
  std::string machine_driver;  ///< SOURCE: sim
  std::string camera;          ///< SOURCE: address of a live camera
  std::string probes;          ///< recorded probe readings
  std::string output;
  std::string format;  ///< empty: from the output's extension
  std::string report;
  std::string save_measurements;
  std::string save_probes;
  std::string clock;
  std::string truth;
  std::string explain;  ///< L14 or 500: see ExplainChoice
  std::string slots;    ///< keep or expand; empty: what suits the format
  std::int64_t max_operations = 1'000'000'000;
  bool force = false;
};

struct TranslateOptions {
  std::string program;
  std::string machine;  ///< may be empty
  std::string output;
  std::string to;     ///< excellon or sieb-meyer; empty: the other language
  std::string clock;  ///< as CheckOptions
  std::int64_t max_operations = 1'000'000'000;
  bool force = false;
};

struct LocateCommandOptions {
  std::vector<std::string> images;
  std::string machine;
  int tool = 1;
  std::vector<double> at_px;  ///< x, y of the middle of the searched circle; empty: everywhere
  std::optional<double> radius_px;  ///< of it; there if at_px is
  std::string overlay;              ///< a .png, or a folder of them; empty: none
  bool lists_candidates = false;
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
};

struct SynthOptions {
  std::string program;
  std::string machine;
  std::string output;
  std::optional<std::uint64_t> seed;
  std::optional<int> tool;  ///< single targets of this vision tool, instead of a program's
  int count = 100;          ///< of them
};

struct DoneOptions {};  ///< help or version was printed

using CommandOptions = std::variant<DoneOptions,
                                    CheckOptions,
                                    SurveyOptions,
                                    RunOptions,
                                    TranslateOptions,
                                    LocateCommandOptions,
                                    PlanOptions,
                                    SynthOptions>;

struct Options {
  CommonOptions common;
  CommandOptions command;
  std::vector<std::string> command_line;  ///< as given, for provenance
};

/// Reads the command line; prints help and version itself.
///
/// Fails  usage
Expected<Options> parse_options(int argc, char** argv);

}  // namespace panelcal
