// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "calib/base/diagnostic.h"
#include "calib/base/expected.h"
#include "calib/base/frames.h"
#include "calib/base/units.h"
#include <gmock/gmock.h>

namespace panelcal {

/// Prints a code for GoogleTest.
inline void PrintTo(Code code, std::ostream* out) {
  *out << info(code).slug;
}

}  // namespace panelcal

namespace panelcal::test {

/// A diagnostic without its wording: `FILE:LINE:COLUMN: error[CODE]`. Tests compare this; the words
/// are pinned by the golden cases alone, so that they can be improved in one place.
inline std::string brief(const Diagnostic& diagnostic) {
  const auto& [file, line, column] = diagnostic.place;
  std::string out = file;
  if (line > 0) out += ':' + std::to_string(line);
  if (line > 0 && column > 0) out += ':' + std::to_string(column);
  if (!out.empty()) out += ": ";
  out += diagnostic.severity() == Severity::Error ? "error[" : "warning[";
  return out + std::string(info(diagnostic.code).slug) + ']';
}

/// The briefs of all diagnostics of a log, in order.
inline std::vector<std::string> briefs(const DiagnosticLog& log) {
  std::vector<std::string> out;
  for (const Diagnostic& diagnostic : log.kept()) out.push_back(brief(diagnostic));
  return out;
}

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

/// Matches the text of a diagnostic whose brief is `expected` and whose wording contains each of
/// `facts`: numbers and offending text that the test is about, not the words around them.
template <class... Facts>
testing::Matcher<const std::string&> Reports(const std::string& expected, const Facts&... facts) {
  return testing::AllOf(testing::StartsWith(expected + ": "),
                        testing::HasSubstr(std::string(facts))...);
}

/// Matches an Expected that failed with `code`.
MATCHER_P(FailsWith, code, "") {
  if (arg) {
    *result_listener << "has a value";
    return false;
  }
  *result_listener << "says " << arg.error().text();
  return arg.error().code == code;
}

/// Matches an Expected that failed with `code`, whose text contains `part`: a place, a number or
/// the offending text, not the words around it.
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
