// SPDX-License-Identifier: Apache-2.0
#include "program/excellon/text/stated_format.h"

#include <algorithm>
#include <tuple>
#include <utility>

#include "program/walk/options.h"

namespace panelcal::excellon {
namespace {

template <class Part>
bool parts_differ(const Part& a, const Part& b) {
  return a && b && *a != *b;
}

}  // namespace

StatedFormat::StatedFormat(const ReadOptions& reading) {
  add(Source::Operator, reading.forced_format);
  add(Source::Beside, reading.format_beside.format);
  if (!reading.format_beside.fault) add(Source::Setting, reading.last_format);
}

void StatedFormat::add(Source source, const PartialFormat& statement) {
  if (statement.is_empty()) return;
  Statement added{source, statement, statement.unit};
  // In inch a control has one digit format only (CNC-7 manual, Inch vs. Metric).
  if (source == Source::Setting && !statement.unit) added.unit_of_digits = LengthUnit::Millimeter;
  const auto place = std::ranges::upper_bound(statements_, source, {}, &Statement::source);
  statements_.insert(place, std::move(added));
  decide();
}

void StatedFormat::add_comment_of_body(const PartialFormat& comment) {
  const PartialFormat parts = obeyed(Source::Comment, comment);
  if (parts.is_empty() || (!parts.unit && !states_unit())) return;
  const bool is_known = std::ranges::any_of(statements_, [&](const Statement& of) {
    return of.source == Source::Comment &&
           std::tie(of.parts.unit, of.parts.zeros, of.parts.digits) ==
               std::tie(comment.unit, comment.zeros, comment.digits);
  });
  if (!is_known) add(Source::Comment, comment);
}

/// Of the first source with such a statement: the last one, of comments the first one.
template <class States>
StatedFormat::Index StatedFormat::first_that(const States& states) const {
  Index found;
  for (std::size_t i = 0; i < statements_.size(); ++i) {
    const Source source = statements_[i].source;
    if (found && (source == Source::Comment || source != statements_[*found].source)) break;
    if (states(statements_[i])) found = i;
  }
  return found;
}

void StatedFormat::decide() {
  format_ = {};
  unit_ = first_that([](const Statement& of) { return of.parts.unit.has_value(); });
  if (unit_) format_.unit = *statements_[*unit_].parts.unit;
  zeros_ = first_that([&](const Statement& of) {
    const bool is_of_a_unit = of.source == Source::Comment || of.source == Source::Beside;
    return of.parts.zeros &&
           (!is_of_a_unit || of.parts.unit.value_or(format_.unit) == format_.unit);
  });
  if (zeros_) format_.zeros = *statements_[*zeros_].parts.zeros;
  digits_ = first_that([&](const Statement& of) {
    return of.parts.digits && of.unit_of_digits.value_or(format_.unit) == format_.unit;
  });
  format_.take_usual_digits();
  if (!digits_) return;
  const Statement& digits = statements_[*digits_];
  std::tie(format_.integer_digits, format_.decimal_digits) = *digits.parts.digits;
  format_.states_digits = digits.source != Source::Numbers;
}

bool StatedFormat::uses(Source source) const {
  return source_of_unit() == source || source_of_zeros() == source || source_of_digits() == source;
}

std::string StatedFormat::evidence() const {
  std::string text;
  for (std::size_t i = 0; i < statements_.size(); ++i) {
    const std::string& from = statements_[i].parts.from;
    if (from.empty() || (unit_ != i && zeros_ != i && digits_ != i)) continue;
    text += (text.empty() ? "" : "; ") + from;
  }
  return text;
}

PartialFormat StatedFormat::obeyed(Source source, PartialFormat statement) const {
  const bool rules_unit = source_of_unit() == Source::Operator;
  if (rules_unit && statement.unit.value_or(format_.unit) != format_.unit) {
    statement.digits.reset();
    if (source == Source::Comment) statement.zeros.reset();
  }
  if (rules_unit) statement.unit.reset();
  if (source_of_zeros() == Source::Operator) statement.zeros.reset();
  if (source_of_digits() == Source::Operator) statement.digits.reset();
  return statement;
}

bool StatedFormat::is_overruled(const PartialFormat& statement) const {
  if (statements_.empty() || statements_.front().source != Source::Operator) return false;
  const PartialFormat& ruling = statements_.front().parts;
  return parts_differ(statement.unit, ruling.unit) || parts_differ(statement.zeros, ruling.zeros) ||
         parts_differ(statement.digits, ruling.digits);
}

std::string StatedFormat::ruling() const {
  const bool is_there = !statements_.empty() && statements_.front().source == Source::Operator;
  return is_there ? statements_.front().parts.from : std::string();
}

bool StatedFormat::is_contradicted_by(const PartialFormat& statement, Form form) const {
  const PartialFormat parts = obeyed(Source::Word, statement);
  const bool operator_has_digits = source_of_digits() == Source::Operator;
  const bool operator_has_zeros = source_of_zeros() == Source::Operator;
  const auto is_comment_on_all = [&](const Statement& of) {
    if (of.source != Source::Comment) return false;
    if (of.parts.unit) return *of.parts.unit == format_.unit;
    return (of.parts.digits && !operator_has_digits) || (of.parts.zeros && !operator_has_zeros);
  };
  const bool may_change_unit = form == Form::Code && source_of_unit() == Source::Word &&
                               std::ranges::none_of(statements_, is_comment_on_all);
  return (parts.unit && states_unit() && !may_change_unit && *parts.unit != format_.unit) ||
         (parts.zeros && states_zeros() && *parts.zeros != format_.zeros);
}

void check_obeyed(const StatedFormat& stated,
                  const PartialFormat& statement,
                  std::string_view text,
                  int line,
                  int column,
                  const Reporter& reporter) {
  if (!stated.is_overruled(statement)) return;
  reporter.report(Code::FormatOverridden,
                  line,
                  column,
                  quoted(text) + " is not obeyed: " + stated.ruling(),
                  "the format that the program states");
}

}  // namespace panelcal::excellon
