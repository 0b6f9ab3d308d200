// SPDX-License-Identifier: Apache-2.0
// Lines of the G-code output, and the tool's way from one job to the next.
#include <array>
#include <cmath>
#include <string>

#include "program/writers/gcode/writer.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr double kStepsPerMm = 1e6;  // kMmDecimals
/// Centres of arcs may be far away; numbers with this many decimals are still exact.
constexpr double kMost_mm = 1e9;

std::string number(double value, int n_decimals) {
  std::array<char, kFixedChars> chars;
  return {chars.data(), write_fixed(chars.data(), value, n_decimals)};
}

}  // namespace

GcodeWriter::Steps GcodeWriter::steps(double value_mm) {
  if (std::abs(value_mm) < kMost_mm) return std::llround(value_mm * kStepsPerMm);
  fail({Code::Internal,
        place(),
        fmt::format("a coordinate of {} mm", value_mm),
        fmt::format("one below {:g} mm", kMost_mm)});
  return 0;
}

/// Counted from one zero all along, so that nothing in the program shifts coordinates: work zero,
/// which counts from absolute zero.
Eigen::Vector2d GcodeWriter::from_zero_mm(const Position<frame::Machine>& actual) const {
  return (actual - options().absolute_zero).in_mm() - options().work_zero.in_mm();
}

GcodeWriter::Place GcodeWriter::place_of(const Position<frame::Machine>& actual) {
  const Eigen::Vector2d at_mm = from_zero_mm(actual);
  return {steps(at_mm.x()), steps(at_mm.y())};
}

Eigen::Vector2d GcodeWriter::in_mm(const Place& at) {
  return {static_cast<double>(at[0]) / kStepsPerMm, static_cast<double>(at[1]) / kStepsPerMm};
}

std::string GcodeWriter::word(char letter, Steps value) const {
  return letter + number(static_cast<double>(value) / kStepsPerMm, kMmDecimals);
}

std::string GcodeWriter::words(const Place& at) const {
  return word('X', at[0]) + ' ' + word('Y', at[1]);
}

/// A cutting move, with the feed where it changes; before it where a line would be too long.
void GcodeWriter::say_move(std::string_view code, std::string_view rest, Feed feed) {
  const std::string rate = "F" + number(feed.in_mm_s() * 60, kMmDecimals);
  std::string block(code);
  block += ' ';
  block += rest;
  if (rate != feed_) {
    if (block.size() + 1 + rate.size() <= wording_.max_characters) {
      block += ' ' + rate;
    } else {
      line(wording_.is_one_command_a_line ? "G1 " + rate : rate);
    }
  }
  feed_ = rate;
  line(block);
}

void GcodeWriter::say_rapid(std::string_view rest) {
  if (wording_.rapids_need_a_feed) return say_move("G0", rest, *setting_.rapid);
  line(fmt::format("G0 {}", rest));
}

/// An operator may jog during a pause: Marlin then goes on with the feed of the jog.
void GcodeWriter::forget_feed() {
  if (wording_.rapids_need_a_feed) feed_.clear();
}

void GcodeWriter::leave_cycle() {
  if (cycle_.empty()) return;
  cycle_.clear();
  line("G80");
}

/// To where the tool may go anywhere. Nothing moves sideways before.
void GcodeWriter::rise() {
  if (height_ == Height::Safe) return;
  leave_cycle();
  say_rapid(word('Z', steps(setting_.safe_z.in_mm())));
  height_ = Height::Safe;
  told_z_.reset();
}

/// With the tool up.
void GcodeWriter::go_to(const Place& at) {
  leave_cycle();
  rise();
  if (told_ != at) say_rapid(words(at));
  told_ = at;
}

/// False if its speed is unknown.
bool GcodeWriter::start_spindle() {
  if (spindle_runs_) return true;
  if (!work_.speed) {
    refuse_unsaid(fmt::format("T{} has no spindle speed", tool_.number),
                  "S of the tool, or speed_rpm in [gcode] or [[gcode.tool]]");
    return false;
  }
  leave_cycle();
  const std::string speed = 'S' + number(work_.speed->in_rpm(), 3);
  line(wording_.is_one_command_a_line ? "M3 " + speed : speed + " M3");
  if (setting_.spin_up) {
    line(std::string(wording_.dwell) + number(setting_.spin_up->in_s(), 3));
  }
  spindle_runs_ = true;
  return true;
}

void GcodeWriter::stop_spindle() {
  if (!spindle_runs_) return;
  line("M5");
  spindle_runs_ = false;
}

}  // namespace panelcal
