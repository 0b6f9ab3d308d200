// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "calib/base/units.h"

namespace panelcal {

enum class ControlKind : std::uint8_t { Grbl, LinuxCnc };

/// The origin of the machine's coordinates: a home position or not.
enum class Homing : std::uint8_t {
  Required,
  WhenLocked,  ///< the driver homes a control that is locked until it is homed
  None,
};

constexpr std::optional<ControlKind> control_kind_from_name(std::string_view name) {
  if (name == "grbl") return ControlKind::Grbl;
  if (name == "linuxcnc") return ControlKind::LinuxCnc;
  return std::nullopt;
}

constexpr std::optional<Homing> homing_from_name(std::string_view name) {
  if (name == "required") return Homing::Required;
  if (name == "when_locked") return Homing::WhenLocked;
  if (name == "none") return Homing::None;
  return std::nullopt;
}

/// Probing by a control; all heights are Z of the machine.
struct ControlProbe {
  double feed_mm_min = 0;
  Length from;  ///< beginning of the probing move
  Length to;    ///< and ends at the latest
  Length z0;    ///< of a touch of the plane from which heights count
};

/// [machine] driver and its kin: a control that panelcal speaks to itself.
struct ControlSetting {
  std::optional<ControlKind> driver;
  std::string host;
  int port = 0;        ///< 0: the control's usual one
  std::string device;  ///< serial
  int baud = 115200;
  std::string connect_password = "EMC";
  std::string enable_password = "EMCTOO";
  Homing homing = Homing::Required;
  Length safe_z;  ///< machine Z at and above which X and Y may move; the driver lifts Z to it
  double move_feed_mm_min = 0;  ///< of X and Y; 0: rapid
  Time limit = seconds(60);     ///< for one move
  std::optional<ControlProbe> probe;
};

}  // namespace panelcal
