// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/header_format.h"

#include <optional>
#include <utility>

#include "program/excellon/text/comment_format.h"
#include <fmt/format.h>

namespace panelcal::excellon {
namespace {

LengthUnit unit_of_word(std::string_view word) {
  return word == "INCH" ? LengthUnit::Inch : LengthUnit::Millimeter;
}

}  // namespace

HeaderFormat::HeaderFormat(Header& header, const StatedFormat& outside, const Reporter& reporter)
    : header_(header), reporter_(reporter) {
  header.stated = outside;
}

void HeaderFormat::read_unit(int line,
                             int column,
                             std::string_view text,
                             const HeaderCommand& command) {
  const std::string_view word = command.word;
  if (unit_word_ == word && command.value.empty()) return;
  PartialFormat parts =
      read_options(word, line, column + static_cast<int>(word.size()) + 1, command.value);
  parts.unit = unit_of_word(word);
  const PartialFormat obeyed = header_.stated.obeyed(Source::Word, parts);
  if (obeyed.unit && !unit_word_.empty() && unit_word_ != word) {
    invalid(line,
            column,
            quoted(text) + " contradicts the " + unit_word_ + " before it",
            "one unit for the whole program");
  } else if (contradicts_words(obeyed)) {
    invalid(line,
            column,
            quoted(text) + " contradicts the " + unit_word_ + " before it",
            "one number format for the whole program");
    parts.zeros.reset();
    parts.digits.reset();
  }
  unit_word_ = word;
  if (!of_words_.zeros) of_words_.zeros = obeyed.zeros;
  if (!of_words_.digits) of_words_.digits = obeyed.digits;
  take(Source::Word, line, column, text, std::move(parts));
}

bool HeaderFormat::contradicts_words(const PartialFormat& parts) const {
  return (parts.zeros && of_words_.zeros && parts.zeros != of_words_.zeros) ||
         (parts.digits && of_words_.digits && parts.digits != of_words_.digits);
}

PartialFormat HeaderFormat::read_options(std::string_view word,
                                         int line,
                                         int column,
                                         std::string_view options) {
  NumberFormat usual{.unit = unit_of_word(word)};
  usual.take_usual_digits();
  PartialFormat parts;
  while (!options.empty()) {
    const auto comma = options.find(',');
    const std::string_view part = options.substr(0, comma);
    const std::optional<FormatWords> words = read_format_words(part);
    if (words && words->zeros) {
      parts.zeros = words->zeros;
    } else if (words && words->digits) {
      parts.digits = words->digits;
    } else {
      invalid(line, column, quoted(part), "LZ, TZ or digits such as " + usual.digit_mask());
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
  if (comment.is_incremental) {
    header_.incremental |= *comment.is_incremental;
    header_.states_incremental = true;
  }
  const PartialFormat parts{comment.unit, comment.zeros, comment.digits, ""};
  take(Source::Comment, line, 1, text, parts);
  comments_.push_back({line, text, header_.stated.obeyed(Source::Comment, parts)});
}

void HeaderFormat::check_comments() const {
  const StatedFormat& stated = header_.stated;
  const NumberFormat& format = stated.format();
  const std::pair digits(format.integer_digits, format.decimal_digits);
  const auto contradicts = [](bool is_of_comments, const auto& part, const auto& decided) {
    return is_of_comments && part && *part != decided;
  };
  for (const auto& [line, text, parts] : comments_) {
    const bool is_of_unit = parts.unit.value_or(format.unit) == format.unit;
    if (contradicts(stated.source_of_unit() == Source::Comment, parts.unit, format.unit) ||
        (is_of_unit &&
         (contradicts(stated.source_of_zeros() == Source::Comment, parts.zeros, format.zeros) ||
          contradicts(stated.source_of_digits() == Source::Comment, parts.digits, digits)))) {
      invalid(line,
              1,
              quoted(text) + " contradicts " + format.summary(),
              "one number format for the whole program");
    }
  }
}

/// Numbers that stand before it were read in the format of then.
void HeaderFormat::take(
    Source source, int line, int column, std::string_view text, PartialFormat parts) {
  if (parts.is_empty()) return;
  StatedFormat& stated = header_.stated;
  check_obeyed(stated, parts, text, line, column, reporter_);
  parts.from = fmt::format("line {}: {}", line, text);
  const NumberFormat before = stated.format();
  const bool is_first_word = source == Source::Word && !stated.states_unit();
  stated.add(source, parts);
  const NumberFormat& after = stated.format();
  if (header_.has_dimension && (is_first_word || before.unit != after.unit)) {
    report_late(line, column, text, "unit");
  } else if (header_.has_bare_dimension && before.zeros != after.zeros) {
    const auto at = text.find(after.zeros == Zeros::LeadingKept ? "LZ" : "TZ");
    const bool has_word = source == Source::Word && at != std::string_view::npos;
    if (!has_word) return report_late(line, column, text, "zeros");
    report_late(line, column + static_cast<int>(at), text.substr(at, 2), "zeros");
  } else if (header_.has_bare_dimension && !are_scaled_alike(before, after)) {
    report_late(line, column, text, "digits");
  }
}

void HeaderFormat::report_late(int line,
                               int column,
                               std::string_view text,
                               std::string_view stated) const {
  invalid(line,
          column,
          fmt::format("{} comes behind numbers whose {} it states", quoted(text), stated),
          kFormatFirst);
}

void HeaderFormat::invalid(int line,
                           int column,
                           std::string what,
                           std::string_view expected) const {
  reporter_.report(Code::ArgumentInvalid, line, column, std::move(what), std::string(expected));
}

}  // namespace panelcal::excellon
