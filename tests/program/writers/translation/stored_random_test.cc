// SPDX-License-Identifier: Apache-2.0
// Random programs whose boards store corrections (M50, M51, M52), and their translations.
#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/program/random/compared_share.h"
#include "tests/program/writers/translation/boards.h"

namespace panelcal {
namespace {

using test::check_compared;
using test::FunctionSource;
using test::kSameOnPanel_um;
using test::run_on;
using test::small_boards;
using test::translate;
using test::Translation;
using test::WorkRun;

bool may() {
  return *rc::gen::arbitrary<bool>();
}

/// One time of n.
bool may_seldom(int n) {
  return *rc::gen::inRange(0, n) == 0;
}

std::string random_holes() {
  std::string text;
  for (int n = *rc::gen::inRange(1, 4); n > 0; --n) {
    text += fmt::format("X{}.Y{}.\n", *rc::gen::inRange(1, 49), *rc::gen::inRange(1, 49));
  }
  return text;
}

constexpr char kNestedSeries[] = "G46X5.Y5.\nG46X45.Y5.\nG46X5.Y45.\n";

/// Copies by step and repeat, and their number.
struct Copies {
  std::string text;
  int n = 0;
};
Copies random_copies() {
  if (may()) return {"M01\nR1M02X50.\nM01\nR2M02Y50.\nM08\n", 6};
  if (may()) return {"M01\nR3M02X50.\nM08\n", 4};
  return {"M01\nM02X100.M80\nM08\n", 2};
}

/// Boards stored under labels and used several times, in patterns and outside, with cancellations,
/// holes and nested series that are not stored between.
class StoredJob {
 public:
  StoredJob() {
    text_ = "T1\n";
    if (may()) text_ += "G36X0.Y0.\nG36X190.Y0.\nG36X0.Y190.\n";
    copies_ = random_copies();
    is_nested_ = may();
    const int n_labels = *rc::gen::inRange(1, 3);
    for (int label = 1; label <= n_labels; ++label) {
      if (may_seldom(12)) add_written_out();
      if (may_seldom(3)) {
        add_nested();
        text_ += "G47\n";
      }
      begin_recording(label);
      text_ += "M25\n";
      finish_recording();
      for (int n = *rc::gen::inRange(0, 4); n > 0; --n) {
        use();
        if (may_seldom(3)) replay();
        if (is_nested_ && may_seldom(3)) add_nested();
      }
    }
    text_ += "G37\nX1.Y1.\n";
  }

  std::string text() const { return test::boards_in_excellon(text_); }
  /// Texts of the only refusals that a translation to SIEB & MEYER may have.
  const std::vector<std::string>& reasons() const { return reasons_; }

 private:
  void add_written_out() {
    text_ += "M50,9\nM25\nX1.Y1.\nT2\nX2.Y2.\nT1\nM01\nM02X50.\nM08\n";
    reasons_.push_back("whose copies are written out");
  }

  void begin_recording(int label) {
    is_single_[label] = may_seldom(4);
    last_label_ = label;
    text_ += fmt::format("M50,{}\n", label);
  }

  void finish_recording() {
    const bool is_single = is_single_[last_label_];
    if (may()) text_ += (!is_nested_ && may() ? "G47\n" : "") + random_holes();
    if (is_single) {
      text_ += is_nested_ ? "G45X5.Y5.\n" : "G35X5.Y5.\n";
    } else {
      text_ += fmt::format("{0}X5.Y5.\n{0}X45.Y5.\n{0}X5.Y45.\n", is_nested_ ? "G46" : "G36");
    }
    if (may()) text_ += random_holes();
    cancel(is_single);
    text_ += copies_.text;
  }

  /// A nested series that is not stored, in the program itself or in each copy of a pattern.
  void add_nested() {
    if (may()) text_ += "G47\n";
    if (may()) {
      text_ += kNestedSeries + random_holes() + (may() ? "G47\n" : "") + random_holes();
      return;
    }
    text_ += "M25\n";
    text_ += may() ? "G47\n" : may() ? random_holes() : "";
    text_ += kNestedSeries + random_holes();
    if (may()) text_ += "G47\n" + random_holes();
    text_ += copies_.text;
  }

  /// Without M25: each stored correction in its turn, whatever place follows.
  void replay() {
    const int label = last_label_;
    text_ += fmt::format("M51,{}\n", label);
    for (int i = 0; i < copies_.n; ++i) {
      text_ += is_single_[label] ? "M52\n" : may() ? "M52,3\n" : "M52\nM52\nM52\n";
      if (may()) text_ += random_holes();
      if (may_seldom(4)) text_ += "G47\n" + random_holes();
    }
    if (may()) text_ += "G47\n";
    // Behind a pattern with one of its own, an offset from outside would come back.
    if (!text_.ends_with("G47\n") && is_single_[label] && is_nested_) {
      reasons_.push_back("a second nested correction");
    }
  }

  /// The control would end an offset with its copy.
  void cancel(bool is_single) {
    const bool leaves = is_single ? may_seldom(4) : may();
    if (!leaves) text_ += "G47\n";
    if (!leaves || !is_single || !is_nested_) return;
    reasons_.push_back("under the nested correction of");
  }

