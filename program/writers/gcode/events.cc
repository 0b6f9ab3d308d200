// SPDX-License-Identifier: Apache-2.0
// Stops, messages and the machine's own events in G-code.
#include <algorithm>
#include <string>

#include "program/model/tool_links.h"
#include "program/writers/foreign_settings.h"
#include "program/writers/gcode/writer.h"
#include <fmt/format.h>

namespace panelcal {

std::string GcodeWriter::shown(std::string_view words) const {
  std::string out = printable(words);
  std::ranges::replace_if(
      out, [this](char c) { return wording_.reserved.find(c) != std::string_view::npos; }, '.');
  return out;
}

/// A long one goes on in further lines.
void GcodeWriter::comment(std::string_view words) {
  std::string rest = shown(words);
  do {
    line("; " + rest.substr(0, wording_.max_text));
    rest.erase(0, wording_.max_text);
  } while (!rest.empty());
}

/// A bracket would end it.
void GcodeWriter::say_message(std::string_view words) {
  std::string rest = shown(words);
  std::ranges::replace(rest, '(', '[');
  std::ranges::replace(rest, ')', ']');
  do {
    line(fmt::format(
        "{}{}{}", wording_.message, rest.substr(0, wording_.max_text), wording_.message_end));
    rest.erase(0, wording_.max_text);
  } while (!rest.empty());
}

/// Up, and where the operator is to find the tool. Behind a change of tool it stands well.
void GcodeWriter::park(const std::optional<Position<frame::Machine>>& place) {
  leave_cycle();
  if (height_ != Height::Unknown || place) {
    if (height_ == Height::Down || height_ == Height::Unknown) rise();
    if (setting_.change_z && *setting_.change_z > setting_.safe_z && height_ != Height::Change) {
      say_rapid(word('Z', steps(setting_.change_z->in_mm())));
      height_ = Height::Change;
    }
  }
  stop_spindle();
  if (!place) return;
  told_ = place_of(*place);
  say_rapid(words(*told_));
}

/// For an operator, who may put a hand between.
void GcodeWriter::pause(std::string_view code,
                        const std::optional<Position<frame::Machine>>& place) {
  if (height_ == Height::Down && !has_ended_) {
    refuse("a stop or a message inside a contour, where the tool would be raised",
           "it before the contour, or behind");
  }
  park(place);
  if (!code.empty()) line(code);
  forget_feed();
}

/// A program behind % of the header waits for START anyway.
void GcodeWriter::write(const Stop& stop) {
  switch (stop.kind) {
    case StopKind::HeaderEnd:
      return;
    case StopKind::Inspection:
      return pause("M0", stop.actual);
    case StopKind::Optional:
      return pause(wording_.optional_stop, stop.actual);
    case StopKind::EndAccepted:
      comment(kEndAcceptedComment);
      [[fallthrough]];
    case StopKind::EndNoRewind:
    case StopKind::EndRewind:
      has_ended_ = true;
      return pause(wording_.end, stop.actual);
  }
}

void GcodeWriter::write(const Message& message) {
  std::string_view rest = words_of(message.text);
  leave_cycle();
  while (true) {
    const auto end = rest.find('\n');
    say_message(rest.substr(0, end));
    if (end == std::string_view::npos) break;
    rest.remove_prefix(end + 1);
  }
  pause("M0");
}

/// This control does not count hits, so that the change has to be said.
void GcodeWriter::change_expired(const Function& expired) {
  if (!expired.next_tool) {
    park({});
    say_message(fmt::format("T{} is used up: a fresh one", expired.tool));
    pause("M0");
    height_ = Height::Unknown;
    told_.reset();
    return;
  }
  const auto known = info().tools.find(*expired.next_tool);
  Tool next = known != info().tools.end() ? known->second : tool_;
  next.number = *expired.next_tool;
  take(next);
}

void GcodeWriter::write(const Function& function) {
  switch (function.kind) {
    case FunctionKind::ToolExpired:
      return change_expired(function);
    case FunctionKind::PeckOn:
    case FunctionKind::PulseOn:
      pecking_ = function.kind == FunctionKind::PeckOn ? Pecking::Retracting : Pecking::Pulsing;
      // M62 says nothing but that.
      if (function.text.size() > 3) {
        lose_once(fmt::format("the strokes of {}, for which peck_mm of [gcode] holds,",
                              quoted(function.text)));
      }
      return;
    case FunctionKind::PeckOff:
    case FunctionKind::PulseOff:
      pecking_ = Pecking::Off;
      return;
    case FunctionKind::ScalingOn:
      if (function.text.empty()) return;  // it is in the coordinates
      return refuse("reference scaling (" + std::string(function.text) + ")",
                    "[reference_scaling] in machine.toml");
    case FunctionKind::ScalingOff:
      return;
    default:
      if (function.text.empty()) return;  // the control does it by itself
      return lose(fmt::format("{} ({})", quoted(function.text), name(function.kind)));
  }
}

void GcodeWriter::write(const Setting& setting) {
  if (setting.kind == SettingKind::Vision) return lose_vision(setting);
  if (info().dialect == Dialect::SiebMeyer) {
    constexpr std::string_view kCommand = "M49,";
    if (setting.text.starts_with(kCommand)) {
      const std::string_view command = setting.text.substr(kCommand.size());
      if (is_obeyed(command) || is_initial(command, setting.unit)) return;
    }
    return lose(quoted(setting.text));
  }
  const std::string_view key = setting_key(setting.text);
  if (is_spelling(key) || is_tool_link(setting.text) || setting.text == "/") return;
  if (decides_places(key)) {
    return refuse(quoted(setting.text), "[gcode] of machine.toml, which states depths");
  }
  lose(quoted(setting.text));
}

void GcodeWriter::refuse_structure() {
  fail({Code::Internal, place(), "a pattern or a target in G-code", "programs that are executed"});
}

}  // namespace panelcal
