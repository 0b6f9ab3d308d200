// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "calib/camera/calibration/calibration_file.h"

namespace panelcal {

/// The kind of machine that a new machine.toml is for.
enum class MachineKind : std::uint8_t { UsbCameraLinuxCnc, UsbCameraGrbl, GigeCnc7, Folder };

/// "usb-camera-linuxcnc", "usb-camera-grbl", "gige-cnc7", "folder".
std::string_view name(MachineKind kind);
std::optional<MachineKind> machine_kind_from_name(std::string_view name);
/// A line about the kind, for people who choose.
std::string_view summary(MachineKind kind);

/// Answers of a person about the machine; the rest is assumed, and marked so.
struct MachineAnswers {
  MachineKind kind = MachineKind::Folder;
  std::string name = "my machine";
  std::optional<std::string> camera;  ///< its address; absent: the kind's usual one
  std::string device;                 ///< serial, of a GRBL
  std::string host;                   ///< of the control
  std::optional<Length> safe_z;       ///< machine Z
  std::optional<std::pair<Length, Length>> travel_low, travel_high;
  std::optional<std::pair<Length, Length>> camera_offset;  ///< from the spindle to the camera
  std::optional<Length> camera_offset_sigma;
  std::vector<Length> fiducials;  ///< diameters of round bright targets, tools 1, 2, ...
  /// A camera calibration that exists; empty: one is assumed, of this size and scale.
  std::string calibration;
  std::optional<Length> pixel;                    ///< on the panel; absent: the kind's usual one
  std::optional<std::pair<int, int>> picture_px;  ///< absent: the kind's usual one
};

/// The name of the assumed camera calibration beside machine.toml.
inline constexpr std::string_view kAssumedCameraFile = "camera.cal.json";

/// machine.toml for these answers: each key behind its line of help. Numbers that were not
/// measured are marked "assumed", and the head says which commands measure them.
///
/// In     file: its name, for the commands in the head
/// See    tests/machine/init/machine_text_test.cc
std::string machine_text(const MachineAnswers& answers, std::string_view file);

/// A camera that looks straight down, square to the machine, with its axis in the picture's middle,
/// as uncertain as a camera that was just screwed on: 2 % of scale, 50 mrad, 20 px.
///
/// In     date: of the file
CameraCalibration assumed_camera(const MachineAnswers& answers, std::chrono::sys_seconds date);

}  // namespace panelcal
