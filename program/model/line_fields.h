// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "calib/base/fields/slots.h"
#include "calib/base/statistics/covariance_check.h"

// Not installed: what lines of measurements, calibrations and probes have in common. Numbers beyond
// these ranges have the wrong unit, and would make searches endless or their results infinite.
namespace panelcal::internal {

inline constexpr Code kLineCode = Code::MeasurementFile;
/// Beyond any machine.
inline constexpr double kMostRecorded_mm = 1e5;
inline constexpr Range kRecordedPlace{-kMostRecorded_mm, kMostRecorded_mm};
inline constexpr Range kRecordedLength{0, kMostRecorded_mm};
inline constexpr Range kRecordedSigma{0, kMostSigma_mm};
/// Lamps and zooms count in units of their own.
inline constexpr Range kRecordedDevice{-1e6, 1e6};
inline constexpr WholeRange kRecordedInt{0, std::numeric_limits<int>::max()};
inline constexpr WholeRange kRecordedSeq{0, std::numeric_limits<std::int64_t>::max()};
/// More spindles than a machine has.
inline constexpr WholeRange kRecordedAxis{0, 63};

/// A SHA-256 in small letters.
inline std::optional<std::string> recorded_digest(std::string_view text) {
  constexpr std::size_t kDigits = 64;
  std::string digits(text);
  std::ranges::transform(digits, digits.begin(), [](char c) {
    return c >= 'A' && c <= 'F' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  const bool is_hexadecimal = digits.find_first_not_of("0123456789abcdef") == std::string::npos;
  return digits.size() == kDigits && is_hexadecimal ? std::optional(digits) : std::nullopt;
}
inline std::string_view same_digest(const std::string& digest) {
  return digest;
}

template <class Line>
using RequestOf = decltype(Line::request);

#include "program/model/line_fields.def"

}  // namespace panelcal::internal
