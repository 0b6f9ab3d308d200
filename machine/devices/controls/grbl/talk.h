// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/expected.h"
#include "calib/base/units.h"
#include "machine/devices/controls/grbl/report.h"
#include "machine/devices/controls/line_link.h"

namespace panelcal::grbl {

/// The dialogue with a GRBL: an order is a line that `ok` or `error:N` answers, `?` is answered by
/// a report, and alarms come by themselves. One order at a time is under way, so that no buffer of
/// the control overflows.
///
/// All fail with device-stage: the connection is lost; the control does not answer in time, refuses
/// the order, raises an alarm, was reset, or answers what is no GRBL's; and with interrupted.
class Talk {
 public:
  /// An answer, or a line of one.
  struct Heard {
    enum class Kind { Done, Report, Data } kind = Kind::Done;
    std::string text;
    Report report;
  };

  struct Patience {
    Time answer = seconds(5);  ///< also for a machine that is being stopped
    Time quiet = seconds(0.1);
    Time unread = seconds(1);  ///< until an order that is not answered counts as never read
    Time between_reports = seconds(0.05);
  };

  explicit Talk(std::unique_ptr<LineLink> link) : Talk(std::move(link), Patience()) {}
  Talk(std::unique_ptr<LineLink> link, Patience patience)
      : link_(std::move(link)), patience_(patience) {}

  /// Waits until the control answers `?`, twice as long as for an answer, and drops what it has
  /// said before: a controller whose serial device is opened starts anew.
  ///
  /// Out    its state
  Expected<Report> wake();
  /// Sends a line, and gives the lines of its answer.
  Expected<std::vector<std::string>> order(const std::string& line) {
    return order(line, patience_.answer);
  }
  Expected<std::vector<std::string>> order(const std::string& line, Time limit);
  Expected<Report> report();

  /// Single steps, for orders that take time.
  Expected<void> send(const std::string& line);
  Expected<std::optional<Heard>> hear(Time within);

  /// While the machine is being stopped: neither signals nor alarms matter any more.
  Expected<void> send_now(char byte) { return link_->send({&byte, 1}); }
  /// Resets the control, and passes over what it says until it has begun anew.
  Expected<void> reset();
  /// The next report, asked for; absent: no answer within the time.
  Expected<std::optional<Report>> last_report(Time within);
  /// The control has greeted when it was woken, as after a reset by the opening of its serial
  /// device; some greet each new connection too.
  bool has_greeted() const { return has_greeted_; }
  /// The last order is not answered: the control may not have begun with it.
  bool is_unanswered() const { return is_unanswered_; }

  Diagnostic problem(std::string what, std::string expected) const;
  /// The same with what the control has said last by [MSG:...].
  Diagnostic refused(std::string what, std::string expected) const;
  const std::string& name() const { return link_->name(); }
  const Patience& patience() const { return patience_; }

 private:
  Expected<std::optional<Heard>> heard(std::string line);

  std::unique_ptr<LineLink> link_;
  Patience patience_;
  std::string order_;  ///< the one that is under way, or was last
  bool is_unanswered_ = false;
  bool has_greeted_ = false;
  std::string message_;  ///< of the last [MSG:...]
};

}  // namespace panelcal::grbl
