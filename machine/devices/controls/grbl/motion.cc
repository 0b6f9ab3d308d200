// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "machine/devices/controls/grbl/machine.h"
#include "machine/devices/controls/grbl/words.h"
#include <fmt/format.h>

// Moves, probing, and how both are stopped.
namespace panelcal::grbl {
namespace {

using MotionClock = std::chrono::steady_clock;

constexpr char kJogCancel = '\x85';
constexpr char kFeedHold = '!';
constexpr char kAxisNames[] = "XYZ";

MotionClock::duration motion_time(Time time) {
  return std::chrono::duration_cast<MotionClock::duration>(
      std::chrono::duration<double>(time.in_s()));
}

MotionClock::time_point motion_deadline(Time within) {
  return MotionClock::now() + motion_time(within);
}

std::string place_words(const Eigen::Vector3d& place_mm) {
  return fmt::format("X{:.3f} Y{:.3f} Z{:.3f}", place_mm.x(), place_mm.y(), place_mm.z());
}

}  // namespace

template <class T, class F>
Expected<T> Machine::guarded(F order) {
  if (broken_) {
    Diagnostic again = *broken_;
    again.what = "stopped after an earlier failure: " + again.what;
    return failure(std::move(again));
  }
  Expected<T> result = order();
  if (result) return result;
  const Code code = result.error().code;
  if (motion_ == Motion::None && code == Code::TravelExceeded) return result;
  broken_ = stopped(std::move(result).error());
  return failure(*broken_);
}

Expected<Eigen::Vector2d> Machine::move_to(const Eigen::Vector2d& place_mm) {
  return guarded<Eigen::Vector2d>([&] { return drive(place_mm); });
}

Expected<double> Machine::probe_at(const Eigen::Vector2d& place_mm) {
  return guarded<double>([&] { return touch_at(place_mm); });
}

Expected<Report> Machine::idle() {
  PANELCAL_TRY(Report report, talk_.report());
  if (report.is("Idle")) return report;
  return failure(talk_.refused("the control is " + state_words(report.state),
                               "a control that is idle between moves"));
}

Expected<Eigen::Vector3d> Machine::standing() {
  PANELCAL_TRY(const Report report, idle());
  return place_of(report);
}

Expected<void> Machine::check_inside(const Eigen::Vector3d& target_mm) const {
  if (setting_.homing == Homing::None) return {};
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto travel_mm = facts_.setting(130 + static_cast<int>(axis));
    if (!travel_mm) continue;
    // GRBL 1.1 homes to a place above which there is nothing; the others can be told otherwise.
    const bool is_below_zero = facts_.firmware == Firmware::Grbl && !facts_.has_forced_origin;
    const double high_mm = is_below_zero ? 0 : *travel_mm;
    const double slack_mm = tolerance_mm(axis);
    if (target_mm[axis] >= -*travel_mm - slack_mm && target_mm[axis] <= high_mm + slack_mm)
      continue;
    return failure({Code::TravelExceeded,
                    {talk_.name(), 0, 0},
                    fmt::format("{}{:.3f} is outside the control's travel, from {} to {} mm (${})",
                                kAxisNames[axis],
                                target_mm[axis],
                                -*travel_mm,
                                high_mm,
                                130 + axis),
                    "a place where the machine can go"});
  }
  return {};
}

Expected<void> Machine::check_probe_is_free(const Report& report, std::string_view when) const {
  if (!report.is_probe_known) {
    return failure(talk_.problem("the control says that no probe is connected", "a probe"));
  }
  if (!report.is_probe_tripped) return {};
  return failure(talk_.problem(fmt::format("the probe is tripped {}", when),
                               "a probe that touches nothing, a sound cable, and $6 as it needs"));
}