  void use() {
    if (may()) text_ += may() ? "T1\n" : "T2\n";
    if (may()) text_ += "X1.Y1.\n";
    const int label = may_seldom(4) ? *rc::gen::inRange(1, last_label_ + 1) : last_label_;
    if (label != last_label_) reasons_.push_back("behind those of another label");
    const bool is_single = is_single_[label];
    if (may_seldom(3)) text_ += "G47\nG47\n";
    text_ += fmt::format("M51,{}\n", label);
    // A pattern may use one label and record another.
    const bool records = last_label_ == label && may_seldom(8);
    if (records) begin_recording(label + 1);
    text_ +=
        fmt::format("M25\n{}M52{}\n", may_seldom(3) ? "G47\nG47\n" : "", is_single ? "" : ",3");
    text_ += random_holes();
    if (records) {
      reasons_.push_back("ahead of");
      reasons_.push_back("a second nested correction");
      return finish_recording();
    }
    cancel(is_single);
    if (!is_single && may()) text_ += random_holes();
    text_ += copies_.text;
    if (may()) text_ += "M25\n" + random_holes() + copies_.text;
  }

  std::string text_;
  Copies copies_;
  bool is_nested_ = false;
  std::map<int, bool> is_single_;  ///< by label: of one target
  int last_label_ = 0;
  std::vector<std::string> reasons_;
};

bool is_among(const std::vector<std::string>& reasons, const std::string& refusal) {
  return std::ranges::any_of(reasons, [&](const std::string& reason) {
    return refusal.find(reason) != std::string::npos;
  });
}

TEST(StoredTranslation, RandomJobsDrillTheSameHolesAtTheSamePlaces) {
  check_compared("stored corrections in SIEB & MEYER", 0.2, [] {
    const StoredJob job;
    FunctionSource panel = small_boards();
    const WorkRun before = run_on(panel, job.text());
    RC_LOG(job.text());
    if (!before.errors.empty()) RC_LOG(before.errors.front());
    RC_ASSERT(before.errors.empty());
    const Translation translation = translate(job.text(), Dialect::SiebMeyer);
    RC_LOG(translation.text);
    for (const auto* refusals : {&translation.errors, &translation.losses}) {
      for (const std::string& refusal : *refusals) {
        RC_LOG(refusal);
        RC_ASSERT(is_among(job.reasons(), refusal));
      }
    }
    const bool has_form = translation.errors.empty() && !translation.is_refused;
    RC_CLASSIFY(has_form, "translated");
    if (!has_form) return false;
    FunctionSource panel_after = small_boards();
    const WorkRun after = run_on(panel_after, translation.text);
    if (!after.errors.empty()) RC_LOG(after.errors.front());
    RC_ASSERT(after.errors.empty());
    const double worst_um = distance_um(before, panel, after, panel_after);
    RC_ASSERT(worst_um >= 0);
    RC_ASSERT(worst_um < kSameOnPanel_um);
    return true;
  });
}

/// What translate has written itself. Targets are looked for where they are nominally.
TEST(StoredTranslation, RandomJobsComeBack) {
  check_compared("stored corrections there and back", 0.1, [] {
    const StoredJob job;
    const Translation there = translate(job.text(), Dialect::SiebMeyer);
    if (!there.errors.empty() || there.is_refused) return false;
    const Translation back = translate(there.text, Dialect::Excellon);
    RC_LOG(there.text);
    RC_LOG(back.text);
    for (const std::string& loss : back.losses) RC_LOG(loss);
    RC_ASSERT(back.errors.empty());
    RC_CLASSIFY(!back.is_refused, "came back");
    if (back.is_refused) return false;
    FunctionSource panel = small_boards();
    FunctionSource panel_after = small_boards();
    const WorkRun before = run_on(panel, there.text);
    const WorkRun after = run_on(panel_after, back.text);
    if (!after.errors.empty()) RC_LOG(after.errors.front());
    RC_ASSERT(after.errors.empty());
    const double worst_um = distance_um(before, panel, after, panel_after, true);
    RC_ASSERT(worst_um >= 0);
    RC_ASSERT(worst_um < test::kSameFit_um);
    return true;
  });
}

TEST(StoredTranslation, ExcellonKeepsItsOwnRandomJobs) {
  check_compared("stored corrections in their own language", 0.2, [] {
    const StoredJob job;
    const Translation same = translate(job.text(), Dialect::Excellon);
    RC_LOG(same.text);
    for (const std::string& error : same.errors) RC_ASSERT(is_among(job.reasons(), error));
    RC_ASSERT(same.losses.empty());
    if (!same.errors.empty()) return false;
    FunctionSource panel = small_boards();
    const WorkRun after = run_on(panel, same.text);
    RC_ASSERT(after.errors.empty());
    RC_ASSERT(test::difference_of_work(run_on(panel, job.text()), after).empty());
    return true;
  });
}

}  // namespace
}  // namespace panelcal
