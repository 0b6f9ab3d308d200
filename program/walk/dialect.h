// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "calib/base/diagnostic.h"
#include "program/model/measurement.h"
#include "program/model/operation.h"
#include "program/walk/options.h"
#include "program/walk/probing.h"
#include "program/walk/program.h"
#include "program/walk/reporter.h"
#include "program/walk/survey.h"
#include "program/walk/trial_execution.h"

namespace panelcal {

/// Sources of a walk's answers, and sink of its operations. The first walk has sources and no sink,
/// the second a sink and no sources; a trial has all of them.
struct WalkEnds {
  MeasurementSource* measurements = nullptr;
  ProbeSource* probes = nullptr;
  OperationSink* sink = nullptr;
  DiagnosticLog& log;
  TrialExecution* trial = nullptr;
  /// The byte of the program behind which a measuring walk asks for nothing, as a check has found
  /// it; absent: not known.
  std::optional<std::size_t> asks_until = std::nullopt;

  /// Of the program's own file. A walk that executes alone repeats no warnings.
  Reporter reporter(std::string file) const {
    const bool is_second = sink != nullptr && trial == nullptr;
    return {std::move(file),
            log,
            is_second ? Reporter::Level::ErrorsOnly : Reporter::Level::All,
            trial == nullptr ? nullptr : &trial->working_log};
  }
};

/// A language of part programs, as loading and walking know it. A further language is a room with
/// one of these and a line in program/dialects.cc.
class ProgramDialect {
 public:
  virtual ~ProgramDialect() = default;

  virtual Dialect id() const = 0;
  /// True if a text begins as programs of this language do.
  virtual bool begins(std::string_view bytes) const = 0;
  /// Reads the head, and the stored patterns that the program names; problems go into the log.
  ///
  /// In     program: with its source and `reading`
  virtual void read(Program& program, DiagnosticLog& log) const = 0;
  /// True if its programs switch [reference_scaling] on and off (M60).
  virtual bool has_reference_scaling() const { return false; }
  /// True if a coordinate of a program that read() has read has a decimal point: then its digits
  /// are not those that its head declares. Languages whose numbers have one form only need not
  /// look.
  virtual bool has_decimal_coordinates(const Program& /*program*/) const { return false; }
  /// One walk over a program that read() has read.
  ///
  /// Out    the byte behind which the program asks for nothing more; absent: not known
  virtual std::optional<std::size_t> walk(const Program& program,
                                          const WalkOptions& options,
                                          Survey& survey,
                                          const WalkEnds& ends) const = 0;
};

/// All of them, in the order in which a text is tried; the last one takes any text. Defined above
/// the languages, in program/dialects.cc.
std::span<const ProgramDialect* const> dialects();

}  // namespace panelcal
