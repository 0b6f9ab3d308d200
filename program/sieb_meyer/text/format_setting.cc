// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/text/format_setting.h"

#include <utility>

namespace panelcal::sieb_meyer {
namespace {

constexpr std::string_view kPercentSigns = "%%";

ProgramFormat format_from(const PartialFormat& stated, FileFormat file) {
  ProgramFormat format(file);
  if (stated.unit) format.unit = *stated.unit;
  if (stated.zeros) format.zeros = *stated.zeros;
  format.digits = stated.digits;
  return format;
}

bool mean_the_same(const ProgramFormat& a, const ProgramFormat& b) {
  return a.unit == b.unit && a.zeros == b.zeros && a.decimal_digits() == b.decimal_digits() &&
         (a.zeros == Zeros::TrailingKept || a.integer_digits() == b.integer_digits());
}

/// The parts that count, of --format and the control's setting.
PartialFormat stated_numbers(const FormatMark& mark, const ReadOptions& reading) {
  PartialFormat stated = reading.forced_format;
  const PartialFormat& last = reading.last_format;
  if (mark.setting.empty() || mark.is_special) {
    stated.fill_from(last);
    return stated;
  }
  // The digits of a unit that --format alone names are those of the control in that unit.
  const bool is_other_unit = stated.unit && *stated.unit != LengthUnit::Millimeter;
  if (is_other_unit && !stated.digits && last.digits && last.unit == stated.unit) {
    stated.digits = last.digits;
    stated.from += " and " + last.from;
  }
  return stated;
}

}  // namespace

std::optional<FormatMark> parse_format_mark(std::string_view text) {
  constexpr int kMostSpecial = 10;
  if (!text.starts_with(kPercentSigns)) return std::nullopt;
  FormatMark mark{.setting = text.substr(kPercentSigns.size())};
  if (mark.setting.empty()) {
    mark.file = FileFormat::F1000;
    return mark;
  }
  const auto number = parse_count(mark.setting);
  if (!number || mark.setting.size() != 4 || *number % 1000 > kMostSpecial) return std::nullopt;
  switch (*number / 1000) {
    case 1:
      mark.file = FileFormat::F1000;
      break;
    case 3:
      mark.file = FileFormat::F3000;
      break;
    case 5:
      mark.file = FileFormat::F5000;
      break;
    default:
      return std::nullopt;
  }
  mark.is_special = *number % 1000 > 0;
  return mark;
}

FormatChoice choose_format(const FormatMark& mark,
                           std::string_view text,
                           int line,
                           int column,
                           const ReadOptions& reading,
                           const Reporter& reporter) {
  const auto report = [&](Code code, std::string what, std::string expected) {
    reporter.report(code, line, column, std::move(what), std::move(expected));
  };
  const PartialFormat& forced = reading.forced_format;
  const PartialFormat stated = stated_numbers(mark, reading);
  if (mark.is_special && !(stated.unit && stated.zeros && stated.digits)) {
    report(Code::CommandFormat,
           quoted(text),
           "--format with a unit, zeros and digits, or units, zeros and digits of [program]: the "
           "manual does not describe the formats xx01 to xx10");
    return {mark.file, ""};
  }
  FormatChoice choice{format_from(stated, mark.file), stated.from};
  const ProgramFormat& format = choice.format;
  if (mark.file == FileFormat::F1000 && format.unit == LengthUnit::Inch && !format.digits) {
    report(Code::FormatAmbiguous,
           "steps of " + quoted(text) + " are 0.001 inch or 0.0001 inch",
           "digits, such as --format inch,2.3");
    return {mark.file, ""};
  }
  if (mark.is_special) return choice;
  if (mark.setting.empty()) {
    if (!mean_the_same(format, format_from(forced, mark.file))) {
      report(Code::FormatAssumed,
             quoted(text) + " is read as " + summary(format) + ": " + stated.from,
             "%%1000, if it is in the manual's format 1000, or --format");
    }
  } else if (!format.is_described()) {
    report(Code::FormatOverridden,
           quoted(text) + " is not obeyed in its numbers: " + forced.from,
           "the format that the program states");
  } else if (!forced.unit && reading.last_format.unit == LengthUnit::Inch) {
    report(Code::FormatOverridden,
           quoted(text) + " states millimetres, " + reading.last_format.from + " inch",
           "units = \"metric\" there, or --format inch if the program is in inch");
  }
  return choice;
}

}  // namespace panelcal::sieb_meyer
