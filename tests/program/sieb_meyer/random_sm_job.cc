// SPDX-License-Identifier: Apache-2.0
#include "tests/program/sieb_meyer/random_sm_job.h"

#include <array>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "tests/program/sieb_meyer/random_draws.h"
#include "tests/program/sieb_meyer/random_sm_contours.h"

namespace panelcal::test {
namespace {

/// Writes lines and what they mean, and keeps to the rules that panelcal holds programs to.
class JobWriter : SmContourWriter {
 public:
  explicit JobWriter(SmTargets targets) {
    job_.has_targets = targets == SmTargets::OfTheBoard;
    job_.is_3000 = !job_.has_targets && one_in(3);
    job_.deletes_blocks = one_in(2);
    nodes_ = &job_.nodes;
  }

  SmJob write() {
    if (job_.has_targets) board_targets();
    const bool has_brackets = job_.has_targets || !one_in(4);
    if (!has_brackets) {
      for (int n = any(1, 3); n > 0; --n) unbracketed();
      return std::move(job_);
    }
    first_tool();
    for (int n = any(1, 5); n > 0; --n) one_in(2) ? section(1) : piece();
    if (job_.has_targets && one_in(3)) correction_off();
    return std::move(job_);
  }

 private:
  // --- drilling ---

  void first_tool() {
    take_any_tool();
    hole();
  }

  void piece() {
    switch (any(0, 9)) {
      case 0:
      case 1:
        return contour();
      case 2:
        return rounded_contour();
      case 3:
        return figures();
      case 4:
        return pattern();
      case 5:
        return idle_line();
      case 6:
        return job_.has_targets ? target_hole() : slashed_hole();
      default:
        return hole();
    }
  }

  void hole() {
    for (int n = any(1, 3); n > 0; --n) {
      modes();
      SmNode node;
      node.place = any_place();
      line(go_to(node.place));
      add(std::move(node));
    }
  }

  void target_hole() {
    if (one_in(4)) take_any_tool();
    SmNode node;
    node.kind = Kind::TargetHole;
    node.place = any_place();
    line(go_to(node.place), "G36");
    add(std::move(node));
  }

  /// If blocks are deleted, it is as if the line were not there.
  void slashed_hole() {
    if (!prefix_.empty()) return hole();
    const Microns before = at_;
    const bool was_behind_section = is_behind_section_;
    const bool was_incremental = std::exchange(incremental_, false);
    SmNode node;
    node.place = any_place();
    std::vector<SmWord> words = go_to(node.place);
    if (was_incremental) words.push_back(code("G90"));
    line(std::move(words), {}, true);
    if (!job_.deletes_blocks) {
      add(std::move(node));
      return;
    }
    at_ = before;
    incremental_ = was_incremental;
    is_behind_section_ = was_behind_section;
  }

  void pattern() {
    modes();
    SmNode node;
    node.kind = Kind::Pattern;
    node.number = any(1, job_.is_3000 ? 2 : 4);
    node.place = any_place();
    if (node.number == 2 || node.number == 4) {
      node.n_in_row = any(2, 9);
      node.second = node.place + Microns{any(300, 30'000), any_either_way(30'000)};
    } else {
      grid(node);
    }
    std::vector<SmWord> words = go_to(node.place);
    words.push_back(code("V" + std::to_string(node.number)));
    line(std::move(words));
    words = go_to(node.second);
    if (node.n_in_row) words.push_back(code("W" + std::to_string(*node.n_in_row)));
    line(std::move(words));
    add(std::move(node));
  }

  void grid(SmNode& node) {
    const bool is_falling = one_in(2);
    const long n_along = any(1, 6);
    const long n_across = any(1, 6);
    const bool is_free = one_in(2);
    const long pitch_um = is_free ? any(500, 4000) : 2540;
    // The corner may be off by up to half a pitch, but with W the rows keep their length.
    const auto off = [&] { return any_either_way(static_cast<int>(pitch_um) / 2 - 20); };
    const long along = n_along * pitch_um + (is_free ? 0 : off());
    const long across = n_across * pitch_um + off();
    if (is_free) node.n_in_row = static_cast<int>(n_along) + 1;
    const Microns sides = is_falling ? Microns{along, across} : Microns{across, along};
    const long sign = one_in(2) ? 1 : -1;
    node.second =
        node.place + Microns{sign * sides.x, is_falling ? -sign * sides.y : sign * sides.y};
  }

