// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include "calib/base/clock.h"
#include "calib/base/fields/json.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace panelcal::internal {
namespace {

using nlohmann::json;

bool take_number(const Field& field, const json& value, double& out) {
  if (field.has_gaps && value.is_null()) {
    out = std::numeric_limits<double>::quiet_NaN();
    return true;
  }
  if (!value.is_number()) return false;
  out = value.get<double>();
  if (!field.range.contains(out)) return false;
  out = field.unit.stored(out);
  return true;
}

/// Whole numbers may be written as 2.0.
bool take_whole(const Field& field, const json& value, std::int64_t& out) {
  if (value.is_number_float()) {
    const double number = value.get<double>();
    if (number != std::floor(number) || std::abs(number) > 0x1p53) return false;
    out = static_cast<std::int64_t>(number);
  } else if (value.is_number_unsigned() && value.get<std::uint64_t>() > INT64_MAX) {
    return false;
  } else if (value.is_number()) {
    out = value.get<std::int64_t>();
  }
  return value.is_number() && field.whole.contains(out);
}

/// Calls `take` with each element of a list of n; n = 0: of any list.
template <class Take>
bool take_each(const json& value, std::size_t n, const Take& take) {
  return value.is_array() && (n == 0 || value.size() == n) &&
         std::all_of(value.begin(), value.end(), take);
}

bool take_numbers(const Field& field, const json& value, std::size_t n, std::vector<double>& out) {
  return take_each(value, n, [&](const json& element) {
    return take_number(field, element, out.emplace_back());
  });
}

bool take_text(const Field& field, const json& value, std::string& out) {
  if (!value.is_string()) return false;
  out = value.get<std::string>();
  const bool is_constant = field.kind == FieldKind::Word && field.store == nullptr;
  if (is_constant) return quoted(out) == field.expected;
  return field.kind != FieldKind::Text || field.expected.empty() || !out.empty();
}

bool take_value(const Field& field, const json& value, FieldValue& out) {
  switch (field.kind) {
    case FieldKind::Any:
      return true;
    case FieldKind::Truth:
      if (value.is_boolean()) out.truth = value.get<bool>();
      return value.is_boolean();
    case FieldKind::Whole:
      return take_whole(field, value, out.whole);
    case FieldKind::Counter:
      if (value.is_number_unsigned()) {
        out.whole = static_cast<std::int64_t>(value.get<std::uint64_t>());
      }
      return value.is_number_unsigned();
    case FieldKind::Number:
      return take_number(field, value, out.number);
    case FieldKind::Pair:
      return take_numbers(field, value, 2, out.numbers);
    case FieldKind::Numbers:
      return take_numbers(field, value, field.n_rows, out.numbers);
    case FieldKind::Matrix: {
      const std::size_t n =
          field.n_columns > 0 || !value.is_array() ? field.n_columns : value.size();
      return take_each(value, field.n_rows, [&](const json& row) {
        return take_numbers(field, row, n, out.numbers);
      });
    }
    case FieldKind::Wholes:
      return take_each(value, field.n_rows, [&](const json& element) {
        return take_whole(field, element, out.wholes.emplace_back());
      });
    case FieldKind::Texts:
      return take_each(value, field.n_rows, [&](const json& element) {
        const auto* text = element.get_ptr<const std::string*>();
        if (text != nullptr) out.texts.push_back(*text);
        return text != nullptr;
      });
    case FieldKind::Time:
      if (const auto* text = value.get_ptr<const std::string*>()) {
        const auto time = from_iso_8601(*text);
        if (time) out.time = *time;
        return time.has_value();
      }
      return false;
    default:
      return take_text(field, value, out.text);
  }
}

bool is_several(FieldKind kind) {
  constexpr std::array kSeveral = {FieldKind::Pair, FieldKind::Numbers, FieldKind::Matrix};
  return std::ranges::find(kSeveral, kind) != kSeveral.end();
}

/// The values that a key takes, for messages.
std::string taken_values(const Field& field) {
  std::string text = field.takes();
  if (is_several(field.kind) && (std::isfinite(field.range.low) || std::isfinite(field.range.high)))
    text += ", each " + field.range.text();
  return field.is_optional && !field.may_lack ? text + ", or null" : text;
}

/// False: the value is not as expected.
Expected<bool> put_value(const Field& field, const json& value, void* object) {
  FieldValue out;
  if (value.is_null() && field.is_optional) {
    out.is_off = true;
  } else if (!take_value(field, value, out)) {
    return false;
  }
  return field.store == nullptr || field.store(object, out);
}

class Reader {
 public:
  Reader(Code code, const std::string& file) : code_(code), file_(file) {}

