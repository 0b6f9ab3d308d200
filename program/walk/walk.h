// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

#include "calib/base/diagnostic.h"
#include "calib/base/machine_uncertainty.h"
#include "calib/correction/table_correction.h"
#include "calib/correction/tolerance.h"
#include "calib/faults/known_pads.h"
#include "calib/panel/fit.h"
#include "calib/panel/gates.h"
#include "program/model/board_depths.h"
#include "program/model/measurement.h"
#include "program/model/operation.h"
#include "program/walk/options.h"
#include "program/walk/probing.h"
#include "program/walk/program.h"
#include "program/walk/survey.h"

namespace panelcal {

/// Reads the header, or the tool table, and the stored patterns that the program names; problems go
/// into the log. A pattern that is missing is a problem only where the program runs it. A program
/// is SIEB & MEYER's if %% opens it, else Excellon.
Program load_program(SourceText source, DiagnosticLog& log, ReadOptions options = {});

/// The information that sinks get before the first operation.
ProgramInfo program_info(const Program& program, const WalkOptions& options);

/// The measuring walk: executes the vision commands, asks `source` for every target, fits every
/// series and holds it against its limits. Checks the whole program on the way, so that with a
/// NominalSource it is what `panelcal check` does. Stops early when the source fails or a base
/// series has no fit, since then the next place to look at is unknown.
///
/// Fails  into the log: everything in diagnostic_codes.def under "Part programs" and "Vision
///        results", and what the source reports
/// Source CNC-7 manual, Part Program Vision Commands (two passes)
Survey survey(const Program& program,
              const WalkOptions& options,
              MeasurementSource& source,
              DiagnosticLog& log);
/// The same where surfaces are probed as well; without `probes` they are where the machine expects
/// them.
Survey survey(const Program& program,
              const WalkOptions& options,
              MeasurementSource& source,
              ProbeSource& probes,
              DiagnosticLog& log);

/// The result of check().
struct CheckedWalk {
  Survey survey;
  bool asks = false;          ///< a target, a probe, a focus or a calibration
  bool is_executed = false;   ///< the sink has the whole job
  DiagnosticLog working_log;  ///< problems that only a working walk finds, if it is executed
  /// The byte of the program behind which it asks for nothing more; absent: not known.
  std::optional<std::size_t> asks_until;
};

/// Until where a check executes as well.
enum class Execution : std::uint8_t {
  None,
  UntilAsked,  ///< if the program asks for a measurement, another walk executes it
  OfNominal,   ///< on a perfect panel
};

/// The measuring walk over a perfect panel, which breaks no limit: gates are left out.
///
/// With a sink this is the working walk as well, as long as that is certain: a section that is
/// repeated ends the execution, since a check only counts its copies. Nothing of a sink that does
/// not get the whole job may be used.
///
/// In     options.structure: Expanded, if anything is executed
///        sink: not null, if anything is executed
CheckedWalk check(const Program& program,
                  const WalkOptions& options,
                  Execution execution,
                  OperationSink* sink,
                  DiagnosticLog& log);
/// The check alone.
CheckedWalk check(const Program& program, const WalkOptions& options, DiagnosticLog& log);

/// The measuring walk of a program that was checked without errors, as far as it asks for anything.
Survey survey(const Program& program,
              const WalkOptions& options,
              const CheckedWalk& checked,
              MeasurementSource& source,
              ProbeSource& probes,
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
