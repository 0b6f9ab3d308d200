// SPDX-License-Identifier: Apache-2.0
#include "calib/base/fields/field.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal::internal {

std::string Range::text() const {
  const bool has_low = std::isfinite(low);
  const bool has_high = std::isfinite(high);
  if (has_low && has_high && !low_is_open) return fmt::format("a number from {} to {}", low, high);
  std::string out = has_high ? "a number" : "a finite number";
  if (has_low) out += fmt::format(" {} {}", low_is_open ? "above" : "from", low);
  if (has_high) out += fmt::format("{} at most {}", has_low ? " and" : "", high);
  return out;
}

std::string WholeRange::text() const {
  return fmt::format("a whole number from {} to {}", low, high);
}

std::string Field::takes() const {
  switch (kind) {
    case FieldKind::Truth:
      return "true or false";
    case FieldKind::Whole:
      return whole.text();
    case FieldKind::Number:
      return range.text();
    case FieldKind::Limit:
      return range.text() + ", or \"off\"";
    case FieldKind::Pair:
      return "two numbers, [x, y]";
    case FieldKind::Numbers:
      return n_rows > 0 ? fmt::format("an array of {} numbers", n_rows)
                        : "a list of numbers, [1, 2]";
    case FieldKind::Text:
      return "a text in quotes";
    case FieldKind::Word:
    case FieldKind::Form:
      return std::string(expected);
    case FieldKind::File:
      return "the name of a file";
    case FieldKind::Folder:
      return "the name of a folder";
    case FieldKind::Texts:
      return "a list of texts, [\"a\", \"b\"]";
    case FieldKind::WallTime:
      return "a date and a time without a zone, such as 2026-11-21T08:00:00, no quotes";
    case FieldKind::Time:
      return "a time such as 2026-11-21T08:37:38Z";
    case FieldKind::Counter:
      return fmt::format("a whole number from 0 to {}", std::numeric_limits<std::uint64_t>::max());
    case FieldKind::Wholes:
      return fmt::format("an array, each {}", whole.text());
    case FieldKind::Matrix:
      if (n_columns == 0) return "as many arrays of numbers as each has numbers";
      return fmt::format(
          "{}arrays of {} numbers", n_rows > 0 ? fmt::format("{} ", n_rows) : "", n_columns);
    case FieldKind::Object:
      return "an object, {...}";
    case FieldKind::Objects:
      return "an array of objects, [{...}, ...]";
    case FieldKind::Any:
      return "anything";
  }
  return {};
}

std::string TableDescription::initial_text(const Field& field) const {
  FieldValue value;
  if (initial == nullptr || !initial(field, value)) return {};
  // As written: all units are proportional to those that are stored.
  const auto written = [&](double stored) {
    return fmt::format("{:.6g}", stored / field.unit.stored(1) + 0.0);
  };
  switch (field.kind) {
    case FieldKind::Truth:
      return value.truth ? "true" : "false";
    case FieldKind::Whole:
      return fmt::format("{}", value.whole);
    case FieldKind::Number:
    case FieldKind::Limit:
      return written(value.number);
    case FieldKind::Pair:
    case FieldKind::Numbers: {
      std::vector<std::string> all;
      for (const double one : value.numbers) all.push_back(written(one));
      return fmt::format("[{}]", fmt::join(all, ", "));
    }
    case FieldKind::Text:
    case FieldKind::File:
      return fmt::format("\"{}\"", value.text);
    default:
      return {};
  }
}

std::string TableDescription::heading() const {
  return rows == Rows::Many ? fmt::format("[[{}]]", name) : fmt::format("[{}]", name);
}

std::string_view TableDescription::parent() const {
  const std::size_t dot = name.rfind('.');
  return dot == std::string_view::npos ? std::string_view() : name.substr(0, dot);
}

std::string_view TableDescription::key() const {
  const std::size_t dot = name.rfind('.');
  return dot == std::string_view::npos ? name : name.substr(dot + 1);
}

std::vector<std::string_view> FileDescription::known_keys(std::string_view table) const {
  std::vector<std::string_view> known;
  for (const TableDescription* const one : tables) {
    if (one->name == table) {
      for (const Field& field : one->fields) known.push_back(field.key);
    } else if (one->parent() == table) {
      known.push_back(one->key());
    }
  }
  std::ranges::sort(known);
  return known;
}

}  // namespace panelcal::internal
