// SPDX-License-Identifier: Apache-2.0
// Spelling of the numbers and codes of a random job.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <ostream>

#include "tests/program/random/random_job.h"

namespace panelcal::test {
namespace {

std::string number(long steps, int style, const NumberFormat& format, Spelling::Digits digits) {
  if (steps == 0 && style == 8) return "";
  const int n_digits = format.integer_digits + format.decimal_digits;
  std::string text = std::to_string(std::labs(steps));
  if (static_cast<int>(text.size()) < n_digits) {
    text.insert(0, static_cast<std::size_t>(n_digits) - text.size(), '0');
  }
  const auto drop_front = [](std::string& s) {
    s.erase(0, std::min(s.find_first_not_of('0'), s.size()));
  };
  const auto drop_back = [](std::string& s) { s.erase(s.find_last_not_of('0') + 1); };
  const bool keeps_zeros = (style & 1) != 0;
  if (digits == Spelling::Digits::Point || style / 2 == 3) {
    std::string behind = text.substr(text.size() - static_cast<std::size_t>(format.decimal_digits));
    text.resize(text.size() - behind.size());
    drop_front(text);
    if (!keeps_zeros) drop_back(behind);
    if (text.empty() && behind.empty()) text = "0";
    text += "." + behind;
  } else if (!keeps_zeros) {
    digits == Spelling::Digits::LeadingZeros ? drop_back(text) : drop_front(text);
    if (text.empty()) text = "0";
  }
  return (steps < 0 ? "-" : style / 4 == 3 ? "+" : "") + text;
}

/// CNC-7 manual, List of Equivalent Format One Commands.
std::string in_format_one(const std::string& code) {
  static const std::map<std::string, std::string> kEquivalent = {{"G05", "G81"},
                                                                 {"G81", "G82"},
                                                                 {"M00", "M02"},
                                                                 {"M01", "M24"},
                                                                 {"M02", "M26"},
                                                                 {"M06", "M01"},
                                                                 {"M08", "M27"},
                                                                 {"M09", "M00"},
                                                                 {"M70", "M23"},
                                                                 {"M72", "M70"},
                                                                 {"M80", "M21"},
                                                                 {"M90", "M22"}};
  const auto found = kEquivalent.find(code);
  return found == kEquivalent.end() ? code : found->second;
}

void append(std::string& out, const std::vector<TokenLine>& lines, const Job& job, Spelling how) {
  for (const TokenLine& line : lines) {
    for (const Token& token : line) {
      out += how.is_format_one ? in_format_one(token.text) : token.text;
      if (token.steps) out += number(*token.steps, token.style, job.format, how.digits);
    }
    out += '\n';
  }
}

}  // namespace

Length Job::step() const {
  return format.one_unit() * std::pow(10.0, -format.decimal_digits);
}

std::string text_of(const Job& job, const Spelling& spelling, std::string_view targets) {
  const NumberFormat& format = job.header_format;
  std::string text = "M48\n";
  text += format.unit == LengthUnit::Inch ? "INCH," : "METRIC,";
  text += spelling.digits == Spelling::Digits::TrailingZeros ? "TZ" : "LZ";
  if (format.decimal_digits == 2) text += format.integer_digits == 4 ? ",0000.00" : ",000.00";
  text += spelling.is_format_one ? "\nFMAT,1\n" : "\nFMAT,2\n";
  for (const std::string& line : job.header) text += line + "\n";
  text += job.header_end + "\n";
  append(text, job.preamble, job, spelling);
  text += targets;
  append(text, job.body, job, spelling);
  return text;
}

std::ostream& operator<<(std::ostream& out, const Job& job) {
  return out << text_of(job, {});
}

std::ostream& operator<<(std::ostream& out, const RoutedPattern& pattern) {
  return out << pattern.repeated;
}

}  // namespace panelcal::test
