// SPDX-License-Identifier: Apache-2.0
#include "tests/program/random/random_program.h"

#include <cstdlib>

namespace panelcal::test {
namespace {

int any(int low, int high) {
  return *rc::gen::inRange(low, high + 1);
}

/// A multiple of 0.0001 inch up to 2 inch either way, now and then as short as it can be.
std::string number() {
  if (any(0, 5) == 0) return "";
  const int steps = any(-20000, 20000);
  const int rest = std::abs(steps) % 10000;
  std::string text = steps < 0 ? "-" : "";
  if (std::abs(steps) >= 10000) text += std::to_string(std::abs(steps) / 10000);
  text += "." + std::string(4 - std::to_string(rest).size(), '0') + std::to_string(rest);
  return text;
}

/// Writes lines, and keeps to the rules that panelcal holds programs to.
class BodyWriter {
 public:
  explicit BodyWriter(bool has_vision) : has_vision_(has_vision) {}

  std::string write() {
    full_hole();
    for (int n = any(1, 4); n > 0; --n) any(0, 2) == 0 ? motion() : section();
    return text_;
  }

 private:
  void line(const std::string& words) { text_ += words + "\n"; }

  void full_hole() {
    if (incremental_) line("G90");
    incremental_ = false;
    line("X" + number() + "Y" + number());
    needs_both_axes_ = false;
    after_section_ = false;
    has_hole_ = true;
  }

  void motion() {
    if (needs_both_axes_ || (after_section_ && !incremental_)) return full_hole();
    switch (any(0, has_hole_ ? 6 : 4)) {
      case 0:
        line("X" + number());
        break;
      case 1:
        line("Y" + number());
        break;
      case 2:
        line("X" + number() + "Y" + number());
        break;
      case 3:
        line(incremental_ ? "G90" : "G91");
        incremental_ = !incremental_;
        return;
      case 4:
        line("; nothing");
        return;
      default:
        line("R" + std::to_string(any(1, 4)) + (any(0, 1) == 0 ? "X" : "X.1Y") + number());
        break;
    }
    has_hole_ = true;
    after_section_ = false;
  }

  void targets() {
    if (incremental_) line("G90");
    incremental_ = false;
    line("G46X.1Y.1");
    line("G46X1.7Y" + number());
    line("G46X.3Y1.9");
    if (any(0, 1) == 0) line("G48X" + number() + "Y" + number());
    needs_both_axes_ = true;
    has_hole_ = false;
  }

  void copy() {
    if (any(0, 5) == 0) return line("M02");
    std::string words = any(0, 2) == 0 ? "R" + std::to_string(any(1, 2)) : "";
    words += "M02X" + number() + "Y" + number();
    for (const char* turn : {"M80", "M90", "M70"}) {
      if (any(0, 3) == 0) words += turn;
    }
    line(words);
  }

  void section() {
    line("M25");
    after_section_ = true;
    has_hole_ = false;
    if (has_vision_) targets();
    for (int n = any(1, 5); n > 0; --n) motion();
    for (int levels = any(1, 3); levels > 0; --levels) {
      line("M01");
      for (int n = any(0, 2); n > 0; --n) copy();
      const std::string last = text_.substr(text_.rfind('\n', text_.size() - 2) + 1);
      if (last.starts_with("M02X")) line("M02");
    }
    line("M08");
    after_section_ = true;
    needs_both_axes_ = false;
    has_hole_ = false;
  }

  bool has_vision_;
  std::string text_;
  bool incremental_ = false;
  bool needs_both_axes_ = false;  ///< a target came last
  bool after_section_ = false;    ///< or at a pattern's begin: no axis is known but to G91
  bool has_hole_ = false;
};

}  // namespace

rc::Gen<std::string> random_body() {
  return rc::gen::exec([] { return BodyWriter(false).write(); });
}

rc::Gen<std::string> random_vision_body() {
  return rc::gen::exec([] { return BodyWriter(true).write(); });
}

}  // namespace panelcal::test
