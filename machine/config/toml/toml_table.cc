// SPDX-License-Identifier: Apache-2.0
#include "machine/config/toml/toml_table.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <utility>

#include "calib/base/clock.h"
#include "calib/base/units.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

/// Line `number` (from 1) of a text, without its line end.
std::string_view line_of(std::string_view text, std::size_t number) {
  for (; number > 1; --number) {
    const std::size_t end = text.find('\n');
    if (end == std::string_view::npos) return {};
    text.remove_prefix(end + 1);
  }
  text = text.substr(0, text.find('\n'));
  if (text.ends_with('\r')) text.remove_suffix(1);
  return text;
}

/// The byte at which code point number `column` (from 1) begins; toml++ counts code points.
std::size_t byte_of_column(std::string_view line, std::size_t column) {
  std::size_t i = 0;
  while (i < line.size() && column > 1) {
    ++i;
    while (i < line.size() && (static_cast<unsigned char>(line[i]) & 0xC0) == 0x80) ++i;
    --column;
  }
  return i;
}

std::optional<std::size_t> line_too_long(std::string_view text) {
  std::size_t number = 1;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    if (std::min(end, text.size()) > kMaxTomlLine) return number;
    if (end == std::string_view::npos) break;
    text.remove_prefix(end + 1);
    ++number;
  }
  return std::nullopt;
}

/// The parser quotes what it met as it is, which may be anything.
std::string printable(std::string_view words) {
  std::string clean(words.substr(0, 200));
  for (char& c : clean) {
    if (c < 0x20 || c > 0x7e) c = '?';
  }
  return clean;
}

}  // namespace

Place TomlSource::place(const toml::source_position& at) const {
  return {file, static_cast<int>(at.line), static_cast<int>(at.column)};
}

std::string TomlSource::excerpt(const toml::source_region& region) const {
  const std::string_view line = line_of(text, region.begin.line);
  const std::size_t begin = byte_of_column(line, region.begin.column);
  const std::size_t end =
      region.end.line == region.begin.line ? byte_of_column(line, region.end.column) : line.size();
  // Without quotes of our own: "3" and 3 are different things in TOML.
  const std::string text_of_it = quoted(line.substr(begin, end > begin ? end - begin : 0));
  return text_of_it.substr(1, text_of_it.size() - 2);
}

Expected<toml::table> parse_toml(const TomlSource& source) {
  if (const auto line = line_too_long(source.text)) {
    return failure({Code::TomlSyntax,
                    {source.file, static_cast<int>(*line), 1},
                    "the line is too long",
                    fmt::format("at most {} bytes", kMaxTomlLine)});
  }
  try {
    return toml::parse(source.text, std::string_view(source.file));
  } catch (const toml::parse_error& error) {
    return failure(
        {Code::TomlSyntax, source.place(error.source().begin), printable(error.description()), ""});
  } catch (const std::exception& error) {
    return failure({Code::TomlSyntax, {source.file, 0, 0}, printable(error.what()), ""});
  }
}

TomlTable::TomlTable(const toml::table& table,
                     std::string name,
                     const FileDescription& file,
                     const TomlSource& source)
    : table_(&table), name_(std::move(name)), file_(&file), source_(&source) {
}

Expected<TomlTable> TomlTable::make(const toml::table& table,
                                    std::string name,
                                    std::string_view path,
                                    std::string_view planned,
                                    const FileDescription& file,
                                    const TomlSource& source) {
  const std::vector<std::string_view> known = file.known_keys(path);
  for (const auto& [key, value] : table) {
    const std::string_view word = key.str();
    if (std::ranges::find(known, word) != known.end()) continue;
    const Place place = source.place(key.source().begin);
    if (!planned.empty() && word == planned) {
      return failure(
          {Code::NotSupported, place, quoted(word) + " in " + name, "a file without it"});
    }
    const std::string_view nearest = nearest_word(word, known);
    return failure({Code::ConfigKeyUnknown,
                    place,
                    quoted(word) + " in " + name,
                    nearest.empty() ? fmt::format("one of {}", fmt::join(known, ", "))
                                    : "did you mean " + quoted(nearest) + "?"});
  }
  return TomlTable(table, std::move(name), file, source);
}

Expected<TomlTable> TomlTable::of_file(const toml::table& document,
                                       const FileDescription& file,
                                       const TomlSource& source) {
  return make(document, std::string(file.name), "", "", file, source);
}

Expected<TomlTable> TomlTable::child(const toml::node& node,
                                     const TableDescription& description) const {
  const std::string heading = description.heading();
  const auto* const found = node.as_table();
  if (!found) return failure(wrong_value(description.key(), node, "a table " + heading));
  return make(*found, heading, description.name, description.planned, *file_, *source_);
}

