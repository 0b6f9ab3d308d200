// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/diagnostic.h"
#include "calib/base/machine_uncertainty.h"
#include "calib/correction/table_correction.h"
#include "calib/correction/tolerance.h"
#include "calib/faults/known_pads.h"
#include "calib/panel/fit.h"
#include "calib/panel/gates.h"
#include "program/excellon/header.h"
#include "program/model/board_depths.h"
#include "program/model/measurement.h"
#include "program/model/operation.h"
#include "program/sieb_meyer/file_layout.h"
#include "program/sieb_meyer/settings.h"
#include "program/walk/options.h"
#include "program/walk/probing.h"
#include "program/walk/program.h"
#include "program/walk/survey.h"

namespace panelcal {

/// Reads the header, or the tool table, and the stored patterns that the program names; problems go
/// into the log. A pattern that is missing is a problem only where the program runs it. A program
/// is SIEB & MEYER's if %% opens it, else Excellon.
Program load_program(SourceText source, DiagnosticLog& log, ReadOptions options = {});

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

/// The working walk: passes every operation, corrected by the fits of `survey`, to `sink`.
///
/// Precondition: surveyed with the same program and options, survey.is_complete(), and no errors.
void execute(const Program& program,
             const WalkOptions& options,
             const Survey& survey,
             OperationSink& sink,
             DiagnosticLog& log);

}  // namespace panelcal
