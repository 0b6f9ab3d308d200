// SPDX-License-Identifier: Apache-2.0
#include "machine/job/camera_pose.h"

#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

/// A refused series on a panel that lies turned and displaced, seen by a camera that turns what it
/// sees by `pose`.
Survey survey_seen(const Eigen::Matrix2d& pose, double turn_rad, std::size_t n_targets) {
  const std::vector<Eigen::Vector2d> places_mm = {{0, 0}, {180, 5}, {175, 120}, {3, 118}};
  Random random(4);
  Survey survey;
  SeriesResult series;
  for (std::size_t i = 0; i < n_targets; ++i) {
    const Eigen::Vector2d& expected_mm = places_mm[i];
    const Eigen::Vector2d turn_mm(-turn_rad * expected_mm.y(), turn_rad * expected_mm.x());
    const Eigen::Vector2d noise_mm(0.002 * random.normal(), 0.002 * random.normal());
    const Eigen::Vector2d deviation_mm = Eigen::Vector2d(0.2, -0.1) + turn_mm + noise_mm;
    Measurement one;
    one.status = MeasurementStatus::Found;
    one.request.expected = position_mm<frame::Actual>(expected_mm);
    one.measured.position =
        position_mm<frame::Actual>(Eigen::Vector2d(expected_mm + pose * deviation_mm));
    series.measurements.push_back(survey.measurements.size());
    survey.measurements.push_back(one);
  }
  survey.series.push_back(series);  // not fitted: refused
  return survey;
}

Eigen::Matrix2d pose_of(double xx, double xy, double yx, double yy) {
  Eigen::Matrix2d pose;
  pose << xx, xy, yx, yy;
  return pose;
}

bool speaks_for(const Survey& survey, const std::string& words) {
  const auto said = camera_pose_words(survey);
  return said && said->find("agree with " + words) != std::string::npos;
}

TEST(CameraPose, TellsMirroredAndTurnedCameras) {
  constexpr double kTurn = 3e-3;
  EXPECT_TRUE(speaks_for(survey_seen(pose_of(-1, 0, 0, 1), kTurn, 4), "x -> -x"));
  EXPECT_TRUE(speaks_for(survey_seen(pose_of(1, 0, 0, -1), kTurn, 3), "x -> -x (or y -> -y)"));
  EXPECT_TRUE(speaks_for(survey_seen(pose_of(0, -1, 1, 0), kTurn, 4), "a turn by 90 degrees"));
  EXPECT_TRUE(speaks_for(survey_seen(pose_of(0, 1, 1, 0), kTurn, 4), "x <-> y"));
}

TEST(CameraPose, IsSilentWhereTheCameraIsRightOrNothingTells) {
  const Eigen::Matrix2d mirrored = pose_of(-1, 0, 0, 1);
  EXPECT_FALSE(camera_pose_words(survey_seen(pose_of(1, 0, 0, 1), 3e-3, 4)).has_value());
  EXPECT_FALSE(camera_pose_words(survey_seen(pose_of(-1, 0, 0, -1), 3e-3, 4)).has_value());
  EXPECT_FALSE(camera_pose_words(survey_seen(mirrored, 0, 4)).has_value());
  EXPECT_FALSE(camera_pose_words(survey_seen(mirrored, 3e-3, 2)).has_value());
  EXPECT_FALSE(camera_pose_words(Survey()).has_value());
}

}  // namespace
}  // namespace panelcal
