// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/controls/grbl/machine.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "machine/devices/controls/grbl/words.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

// Opening: what the control states of itself, and what is refused.
namespace panelcal::grbl {
namespace {

constexpr Time kHomingLimit = seconds(300);
/// grblHAL answers with all fields.
constexpr char kFullReport = '\x87';

}  // namespace

Expected<Machine> Machine::open(Talk talk, const ControlSetting& setting) {
  Machine machine(std::move(talk), setting);
  PANELCAL_TRY(Report report, machine.talk_.wake());
  if (report.is("Alarm") && setting.homing == Homing::WhenLocked) {
    PANELCAL_CHECK(machine.home());
    PANELCAL_TRY(report, machine.talk_.report());
  }
  if (!report.is("Idle")) {
    return failure(machine.talk_.refused(
        "the control is " + state_words(report.state),
        report.is("Alarm") ? "a control that is idle: find the cause, then home it ($H) or unlock "
                             "it ($X) at its console, or homing = \"when_locked\""
                           : "a control that is idle"));
  }
  PANELCAL_CHECK(machine.read_facts());
  PANELCAL_CHECK(machine.check_facts(report));
  return machine;
}

Expected<void> Machine::home() {
  motion_ = Motion::Homing;
  auto homed = talk_.order("$H", kHomingLimit);
  if (!homed) return failure(stopped(std::move(homed).error()));
  motion_ = Motion::None;
  return {};
}

Expected<void> Machine::read_modes() {
  PANELCAL_TRY(const auto lines, talk_.order("$G"));
  if (take_modes(lines, facts_)) return {};
  return failure(talk_.problem("no modes in the answer to \"$G\"", "[GC:G0 G54 ...]"));
}

Expected<void> Machine::read_facts() {
  PANELCAL_TRY(const auto identity, talk_.order("$I"));
  take_identity(identity, facts_);
  PANELCAL_TRY(const auto settings, talk_.order("$$"));
  take_settings(settings, facts_);
  if (facts_.settings.empty()) {
    return failure(talk_.problem("no settings in the answer to \"$$\"", "$0=10 and so on"));
  }
  PANELCAL_CHECK(read_modes());
  PANELCAL_TRY(const auto offsets, talk_.order("$#"));
  take_offsets(offsets, facts_);
  return {};
}

Expected<void> Machine::check_modes(bool is_to_probe) {
  // Moves are in machine coordinates, which work zeros, G92 and tool lengths do not change.
  for (const std::string_view mode : {"G51", "G68"}) {
    if (!facts_.has_mode(mode)) continue;
    return failure(talk_.problem(fmt::format("{} is active, which scales or turns moves", mode),
                                 "G50 and G69 first"));
  }
  if (is_to_probe && (facts_.has_mode("M3") || facts_.has_mode("M4"))) {
    return failure(talk_.problem("the spindle runs, and a probe would turn", "M5 first"));
  }
  return {};
}

/// What grblHAL says of its homing; absent: nothing in time.
Expected<std::optional<bool>> Machine::stated_homing() {
  using Clock = std::chrono::steady_clock;
  PANELCAL_CHECK(talk_.send_now(kFullReport));
  const auto until = Clock::now() + std::chrono::duration<double>(talk_.patience().answer.in_s());
  // Reports that it sends by itself do not have it.
  while (Clock::now() < until) {
    PANELCAL_TRY(const auto full, talk_.hear(talk_.patience().between_reports));
    if (full && full->kind == Talk::Heard::Kind::Report && full->report.is_homed) {
      return full->report.is_homed;
    }
  }
  return std::optional<bool>();
}

Expected<void> Machine::check_homing(const Report& awake) {
  const bool is_off = facts_.setting(22) == 0.0;
  if (setting_.homing == Homing::None) return {};
  if (is_off) {
    return failure(
        talk_.problem("the control has no homing ($22=0), so that its coordinates count "
                      "from where it was switched on",
                      "homing switched on, or [machine] homing = \"none\""));
  }
  std::optional<bool> is_homed = awake.is_homed;
  if (facts_.firmware == Firmware::GrblHal) {
    PANELCAL_TRY(is_homed, stated_homing());
    if (!is_homed) {
      return failure(
          talk_.problem("the control does not say whether the machine is homed",
                        "a report with H:1 as the answer to 0x87, or [machine] homing = \"none\""));
    }
  }
  if (is_homed == false) {
    return failure(talk_.problem("the machine is not homed", "$H at its console first"));
  }
  return {};
}

Expected<void> Machine::check_facts(const Report& awake) {
  const bool is_grblhal = facts_.firmware == Firmware::GrblHal;
  PANELCAL_CHECK(check_homing(awake));
  PANELCAL_CHECK(check_modes(false));
  constexpr int kPinsInReport = 16;
  const auto reported = facts_.setting(10);
  if (setting_.probe && is_grblhal && reported &&
      (static_cast<int>(*reported) & kPinsInReport) == 0) {
    return failure(talk_.problem(
        fmt::format("reports do not have the probe's pin ($10={})", *reported), "$10=511"));
  }
  for (int axis = 0; axis < 3; ++axis) {
    if (facts_.setting(100 + axis).value_or(0) > 0 && facts_.setting(110 + axis).value_or(0) > 0) {
      continue;
    }
    return failure(
        talk_.problem(fmt::format("no ${} or ${} in the answer to \"$$\"", 100 + axis, 110 + axis),
                      "steps per mm and the maximum rate of each axis"));
  }
  return check_coordinates(awake);
}

Expected<void> Machine::check_coordinates(const Report& awake) {
  PANELCAL_TRY(const Eigen::Vector3d at_mm, place_of(awake));
  // A control that has kept its coordinates may greet as well, but not from zero.
  const bool is_reset = talk_.has_greeted() && (at_mm.array() == 0).all();
  if (setting_.homing != Homing::None || !is_reset) return {};
  return failure(talk_.problem(
      "the control was reset when its connection was opened: its coordinates count from where it "
      "stands now, so that Z may be low and no zero or alignment holds",
      "Z lifted and the zeros set anew at its console, then the command again"));
}

std::string Machine::words() const {
  std::string words = facts_.name + " at " + talk_.name();
  std::vector<std::string> notes;
  if (!facts_.offsets.empty()) {
    notes.push_back(fmt::format("{} not used: moves are in machine coordinates",
                                fmt::join(facts_.offsets, ", ")));
  }
  if (setting_.homing == Homing::None) {
    notes.emplace_back("not homed: coordinates count from where it was switched on");
  }
  if (!facts_.is_on(20)) notes.emplace_back("no soft limits ($20=0)");
  return notes.empty() ? words : fmt::format("{} ({})", words, fmt::join(notes, "; "));
}

Eigen::Vector3d Machine::in_mm(const Eigen::Vector3d& reported) const {
  return facts_.is_on(13) ? Eigen::Vector3d(reported * inch(1).in_mm()) : reported;
}

Expected<Eigen::Vector3d> Machine::place_of(const Report& first) {
  // The difference of the two zeros is in one of some ten reports, and in the next one when it
  // changes.
  constexpr int kMostReports = 40;
  Report report = first;
  for (int i = 0; i < kMostReports; ++i) {
    if (report.offset) offset_ = report.offset;
    if (report.machine) return in_mm(*report.machine);
    if (offset_) return in_mm(*report.work + *offset_);
    PANELCAL_TRY(report, talk_.report());
  }
  return failure(talk_.problem("reports state work coordinates and no WCO", "$10=1"));
}

/// One step, and the rounding of reports.
double Machine::tolerance_mm(Eigen::Index axis) const {
  const double rounding_mm = facts_.is_on(13) ? inch(1e-4).in_mm() : mm(1e-3).in_mm();
  return 1 / facts_.setting(100 + static_cast<int>(axis)).value_or(1) + rounding_mm;
}

std::string Machine::rapid_feed(bool is_z) const {
  if (is_z) return fmt::format("{:.1f}", *facts_.setting(112));
  if (setting_.move_feed_mm_min > 0) return fmt::format("{:.1f}", setting_.move_feed_mm_min);
  return fmt::format("{:.1f}", std::max(*facts_.setting(110), *facts_.setting(111)));
}

}  // namespace panelcal::grbl