  // NOLINTNEXTLINE(misc-no-recursion): as deep as tables lie in each other.
  Expected<void> read(const TableDescription& table,
                      const json& value,
                      std::optional<std::size_t> i,
                      void* object) const {
    const auto name = [&] {
      return i ? fmt::format("{} {}", table.name, *i) : std::string(table.name);
    };
    if (!value.is_object()) return refuse(name() + " is no JSON object", "{...}");
    // First, since keys of another kind or of a newer version would be called unknown.
    for (const Field& field : table.fields) {
      const bool is_of_head = field.key == "kind" || field.key == "version";
      if (is_of_head) PANELCAL_CHECK(take(field, value, name, object));
    }
    PANELCAL_CHECK(check_keys(table, value, name));
    for (const Field& field : table.fields) PANELCAL_CHECK(take(field, value, name, object));
    return {};
  }

 private:
  static constexpr auto kReplace = json::error_handler_t::replace;
  static constexpr std::size_t kShown = 60;  ///< characters of a value in a message

  tl::unexpected<Diagnostic> refuse(std::string what, std::string expected) const {
    return failure({code_, {file_, 0, 0}, std::move(what), std::move(expected)});
  }

  // NOLINTNEXTLINE(misc-no-recursion): as above.
  template <class Name>
  Expected<void> take(const Field& field, const json& value, const Name& name, void* object) const {
    const auto member = value.find(field.key);
    if (member == value.end()) return {};
    PANELCAL_TRY(const bool is_taken, put(field, *member, object));
    if (is_taken) return {};
    const std::string text = member->dump(-1, ' ', true, kReplace);
    const bool is_shown = text.size() <= kShown || !member->is_structured();
    const std::string found = is_shown ? "is " + text.substr(0, kShown) : "has another form";
    return refuse(fmt::format("{} of {} {}", quoted(field.key), name(), found),
                  taken_values(field));
  }

  template <class Name>
  Expected<void> check_keys(const TableDescription& table,
                            const json& value,
                            const Name& name) const {
    for (const auto& [key, ignored] : value.items()) {
      if (std::ranges::find(table.fields, key, &Field::key) != table.fields.end()) continue;
      std::vector<std::string_view> known;
      for (const Field& field : table.fields) known.push_back(field.key);
      const std::string_view nearest = nearest_word(key, known);
      return refuse("unknown key " + quoted(key) + " in " + name(),
                    nearest.empty() ? fmt::format("one of {}", fmt::join(known, ", "))
                                    : "did you mean " + quoted(nearest) + "?");
    }
    for (const Field& field : table.fields) {
      if (field.may_lack || value.contains(field.key)) continue;
      return refuse(name() + ": missing key " + quoted(field.key), "");
    }
    return {};
  }

  // NOLINTNEXTLINE(misc-no-recursion): as above.
  Expected<bool> put(const Field& field, const json& value, void* object) const {
    const bool is_none = value.is_null() && field.is_optional;
    if (field.table == nullptr || is_none) {
      return is_none && field.store == nullptr ? true : put_value(field, value, object);
    }
    if (field.kind == FieldKind::Object || (value.is_object() && field.is_alone_plain)) {
      PANELCAL_CHECK(read(*field.table, value, std::nullopt, field.inner.open(object)));
      return true;
    }
    if (!value.is_array()) return false;
    for (std::size_t i = 0; i < value.size(); ++i) {
      PANELCAL_CHECK(read(*field.table, value[i], i, field.inner.open(object)));
    }
    return true;
  }

  Code code_;
  const std::string& file_;
};

json number_of(std::string_view text) {
  const char* const end = text.data() + text.size();
  std::int64_t whole = 0;
  const auto [stop, error] = std::from_chars(text.data(), end, whole);
  if (text != "-0" && stop == end && error == std::errc()) {
    return whole < 0 ? json(whole) : json(static_cast<std::uint64_t>(whole));
  }
  double number = 0;
  // What no double holds is no number.
  if (std::from_chars(text.data(), end, number).ec == std::errc()) return number;
  return json::object();  // which no key of a line takes
}

struct ValueOf {
  json operator()(const JsonNumber& number) const { return number_of(number.text); }
  json operator()(const std::vector<JsonNumber>& numbers) const {
    json out = json::array();
    for (const JsonNumber& number : numbers) out.push_back(number_of(number.text));
    return out;
  }
  json operator()(const std::string& text) const { return text; }
  json operator()(bool truth) const { return truth; }
  json operator()(std::monostate) const { return nullptr; }
};

}  // namespace

Expected<void> read_json(const TableDescription& table,
                         const json& value,
                         void* object,
                         Code code,
                         const std::string& file) {
  return Reader(code, file).read(table, value, std::nullopt, object);
}

Expected<void> read_line(const TableDescription& table,
                         const JsonLine& line,
                         void* object,
                         Code code) {
  std::vector<std::string_view> known;
  for (const Field& field : table.fields) known.push_back(field.key);
  PANELCAL_CHECK(line.check_keys(known, code));
  for (const Field& field : table.fields) {
    const JsonMember* const member = line.find(field.key);
    if (member == nullptr) {
      if (!field.may_lack) return failure(line.missing(field.key, code));
      continue;
    }
    PANELCAL_TRY(const bool is_taken,
                 put_value(field, std::visit(ValueOf(), member->value), object));
    if (!is_taken) return failure(line.problem(field.key, code, taken_values(field)));
  }
  return {};
}

}  // namespace panelcal::internal
