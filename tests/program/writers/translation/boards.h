// SPDX-License-Identifier: Apache-2.0
// Programs with boards on a panel, and what translations of them have in common.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/program_run.h"
#include "tests/program/writers/translation/run.h"

namespace panelcal::test {

/// A panel that lies turned and stretched, with boards that lie on it each in its own way.
inline FunctionSource panel_of_boards(const Eigen::Vector2d& pitch_mm,
                                      const Eigen::Vector2d& first_mm) {
  return FunctionSource([=](const MeasurementRequest& request) -> Eigen::Vector2d {
    const Eigen::Vector2d p = request.nominal.in_mm();
    const Eigen::Vector2d board((p - first_mm).cwiseQuotient(pitch_mm).array().floor());
    const double k = board.x() + 3 * board.y();
    const double angle_rad = 0.0003 * std::sin(1 + 2 * k);
    const Eigen::Vector2d in_board = p - first_mm - board.cwiseProduct(pitch_mm);
    const Eigen::Vector2d moved = p + angle_rad * Eigen::Vector2d(-in_board.y(), in_board.x()) +
                                  0.04 * Eigen::Vector2d(std::cos(k), std::sin(3 * k));
    return {1.0003 * moved.x() - 0.002 * moved.y() + 0.4,
            0.002 * moved.x() + 0.9998 * moved.y() - 0.2};
  });
}

inline FunctionSource small_boards() {
  return panel_of_boards({50, 50}, {0, 0});
}

/// `body` with its vision tool; its lines count from 7.
inline std::string excellon_boards(const std::string& body) {
  return "M48\nMETRIC,LZ\nT1C1.0\nT2C2.0\n%\nG34,1\n" + body + "M30\n";
}
/// `body` in format 5000; its lines count from 2.
inline std::string sieb_meyer_boards(const std::string& body) {
  return "%%5000\n" + body + "$\nT1D1.\nT2D2.\n$\n";
}

inline Dialect other(const std::string& text) {
  return text.starts_with("%%") ? Dialect::Excellon : Dialect::SiebMeyer;
}

/// Holes of two runs at the same places, in the same order, by the same tools; the largest distance
/// of two in um, negative if they are not the same holes.
inline double distance_um(const WorkRun& a, const WorkRun& b) {
  std::vector<Drill> holes[2];
  const WorkRun* runs[2] = {&a, &b};
  for (int i = 0; i < 2; ++i) {
    for (const Event& event : runs[i]->events) {
      if (const auto* drill = std::get_if<Drill>(&event.what)) holes[i].push_back(*drill);
    }
  }
  if (holes[0].size() != holes[1].size()) return -1;
  double worst_um = 0;
  for (std::size_t i = 0; i < holes[0].size(); ++i) {
    const Drill& from = holes[0][i];
    const Drill& to = holes[1][i];
    if (from.tool != to.tool || (from.nominal - to.nominal).in_mm().norm() > 1e-5) return -1;
    worst_um = std::max(worst_um, 1000 * (from.corrected - to.corrected).in_mm().norm());
  }
  return worst_um;
}

/// Fits of the same targets from the same places; programs are written in 0.001 um.
inline constexpr double kSameFit_um = 0.002;
/// One fit from where targets are nominally, instead of two that follow each other, lacks a shear
/// that is the product of a turn and a difference of stretches: 2 mrad times 500 ppm here. Holes on
/// their own board are 50 mm from its targets, others (behind the pattern) as far as the panel
/// goes.
inline constexpr double kShear_um_per_mm = 1e3 * 0.002 * 500e-6;
inline constexpr double kSameOnBoard_um = 2 * kShear_um_per_mm * 50;
inline constexpr double kSameOnPanel_um = 2 * kShear_um_per_mm * 250;

/// The translation into the other language, which drills the same holes on the same panel and does
/// `n_losses` things less.
inline std::string same_holes(const std::string& text,
                              double limit_um = kSameOnBoard_um,
                              FunctionSource panel = small_boards(),
                              const WalkOptions& options = {},
                              std::size_t n_losses = 0) {
  const Translation translation = translate(text, other(text), options);
  EXPECT_THAT(translation.errors, testing::IsEmpty());
  EXPECT_EQ(translation.losses.size(), n_losses) << testing::PrintToString(translation.losses);
  EXPECT_FALSE(translation.is_refused) << testing::PrintToString(translation.losses);
  const WorkRun before = run_on(panel, text, options);
  const WorkRun after = run_on(panel, translation.text, options);
  EXPECT_THAT(before.errors, testing::IsEmpty());
  EXPECT_THAT(after.errors, testing::IsEmpty()) << translation.text;
  EXPECT_FALSE(before.events.empty());
  const double worst_um = distance_um(before, after);
  EXPECT_GE(worst_um, 0) << translation.text;
  EXPECT_LT(worst_um, limit_um) << translation.text;
  return translation.text;
}

}  // namespace panelcal::test
