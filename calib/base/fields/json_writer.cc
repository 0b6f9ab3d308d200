// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <iterator>

#include "calib/base/append_format.h"
#include "calib/base/clock.h"
#include "calib/base/fields/json.h"
#include "calib/base/json/json_string.h"
#include <fmt/format.h>

namespace panelcal::internal {
namespace {

class Writer {
 public:
  explicit Writer(JsonStyle style) : style_(style), gap_(style == JsonStyle::File ? " " : "") {}

  // NOLINTNEXTLINE(misc-no-recursion): as deep as tables lie in each other.
  void write(const TableDescription& table, const void* object) {
    const int outer = indent_;
    if (style_ == JsonStyle::File) indent_ += table.indent;
    out_ += '{';
    bool is_first = true;
    for (const Field& field : table.fields) {
      FieldValue value;
      const bool has_value = load(field, object, value);
      if (!has_value && field.may_lack) continue;
      if (!is_first) out_ += ',';
      if (table.is_in_lines || field.is_on_new_line) {
        begin_line(indent_);
      } else if (!is_first) {
        out_ += gap_;
      }
      is_first = false;
      append_format(out_, "\"{}\":{}", field.key, gap_);
      if (!has_value && field.is_optional) {
        out_ += "null";
      } else {
        put(field, object, value);
      }
    }
    indent_ = outer;
    if (table.is_in_lines) begin_line(indent_);
    out_ += '}';
  }

  std::string take() { return std::move(out_); }

 private:
  static bool load(const Field& field, const void* object, FieldValue& value) {
    if (field.table != nullptr) return field.inner.count(object) > 0;
    if (field.load == nullptr) return true;
    const bool is_whole = field.kind == FieldKind::Whole;
    return field.load(object, value) &&
           (is_whole ? static_cast<double>(value.whole) : value.number) != field.left_out_at;
  }

  void begin_line(int indent) {
    out_ += '\n';
    out_.append(static_cast<std::size_t>(indent), ' ');
  }

  /// A list of n elements, each put by `put_one`.
  template <class PutOne>
  void list(std::size_t n, bool is_in_lines, const PutOne& put_one) {
    const int outer = indent_;
    if (is_in_lines && style_ == JsonStyle::File) indent_ += 2;
    out_ += '[';
    for (std::size_t i = 0; i < n; ++i) {
      if (i > 0) out_ += ',';
      if (is_in_lines) {
        begin_line(indent_);
      } else if (i > 0) {
        out_ += gap_;
      }
      put_one(i);
    }
    indent_ = outer;
    if (is_in_lines && n > 0 && style_ == JsonStyle::File) begin_line(indent_);
    out_ += ']';
  }

  // NOLINTNEXTLINE(misc-no-recursion): as above.
  void put(const Field& field, const void* object, const FieldValue& value) {
    switch (field.kind) {
      case FieldKind::Truth:
        out_ += value.truth ? "true" : "false";
        return;
      case FieldKind::Whole:
        return whole(field.load == nullptr ? field.whole.low : value.whole);
      case FieldKind::Counter:
        append_format(out_, "{}", static_cast<std::uint64_t>(value.whole));
        return;
      case FieldKind::Number:
        return number(field, value.number);
      case FieldKind::Pair:
      case FieldKind::Numbers:
        return numbers(field, value.numbers, 0, value.numbers.size());
      case FieldKind::Matrix:
        return matrix(field, value.numbers);
      case FieldKind::Wholes:
        return list(value.wholes.size(), false, [&](std::size_t i) { whole(value.wholes[i]); });
      case FieldKind::Texts:
        return list(
            value.texts.size(), field.is_in_lines, [&](std::size_t i) { text(value.texts[i]); });
      case FieldKind::Time:
        return text(iso_8601(value.time));
      case FieldKind::Object:
        return write(*field.table, field.inner.at(object, 0));
      case FieldKind::Objects:
        return objects(field, object);
      default:
        if (field.load == nullptr) {
          out_ += field.expected;
        } else {
          text(value.text);
        }
    }
  }

  // NOLINTNEXTLINE(misc-no-recursion): as above.
  void objects(const Field& field, const void* object) {
    const std::size_t n = field.inner.count(object);
    if (n == 1 && field.is_alone_plain) return write(*field.table, field.inner.at(object, 0));
    list(n, field.is_in_lines, [&](std::size_t i) {
      write(*field.table, field.inner.at(object, i));
    });
  }

  void whole(std::int64_t value) { append_format(out_, "{}", value); }

  /// Minus zero would not come back from readers that take it for a whole number.
  void number(const Field& field, double stored) {
    const double written = field.unit.written(stored);
    if (field.has_gaps && std::isnan(written)) {
      out_ += "null";
    } else if (!std::isfinite(written)) {
      append_format(out_, "\"{}\"", written);
    } else {
      append_format(out_, "{}", style_ == JsonStyle::Line ? written : written + 0.0);
    }
  }

  void numbers(const Field& field,
               const std::vector<double>& all,
               std::size_t begin,
               std::size_t n) {
    list(n, false, [&](std::size_t i) { number(field, all[begin + i]); });
  }

  void matrix(const Field& field, const std::vector<double>& all) {
    std::size_t n_columns = field.n_columns;
    while (field.n_columns == 0 && n_columns * n_columns < all.size()) ++n_columns;
    const std::size_t n_rows = n_columns > 0 ? all.size() / n_columns : 0;
    list(n_rows, field.is_in_lines, [&](std::size_t row) {
      numbers(field, all, row * n_columns, n_columns);
    });
  }

  void text(std::string_view text) {
    if (style_ == JsonStyle::Line) {
      append_json_string(out_, text);
    } else {
      out_ += ascii_json_string(text);
    }
  }

  JsonStyle style_;
  std::string_view gap_;
  int indent_ = 0;
  std::string out_;
};

}  // namespace

std::string json_text(const TableDescription& table, const void* object, JsonStyle style) {
  Writer writer(style);
  writer.write(table, object);
  std::string text = writer.take();
  if (style == JsonStyle::File) text += '\n';
  return text;
}

}  // namespace panelcal::internal
