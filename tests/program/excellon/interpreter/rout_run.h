// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"

// Helpers of the tests of routing.
namespace panelcal::test {

inline constexpr double kRounding_inch = 1e-9;
inline constexpr double kRounding_mm = 1e-9;

inline ProgramRun run_clean(std::string text, const WalkOptions& options = {}) {
  ProgramRun run = run_program(std::move(text), options);
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  return run;
}

/// `body` behind T1 in line 6, before M30.
inline std::string metric_t1(std::string_view body) {
  return metric("T1\n" + std::string(body) + "M30\n");
}
inline std::string inch_t1(std::string_view body) {
  return inch_leading_zeros("T1\n" + std::string(body) + "M30\n");
}

/// Steps of the body, without line numbers and settings.
inline std::vector<std::string> steps(const ProgramRun& run) {
  std::vector<std::string> out;
  for (const std::string& line : run.executed.lines()) {
    std::string what = line.substr(line.find(' ') + 1);
    if (!what.starts_with("setting") && what != "header_end") out.push_back(std::move(what));
  }
  return out;
}

inline Eigen::Vector2d end_inch(const Rout& rout) {
  return rout.nominal.in_mm() / kMmPerInch;
}
inline Eigen::Vector2d center_inch(const Rout& rout) {
  return rout.center.in_mm() / kMmPerInch;
}

/// An arc of this radius and sense, at most half a circle, from a place to where `rout` ends.
inline void expect_arc(const Rout& rout,
                       RoutKind kind,
                       const Eigen::Vector2d& start_inch,
                       double radius_inch) {
  EXPECT_EQ(rout.kind, kind);
  const Eigen::Vector2d from = start_inch - center_inch(rout);
  const Eigen::Vector2d to = end_inch(rout) - center_inch(rout);
  EXPECT_NEAR(from.norm(), radius_inch, kRounding_inch);
  EXPECT_NEAR(to.norm(), radius_inch, kRounding_inch);
  const double left_turn = from.x() * to.y() - from.y() * to.x();
  const double turn = kind == RoutKind::Clockwise ? -left_turn : left_turn;
  EXPECT_GE(turn, -kRounding_inch);
}

}  // namespace panelcal::test
