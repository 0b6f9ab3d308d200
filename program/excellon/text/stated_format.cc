// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/stated_format.h"

#include <tuple>

#include "program/walk/options.h"

namespace panelcal::excellon {

StatedFormat::StatedFormat(const ReadOptions& reading) {
  add(Source::Operator, reading.forced_format);
  add(Source::Beside, reading.format_beside.format);
  if (!reading.format_beside.fault) add(Source::Setting, reading.last_format);
}

void StatedFormat::add(Source source, const PartialFormat& parts) {
  PartialFormat& known = parts_[static_cast<std::size_t>(source)];
  // Digits belong to the unit that they were stated with.
  if (parts.unit && known.unit && *parts.unit != *known.unit) known.digits.reset();
  if (parts.unit) known.unit = parts.unit;
  if (parts.zeros) known.zeros = parts.zeros;
  if (parts.digits) known.digits = parts.digits;
  if (!parts.from.empty()) known.from = parts.from;
  decide();
}

void StatedFormat::decide() {
  const auto first = [&](const auto& states) {
    std::optional<Source> source;
    for (std::size_t i = 0; i < kSources && !source; ++i) {
      if (states(parts_[i])) source = static_cast<Source>(i);
    }
    return source;
  };
  format_ = {};
  unit_ = first([](const PartialFormat& parts) { return parts.unit.has_value(); });
  if (unit_) format_.unit = *of(*unit_).unit;
  const auto is_of_unit = [&](const PartialFormat& parts) {
    return parts.unit.value_or(format_.unit) == format_.unit;
  };
  // Of a comment on numbers of the other unit, zeros mean nothing either.
  const PartialFormat& comment = of(Source::Comment);
  zeros_ = first([&](const PartialFormat& parts) {
    return parts.zeros && (&parts != &comment || is_of_unit(parts));
  });
  if (zeros_) format_.zeros = *of(*zeros_).zeros;
  digits_ = first([&](const PartialFormat& parts) { return parts.digits && is_of_unit(parts); });
  format_.take_usual_digits();
  if (!digits_) return;
  std::tie(format_.integer_digits, format_.decimal_digits) = *of(*digits_).digits;
  format_.states_digits = *digits_ != Source::Numbers;
}

std::string StatedFormat::evidence() const {
  std::string text;
  for (std::size_t i = 0; i < kSources; ++i) {
    if (parts_[i].from.empty() || !uses(static_cast<Source>(i))) continue;
    text += (text.empty() ? "" : "; ") + parts_[i].from;
  }
  return text;
}

void StatedFormat::check_obeyed(const PartialFormat& statement,
                                std::string_view text,
                                int line,
                                int column,
                                const Reporter& reporter) const {
  const PartialFormat& ruling = of(Source::Operator);
  const auto differ = [](const auto& a, const auto& b) { return a && b && *a != *b; };
  if (!differ(statement.unit, ruling.unit) && !differ(statement.zeros, ruling.zeros) &&
      !differ(statement.digits, ruling.digits)) {
    return;
  }
  reporter.report(Code::FormatOverridden,
                  line,
                  column,
                  quoted(text) + " is not obeyed: " + ruling.from,
                  "the format that the program states");
}

}  // namespace panelcal::excellon
