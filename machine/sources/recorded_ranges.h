// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <string_view>
#include <vector>

#include "calib/base/json/json_line.h"
#include "calib/base/statistics/covariance_check.h"
#include <Eigen/Core>

// Not installed: what numbers of recorded measurements and probes may be. What lies outside has the
// wrong unit, and would make searches endless or their results infinite.
namespace panelcal::internal {

/// Beyond any machine.
inline constexpr double kMostRecorded_mm = 1e5;
/// Lamps and zooms count in units of their own.
inline constexpr double kMostOfDevice = 1e6;

struct RecordedRange {
  double low = 0;
  double high = 0;
};
inline constexpr RecordedRange kRecordedPlace{-kMostRecorded_mm, kMostRecorded_mm};
inline constexpr RecordedRange kRecordedLength{0, kMostRecorded_mm};
inline constexpr RecordedRange kRecordedScore{0, 1};
inline constexpr RecordedRange kRecordedSigma{0, kMostSigma_mm};

/// Fails  `code`: not a number, or outside of the range
Expected<double> recorded_number(const JsonLine& line,
                                 std::string_view key,
                                 const RecordedRange& range,
                                 Code code);

/// As recorded_number(), of all numbers of a list of n.
Expected<std::vector<double>> recorded_numbers(const JsonLine& line,
                                               std::string_view key,
                                               std::size_t n,
                                               const RecordedRange& range,
                                               Code code);

/// [x, y], mm, each within kMostRecorded_mm of 0.
Expected<Eigen::Vector2d> recorded_place(const JsonLine& line, std::string_view key, Code code);

}  // namespace panelcal::internal
