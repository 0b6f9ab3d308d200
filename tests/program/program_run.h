// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "program/walk/walk.h"
#include <Eigen/Core>
#include <gmock/gmock.h>

namespace panelcal::test {

/// A drilled hole, with copies of all that a sink sees only for a moment.
struct Hole {
  int line = 0;
  InstancePath path;
  Drill drill;

  Eigen::Vector2d nominal_mm() const { return drill.nominal.in_mm(); }
  Eigen::Vector2d nominal_inch() const { return drill.nominal.in_mm() / kMmPerInch; }
  Eigen::Vector2d corrected_mm() const { return drill.corrected.in_mm(); }
  Eigen::Vector2d actual_mm() const { return drill.actual.in_mm(); }
};

/// Remembers everything that is executed: holes as they are, everything as one line of text such
/// as `12 tool 1` or `14 drill 1 [0,2] (1.5, 2)`, lengths in mm.
class Recorder final : public OperationSink {
 public:
  void put(const Operation& operation) override;

  const std::vector<Hole>& holes() const { return holes_; }
  const std::vector<std::string>& lines() const { return lines_; }
  const std::vector<Tool>& tools() const { return tools_; }
  const std::vector<Rout>& routs() const { return routs_; }

 private:
  std::vector<Hole> holes_;
  std::vector<std::string> lines_;
  std::vector<Tool> tools_;
  std::vector<Rout> routs_;
};

/// Answers with a function of the request, and remembers what was asked.
class FunctionSource final : public MeasurementSource {
 public:
  using Place = std::function<Eigen::Vector2d(const MeasurementRequest&)>;
  explicit FunctionSource(Place place_mm) : place_mm_(std::move(place_mm)) {}

  Expected<Measurement> measure(const MeasurementRequest& request) override;
  /// The target with this number is answered with `status` instead.
  void lose(std::int64_t seq, MeasurementStatus status, std::string reason);

  const std::vector<MeasurementRequest>& requests() const { return requests_; }

 private:
  struct Loss {
    MeasurementStatus status;
    std::string reason;
  };
  Place place_mm_;
  std::map<std::int64_t, Loss> losses_;
  std::vector<MeasurementRequest> requests_;
};

/// Every target is found `shift_mm` away from its nominal place.
FunctionSource shifted_by(double x_mm, double y_mm);

/// A program that was read, surveyed and, if no error came up, executed.
struct ProgramRun {
  Program program;
  Survey survey;
  Recorder executed;
  std::vector<std::string> diagnostics;  ///< without their wording (test::brief), in order
  std::vector<std::string> texts;        ///< the same with their wording, for test::Reports
  bool has_errors = false;

  const std::vector<Hole>& holes() const { return executed.holes(); }
};

/// The last setting of a control on which the manual's examples run that state no format: inch with
/// leading zeros.
PartialFormat last_set_to_inch();

/// The file is called `p.exc` in diagnostics. Where `reading` has no last setting, it is
/// last_set_to_inch().
ProgramRun run_program(std::string text,
                       const WalkOptions& options,
                       MeasurementSource& source,
                       ReadOptions reading = {});
/// On a perfect panel.
ProgramRun run_program(std::string text, const WalkOptions& options = {}, ReadOptions reading = {});

/// `body` with a header of five lines: metric, tools 1 and 2, so that body lines count from 6.
std::string metric(std::string_view body);
/// `body` with a header of five lines in front: inch, leading zeros, tools 1 and 2.
std::string inch_leading_zeros(std::string_view body);

/// Matches a diagnostic of this line of `p.exc` with `what`, which is no wording, in its text.
testing::Matcher<const std::string&> says(int line, const std::string& what);

/// Nominal places of the holes, for comparison with the manual's numbers.
std::vector<Eigen::Vector2d> nominal_inch(const ProgramRun& run);

}  // namespace panelcal::test
