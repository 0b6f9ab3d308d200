// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/controls/linuxcnc/drive.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <string_view>
#include <thread>

#include "calib/base/interruption.h"
#include "machine/devices/commands/command_stage.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// linuxcncrsh prints six decimals, of an inch perhaps, and the move has six of a millimetre.
constexpr double kReached_mm = 1e-4;
/// The encoders have settled where three looks differ by less.
constexpr double kSettled_mm = 5e-4;
constexpr int kSettledLooks = 3;
const Time kLook = seconds(0.01);
/// Between two MDI lines the interpreter is idle for as long as the task's cycle, 0.1 s at most.
constexpr std::chrono::duration<double> kEnded{0.3};
/// A line that was accepted begins; a computer that is busy takes its time.
constexpr std::chrono::duration<double> kBegin{3};
/// A move that is not paused and does not go on: feed hold, or an override of 0.
constexpr std::chrono::duration<double> kHeld{4};
constexpr std::chrono::duration<double> kLongestStop{2};
constexpr std::chrono::milliseconds kStopLook{100};
/// Where a control reports one error after the other.
constexpr int kMostErrors = 20;

/// The operator's, which an order ahead of the moves has kept.
constexpr const char* kFeedAgain = " F#<_panelcal_feed>";

using DriveClock = std::chrono::steady_clock;

std::string axes_words(const LinuxCncPlace& place) {
  return fmt::format("X {:.4f}, Y {:.4f}, Z {:.4f}",
                     place.command_mm.x(),
                     place.command_mm.y(),
                     place.command_mm.z());
}

bool has_code(const std::string& codes, std::string_view code) {
  return (" " + codes + " ").find(fmt::format(" {} ", code)) != std::string::npos;
}

/// The index of the first word that is not what all should be; -1 if there is no such word.
int first_other(std::string_view words, std::string_view wanted) {
  int index = 0;
  while (!words.empty()) {
    const std::string_view word = words.substr(0, words.find(' '));
    if (word != wanted) return index;
    words.remove_prefix(std::min(words.size(), word.size() + 1));
    ++index;
  }
  return -1;
}

}  // namespace

Diagnostic LinuxCncDrive::problem(std::string what, std::string expected) const {
  return {Code::DeviceStage, {name(), 0, 0}, std::move(what), std::move(expected)};
}

Expected<bool> LinuxCncDrive::is_on(const char* subject, const char* word) {
  PANELCAL_TRY(const std::string answer, session_->get(subject));
  return answer == word;
}

Expected<void> LinuxCncDrive::connect(bool heeds_signals) {
  if (session_ && !session_->is_broken()) return {};
  // linuxcncrsh may be told to serve one connection only.
  session_.reset();
  PANELCAL_TRY(session_, LinuxCncSession::open(setting_, heeds_signals));
  PANELCAL_TRY(const std::string units, session_->get("user_linear_units"));
  if (units != "MM" && units != "INCH") {
    return failure(
        problem("its linear units are " + quoted(units), "[TRAJ] LINEAR_UNITS mm or inch"));
  }
  mm_per_unit_ = units == "MM" ? 1.0 : inch(1).in_mm();
  return {};
}

Expected<void> LinuxCncDrive::check_switched_on() {
  // In this order: whatever switches the machine off has come before it.
  PANELCAL_TRY(const bool is_switched_on, is_on("machine", "ON"));
  PANELCAL_TRY(const bool is_stopped, is_on("estop", "ON"));
  if (is_stopped) {
    return failure(problem("the emergency stop is on", "it released and the machine switched on"));
  }
  PANELCAL_TRY(const std::string limits, session_->get("joint_limit"));
  if (const int joint = first_other(limits, "OK"); joint >= 0) {
    return failure(problem(fmt::format("joint {} is at a limit: {}", joint, quoted(limits)),
                           "it jogged off the limit at the control"));
  }
  PANELCAL_TRY(const std::string faults, session_->get("joint_fault"));
  if (const int joint = first_other(faults, "OK"); joint >= 0) {
    return failure(problem(fmt::format("joint {} has a fault: {}", joint, quoted(faults)),
                           "the fault cleared at the control"));
  }
  if (is_switched_on) return {};
  PANELCAL_CHECK(take_errors());
  return failure(problem("the machine is switched off" +
                             (errors_.empty() ? std::string() : ": " + quoted(errors_, 300)),
                         "it switched on at the control"));
}

