// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/header_format.h"

#include <optional>
#include <utility>

#include "program/excellon/text/comment_format.h"
#include <fmt/format.h>

namespace panelcal::excellon {

HeaderFormat::HeaderFormat(Header& header, const StatedFormat& outside, const Reporter& reporter)
    : header_(header), reporter_(reporter) {
  header.stated = outside;
  header.format = outside.format();
}

void HeaderFormat::read_unit(int line, int column, HeaderCommand command) {
  const std::string_view word = command.word;
  if (unit_word_ == word && command.value.empty()) return;
  if (!unit_word_.empty() && unit_word_ != word) {
    invalid(line,
            column,
            quoted(word) + " contradicts the " + unit_word_ + " before it",
            "one unit for the whole program");
  }
  const bool is_late = header_.has_dimension && unit_word_ != word && !has_ruled_unit();
  if (is_late) report_late(line, column, quoted(word), "unit");
  unit_word_ = word;
  PartialFormat parts =
      read_options(line, column + static_cast<int>(word.size()) + 1, command.value, is_late);
  parts.unit = word == "INCH" ? LengthUnit::Inch : LengthUnit::Millimeter;
  take(StatedFormat::Source::Word, line, column, command.text(), std::move(parts));
}

PartialFormat HeaderFormat::read_options(int line,
                                         int column,
                                         std::string_view options,
                                         bool is_late) {
  const StatedFormat& stated = header_.stated;
  PartialFormat parts;
  while (!options.empty()) {
    const auto comma = options.find(',');
    const std::string_view part = options.substr(0, comma);
    const std::optional<FormatWords> words = read_format_words(part);
    if (words && words->zeros) {
      const bool changes = *words->zeros != header_.format.zeros && !stated.states_zeros();
      if (changes && header_.has_dimension && !is_late) {
        report_late(line, column, quoted(part), "zeros");
      }
      parts.zeros = words->zeros;
    } else if (words && words->digits) {
      parts.digits = words->digits;
    } else {
      invalid(line, column, quoted(part), "LZ, TZ or digits such as 000.000");
    }
    if (comma == std::string_view::npos) break;
    options.remove_prefix(comma + 1);
    column += static_cast<int>(comma) + 1;
  }
  return parts;
}

void HeaderFormat::read_comment(int line, std::string_view text) {
  const CommentFormat comment = read_comment_format(text);
  if (!comment.unknown.empty()) {
    invalid(line, 1, quoted(comment.unknown) + " in " + quoted(text), CommentFormat::kExpected);
  }
  const bool is_other_unit = comment.unit && *comment.unit != header_.format.unit;
  if (is_other_unit && unit_word_.empty() && !has_ruled_unit()) {
    if (header_.stated.states_unit()) {
      return invalid(line,
                     1,
                     quoted(text) + " contradicts " + header_.format.summary(),
                     "one number format for the whole program");
    }
    if (header_.has_dimension) report_late(line, 1, quoted(text), "unit");
  }
  if (comment.is_incremental) {
    header_.incremental |= *comment.is_incremental;
    header_.states_incremental = true;
  }
  take(StatedFormat::Source::Comment,
       line,
       1,
       text,
       {comment.unit, comment.zeros, comment.digits, ""});
}

/// A comment on numbers of another unit than INCH or METRIC has means nothing.
void HeaderFormat::take(
    StatedFormat::Source source, int line, int column, std::string_view text, PartialFormat parts) {
  if (parts.is_empty()) return;
  StatedFormat& stated = header_.stated;
  stated.check_obeyed(parts, text, line, column, reporter_);
  const bool is_overruled = source == StatedFormat::Source::Comment && stated.states_unit() &&
                            parts.unit && *parts.unit != header_.format.unit;
  if (is_overruled) return;
  parts.from = fmt::format("line {}: {}", line, text);
  const NumberFormat before = header_.format;
  stated.add(source, parts);
  header_.format = stated.format();
  if (!header_.has_bare_dimension || before.unit != header_.format.unit) return;
  if (before.integer_digits != header_.format.integer_digits ||
      before.decimal_digits != header_.format.decimal_digits) {
    report_late(line, column, quoted(text), "digits");
  } else if (source == StatedFormat::Source::Comment && before.zeros != header_.format.zeros) {
    report_late(line, column, quoted(text), "zeros");  // those of a word are reported at it
  }
}

void HeaderFormat::report_late(int line,
                               int column,
                               const std::string& what,
                               std::string_view stated) {
  invalid(line,
          column,
          fmt::format("{} comes behind numbers whose {} it states", what, stated),
          "INCH or METRIC, with LZ or TZ, before all dimensions");
}

void HeaderFormat::invalid(int line, int column, std::string what, std::string expected) {
  reporter_.report(Code::ArgumentInvalid, line, column, std::move(what), std::move(expected));
}

}  // namespace panelcal::excellon