Expected<std::optional<TomlTable>> TomlTable::table(const TableDescription& description) const {
  const toml::node* const node = table_->get(description.key());
  if (!node) return std::nullopt;
  PANELCAL_TRY(TomlTable made, child(*node, description));
  return made;
}

Expected<std::vector<TomlTable>> TomlTable::tables(const TableDescription& description) const {
  std::vector<TomlTable> made;
  const toml::node* const node = table_->get(description.key());
  if (!node) return made;
  const auto* const array = node->as_array();
  if (!array) {
    return failure(wrong_value(description.key(), *node, "tables " + description.heading()));
  }
  for (const toml::node& row : *array) {
    PANELCAL_TRY(TomlTable one, child(row, description));
    made.push_back(std::move(one));
  }
  return made;
}

Expected<void> TomlTable::read_fields(const TableDescription& description, void* object) const {
  std::vector<RequiredKey> required;
  for (const Field& field : description.fields) {
    if (field.is_required() && field.alternative.empty()) {
      required.push_back({field.key, field.example});
    }
  }
  PANELCAL_CHECK(require(required));
  for (const Field& field : description.fields) {
    if (!has(field.key) || field.store == nullptr) continue;
    FieldValue value;
    PANELCAL_CHECK(read_value(field, value));
    const bool is_empty =
        !field.expected.empty() && field.kind == FieldKind::Text && value.text.empty();
    if (is_empty || !field.store(object, value)) {
      return failure(problem(field.key, std::string(field.expected)));
    }
  }
  return {};
}

Expected<void> TomlTable::read_value(const Field& field, FieldValue& value) const {
  const auto take = [](auto read, auto& member) -> Expected<void> {
    if (!read) return failure(std::move(read).error());
    member = **std::move(read);
    return {};
  };
  const std::string_view key = field.key;
  switch (field.kind) {
    case FieldKind::Truth:
      return take(truth(key), value.truth);
    case FieldKind::Whole:
      return take(integer(key, field.whole), value.whole);
    case FieldKind::Number:
      PANELCAL_CHECK(take(number(key, field.range), value.number));
      value.number = field.unit.stored(value.number);
      return {};
    case FieldKind::Limit:
      value.is_off = is_off(key);
      if (value.is_off) return {};
      if (!take(number(key, field.range), value.number)) {
        return failure(problem(key, field.takes()));
      }
      value.number = field.unit.stored(value.number);
      return {};
    case FieldKind::Pair:
    case FieldKind::Numbers:
      if (field.kind == FieldKind::Numbers) {
        PANELCAL_CHECK(take(numbers(key, field.range), value.numbers));
      } else {
        PANELCAL_TRY(const std::optional<Eigen::Vector2d> both, pair(key, field.range));
        value.numbers = {both->x(), both->y()};
      }
      for (double& one : value.numbers) one = field.unit.stored(one);
      return {};
    case FieldKind::Text:
    case FieldKind::Word:
    case FieldKind::Form:
      return take(text(key), value.text);
    case FieldKind::File:
    case FieldKind::Folder:
      PANELCAL_CHECK(take(text(key), value.text));
      if (value.text.empty()) return failure(problem(key, field.takes()));
      value.folder = folder();
      return {};
    case FieldKind::Texts: {
      PANELCAL_TRY(value.texts, texts(key));
      value.folder = folder();
      return {};
    }
    case FieldKind::WallTime:
      return take(wall_time(key), value.time);
    default:
      return {};  // of JSON alone
  }
}

std::filesystem::path TomlTable::folder() const {
  return std::filesystem::path(source_->file).parent_path();
}

Diagnostic TomlTable::wrong_value(std::string_view key,
                                  const toml::node& node,
                                  std::string expected) const {
  return {Code::ConfigValue,
          source_->place(node.source().begin),
          fmt::format("{} in {} is {}", key, name_, source_->excerpt(node.source())),
          std::move(expected)};
}

Diagnostic TomlTable::problem(std::string_view key,
                              std::string expected,
                              std::string because) const {
  Diagnostic diagnostic = wrong_value(key, *table_->get(key), std::move(expected));
  if (!because.empty()) diagnostic.what += ": " + because;
  return diagnostic;
}

Expected<void> TomlTable::require(std::span<const RequiredKey> keys) const {
  std::string absent;
  std::string examples;
  std::size_t n_absent = 0;
  for (const RequiredKey& required : keys) {
    if (has(required.key)) continue;
    const bool is_first = n_absent++ == 0;
    absent += fmt::format("{}{}", is_first ? "" : ", ", quoted(required.key));
    examples += fmt::format("{}{}", is_first ? "" : "; ", required.example);
  }
  if (n_absent == 0) return {};
  return failure(missing((n_absent == 1 ? "key " : "keys ") + absent, std::move(examples)));
}

