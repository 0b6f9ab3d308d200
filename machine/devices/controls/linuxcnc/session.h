// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "machine/config/settings/control_setting.h"
#include "machine/devices/controls/line_link.h"

namespace panelcal::internal {

/// A connection to linuxcncrsh with the right to control LinuxCNC: a line each way for an order.
///
/// Source linuxcncrsh(1) of LinuxCNC 2.9, and what it answers: replies end with \r\n or \n\r, some
///        have an empty line behind them, and in verbose mode each `set` is answered by ACK or NAK
/// See    tests/machine/devices/controls/linuxcnc/
class LinuxCncSession {
 public:
  /// Says hello and takes the right to control from the client that has it; nothing moves.
  ///
  /// In     heeds_signals: false from the first byte on, as after ignore_signals
  /// Fails  device-stage (no connection, wrong password, other answers than linuxcncrsh gives);
  ///        interrupted
  static Expected<std::unique_ptr<LinuxCncSession>> open(const ControlSetting& setting,
                                                         bool heeds_signals = true);

  /// The answer to `get SUBJECT`, behind the subject.
  ///
  /// Fails  device-stage (connection lost, no answer within 5 s, another answer); interrupted
  Expected<std::string> get(std::string_view subject);
  /// True if linuxcncrsh accepts `set ORDER`, which says little: it accepts an MDI line before the
  /// interpreter has read it.
  ///
  /// Fails  as get
  Expected<bool> set(std::string_view order);

  /// From here on a signal that asks this process to end does not end a wait for an answer.
  void ignore_signals() { heeds_signals_ = false; }
  /// After a failure other than a signal: what arrives next may be the answer to anything.
  bool is_broken() const { return is_broken_; }
  /// "mill:5007", the place of diagnostics.
  const std::string& name() const { return link_->name(); }

 private:
  explicit LinuxCncSession(std::unique_ptr<LineLink> link);
  Expected<void> greet(const ControlSetting& setting);
  Expected<std::string> answer_to(const std::string& order);
  /// The next line that is neither empty nor an echo of the order.
  Expected<std::string> next_answer(const std::string& order);
  Diagnostic odd_answer(const std::string& order, const std::string& answer);

  std::unique_ptr<LineLink> link_;
  Time longest_answer_;
  bool heeds_signals_ = true;
  bool is_broken_ = false;
  bool owes_answer_ = false;  ///< to an order whose wait a signal has ended
};

}  // namespace panelcal::internal
