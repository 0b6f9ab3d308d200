// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ostream>
#include <string>

#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include <gmock/gmock.h>

namespace panelcal {

/// How GoogleTest prints a code.
inline void PrintTo(Code code, std::ostream* out) {
  *out << info(code).slug;
}

}  // namespace panelcal

namespace panelcal::test {

/// Matches a position within `tolerance` of `expected`; never matches NaN.
MATCHER_P2(IsNearPosition, expected, tolerance, "") {
  const double distance_mm = (arg.in_mm() - expected.in_mm()).norm();
  *result_listener << "(" << arg.in_mm().x() << ", " << arg.in_mm().y() << ") mm is "
                   << distance_mm * 1e3 << " um from (" << expected.in_mm().x() << ", "
                   << expected.in_mm().y() << ") mm, tolerance " << tolerance.in_um() << " um";
  return distance_mm <= tolerance.in_mm();
}

/// Matches a matrix or vector whose every element is within `tolerance` of that of `expected`;
/// never matches NaN.
MATCHER_P2(IsNearMatrix, expected, tolerance, "") {
  if (arg.rows() != expected.rows() || arg.cols() != expected.cols()) {
    *result_listener << arg.rows() << " x " << arg.cols();
    return false;
  }
  const double difference = (arg - expected).cwiseAbs().maxCoeff();
  *result_listener << "greatest difference " << difference << ", tolerance " << tolerance;
  return difference <= tolerance && (arg - expected).allFinite();
}

/// Matches an Expected that failed with `code`, whose text contains `part`.
MATCHER_P2(FailsWith, code, part, "") {
  if (arg) {
    *result_listener << "has a value";
    return false;
  }
  const std::string text = arg.error().text();
  *result_listener << "says " << text;
  return arg.error().code == code && text.find(part) != std::string::npos;
}

}  // namespace panelcal::test
