// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "panelcal/calib/base/diagnostic.h"
#include "panelcal/calib/gates.h"
#include "panelcal/calib/panel_fit.h"
#include "panelcal/program/excellon/header.h"
#include "panelcal/program/measurement.h"
#include "panelcal/program/operation.h"
#include "panelcal/program/survey.h"

namespace panelcal {

/// What the machine decides about how a program is read.
struct ReadOptions {
  /// Tool data by diameter; every row has a diameter (CNC-7 manual, Tool Diameter).
  std::vector<Tool> diameter_page;
  std::vector<std::filesystem::path> pattern_folders;  ///< where M99 looks for files, in order
  std::optional<bool> block_delete;  ///< the operator's switch, where the header has no BLKD
  int axis_version = 1;              ///< where the header has no VER
  std::string operator_id;           ///< OPID: what an asterisk in a canned text stands for
};

/// Scales drilled holes about a point, in work coordinates, while M60 is in force.
struct ReferenceScaling {
  double x = 1;
  double y = 1;
  Position<frame::Nominal> about;
  bool starts_enabled = false;  ///< SCLR,ON before the program starts
};

enum class Cycles : std::uint8_t {
  Expanded,  ///< every hole and pass is an operation of its own
  Kept,      ///< passed on whole; the control expands it
};

/// What the machine and the vision system decide about how a program is executed.
struct WalkOptions {
  int series_size = 3;              ///< [vision] rotate: G36 or G46 blocks that form one series
  std::optional<PanelModel> model;  ///< [vision] model; absent: what the manual says for the count
  GateLimits base_limits;
  GateLimits nested_limits;
  /// Work zero without any zero set (the machine's zero correction), and absolute zero.
  Position<frame::Machine> work_zero;
  Position<frame::Machine> absolute_zero;
  /// A repeat of repeats can ask for more holes than there are atoms; this is where we stop. So
  /// many lines of step and repeat that do not operate are the most as well.
  std::int64_t max_operations = 1'000'000'000;
  /// The same for targets; their measurements are kept in memory, about 1 kB each.
  std::int64_t max_measurements = 100'000;
  std::optional<ReferenceScaling> scaling;
  Cycles slots = Cycles::Expanded;       ///< G85
  Cycles step_slots = Cycles::Expanded;  ///< G87
  /// A corrected arc stays one arc while it is this close to the true ellipse.
  Length arc_tolerance = um(1);
};

/// A program that has been read as far as its header.
struct Program {
  SourceText source;
  excellon::Header header;
  std::map<std::string, SourceText, std::less<>> patterns;  ///< the stored patterns it names
  ReadOptions reading;

  bool deletes_blocks() const;  ///< blocks that begin with / are left out
  int axis_version() const { return header.axis_version.value_or(reading.axis_version); }
};

/// Reads the header, and the stored patterns that the program names; problems go into the log. A
/// pattern that is missing is a problem only where the program runs it.
Program load_program(SourceText source, DiagnosticLog& log, ReadOptions options = {});

/// The measuring walk: executes the vision commands, asks `source` for every target, fits every
/// series and holds it against its limits. Checks the whole program on the way, so that with a
/// NominalSource it is what `panelcal check` does. Stops early when the source fails or a base
/// series has no fit, since then nobody knows where to look next.
///
/// Fails  into the log: everything in diagnostic_codes.def under "Part programs" and "Vision
///        results", and what the source reports
/// Source CNC-7 manual, Part Program Vision Commands (two passes)
Survey survey(const Program& program,
              const WalkOptions& options,
              MeasurementSource& source,
              DiagnosticLog& log);

/// The working walk: passes every operation, corrected by the fits of `survey`, to `sink`.
///
/// Precondition: surveyed with the same program and options, survey.is_complete(), and no errors.
void execute(const Program& program,
             const WalkOptions& options,
             const Survey& survey,
             OperationSink& sink,
             DiagnosticLog& log);

}  // namespace panelcal
