// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/header_format.h"

#include <optional>
#include <tuple>

#include "program/excellon/text/body_unit.h"
#include "program/excellon/text/comment_format.h"
#include <fmt/format.h>

namespace panelcal::excellon {

HeaderFormat::HeaderFormat(Header& header,
                           const Reporter& reporter,
                           const FormatStart& start,
                           const ReadOptions& reading)
    : header_(header),
      reporter_(reporter),
      forced_(reading.forced_format),
      setting_(reading.unstated_format()),
      start_(start),
      digits_from_hint_(forced_.digits.has_value()) {
  header.format = start.format;
  header.is_refused = start.is_open;
  header.states_format = forced_.unit.has_value();
  header.states_zeros = forced_.zeros.has_value();
  header.states_digits = forced_.digits.has_value();
}

void HeaderFormat::read_unit(int line, int column, HeaderCommand command) {
  NumberFormat& format = header_.format;
  const std::string_view word = command.word;
  if (unit_word_ == word && command.value.empty()) return;
  if (!unit_word_.empty() && unit_word_ != word) {
    invalid(line,
            column,
            quoted(word) + " contradicts the " + unit_word_ + " before it",
            "one unit for the whole program");
  }
  const bool is_late = header_.has_dimension && unit_word_ != word && !forced_.unit;
  if (is_late) report_late(line, column, quoted(word), "unit");
  unit_word_ = word;
  format.unit = word == "INCH" ? LengthUnit::Inch : LengthUnit::Millimeter;
  if (hint_unit_.value_or(format.unit) != format.unit) {
    digits_from_hint_ = header_.states_digits = format.states_digits = false;
  }
  if (!digits_from_hint_ && !has_digit_mask_) format.take_digits(setting_);
  header_.states_format = true;
  header_.format_evidence = fmt::format("line {}: {}", line, command.text());
  take_options(line, column + static_cast<int>(word.size()) + 1, command.value, is_late);
  impose(line, column, command.text());
}

void HeaderFormat::take_options(int line, int column, std::string_view options, bool is_late) {
  NumberFormat& format = header_.format;
  while (!options.empty()) {
    const auto comma = options.find(',');
    const std::string_view part = options.substr(0, comma);
    const std::optional<FormatWords> words = read_format_words(part);
    if (words && words->zeros) {
      const bool changes = *words->zeros != format.zeros && !header_.states_zeros;
      if (changes && header_.has_dimension && !is_late && !forced_.zeros) {
        report_late(line, column, quoted(part), "zeros");
      }
      format.zeros = *words->zeros;
      has_zeros_word_ = header_.states_zeros = true;
    } else if (words && words->digits) {
      has_digit_mask_ = format.states_digits = true;
      std::tie(format.integer_digits, format.decimal_digits) = *words->digits;
    } else {
      invalid(line, column, quoted(part), "LZ, TZ or digits such as 000.000");
    }
    if (comma == std::string_view::npos) return;
    options.remove_prefix(comma + 1);
    column += static_cast<int>(comma) + 1;
  }
}

void HeaderFormat::read_comment(int line, std::string_view text) {
  const CommentFormat stated = read_comment_format(text);
  if (!stated.unknown.empty()) {
    invalid(line, 1, quoted(stated.unknown) + " in " + quoted(text), CommentFormat::kExpected);
  }
  const bool is_other_unit =
      stated.unit && header_.states_format && *stated.unit != header_.format.unit;
  if (is_other_unit && unit_word_.empty() && !forced_.unit) {
    return invalid(line,
                   1,
                   quoted(text) + " contradicts " + header_.format.summary(),
                   "one number format for the whole program");
  }
  header_.incremental |= stated.is_incremental;
  // Of a comment that the header overrules in its unit, digits and zeros mean nothing either.
  if (is_other_unit) return impose(line, 1, text);
  if (stated.digits && !has_digit_mask_) {
    take_digits(line, *stated.digits, text);
    hint_unit_ = stated.unit;
  }
  if (stated.unit && !header_.states_format) take_unit(line, *stated.unit, text);
  if (stated.zeros && !has_zeros_word_) {
    header_.format.zeros = *stated.zeros;
    header_.states_zeros = true;
  }
  impose(line, 1, text);
}

void HeaderFormat::take_unit(int line, LengthUnit unit, std::string_view comment) {
  if (header_.has_dimension && unit != header_.format.unit) {
    report_late(line, 1, quoted(comment), "unit");
  }
  header_.format.unit = unit;
  if (!digits_from_hint_) header_.format.take_digits(setting_);
  header_.states_format = true;
  header_.format_evidence = fmt::format("line {}: {}", line, comment);
}

void HeaderFormat::take_digits(int line,
                               const std::pair<int, int>& digits,
                               std::string_view comment) {
  std::tie(header_.format.integer_digits, header_.format.decimal_digits) = digits;
  header_.format_evidence = fmt::format("line {}: {}", line, comment);
  header_.states_digits = header_.format.states_digits = true;
  digits_from_hint_ = true;
}

/// Outputs state the unit in their header.
void HeaderFormat::read_body(LineCursor body) {
  if (!header_.states_format && !header_.has_dimension) {
    if (const auto stated = find_body_unit(body, header_.set)) {
      header_.body_format = header_.format;
      header_.body_format->unit = stated->unit;
      if (!header_.states_digits) header_.body_format->take_digits(setting_);
      if (stated->zeros && !forced_.zeros) header_.body_format->zeros = *stated->zeros;
      header_.format_evidence = fmt::format("line {}: {}", stated->line, stated->text);
    }
  }
  add_evidence_of_start();
}

/// What --format says holds, whatever the line states.
void HeaderFormat::impose(int line, int column, std::string_view text) {
  if (forced_.is_empty()) return;
  NumberFormat imposed = header_.format;
  const LengthUnit unit = forced_.unit.value_or(imposed.unit);
  // Digits of a mask are those of its unit; a comment's may be of either.
  const bool takes_digits = unit != imposed.unit && !digits_from_hint_;
  imposed.unit = unit;
  if (takes_digits) {
    imposed.states_digits = false;
    imposed.take_digits(setting_);
  }
  forced_.apply_to(imposed);
  const bool is_another = imposed.summary() != header_.format.summary();
  header_.format = imposed;
  if (!is_another || std::exchange(is_overridden_, true)) return;
  reporter_.report(Code::FormatOverridden,
                   line,
                   column,
                   quoted(text) + " is not obeyed: " + forced_.from,
                   "the format that the program states");
}

void HeaderFormat::add_evidence_of_start() {
  std::string& evidence = header_.format_evidence;
  const auto join = [](std::string_view first, std::string_view second) {
    return fmt::format("{}{}{}", first, first.empty() || second.empty() ? "" : "; ", second);
  };
  const NumberFormat format = header_.number_format();
  NumberFormat usual = format;
  usual.take_digits(setting_);
  const bool has_setting_digits = !header_.states_digits && !has_digit_mask_ && setting_.digits &&
                                  usual.summary() == format.summary();
  if (!forced_.is_empty()) {
    evidence = join(start_.evidence, evidence);
  } else if (evidence.empty() || !header_.states_zeros || has_setting_digits) {
    evidence = join(evidence, start_.evidence);
  }
  evidence = join(evidence, start_.assumed);
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
