// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/controls/grbl/talk.h"

#include <algorithm>
#include <chrono>

#include "machine/devices/controls/grbl/words.h"
#include <fmt/format.h>

namespace panelcal::grbl {
namespace {

constexpr char kResetByte = '\x18';

bool is_banner(std::string_view line) {
  return line.starts_with("Grbl ") || line.starts_with("GrblHAL ");
}

using TalkClock = std::chrono::steady_clock;

/// The time up to which something may last.
class Deadline {
 public:
  explicit Deadline(Time within)
      : until_(TalkClock::now() + std::chrono::duration_cast<TalkClock::duration>(
                                      std::chrono::duration<double>(within.in_s()))) {}
  Time left() const {
    const std::chrono::duration<double> left = until_ - TalkClock::now();
    return seconds(std::max(0.0, left.count()));
  }
  bool is_over() const { return TalkClock::now() >= until_; }

 private:
  TalkClock::time_point until_;
};

bool is_number(std::string_view text) {
  return !text.empty() && text.size() <= 4 &&
         std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
}

}  // namespace

Diagnostic Talk::problem(std::string what, std::string expected) const {
  return {Code::DeviceStage, {name(), 0, 0}, std::move(what), std::move(expected)};
}

Diagnostic Talk::refused(std::string what, std::string expected) const {
  if (!message_.empty()) what += "; it says " + quoted(message_);
  return problem(std::move(what), std::move(expected));
}

Expected<std::optional<Talk::Heard>> Talk::heard(std::string line) {
  if (line.empty() || line.starts_with("[echo:")) return std::optional<Heard>();
  if (line.starts_with("[MSG:")) {
    message_ = line.substr(5, line.size() - (line.ends_with(']') ? 6 : 5));
    return std::optional<Heard>();
  }
  if (line == "ok" || line.starts_with("error:") || is_banner(line)) is_unanswered_ = false;
  if (line == "ok") return Heard{Heard::Kind::Done, {}, {}};
  const std::string_view text = line;
  if (text.starts_with("error:") && is_number(text.substr(6))) {
    return failure(
        refused(fmt::format("refuses {}: {}", quoted(order_), error_words(text.substr(6))),
                "an order that the control carries out"));
  }
  if (text.starts_with("ALARM:") && is_number(text.substr(6))) {
    return failure(problem(alarm_words(text.substr(6)),
                           "the cause removed, and the alarm cleared at the control ($H or $X)"));
  }
  if (is_banner(text)) {
    return failure(problem("the control was reset", "a control that is not reset in a job"));
  }
  if (auto report = parse_report(line)) return Heard{Heard::Kind::Report, {}, *std::move(report)};
  const bool is_data = (text.starts_with('[') && text.ends_with(']')) || text.starts_with('$');
  if (is_data) return Heard{Heard::Kind::Data, std::move(line), {}};
  return failure(problem("answers " + quoted(line), "a line of GRBL 1.1, grblHAL or FluidNC"));
}

Expected<std::optional<Talk::Heard>> Talk::hear(Time within) {
  const Deadline deadline(within);
  for (;;) {
    PANELCAL_TRY(std::optional<std::string> line, link_->line(deadline.left()));
    if (!line) return std::optional<Heard>();
    PANELCAL_TRY(std::optional<Heard> one, heard(*std::move(line)));
    if (one) return one;
  }
}

Expected<Report> Talk::wake() {
  constexpr Time kAskAgain = seconds(0.5);
  const Deadline deadline(2 * patience_.answer);
  bool is_awake = false;
  while (!is_awake) {
    if (deadline.is_over()) {
      return failure(problem("the control does not answer to \"?\"",
                             "GRBL 1.1, grblHAL or FluidNC, with this baud rate"));
    }
    PANELCAL_CHECK(link_->send("?"));
    for (const Deadline next(kAskAgain); !is_awake && !next.is_over() && !deadline.is_over();) {
      PANELCAL_TRY(const auto line, link_->line(next.left()));
      has_greeted_ = has_greeted_ || (line && is_banner(*line));
      is_awake = line && parse_report(*line);
    }
  }
  // Ends a line that another program has left half written, and makes it one that is not carried
  // out; alone it asks for help. Its answer is the end of the old talk.
  PANELCAL_CHECK(link_->send("$\n"));
  bool has_answered = false;
  for (const Deadline silence(patience_.answer); !silence.is_over();) {
    PANELCAL_TRY(const auto line, link_->line(has_answered ? patience_.quiet : silence.left()));
    if (!line && has_answered) return report();
    has_greeted_ = has_greeted_ || (line && is_banner(*line));
    has_answered = has_answered || (line && (*line == "ok" || line->starts_with("error:")));
  }
  return failure(has_answered
                     ? problem("the control does not stop talking", "no other program that uses it")
                     : problem("no answer to \"$\"", "\"ok\" or \"error:N\""));
}

Expected<void> Talk::send(const std::string& line) {
  order_ = line;
  is_unanswered_ = true;
  message_.clear();
  return link_->send(line + "\n");
}

Expected<std::vector<std::string>> Talk::order(const std::string& line, Time limit) {
  constexpr Time kAskWhy = seconds(1);
  PANELCAL_CHECK(send(line));
  std::vector<std::string> lines;
  for (const Deadline deadline(limit); !deadline.is_over();) {
    PANELCAL_TRY(std::optional<Heard> one, hear(std::min(kAskWhy, deadline.left())));
    if (!one) {
      PANELCAL_CHECK(link_->send("?"));
    } else if (one->kind == Heard::Kind::Done) {
      return lines;
    } else if (one->kind == Heard::Kind::Data) {
      lines.push_back(std::move(one->text));
    } else if (one->report.is("Hold") || one->report.is("Door")) {
      return failure(problem(
          fmt::format("the control is {} at {}", state_words(one->report.state), quoted(line)),
          "an order that nothing stops"));
    }
  }
  return failure(problem(fmt::format("no answer to {} within {} s", quoted(line), limit.in_s()),
                         "\"ok\" or \"error:N\""));
}

Expected<Report> Talk::report() {
  // What has come by itself is older than the question.
  bool has_asked = false;
  const Deadline deadline(patience_.answer);
  for (;;) {
    PANELCAL_TRY(std::optional<Heard> one, hear(has_asked ? deadline.left() : Time()));
    if (one && one->kind == Heard::Kind::Report) {
      if (has_asked) return std::move(one->report);
    } else if (one) {
      return failure(problem(
          fmt::format("answers {} to no order", quoted(one->text.empty() ? "ok" : one->text)),
          "no other program that uses the control"));
    } else if (has_asked) {
      return failure(problem(fmt::format("no answer to \"?\" within {} s", patience_.answer.in_s()),
                             "a report, <...>"));
    } else {
      PANELCAL_CHECK(link_->send("?"));
      has_asked = true;
    }
  }
}

Expected<void> Talk::reset() {
  PANELCAL_CHECK(send_now(kResetByte));
  for (const Deadline deadline(patience_.answer); !deadline.is_over();) {
    PANELCAL_TRY(const auto line, link_->line(deadline.left(), false));
    if (line && is_banner(*line)) break;
  }
  is_unanswered_ = false;
  return {};
}

Expected<std::optional<Report>> Talk::last_report(Time within) {
  PANELCAL_CHECK(link_->send("?"));
  const Deadline deadline(within);
  for (;;) {
    PANELCAL_TRY(const std::optional<std::string> line, link_->line(deadline.left(), false));
    if (!line) return std::optional<Report>();
    if (*line == "ok" || line->starts_with("error:")) is_unanswered_ = false;
    if (auto report = parse_report(*line)) return report;
  }
}

}  // namespace panelcal::grbl
