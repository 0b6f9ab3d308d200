// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/options/parse_problem.h"

#include <optional>
#include <utility>
#include <vector>

namespace panelcal {
namespace {

/// The parts of `text` around the first `middle`.
std::optional<std::pair<std::string_view, std::string_view>> split_at(std::string_view text,
                                                                      std::string_view middle) {
  const auto at = text.find(middle);
  if (at == text.npos) return std::nullopt;
  return std::pair(text.substr(0, at), text.substr(at + middle.size()));
}

/// A list of CLI11, `a,b,c` up to a closing bracket, as `"a", "b", "c"`.
std::string quoted_list(std::string_view list) {
  list = list.substr(0, list.find_first_of("]}"));
  std::string out;
  while (!list.empty()) {
    const auto comma = list.find(',');
    if (!out.empty()) out += ", ";
    out += quoted(list.substr(0, comma));
    list.remove_prefix(comma == list.npos ? list.size() : comma + 1);
  }
  return out;
}

/// A mistake and its remedy.
struct Problem {
  std::string what;
  std::string expected;
};

Problem unexpected(std::span<const std::string> extras) {
  Problem problem{extras.size() == 1 ? "unknown argument " : "unknown arguments ", ""};
  for (std::size_t i = 0; i < extras.size(); ++i) {
    problem.what += (i == 0 ? "" : " ") + quoted(extras[i]);
  }
  return problem;
}

std::optional<Problem> missing(std::string_view text) {
  if (const auto list = split_at(text, "Exactly 1 option from [")) {
    const bool are_several = text.find("were given") != text.npos;
    return Problem{are_several ? "arguments that exclude each other" : "missing argument",
                   "one of " + quoted_list(list->second)};
  }
  if (const auto list = split_at(text, "options be given from [")) {
    return Problem{"options that exclude each other", "one of " + quoted_list(list->second)};
  }
  if (const auto name = split_at(text, " is required")) {
    return Problem{"missing " + quoted(name->first), ""};
  }
  return std::nullopt;
}

std::optional<Problem> invalid(std::string_view text) {
  const auto name = split_at(text, ": ");
  if (!name) return std::nullopt;
  const std::string option = std::string(name->first) + ' ';
  if (const auto words = split_at(name->second, " not in {")) {
    return Problem{option + quoted(words->first), "one of " + quoted_list(words->second)};
  }
  if (const auto range = split_at(name->second, " not in range ")) {
    std::string_view value = range->first;
    if (value.starts_with("Value ")) value.remove_prefix(6);
    return Problem{option + quoted(value), std::string(range->second)};
  }
  return std::nullopt;
}

std::optional<Problem> conflict(std::string_view text) {
  if (const auto names = split_at(text, " requires ")) {
    return Problem{quoted(names->first) + " without " + quoted(names->second), "both"};
  }
  if (const auto names = split_at(text, " excludes ")) {
    return Problem{quoted(names->first) + " together with " + quoted(names->second), "one of them"};
  }
  return std::nullopt;
}

std::optional<Problem> unreadable(std::string_view text) {
  const auto pair = split_at(text, "Could not convert: ");
  if (!pair) return std::nullopt;
  const auto value = split_at(pair->second, " = ");
  if (!value) return std::nullopt;
  return Problem{std::string(value->first) + ' ' + quoted(value->second), "a number"};
}

std::optional<Problem> problem_of(std::string_view kind,
                                  std::string_view text,
                                  std::span<const std::string> extras) {
  if (!extras.empty()) return unexpected(extras);
  if (kind == "RequiredError") return missing(text);
  if (kind == "ValidationError") return invalid(text);
  if (kind == "RequiresError" || kind == "ExcludesError") return conflict(text);
  if (kind == "ConversionError") return unreadable(text);
  return std::nullopt;
}

}  // namespace

Diagnostic parse_problem(std::string_view kind,
                         std::string_view text,
                         std::span<const std::string> extras,
                         const std::string& command) {
  Problem problem = problem_of(kind, text, extras).value_or(Problem{std::string(text), ""});
  if (problem.expected.empty()) {
    std::string page = command;
    if (const auto name = command.find(' '); name != command.npos)
      page.insert(name, " help");
    else
      page += " help";
    problem.expected = "an argument that `" + page + "` lists";
  }
  return {Code::Usage, {command, 0, 0}, std::move(problem.what), std::move(problem.expected)};
}

}  // namespace panelcal