Expected<void> LinuxCncDrive::check_homed() {
  if (setting_.homing == Homing::None) return {};
  PANELCAL_TRY(const std::string homed, session_->get("joint_homed"));
  // Joints that the machine does not have are not homed either; what else it has, the control
  // itself wants homed before it takes an MDI line.
  if (homed.starts_with("YES YES YES")) return {};
  return failure(problem(fmt::format("joint {} is not homed", first_other(homed, "YES")),
                         "the machine homed at the control"));
}

Expected<std::string> LinuxCncDrive::rest_status() {
  const auto until = DriveClock::now() + kBegin;
  PANELCAL_TRY(std::string status, session_->get("program_status"));
  while (status == "RUNNING" && DriveClock::now() < until) {
    sleep_for(kLook);
    PANELCAL_TRY(status, session_->get("program_status"));
  }
  return status;
}

Expected<void> LinuxCncDrive::check_modes() {
  // The line that gave the operator's modes back may still be executed.
  PANELCAL_TRY(const std::string status, rest_status());
  if (status != "IDLE") {
    return failure(problem(status == "PAUSED" ? "it is paused" : "it executes something else",
                           "the program or MDI line ended, or aborted by the operator"));
  }
  PANELCAL_CHECK(session_->set("set_wait received"));
  PANELCAL_TRY(const bool may_set, session_->set("mode mdi"));
  PANELCAL_TRY(const std::string mode, session_->get("mode"));
  if (!may_set || mode != "MDI") {
    return failure(reason("it stays in mode " + quoted(mode)));
  }
  PANELCAL_TRY(const std::string codes, session_->get("program_codes"));
  if (has_code(codes, "G7")) {
    return failure(problem("X is a diameter (G7)", "G8 at the control"));
  }
  if (!has_code(codes, "G40")) {
    return failure(problem("cutter compensation is active: " + quoted(codes, 200),
                           "G40 at the control; G53 cannot be used with it"));
  }
  mm_per_word_ = has_code(codes, "G20") ? inch(1).in_mm() : 1.0;
  modes_ = has_code(codes, "G91") ? "G91" : "G90";
  for (const char* feed_mode : {" G93", " G94", " G95"}) {
    if (has_code(codes, feed_mode + 1)) modes_ += feed_mode;
  }
  return {};
}

std::string LinuxCncDrive::word(char letter, double value_mm) const {
  return letter + place_text(value_mm / mm_per_word_);
}

Expected<void> LinuxCncDrive::make_ready() {
  PANELCAL_CHECK(connect());
  // Errors from before are not of this move, but may be why the machine is off.
  errors_.clear();
  PANELCAL_CHECK(take_errors());
  PANELCAL_CHECK(check_switched_on());
  errors_.clear();
  PANELCAL_CHECK(check_homed());
  return check_modes();
}

Expected<void> LinuxCncDrive::take_errors() {
  for (int i = 0; i < kMostErrors; ++i) {
    auto error = session_->get("error");
    if (!error) return failure(std::move(error).error());
    if (*error == "OK") break;
    // The first one is the cause, as a rule.
    errors_ += (errors_.empty() ? "" : "; ") + *error;
  }
  return {};
}

Expected<void> LinuxCncDrive::check_cause() {
  PANELCAL_CHECK(check_switched_on());
  PANELCAL_CHECK(take_errors());
  if (!errors_.empty()) {
    return failure(
        problem("the control reports " + quoted(errors_, 300), "its cause removed at the control"));
  }
  PANELCAL_TRY(const bool is_enabled, is_on("enable", "ON"));
  if (!is_enabled) {
    return failure(problem("another client of linuxcncrsh has taken the control",
                           "no other client while panelcal works"));
  }
  PANELCAL_TRY(const std::string mode, session_->get("mode"));
  if (mode != "MDI") {
    return failure(problem("its mode was changed to " + quoted(mode),
                           "the control left to panelcal while it works"));
  }
  return {};
}

Diagnostic LinuxCncDrive::reason(std::string otherwise) {
  if (auto cause = check_cause(); !cause) return cause.error();
  return problem(std::move(otherwise), "the control left to panelcal while it works");
}

Expected<Eigen::Vector3d> LinuxCncDrive::position(const char* subject) {
  PANELCAL_TRY(const std::string answer, session_->get(subject));
  std::string_view text = answer;
  Eigen::Vector3d out;
  for (double& v : out) {
    const auto number = take_number(text);
    if (!number) {
      return failure(problem(fmt::format("answers {} to \"get {}\"", quoted(answer), subject),
                             "the places of X, Y and Z"));
    }
    v = *number * mm_per_unit_;
  }
  return out;
}

Expected<LinuxCncPlace> LinuxCncDrive::place() {
  LinuxCncPlace out;
  PANELCAL_TRY(out.command_mm, position("abs_cmd_pos"));
  PANELCAL_TRY(out.actual_mm, position("abs_act_pos"));
  return out;
}