Diagnostic TomlTable::missing(std::string_view what, std::string expected) const {
  const bool is_key = what.find_first_not_of("abcdefghijklmnopqrstuvwxyz_") == what.npos;
  return {Code::ConfigValue,
          source_->place(table_->source().begin),
          fmt::format("{}: missing {}", name_, is_key ? "key " + quoted(what) : std::string(what)),
          std::move(expected)};
}

Expected<double> TomlTable::checked_number(std::string_view key,
                                           const toml::node& node,
                                           const Range& range) const {
  std::optional<double> value;
  if (const auto* floating = node.as_floating_point()) value = floating->get();
  if (const auto* whole = node.as_integer()) value = static_cast<double>(whole->get());
  if (!value || !std::isfinite(*value) || !range.contains(*value)) {
    return failure(wrong_value(key, node, range.text()));
  }
  return *value;
}

Expected<std::optional<double>> TomlTable::number(std::string_view key, const Range& range) const {
  const toml::node* node = table_->get(key);
  if (!node) return std::nullopt;
  PANELCAL_TRY(const double value, checked_number(key, *node, range));
  return value;
}

bool TomlTable::is_off(std::string_view key) const {
  return (*table_)[key].value_or(std::string_view()) == "off";
}

Expected<std::optional<std::int64_t>> TomlTable::integer(std::string_view key,
                                                         const WholeRange& range) const {
  const toml::node* node = table_->get(key);
  if (!node) return std::nullopt;
  const auto* whole = node->as_integer();
  if (whole && range.contains(whole->get())) return whole->get();
  return failure(wrong_value(key, *node, range.text()));
}

Expected<std::optional<std::string>> TomlTable::text(std::string_view key) const {
  const toml::node* node = table_->get(key);
  if (!node) return std::nullopt;
  if (const auto* text = node->as_string()) return text->get();
  return failure(wrong_value(key, *node, "a text in quotes"));
}

Expected<std::optional<bool>> TomlTable::truth(std::string_view key) const {
  const toml::node* node = table_->get(key);
  if (!node) return std::nullopt;
  if (const auto* truth = node->as_boolean()) return truth->get();
  return failure(wrong_value(key, *node, "true or false"));
}

Expected<std::optional<std::chrono::sys_seconds>> TomlTable::wall_time(std::string_view key) const {
  const toml::node* node = table_->get(key);
  if (!node) return std::nullopt;
  if (const auto* value = node->as_date_time(); value && !value->get().offset) {
    const toml::date& date = value->get().date;
    const toml::time& time = value->get().time;
    const auto read = from_iso_8601(fmt::format("{:04}-{:02}-{:02}T{:02}:{:02}:{:02}Z",
                                                date.year,
                                                date.month,
                                                date.day,
                                                time.hour,
                                                time.minute,
                                                time.second));
    if (read) return read;
  }
  return failure(wrong_value(
      key, *node, "a date and a time without a zone, such as 2026-11-21T08:00:00, no quotes"));
}

Expected<std::vector<std::string>> TomlTable::texts(std::string_view key) const {
  std::vector<std::string> values;
  const toml::node* node = table_->get(key);
  if (!node) return values;
  const auto* array = node->as_array();
  if (!array) return failure(wrong_value(key, *node, "a list of texts, [\"a\", \"b\"]"));
  for (const toml::node& element : *array) {
    const auto* text = element.as_string();
    if (!text) return failure(wrong_value(key, element, "a text in quotes"));
    values.push_back(text->get());
  }
  return values;
}

Expected<std::optional<std::vector<double>>> TomlTable::numbers(std::string_view key,
                                                                const Range& range) const {
  const toml::node* node = table_->get(key);
  if (!node) return std::nullopt;
  const auto* array = node->as_array();
  if (!array) return failure(wrong_value(key, *node, "a list of numbers, [1, 2]"));
  std::vector<double> values;
  for (const toml::node& element : *array) {
    PANELCAL_TRY(const double value, checked_number(key, element, range));
    values.push_back(value);
  }
  return values;
}

Expected<std::optional<Eigen::Vector2d>> TomlTable::pair(std::string_view key,
                                                         const Range& range) const {
  const toml::node* node = table_->get(key);
  if (!node) return std::nullopt;
  const auto* array = node->as_array();
  if (!array || array->size() != 2) return failure(wrong_value(key, *node, "two numbers, [x, y]"));
  Eigen::Vector2d value;
  PANELCAL_TRY(value.x(), checked_number(key, *array->get(0), range));
  PANELCAL_TRY(value.y(), checked_number(key, *array->get(1), range));
  return value;
}

}  // namespace panelcal::internal