Expected<void> Machine::jog(const Eigen::Vector3d& target_mm, bool is_z, bool watches_probe) {
  PANELCAL_CHECK(check_inside(target_mm));
  const std::string words = is_z ? fmt::format("Z{:.4f}", target_mm.z())
                                 : fmt::format("X{:.4f}Y{:.4f}", target_mm.x(), target_mm.y());
  target_mm_ = target_mm;
  motion_ = Motion::Jog;
  PANELCAL_CHECK(talk_.order(fmt::format("$J=G53G21G90{}F{}", words, rapid_feed(is_z))));
  const auto until = motion_deadline(setting_.limit);
  Eigen::Vector3d before_mm = Eigen::Vector3d::Constant(-1e9);
  auto moved = MotionClock::now();
  // A jog begins a moment after its answer.
  constexpr int kMostIdle = 20;
  for (int n_idle = 0; MotionClock::now() < until;) {
    PANELCAL_TRY(const Report report, talk_.report());
    PANELCAL_TRY(const Eigen::Vector3d at_mm, place_of(report));
    if (watches_probe) PANELCAL_CHECK(check_probe_is_free(report, "above probe_from_mm"));
    if (report.is("Idle")) {
      const Eigen::Vector3d off_mm = (at_mm - target_mm).cwiseAbs();
      const bool has_arrived = off_mm.x() <= tolerance_mm(0) && off_mm.y() <= tolerance_mm(1) &&
                               off_mm.z() <= tolerance_mm(2);
      if (has_arrived) {
        motion_ = Motion::None;
        return {};
      }
      if (++n_idle == kMostIdle) {
        return failure(talk_.refused(fmt::format("the machine was sent to {} and stopped at {}",
                                                 place_words(target_mm),
                                                 place_words(at_mm)),
                                     "an arrival: a jog was cancelled, or a pin stopped it"));
      }
    } else if (report.is("Jog") || report.is("Run")) {
      // A door or a hold may stop a jog without a state of its own.
      if (at_mm != before_mm) moved = MotionClock::now();
      before_mm = at_mm;
      if (MotionClock::now() > moved + motion_time(talk_.patience().answer)) {
        return failure(talk_.refused(
            fmt::format(
                "the machine does not move on from {} ({})", place_words(at_mm), report.state),
            "a move that nothing stops: a hold, a door, a feed of zero"));
      }
    } else {
      return failure(talk_.refused("the control is " + state_words(report.state) + " during a move",
                                   "a move that nothing stops"));
    }
    PANELCAL_TRY(const auto pushed, talk_.hear(talk_.patience().between_reports));
    if (pushed && pushed->kind != Talk::Heard::Kind::Report) {
      return failure(talk_.problem(
          "answers " + quoted(pushed->text.empty() ? "ok" : pushed->text) + " during a move",
          "reports"));
    }
  }
  return failure(talk_.problem(
      fmt::format("no arrival at {} within {} s", place_words(target_mm), setting_.limit.in_s()),
      "an arrival in time, or a longer [machine] move_limit_s"));
}

Expected<Eigen::Vector3d> Machine::lift() {
  PANELCAL_TRY(Eigen::Vector3d at_mm, standing());
  const double safe_mm = setting_.safe_z.in_mm();
  if (at_mm.z() >= safe_mm - tolerance_mm(2)) return at_mm;
  at_mm.z() = safe_mm;
  PANELCAL_CHECK(jog(at_mm, true));
  return standing();
}

Expected<Eigen::Vector2d> Machine::drive(const Eigen::Vector2d& place_mm) {
  PANELCAL_CHECK(check_inside({place_mm.x(), place_mm.y(), setting_.safe_z.in_mm()}));
  PANELCAL_TRY(Eigen::Vector3d at_mm, lift());
  PANELCAL_CHECK(jog({place_mm.x(), place_mm.y(), at_mm.z()}, false));
  PANELCAL_TRY(at_mm, standing());
  return Eigen::Vector2d(at_mm.head<2>());
}

Expected<Touch> Machine::touch(double down_mm) {
  motion_ = Motion::Program;
  PANELCAL_CHECK(talk_.send(
      fmt::format("G21G91G94G38.2Z-{:.4f}F{:.1f}", down_mm, setting_.probe->feed_mm_min)));
  std::optional<Touch> touch;
  const auto until = motion_deadline(setting_.limit);
  while (MotionClock::now() < until) {
    PANELCAL_TRY(const auto one, talk_.hear(4 * talk_.patience().between_reports));
    if (!one) {
      PANELCAL_CHECK(talk_.send_now('?'));
    } else if (one->kind == Talk::Heard::Kind::Report) {
      const Report& report = one->report;
      if (report.is("Run") || report.is("Idle")) continue;
      return failure(
          talk_.refused("the control is " + state_words(report.state) + " while it probes",
                        "a probing move that nothing stops"));
    } else if (one->kind == Talk::Heard::Kind::Data) {
      touch = parse_touch(one->text);
      if (!touch) return failure(talk_.problem("answers " + quoted(one->text), "[PRB:x,y,z:1]"));
    } else if (touch) {
      return *touch;
    } else {
      return failure(talk_.problem("a probing move without its [PRB:...]", "[PRB:x,y,z:1]"));
    }
  }
  return failure(
      talk_.problem(fmt::format("no end of the probing move within {} s", setting_.limit.in_s()),
                    "a longer [machine] move_limit_s, or a faster probe_feed_mm_min"));
}

