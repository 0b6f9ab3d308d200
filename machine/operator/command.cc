// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/command.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <initializer_list>
#include <utility>

#include "calib/base/json/strict_json.h"
#include "machine/operator/settings.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal::internal {
namespace {

constexpr const char* kCommand = "command";
constexpr std::array<std::string_view, 9> kChoiceNames = {
    "again", "search", "candidate", "hand", "skip", "leave_board_out", "keep", "done", "stop"};
constexpr std::array<std::string_view, 10> kOrderNames = {
    "open", "close", "start", "resume", "stop", "answer", "jog", "write", "calibrate", "roll_back"};
/// Longer names and reasons say nothing more.
constexpr std::size_t kMaxText = 1000;
constexpr std::size_t kMaxWho = 100;
/// No picture is wider, no jog longer, no lamp brighter.
constexpr double kMaxNumber = 1e6;

/// The members of a command, each of which may be asked for in one form.
class Members {
 public:
  explicit Members(const nlohmann::json& object) : object_(object) {}

  Expected<void> check_keys(std::initializer_list<std::string_view> known) const {
    for (const auto& [key, value] : object_.items()) {
      const bool is_known = std::ranges::find(known, key) != known.end();
      if (!is_known) {
        return failure(refused("key " + quoted(key), fmt::format("{}", fmt::join(known, ", "))));
      }
    }
    return {};
  }

  bool has(const char* key) const { return object_.contains(key) && !object_[key].is_null(); }

  Expected<std::string> text(const char* key) const {
    const bool is_text = has(key) && object_[key].is_string();
    if (is_text) {
      std::string out = object_[key].get<std::string>();
      const bool is_line = escaped_controls(out) == out;
      if (!out.empty() && out.size() <= kMaxText && is_line) return out;
    }
    return failure(wrong(key, fmt::format("a text in one line of 1 to {} bytes", kMaxText)));
  }
  Expected<double> number(const char* key) const {
    if (has(key)) {
      if (const auto value = number_of(object_[key])) return *value;
    }
    return failure(wrong(key, "a number"));
  }
  Expected<std::int64_t> count(const char* key) const {
    const bool is_count = has(key) && object_[key].is_number_integer();
    if (is_count && object_[key] >= 0 && object_[key] <= std::int64_t{1} << 53) {
      return object_[key].get<std::int64_t>();
    }
    return failure(wrong(key, "an integer from 0"));
  }
  /// [x, y]
  Expected<Eigen::Vector2d> point(const char* key) const {
    const bool is_pair = has(key) && object_[key].is_array() && object_[key].size() == 2;
    if (is_pair) {
      const auto x = number_of(object_[key][0]);
      const auto y = number_of(object_[key][1]);
      if (x && y) return Eigen::Vector2d(*x, *y);
    }
    return failure(wrong(key, "[x, y]"));
  }

  Diagnostic wrong(const char* key, std::string expected) const {
    const std::string value = object_.contains(key) ? object_[key].dump() : "nothing";
    return refused(fmt::format("{}: {}", key, quoted(value)), std::move(expected));
  }

 private:
  static std::optional<double> number_of(const nlohmann::json& value) {
    if (!value.is_number()) return std::nullopt;
    const double number = value.get<double>();
    return std::abs(number) <= kMaxNumber ? std::optional(number) : std::nullopt;
  }

