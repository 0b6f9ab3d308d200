// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "calib/base/expected.h"
#include "machine/config/settings/control_setting.h"
#include "machine/devices/controls/linuxcnc/session.h"
#include <Eigen/Core>

namespace panelcal::internal {

/// The place of the axes, in the machine's coordinates.
struct LinuxCncPlace {
  Eigen::Vector3d command_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d actual_mm = Eigen::Vector3d::Zero();  ///< by the encoders
};

/// Moves the axes of a LinuxCNC and watches them. After a failure in the middle of a move it has
/// told the control to abort, and the diagnostic says whether the machine stands.
class LinuxCncDrive {
 public:
  explicit LinuxCncDrive(ControlSetting setting) : setting_(std::move(setting)) {}

  /// Connects if need be and reads the state; nothing moves.
  ///
  /// Fails  device-stage; interrupted
  Expected<void> make_ready();

  /// Lifts Z to the safe height if it is below, drives X and Y to a place and returns where they
  /// stand.
  Expected<LinuxCncPlace> move_to(const Eigen::Vector2d& place_mm);
  /// Touches at a place, with Z at the safe height before and after; absent: nothing was touched.
  ///
  /// Out    Z of the machine, mm
  /// Precondition: setting.probe is there.
  Expected<std::optional<double>> touch_at(const Eigen::Vector2d& place_mm);

  std::string name() const { return session_ ? session_->name() : "LinuxCNC"; }

 private:
  using Condition = std::function<Expected<bool>(const LinuxCncPlace&)>;

  template <class T>
  Expected<T> guarded(const std::function<Expected<T>()>& moves);
  Expected<void> connect(bool heeds_signals = true);
  Expected<void> check_switched_on();
  Expected<void> check_homed();
  Expected<void> check_modes();
  /// The interpreter's status when a line without motion should have ended.
  Expected<std::string> rest_status();
  Expected<LinuxCncPlace> place();
  Expected<Eigen::Vector3d> position(const char* subject);
  /// Sends an MDI line that moves and waits until the machine stands where the condition holds.
  Expected<LinuxCncPlace> move(const std::string& line, const Condition& is_there);
  Expected<LinuxCncPlace> rest(const Condition& is_there);
  Expected<LinuxCncPlace> drive_z(double z_mm);
  Expected<LinuxCncPlace> lift();
  Expected<LinuxCncPlace> go(const Eigen::Vector2d& place_mm);
  Expected<std::optional<double>> touch(const LinuxCncPlace& above);
  /// "Z-12.500000" in the operator's unit.
  std::string word(char letter, double value_mm) const;
  Expected<void> order(const std::string& line);
  /// Adds what the control has to report to errors_.
  Expected<void> take_errors();
  Expected<bool> is_on(const char* subject, const char* word);
  /// Fails if there is a cause why the control does not move: stop, switch, limit, fault, error
  /// text, another's control or mode; in this order.
  Expected<void> check_cause();
  /// That cause, or the problem that there is without one.
  Diagnostic reason(std::string otherwise);
  /// Empty: the machine stands.
  std::string stop();
  Expected<bool> stands_after_abort();
  Diagnostic problem(std::string what, std::string expected) const;

  ControlSetting setting_;
  std::unique_ptr<LinuxCncSession> session_;
  double mm_per_unit_ = 1;  ///< of the machine's places
  double mm_per_word_ = 1;  ///< of the operator's unit, which stays: G20 or G21
  std::string modes_;       ///< the operator's: G90 or G91, G93 to G95
  std::string errors_;
  bool is_in_motion_ = false;  ///< since an MDI line that has not ended
};

}  // namespace panelcal::internal