Expected<double> Machine::touch_at(const Eigen::Vector2d& place_mm) {
  const ControlProbe& probe = *setting_.probe;
  PANELCAL_CHECK(check_inside({place_mm.x(), place_mm.y(), probe.to.in_mm()}));
  PANELCAL_CHECK(read_modes());
  PANELCAL_CHECK(check_modes(true));
  PANELCAL_TRY(const Report free, idle());
  PANELCAL_CHECK(check_probe_is_free(free, "before it moves"));
  PANELCAL_CHECK(drive(place_mm));
  PANELCAL_TRY(Eigen::Vector3d at_mm, standing());
  PANELCAL_CHECK(jog({at_mm.x(), at_mm.y(), probe.from.in_mm()}, true, true));
  PANELCAL_TRY(at_mm, standing());
  target_mm_.z() = probe.to.in_mm();
  PANELCAL_TRY(const Touch touched, touch(at_mm.z() - probe.to.in_mm()));
  const Eigen::Vector3d touched_mm = in_mm(touched.machine);
  PANELCAL_TRY(const Eigen::Vector3d end_mm, standing());
  const double slack_mm = 2 * tolerance_mm(2);
  const bool is_there = std::abs(touched_mm.x() - at_mm.x()) <= 2 * tolerance_mm(0) &&
                        std::abs(touched_mm.y() - at_mm.y()) <= 2 * tolerance_mm(1) &&
                        touched_mm.z() <= at_mm.z() + slack_mm &&
                        touched_mm.z() >= probe.to.in_mm() - slack_mm &&
                        end_mm.z() <= touched_mm.z() + slack_mm;
  if (!touched.is_touched || !is_there) {
    return failure(talk_.problem(
        touched.is_touched ? fmt::format("states a touch at {}, and the probe moved from {} to {}",
                                         place_words(touched_mm),
                                         place_words(at_mm),
                                         place_words(end_mm))
                           : "the probe touched nothing on its way",
        "a touch between probe_from_mm and probe_to_mm"));
  }
  // G38.2 has left its own modes behind.
  std::string modes = facts_.has_mode("G91") ? "G91" : "G90";
  modes += facts_.has_mode("G20") ? "G20" : "G21";
  modes += facts_.has_mode("G93") ? "G93" : facts_.has_mode("G95") ? "G95" : "G94";
  modes += facts_.has_mode("G0") ? "G0" : facts_.has_mode("G1") ? "G1" : "G80";
  PANELCAL_CHECK(talk_.order(modes));
  motion_ = Motion::None;
  PANELCAL_CHECK(lift());
  PANELCAL_TRY(const Report lifted, idle());
  PANELCAL_CHECK(check_probe_is_free(lifted, "though it was lifted"));
  return touched_mm.z();
}

Expected<void> Machine::tell_to_stop() {
  if (motion_ == Motion::Jog) return talk_.send_now(kJogCancel);
  if (motion_ == Motion::Program) return talk_.send_now(kFeedHold);
  return {};
}

std::optional<Report> Machine::wait_until_standing(bool& is_lost) {
  std::optional<Report> last;
  Eigen::Vector3d before = Eigen::Vector3d::Constant(-1e9);
  const auto may_be_read = motion_deadline(talk_.patience().unread);
  for (const auto until = motion_deadline(talk_.patience().answer); MotionClock::now() < until;) {
    auto report = talk_.last_report(0.1 * talk_.patience().answer);
    if (!report) {
      is_lost = true;
      return last;
    }
    if (!*report) continue;
    last = **report;
    const bool moves = last->is("Run") || last->is("Jog") || last->is("Home") ||
                       last->state == "Hold:1" || last->state == "Door:2" ||
                       last->state == "Door:3";
    const Eigen::Vector3d place = last->machine ? *last->machine : *last->work;
    // A control that has just been told to stop may not have begun to; and an order that it has not
    // yet read begins behind the stop.
    const bool may_begin =
        last->is("Idle") && talk_.is_unanswered() && MotionClock::now() < may_be_read;
    if (!moves && !may_begin && before == place) return last;
    before = place;
    if (moves && !tell_to_stop()) is_lost = true;
    std::this_thread::sleep_for(
        std::chrono::duration<double>(talk_.patience().between_reports.in_s()));
  }
  return last;
}

std::string Machine::stop() {
  const std::string goes_on = fmt::format(
      "the move in hand may go on to {}: stop the machine by hand", place_words(target_mm_));
  bool is_lost = false;
  is_lost = !(motion_ == Motion::Homing ? talk_.reset() : tell_to_stop());
  std::optional<Report> report;
  if (!is_lost) report = wait_until_standing(is_lost);
  const auto stands = [&] {
    return report && !(report->is("Idle") && talk_.is_unanswered()) &&
           (report->is("Idle") || report->is("Alarm") || report->is("Sleep"));
  };
  // A move that is held goes on when an operator presses start.
  if (!is_lost && motion_ != Motion::None && !stands()) {
    is_lost = !talk_.reset();
    if (!is_lost) report = wait_until_standing(is_lost);
  }
  const bool was_moving = std::exchange(motion_, Motion::None) != Motion::None;
  if (is_lost) return was_moving ? "; it could not be stopped, and " + goes_on : "";
  if (!report)
    return was_moving ? "; whether it stopped is not known: it does not answer, and " + goes_on
                      : "";
  const bool is_still = stands() || report->state == "Hold:0" || report->is("Check");
  if (!is_still && was_moving) {
    return fmt::format("; it could not be stopped ({}), and {}", report->state, goes_on);
  }
  if (report->offset) offset_ = report->offset;
  const auto& at = report->machine;
  if (!at && !offset_) return fmt::format("; the machine stands ({})", report->state);
  const Eigen::Vector3d at_mm = in_mm(at ? *at : Eigen::Vector3d(*report->work + *offset_));
  return fmt::format("; the machine stands at {} ({})", place_words(at_mm), report->state);
}

Diagnostic Machine::stopped(Diagnostic cause) {
  cause.what += stop();
  return cause;
}

}  // namespace panelcal::grbl
