// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "tests/program/sieb_meyer/random_sm_job.h"

namespace panelcal::test {
namespace {

/// A few choices out of one number.
class Choices {
 public:
  Choices(unsigned style, int line_style) : state_(style * 2654435761U + unsigned(line_style)) {
    is_plain_ = style == 0;
  }
  /// Always 0 in the plainest spelling.
  unsigned below(unsigned n) {
    if (is_plain_) return 0;
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<unsigned>((state_ >> 33) % n);
  }
  bool one_in(unsigned n) { return below(n) == 1; }

 private:
  std::uint64_t state_;
  bool is_plain_ = false;
};

/// With a decimal point: all decimals, or without the zeros behind and in front.
std::string with_point(long steps, SmUnit unit, Choices& choices) {
  const long per_unit = unit == SmUnit::Microns     ? 1000
                        : unit == SmUnit::InchSteps ? 10'000
                                                    : 100'000;
  const long most = std::labs(steps) * (unit == SmUnit::InchStepsInMetric ? 254 : 1);
  std::string whole = std::to_string(most / per_unit);
  std::string decimals = std::to_string(per_unit + most % per_unit).substr(1);
  if (choices.one_in(2)) {
    while (!decimals.empty() && decimals.back() == '0') decimals.pop_back();
  }
  if (whole == "0" && !decimals.empty() && choices.one_in(2)) whole.clear();
  return (steps < 0 ? "-" : "") + whole + "." + decimals;
}

std::string spelled(const SmWord& word, SmUnit unit, Choices& choices) {
  if (!word.um) {
    // G1 may be G01, but a third digit makes another code.
    const bool is_code = word.text[0] == 'G' || word.text[0] == 'T';
    const bool is_short = is_code && word.text.size() == 2;
    return is_short && choices.one_in(4) ? word.text.substr(0, 1) + "0" + word.text.substr(1)
                                         : word.text;
  }
  const long um = *word.um;
  if (um == 0 && choices.one_in(2)) return word.text;
  if (choices.one_in(2) || unit == SmUnit::InchStepsInMetric) {
    return word.text + with_point(um, unit, choices);
  }
  const std::string sign = um > 0 && choices.one_in(8) ? "+" : "";
  const long step = unit == SmUnit::Microns ? word.step_um : 1;
  return word.text + sign + std::to_string(um / step);
}

void append(std::string& out, const SmLine& line, const SmSpelling& spelling) {
  Choices choices(spelling.style, line.style);
  if (choices.one_in(12)) out += "(A COMMENT)" + spelling.line_end;
  if (choices.one_in(12)) out += spelling.line_end;
  std::vector<std::string> words;
  for (const SmWord& word : line.words) words.push_back(spelled(word, spelling.unit, choices));
  for (std::size_t i = words.size(); i > 1; --i) {
    std::swap(words[i - 1], words[i - 1 - choices.below(static_cast<unsigned>(i))]);
  }
  // Brackets alone are read from left to right.
  std::vector<std::string> brackets;
  for (const std::string& word : words) {
    if (word == "M31" || word == "M30") brackets.push_back(word);
  }
  std::ranges::sort(brackets, std::greater());
  auto next = brackets.begin();
  for (std::string& word : words) {
    if (word == "M31" || word == "M30") word = *next++;
  }
  if (line.is_slashed) out += '/';
  const bool has_blanks = choices.one_in(4);
  for (const std::string& word : words) {
    out += word;
    if (has_blanks) out.append(choices.below(3), ' ');
  }
  out += line.tail;
  const bool has_text = line.tail.starts_with('M');
  if (!has_text && choices.one_in(6)) out += " (X1Y1 M30)";
  out += spelling.line_end;
}

}  // namespace

std::string text_of(const SmJob& job, const SmSpelling& spelling) {
  Choices choices(spelling.style, 0);
  std::string out;
  if (choices.one_in(2)) out += "A JOB" + spelling.line_end;
  const bool is_3000 = job.is_3000 && spelling.unit == SmUnit::Microns;
  out += (is_3000 ? "%%3000" : "%%5000") + spelling.line_end;
  for (const SmLine& line : job.lines) append(out, line, spelling);
  out += "$" + spelling.line_end;
  for (std::size_t i = 0; i < kSmTools_um.size(); ++i) {
    const long um = kSmTools_um[i];
    const bool has_point = (!is_3000 && choices.one_in(2)) || spelling.unit != SmUnit::Microns;
    out += "T" + std::to_string(i + 1) + "D" +
           (has_point ? with_point(um, spelling.unit, choices) : std::to_string(um / 10)) +
           spelling.line_end;
  }
  return out + "$" + spelling.line_end;
}

SmSpelling any_sm_spelling() {
  return {*rc::gen::element<std::string>("\n", "\r", "\r\n", "\n\r"),
          *rc::gen::resize(rc::kNominalSize, rc::gen::inRange(1U, 1'000'000U))};
}

std::ostream& operator<<(std::ostream& out, const SmJob& job) {
  return out << (job.deletes_blocks ? "blocks deleted\n" : "") << text_of(job, {});
}

}  // namespace panelcal::test
