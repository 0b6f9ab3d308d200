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

/// Takes the parts of another source that `format` leaves open; digits of another unit stay out,
/// and those without a unit are millimetres'.
void fill_from(const PartialFormat& other, PartialFormat& format) {
  const LengthUnit unit_of_digits = other.unit.value_or(LengthUnit::Millimeter);
  const bool takes_digits =
      !format.digits && format.unit.value_or(unit_of_digits) == unit_of_digits;
  const bool takes_more = (!format.unit && other.unit) || (!format.zeros && other.zeros);
  if (takes_digits) format.digits = other.digits;
  if (!format.unit) format.unit = other.unit;
  if (!format.zeros) format.zeros = other.zeros;
  if (!takes_more && !(takes_digits && other.digits)) return;
  format.from += (format.from.empty() ? "" : " and ") + other.from;
}

/// The digits behind %% state the numbers, but --format another unit.
bool is_overridden(const FormatMark& mark, const PartialFormat& forced) {
  return !mark.setting.empty() && !mark.is_special && forced.unit == LengthUnit::Inch;
}

bool is_whole(const PartialFormat& format) {
  return format.unit && format.zeros && format.digits;
}

/// The parts that count, of --format and the control's setting.
PartialFormat stated_numbers(const FormatMark& mark, const ReadOptions& reading) {
  PartialFormat stated = reading.forced_format;
  const PartialFormat& last = reading.last_format;
  if (mark.setting.empty() || mark.is_special) {
    if (mark.is_special || is_whole(last)) fill_from(last, stated);
    return stated;
  }
  // The digits of a unit that --format alone names are those of the control in that unit.
  if (is_overridden(mark, stated) && !stated.digits && last.digits &&
      last.unit == LengthUnit::Inch) {
    stated.digits = last.digits;
    stated.from += " and " + last.from;
  }
  return stated;
}

struct OpenPart {
  std::string what;
  std::string expected;
};

/// What is left open of the numbers, so that they cannot be read.
std::optional<OpenPart> find_open_part(const FormatMark& mark,
                                       std::string_view text,
                                       const ProgramFormat& format,
                                       const ReadOptions& reading) {
  if (mark.file == FileFormat::F1000 && format.unit == LengthUnit::Inch && !format.digits) {
    return OpenPart{"steps of " + quoted(text) + " are 0.001 inch or 0.0001 inch",
                    "digits, such as --format inch,2.3"};
  }
  // The manual has no number of digits before the point.
  if (format.zeros == Zeros::LeadingKept && !format.digits) {
    return OpenPart{quoted(text) + " counts from the left of an unknown number of digits",
                    "digits as well, such as --format lz,3.3"};
  }
  const PartialFormat& last = reading.last_format;
  if (mark.setting.empty() && !reading.forced_format.unit && last.unit == LengthUnit::Inch &&
      !is_whole(last)) {
    return OpenPart{quoted(text) + " is in millimetres, or in the inch of " + last.from,
                    "zeros and digits there as well, or %%1000, or --format"};
  }
  const bool has_two_zeros = is_overridden(mark, reading.forced_format) &&
                             !reading.forced_format.zeros && last.zeros == Zeros::LeadingKept &&
                             last.unit != LengthUnit::Millimeter;
  if (!has_two_zeros) return std::nullopt;
  return OpenPart{
      quoted(text) + " keeps trailing zeros, in millimetres; " + last.from + " leading ones",
      "zeros as well, such as --format inch,tz"};
}

/// The numbers of programs that state nothing, on this control.
ProgramFormat format_of_control(const ReadOptions& reading, FileFormat file) {
  PartialFormat stated = reading.forced_format;
  fill_from(reading.last_format, stated);
  return format_from(stated, file);
}

/// %% alone and special formats are in the control's numbers, as subprograms are.
SubprogramNumbers numbers_of_subprograms(const FormatMark& mark,
                                         const ProgramFormat& program,
                                         const ProgramFormat& control) {
  if (mark.setting.empty() || mark.is_special || mean_the_same(program, control)) {
    return SubprogramNumbers::OfProgram;
  }
  return program.unit == control.unit ? SubprogramNumbers::OpenWithoutPoint
                                      : SubprogramNumbers::Open;
}

/// Warns where %% alone is not format 1000, or a setting that is not whole would be something else.
void warn_of_default(std::string_view text,
                     const FormatChoice& choice,
                     const ReadOptions& reading,
                     const auto& report) {
  const ProgramFormat& format = choice.format;
  const bool counts = !mean_the_same(format, format_from(reading.forced_format, format.file));
  if (counts) {
    return report(Code::FormatAssumed,
                  quoted(text) + " is read as " + summary(format) + ": " + choice.evidence,
                  "%%1000, if it is in the manual's format 1000, or --format");
  }
  if (is_whole(reading.last_format) ||
      mean_the_same(format, format_of_control(reading, format.file))) {
    return;
  }
  report(Code::FormatAssumed,
         quoted(text) + " is read as " + summary(format) + ", though " + reading.last_format.from +
             " has a part of another format",
         "%%1000, or units, zeros and digits there, or --format");
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
  if (mark.is_special && !is_whole(stated)) {
    report(Code::CommandFormat,
           quoted(text),
           "--format with a unit, zeros and digits, or units, zeros and digits of [program]: the "
           "manual does not describe the formats xx01 to xx10");
    return {.format = mark.file};
  }
  FormatChoice choice{.format = format_from(stated, mark.file), .evidence = stated.from};
  ProgramFormat& format = choice.format;
  format.inch_rates = reading.inch_rates;
  if (auto open = find_open_part(mark, text, format, reading)) {
    report(Code::FormatAmbiguous, std::move(open->what), std::move(open->expected));
    return {.format = mark.file};
  }
  choice.subprograms = numbers_of_subprograms(mark, format, format_of_control(reading, mark.file));
  if (mark.is_special) return choice;
  if (mark.setting.empty()) {
    warn_of_default(text, choice, reading, report);
  } else if (!format.is_described()) {
    report(Code::FormatOverridden,
           quoted(text) + " is read as " + summary(format) + ": " + choice.evidence,
           "the format that the program states");
  } else if (!forced.unit && reading.last_format.unit == LengthUnit::Inch) {
    report(Code::FormatOverridden,
           quoted(text) + " states millimetres, " + reading.last_format.from + " inch",
           "units = \"metric\" there, or --format inch if the program is in inch");
  }
  return choice;
}

}  // namespace panelcal::sieb_meyer