Expected<LinuxCncPlace> LinuxCncDrive::rest(const Condition& is_there) {
  auto last_change = DriveClock::now();
  const auto until = last_change + std::chrono::duration<double>(setting_.limit.in_s());
  PANELCAL_TRY(LinuxCncPlace last, place());
  int n_settled = 0;
  bool has_begun = false;
  for (;;) {
    sleep_for(kLook);
    PANELCAL_TRY(const std::string status, session_->get("program_status"));
    PANELCAL_TRY(const LinuxCncPlace now, place());
    const auto time = DriveClock::now();
    if (status == "PAUSED") {
      return failure(problem("the move was paused", "no pause or feed hold while panelcal works"));
    }
    if (now.command_mm != last.command_mm) last_change = time;
    has_begun = has_begun || status != "IDLE" || now.command_mm != last.command_mm;
    const bool is_settled = (now.actual_mm - last.actual_mm).cwiseAbs().maxCoeff() <= kSettled_mm;
    const bool is_idle = status == "IDLE";
    last = now;
    bool has_arrived = false;
    if (is_idle) {
      PANELCAL_TRY(has_arrived, is_there(now));
    }
    n_settled = has_arrived && is_settled ? n_settled + 1 : 0;
    if (n_settled == kSettledLooks) return now;
    if (is_idle && !has_arrived && time - last_change > kEnded) {
      PANELCAL_CHECK(check_cause());
      if (!has_begun && time - last_change < kBegin) continue;
      return failure(problem("the move ended at " + axes_words(now),
                             "the control left to panelcal while it works"));
    }
    if (!is_idle && time - last_change > kHeld) {
      return failure(reason("the move does not go on from " + axes_words(now) +
                            ": feed hold, or an override of 0"));
    }
    if (time > until) {
      return failure(
          reason(fmt::format("the move did not end within {:g} s", setting_.limit.in_s())));
    }
  }
}

Expected<void> LinuxCncDrive::order(const std::string& line) {
  PANELCAL_TRY(const bool is_taken, session_->set("mdi " + line));
  if (!is_taken) return failure(reason("the control refuses " + quoted(line)));
  return {};
}

Expected<LinuxCncPlace> LinuxCncDrive::move(const std::string& line, const Condition& is_there) {
  is_in_motion_ = true;
  PANELCAL_CHECK(order(line));
  return rest(is_there);
}

Expected<LinuxCncPlace> LinuxCncDrive::drive_z(double z_mm) {
  return move("G90 G53 G0 " + word('Z', z_mm), [&](const LinuxCncPlace& at) {
    return std::abs(at.command_mm.z() - z_mm) <= kReached_mm;
  });
}

Expected<LinuxCncPlace> LinuxCncDrive::lift() {
  PANELCAL_TRY(LinuxCncPlace now, place());
  const double safe_mm = setting_.safe_z.in_mm();
  if (now.command_mm.z() >= safe_mm - kReached_mm) return now;
  return drive_z(safe_mm);
}

Expected<LinuxCncPlace> LinuxCncDrive::go(const Eigen::Vector2d& place_mm) {
  PANELCAL_CHECK(lift());
  const double feed_mm = setting_.move_feed_mm_min;
  const std::string how = feed_mm > 0 ? "G94 G1 " + word('F', feed_mm) : "G0";
  return move(
      fmt::format("G90 G53 {} {} {}", how, word('X', place_mm.x()), word('Y', place_mm.y())),
      [&](const LinuxCncPlace& at) {
        return (at.command_mm.head<2>() - place_mm).cwiseAbs().maxCoeff() <= kReached_mm;
      });
}

