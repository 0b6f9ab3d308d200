// SPDX-License-Identifier: Apache-2.0
// Holes of canned cycles and texts, for comparison with the manual's numbers.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/program/program_run.h"

namespace panelcal::test {

using Places = std::vector<Eigen::Vector2d>;

inline constexpr double kRounding_inch = 1e-9;

inline Places clean_holes(std::string text, const ReadOptions& reading = {}) {
  const ProgramRun run = run_program(std::move(text), {}, reading);
  EXPECT_FALSE(run.has_errors) << testing::PrintToString(run.diagnostics);
  return nominal_inch(run);
}

/// Holes of `body` behind T1 (0.04 inch) in line 6.
inline Places holes_of(const std::string& body) {
  return clean_holes(inch_leading_zeros("T1\n" + body + "M30\n"));
}

/// Diagnostics of `body` behind T1 in line 6.
inline std::vector<std::string> diagnostics_of(const std::string& body) {
  return run_program(inch_leading_zeros("T1\n" + body + "M30\n")).diagnostics;
}

inline void expect_same_places(Places found, const Places& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (const Eigen::Vector2d& place : expected) {
    const auto at = std::ranges::find_if(
        found, [&](const Eigen::Vector2d& hole) { return (hole - place).norm() < kRounding_inch; });
    ASSERT_TRUE(at != found.end()) << "no hole at " << place.transpose();
    found.erase(at);
  }
}

inline Places row(const Eigen::Vector2d& first, const Eigen::Vector2d& step, int count) {
  Places places;
  for (int i = 0; i < count; ++i) places.emplace_back(first + i * step);
  return places;
}

inline Places joined(Places first, const Places& second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

inline Places shifted(const Places& places, const Eigen::Vector2d& by) {
  Places out;
  for (const Eigen::Vector2d& place : places) out.emplace_back(place + by);
  return out;
}

// --- CNC-7 manual: Dual In Line Package ----------------------------------------------------------

}  // namespace panelcal::test
