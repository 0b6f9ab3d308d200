// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "calib/base/expected.h"
#include "machine/config/settings/control_setting.h"
#include "machine/devices/controls/grbl/report.h"
#include "machine/devices/controls/grbl/talk.h"
#include <Eigen/Core>

namespace panelcal::grbl {

/// A GRBL whose state is known (machine/devices/controls/grbl/grbl.h).
class Machine {
 public:
  /// Reads the control's state and refuses one in which it must not be moved.
  static Expected<Machine> open(Talk talk, const ControlSetting& setting);

  /// Drives to a place, with Z at safe_z_mm or above, and returns where it stands.
  Expected<Eigen::Vector2d> move_to(const Eigen::Vector2d& place_mm);
  /// Drives there, probes, and lifts Z again. Returns the machine's Z of the touch.
  ///
  /// Precondition: the setting has a probe.
  Expected<double> probe_at(const Eigen::Vector2d& place_mm);

  /// "GRBL 1.1h at /dev/ttyUSB0".
  std::string words() const;

 private:
  /// The motion that our order may have begun.
  enum class Motion : std::uint8_t { None, Jog, Program, Homing };

  Machine(Talk talk, const ControlSetting& setting) : talk_(std::move(talk)), setting_(setting) {}

  // Opening.
  Expected<void> home();
  Expected<void> read_facts();
  Expected<void> check_facts(const Report& report);
  Expected<void> check_homing(const Report& awake);
  Expected<std::optional<bool>> stated_homing();
  Expected<void> check_coordinates(const Report& awake);
  Expected<void> check_modes(bool is_to_probe);
  Expected<void> read_modes();

  // Motion.
  Expected<Report> idle();
  Expected<Eigen::Vector3d> standing();
  Expected<void> check_inside(const Eigen::Vector3d& target_mm) const;
  Expected<void> jog(const Eigen::Vector3d& target_mm, bool is_z, bool watches_probe = false);
  Expected<Eigen::Vector3d> lift();
  Expected<Eigen::Vector2d> drive(const Eigen::Vector2d& place_mm);
  Expected<double> touch_at(const Eigen::Vector2d& place_mm);
  Expected<Touch> touch(double down_mm);
  Expected<void> check_probe_is_free(const Report& report, std::string_view when) const;

  // Reports in mm.
  Expected<Eigen::Vector3d> place_of(const Report& report);
  Eigen::Vector3d in_mm(const Eigen::Vector3d& reported) const;
  double tolerance_mm(Eigen::Index axis) const;
  std::string rapid_feed(bool is_z) const;

  /// Stops what is in motion; the same diagnostic with what became of it.
  Diagnostic stopped(Diagnostic cause);
  std::string stop();
  Expected<void> tell_to_stop();
  std::optional<Report> wait_until_standing(bool& is_lost);
  template <class T, class F>
  Expected<T> guarded(F order);

  Talk talk_;
  ControlSetting setting_;
  Facts facts_;
  std::optional<Eigen::Vector3d> offset_;  ///< of work zero, in the control's unit
  Motion motion_ = Motion::None;
  Eigen::Vector3d target_mm_ = Eigen::Vector3d::Zero();
  std::optional<Diagnostic> broken_;  ///< the failure after which nothing moves
};

}  // namespace panelcal::grbl
