// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "program/model/calibration_order.h"

namespace panelcal {

/// A calibration as a file of measurements has it. What it was corrected by is not recorded: the
/// measurements before it say that again.
struct RecordedCalibration {
  CalibrationAnswer answer;
  int line = 0;  ///< in the file
};

namespace internal {

/// Answers orders from recorded calibrations, matched by their number.
class CalibrationReplay {
 public:
  /// In     file: as diagnostics name it
  CalibrationReplay(std::string file, std::vector<RecordedCalibration> recorded);

  /// Out    empty where the file has no such calibration: it was only passed on
  /// Fails  measurement-mismatch (it is of another order than the program's)
  Expected<std::optional<CalibrationAnswer>> calibrate(const CalibrationOrder& order);
  /// Fails  measurement-mismatch (a calibration that no command asks for)
  Expected<void> check_all_used() const;

 private:
  std::string file_;
  std::vector<RecordedCalibration> recorded_;  ///< by number
  std::vector<bool> is_used_;
};

}  // namespace internal
}  // namespace panelcal