  // --- sections ---

  /// Offsets without brackets move everything since the last ones.
  void unbracketed() {
    std::vector<SmNode>* const outside = nodes_;
    SmNode node;
    node.kind = Kind::Section;
    nodes_ = &node.body;
    first_tool();
    for (int n = any(0, 3); n > 0; --n) piece();
    offsets(node, false);
    nodes_ = outside;
    add(std::move(node));
  }

  void section(int depth) {
    constexpr int kMostDepth = 3;
    std::vector<SmNode>* const outside = nodes_;
    SmNode node;
    node.kind = Kind::Section;
    nodes_ = &node.body;
    if (one_in(3)) {
      plain_line({code("M31")});
    } else {
      prefix_.push_back(code("M31"));
    }
    if (depth == kMostDepth || !one_in(4)) hole();
    for (int n = any(0, 3); n > 0; --n)
      depth < kMostDepth&& one_in(3) ? section(depth + 1) : piece();
    if (!prefix_.empty()) hole();
    if (one_in(4)) {
      close();
    } else {
      offsets(node, true);
    }
    nodes_ = outside;
    add(std::move(node));
  }

  /// M30 alone, or in the last line, whose coordinate still belongs to the section.
  void close() {
    SmLine& last = job_.lines.back();
    const bool may_join = last.tail.empty() && !last.words.empty() && !last.is_slashed;
    if (may_join && one_in(2)) {
      last.words.push_back(code("M30"));
    } else {
      plain_line({code("M30")});
    }
  }

  void offsets(SmNode& node, bool is_bracketed) {
    for (int n = any(1, 3); n > 0; --n) {
      if (!job_.is_3000 && one_in(4)) {
        row(node);
        continue;
      }
      const std::array<const char*, 8> kinds = {"50", "50", "60", "70", "80", "90", "6070", "6080"};
      const std::string kind = one_in(8) ? "6090" : any_of(kinds);
      const Microns zero = any_place();
      std::vector<SmWord> words = offset(zero);
      words.push_back(code("M" + kind.substr(0, 2)));
      if (kind.size() > 2) words.push_back(code("M" + kind.substr(2)));
      line(std::move(words));
      node.copies.emplace_back(kind, zero);
    }
    if (is_bracketed) close();
    at_ = {};
    incremental_ = false;
    is_behind_section_ = true;
  }

  /// Always absolute; what is left out is 0.
  static std::vector<SmWord> offset(Microns zero) {
    std::vector<SmWord> words;
    if (zero.x != 0 || one_in(2)) words.push_back({"X", zero.x});
    if (zero.y != 0 || words.empty() || one_in(2)) words.push_back({"Y", zero.y});
    return words;
  }

  /// M50V2: n copies from the first to the last zero point; exact steps, so that the model may list
  /// them.
  void row(SmNode& node) {
    const int n = any(2, 4);
    const Microns first = any_place();
    const Microns step = any_place(50'000);
    std::vector<SmWord> words = offset(first);
    words.push_back(code("M50"));
    words.push_back(code("V2"));
    line(std::move(words));
    const Microns last = first + Microns{(n - 1) * step.x, (n - 1) * step.y};
    words = offset(last);
    words.push_back(code("M50"));
    words.push_back(code("W" + std::to_string(n)));
    line(std::move(words));
    for (int i = 0; i < n; ++i) {
      node.copies.emplace_back("50", first + Microns{i * step.x, i * step.y});
    }
  }

  // --- targets ---

  void board_targets() {
    const std::array<Microns, 4> places = {
        {{1000, 2000}, {240'000, 3000}, {5000, 180'500}, {238'000, 190'000}}};
    const int n = any(2, 4);
    for (int i = 0; i < n; ++i) {
      line(go_to(places[static_cast<std::size_t>(i)], i == 0), one_in(2) ? "G32" : "G33");
    }
    plain_line({}, "G31");
    correction(true);
  }

  void correction_off() {
    plain_line({}, "G30");
    correction(false);
    hole();
  }

  void correction(bool is_on) {
    SmNode node;
    node.kind = Kind::Correction;
    node.is_on = is_on;
    add(std::move(node));
  }
};

}  // namespace

rc::Gen<SmJob> random_sm_job(SmTargets targets) {
  return rc::gen::exec([targets] { return JobWriter(targets).write(); });
}

}  // namespace panelcal::test
