// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "panelcal/calib/base/diagnostic.h"
#include "panelcal/calib/gates.h"
#include "panelcal/calib/panel_fit.h"
#include "panelcal/program/excellon/header.h"
#include "panelcal/program/measurement.h"
#include "panelcal/program/operation.h"
#include "panelcal/program/survey.h"

namespace panelcal {

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
};

/// A program that has been read as far as its header.
struct Program {
  SourceText source;
  excellon::Header header;
};

/// Reads the header; problems go into the log.
Program load_program(SourceText source, DiagnosticLog& log);

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
