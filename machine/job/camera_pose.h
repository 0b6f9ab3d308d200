// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "program/walk/survey.h"

namespace panelcal {

/// Tells whether the refused series of a survey would fit if the camera were mounted, or its
/// pictures written, mirrored or turned by a quarter.
///
///   measured_i = expected_i + T (seen_i - expected_i),   T a symmetry of the square
///
/// A series speaks for T if rotation and offset then leave an eighth of the residuals or less. Half
/// a turn makes of a turned and displaced panel one that is turned and displaced the other way, so
/// that residuals never tell it; nor do they tell anything if the panel is only displaced.
///
/// Out    "mirrored or turned camera: residuals agree with x -> -x (or y -> -y) (2 refused
/// series)"; empty
///        unless all refused series of three targets or more speak for the same T
/// See    tests/machine/job/camera_pose_test.cc
std::optional<std::string> camera_pose_words(const Survey& survey);

}  // namespace panelcal