Expected<std::optional<double>> LinuxCncDrive::touch(const LinuxCncPlace& above) {
  const double from_mm = above.command_mm.z();
  const double depth_mm = from_mm - setting_.probe->to.in_mm();
  PANELCAL_TRY(const bool touches_already, is_on("probe_value", "1"));
  if (touches_already) {
    return failure(
        problem(fmt::format("the probe touches at Z {:g} already, where probing begins", from_mm),
                "a probe that is free there, and plugged in"));
  }
  PANELCAL_CHECK(session_->set("probe_clear"));
  bool is_tripped = false;
  PANELCAL_TRY(
      const LinuxCncPlace low,
      move("G91 G94 G38.3 " + word('Z', -depth_mm) + " " + word('F', setting_.probe->feed_mm_min),
           [&](const LinuxCncPlace& at) -> Expected<bool> {
             if (at.command_mm.z() >= from_mm) return false;
             PANELCAL_TRY(is_tripped, is_on("probe_tripped", "1"));
             return is_tripped || std::abs(at.command_mm.z() - from_mm + depth_mm) <= kReached_mm;
           }));
  if (!is_tripped) return std::optional<double>();
  // Up, by half the way, from #5063: where the command then stands tells #5063, whatever offsets
  // are active, and without a message of the control's that a screen may take away.
  const double low_mm = low.command_mm.z();
  const double up_mm = (from_mm - low_mm) / 2;
  PANELCAL_TRY(const LinuxCncPlace high,
               move(fmt::format("G91 G0 Z[#5063-#5422+{}]", place_text(up_mm / mm_per_word_)),
                    [&](const LinuxCncPlace& at) {
                      return at.command_mm.z() >= low_mm + up_mm - kReached_mm;
                    }));
  const double touch_mm = high.command_mm.z() - up_mm;
  if (touch_mm < low_mm - kReached_mm || touch_mm > from_mm + kReached_mm) {
    return failure(
        problem(fmt::format("#5063 says a touch at Z {:.4f}, outside of the probing move "
                            "from {:.4f} to {:.4f}",
                            touch_mm,
                            from_mm,
                            low_mm),
                "a control that keeps #5063"));
  }
  return std::optional(touch_mm);
}

template <class T>
Expected<T> LinuxCncDrive::guarded(const std::function<Expected<T>()>& moves) {
  PANELCAL_CHECK(make_ready());
  // M70 and M72 would round the feed.
  PANELCAL_CHECK(order("#<_panelcal_feed>=#<_feed>"));
  PANELCAL_TRY(const std::string status, rest_status());
  if (status != "IDLE") {
    return failure(
        reason(status == "PAUSED" ? "it is paused" : "it does not execute an MDI line: feed hold"));
  }
  Expected<T> out = moves();
  if (out) {
    is_in_motion_ = false;
    PANELCAL_CHECK(order(modes_ + kFeedAgain));
    return out;
  }
  if (!std::exchange(is_in_motion_, false)) return out;
  Diagnostic diagnostic = out.error();
  const std::string why = stop();
  if (why.empty()) {
    diagnostic.what += (diagnostic.what.empty() ? "" : "; ") + std::string("the machine stands");
  } else {
    diagnostic.what += (diagnostic.what.empty() ? "" : "; ") +
                       fmt::format("it could not be stopped ({}): it may still move", why);
    diagnostic.expected = "the machine stopped by hand";
  }
  return failure(std::move(diagnostic));
}

Expected<bool> LinuxCncDrive::stands_after_abort() {
  PANELCAL_CHECK(connect(false));
  session_->ignore_signals();
  PANELCAL_CHECK(session_->set("abort"));
  const auto until = DriveClock::now() + kLongestStop;
  PANELCAL_TRY(LinuxCncPlace last, place());
  while (DriveClock::now() < until) {
    // Not sleep_for, which a signal ends; the control renews its state in the task's cycle.
    std::this_thread::sleep_for(kStopLook);
    PANELCAL_TRY(const std::string status, session_->get("program_status"));
    PANELCAL_TRY(const bool is_switched_on, is_on("machine", "ON"));
    PANELCAL_TRY(const LinuxCncPlace now, place());
    const bool is_still = now.command_mm == last.command_mm;
    if (is_still && (status == "IDLE" || !is_switched_on)) return true;
    last = now;
  }
  return false;
}

std::string LinuxCncDrive::stop() {
  Expected<bool> stands = stands_after_abort();
  // A connection that is lost may come back as a new one.
  if (!stands) stands = stands_after_abort();
  if (!stands) return stands.error().what;
  if (!*stands) return "it does not stop within 2 s";
  // The operator's modes, as far as that can be: nothing moves by it.
  (void)session_->set("mdi " + modes_ + kFeedAgain);
  return {};
}

Expected<LinuxCncPlace> LinuxCncDrive::move_to(const Eigen::Vector2d& place_mm) {
  return guarded<LinuxCncPlace>([&] { return go(place_mm); });
}

Expected<std::optional<double>> LinuxCncDrive::touch_at(const Eigen::Vector2d& place_mm) {
  return guarded<std::optional<double>>([&]() -> Expected<std::optional<double>> {
    PANELCAL_CHECK(go(place_mm));
    PANELCAL_TRY(const LinuxCncPlace above, drive_z(setting_.probe->from.in_mm()));
    PANELCAL_TRY(const std::optional<double> touched_mm, touch(above));
    PANELCAL_CHECK(lift());
    return touched_mm;
  });
}

}  // namespace panelcal::internal
