// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "machine/calibrate/recorded_calibration.h"
#include "machine/sources/recorded_answers.h"

namespace panelcal {

/// A measurement as a file has it. The file does not know work zero, so request.work_zero is zero.
using RecordedMeasurement = internal::RecordedAnswers<Measurement>::Entry;

/// The measurements of a run, in the order of the file.
struct RecordedMeasurements {
  std::string file;  ///< as diagnostics name it
  std::vector<RecordedMeasurement> measurements;
  /// Of orders to calibrate among them. The measurements are what was measured with them: they are
  /// not moved once more.
  std::vector<RecordedCalibration> calibrations = {};
};

/// Larger files are refused unread; a million measurements are 200 MB.
inline constexpr std::size_t kMaxMeasurementBytes = std::size_t{1} << 30;

/// Reads measurements as to_json(Measurement) writes them: JSON Lines, one object a line.
///
/// All of a request's keys are required, but delta, inspections, search, search_area, lamp, zoom,
/// algorithm and, of one vision tool, tools. `measured` and `cov` stand there if and only if status
/// is found, `by_camera` may then. Numbers read back to the bit. Blank lines are allowed.
///
/// Lines with `calibration` in place of `seq` are as to_json(CalibrationAnswer) writes them.
///
/// Fails  file-unreadable; json-syntax; measurement-file (unknown, missing, misplaced or repeated
///        keys, wrong types, unknown status, a seq that appears twice); measurement-invalid (cov is
///        not positive definite): each with file:line:column
/// See    tests/machine/sources/measurement_file_source_test.cc
Expected<RecordedMeasurements> read_measurements(const std::filesystem::path& path);

/// The same from text; `file` stands in the diagnostics. Any bytes give a value or a diagnostic.
Expected<RecordedMeasurements> parse_measurements(std::string_view text, const std::string& file);

/// Answers requests from recorded measurements: a replay, or another vision system's work.
///
/// Requests are matched by seq; the recorded line, command, vision tool, path and nominal must be
/// the program's, or the file belongs to another program.
class MeasurementFileSource final : public MeasurementSource {
 public:
  explicit MeasurementFileSource(RecordedMeasurements recorded);

  /// Fails  measurement-missing; measurement-mismatch
  Expected<Measurement> measure(const MeasurementRequest& request) override;
  /// Empty where none was recorded: the order was only passed on.
  ///
  /// Fails  measurement-mismatch
  Expected<std::optional<CalibrationAnswer>> calibrate(const CalibrationOrder& order) override {
    return calibrations_.calibrate(order);
  }

  /// After a complete survey: fails if the file has a measurement or a calibration that no command
  /// asked for.
  ///
  /// Fails  measurement-mismatch, at the first such line
  Expected<void> check_all_used() const;
  Expected<void> finish() override { return check_all_used(); }

 private:
  internal::CalibrationReplay calibrations_;
  internal::RecordedAnswers<Measurement> answers_;
};

}  // namespace panelcal