  const nlohmann::json& object_;
};

template <class Enum, std::size_t N>
std::optional<Enum> from_name(const std::array<std::string_view, N>& names, std::string_view name) {
  const auto found = std::ranges::find(names, name);
  if (found == names.end()) return std::nullopt;
  return static_cast<Enum>(found - names.begin());
}

Expected<Answer> read_answer(const Members& members) {
  Answer answer;
  PANELCAL_TRY(const std::int64_t question, members.count("question"));
  answer.question = static_cast<int>(std::min<std::int64_t>(question, 1 << 30));
  PANELCAL_TRY(const std::string word, members.text("choice"));
  const auto choice = choice_from_name(word);
  if (!choice) {
    return failure(members.wrong("choice", fmt::format("{}", fmt::join(kChoiceNames, ", "))));
  }
  answer.choice = *choice;
  if (*choice == Choice::Search || *choice == Choice::Hand) {
    PANELCAL_CHECK(members.check_keys({"do", "question", "choice", "at_px", "frame"}));
    PANELCAL_TRY(answer.at_px, members.point("at_px"));
    if (members.has("frame")) {
      PANELCAL_TRY(const std::int64_t frame, members.count("frame"));
      answer.frame = static_cast<std::uint64_t>(frame);
    }
    return answer;
  }
  if (*choice == Choice::Candidate) {
    PANELCAL_CHECK(members.check_keys({"do", "question", "choice", "index"}));
    PANELCAL_TRY(const std::int64_t index, members.count("index"));
    answer.index = static_cast<std::size_t>(index);
    return answer;
  }
  if (*choice != Choice::Again) {
    PANELCAL_CHECK(members.check_keys({"do", "question", "choice"}));
    return answer;
  }
  PANELCAL_CHECK(members.check_keys({"do", "question", "choice", "lamp", "exposure"}));
  if (members.has("exposure")) {
    PANELCAL_TRY(answer.exposure_us, members.number("exposure"));
  }
  if (members.has("lamp")) {
    PANELCAL_TRY(answer.lamp, members.number("lamp"));
  }
  return answer;
}

/// The ledger's number of an entry, as a number or as text.
Expected<std::int64_t> read_entry(const Members& members) {
  if (const auto number = members.count("to")) return *number;
  PANELCAL_TRY(const std::string text, members.text("to"));
  std::int64_t entry = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), entry);
  if (error == std::errc() && end == text.data() + text.size() && entry >= 0) return entry;
  return failure(members.wrong("to", "the number of an entry of the ledger"));
}

/// The name stands in measurements, in the ledger, and in comments of programs: one line, in any
/// language.
Expected<void> check_who(const std::string& who) {
  const bool is_line = !who.empty() && who.size() <= kMaxWho && escaped_controls(who) == who;
  if (is_line) return {};
  return failure(refused("name " + quoted(who),
                         fmt::format("a person's name in one line of 1 to {} bytes", kMaxWho)));
}

/// Reads the members that an order has, each as a key of its own.
Expected<void> read_members(const Members& members, Command& out) {
  const auto text = [&](const char* key, std::string& into) -> Expected<void> {
    PANELCAL_TRY(into, members.text(key));
    return {};
  };
  switch (out.order) {
    case Order::Open:
      PANELCAL_CHECK(members.check_keys({"do", "program"}));
      return text("program", out.name);
    case Order::Write:
      PANELCAL_CHECK(members.check_keys({"do", "name"}));
      return text("name", out.name);
    case Order::Calibrate:
      PANELCAL_CHECK(members.check_keys({"do", "kind"}));
      return text("kind", out.name);
    case Order::RollBack: {
      PANELCAL_CHECK(members.check_keys({"do", "kind", "to", "reason"}));
      PANELCAL_CHECK(text("kind", out.name));
      PANELCAL_CHECK(text("reason", out.reason));
      PANELCAL_TRY(out.to, read_entry(members));
      return {};
    }
    case Order::Jog: {
      PANELCAL_CHECK(members.check_keys({"do", "by_mm"}));
      PANELCAL_TRY(out.by_mm, members.point("by_mm"));
      return {};
    }
    case Order::Answer: {
      PANELCAL_TRY(out.answer, read_answer(members));
      return {};
    }
    default:
      return members.check_keys({"do"});
  }
}

}  // namespace

std::string_view name(Choice choice) {
  return kChoiceNames[static_cast<std::size_t>(choice)];
}

std::optional<Choice> choice_from_name(std::string_view name) {
  return from_name<Choice>(kChoiceNames, name);
}

Diagnostic refused(std::string what, std::string expected) {
  return {Code::Usage, {kCommand, 0, 0}, std::move(what), std::move(expected)};
}

Expected<Command> parse_command(std::string_view text, const std::string& who) {
  if (text.size() > kMaxCommandBytes) {
    return failure(refused(fmt::format("a command of {} bytes", text.size()),
                           fmt::format("at most {}", kMaxCommandBytes)));
  }
  PANELCAL_CHECK(check_who(who));
  PANELCAL_TRY(const nlohmann::json object, parse_strict_json(text, kCommand));
  if (!object.is_object()) return failure(refused("no object", "{\"do\": ...}"));
  const Members members(object);
  PANELCAL_TRY(const std::string word, members.text("do"));
  const auto order = from_name<Order>(kOrderNames, word);
  if (!order) return failure(members.wrong("do", fmt::format("{}", fmt::join(kOrderNames, ", "))));
  Command out;
  out.order = *order;
  out.who = who;
  PANELCAL_CHECK(read_members(members, out));
  out.answer.who = who;
  return out;
}

}  // namespace panelcal::internal
