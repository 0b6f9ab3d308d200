// SPDX-License-Identifier: Apache-2.0
// Random SIEB & MEYER programs that measure, save and load corrections in every mode, and probe;
// their translations into Excellon and into their own language, run on the same panel.
#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/program/random/compared_share.h"
#include "tests/program/writers/translation/boards.h"

namespace panelcal {
namespace {

using test::asks_alike;
using test::BulgingBoard;
using test::check_compared;
using test::difference_of_work;
using test::distance_um;
using test::FunctionSource;
using test::kSameFit_um;
using test::run_on;
using test::sieb_meyer;
using test::small_boards;
using test::translate;
using test::Translation;
using test::WorkRun;

int drawn(int low, int high) {
  return *rc::gen::inRange(low, high + 1);
}

/// One time of n.
bool comes_up(int n = 2) {
  return drawn(1, n) == 1;
}

std::string drawn_place() {
  return fmt::format("X{}.Y{}.", drawn(1, 49), drawn(1, 49));
}

/// The first `n` of four copies, each on a board of its own: also turned ones (M60, M90) and mirror
/// images (M70, M80), as SAVE and LOAD of the same program have to agree on them.
std::array<std::string, 4> drawn_offsets() {
  return {*rc::gen::element<std::string>("X0.Y0.M50", "X50.Y0.M60", "X0.Y50.M80"),
          *rc::gen::element<std::string>("X50.Y0.M50", "X100.Y0.M70", "X100.Y0.M60"),
          *rc::gen::element<std::string>("X0.Y50.M50", "X50.Y50.M60", "X0.Y100.M80"),
          *rc::gen::element<std::string>("X100.Y100.M90", "X50.Y50.M60M70", "X100.Y100.M60M80")};
}

std::string first_of(const std::array<std::string, 4>& offsets, int n) {
  std::string text;
  for (std::size_t i = 0; i < static_cast<std::size_t>(n); ++i) {
    text += offsets[i] + (static_cast<int>(i) + 1 < n ? "\n" : "M30\n");
  }
  return text;
}

/// What a program measures, saves and loads, with holes between. Most of it can be executed.
class MeasuringJob {
 public:
  /// With orders that SIEB & MEYER alone has: other modes than 1, G31 again, probes.
  explicit MeasuringJob(bool has_own_orders) : has_own_orders_(has_own_orders) {
    if (has_own_orders_) mode_ = *rc::gen::element(1, 1, 2, 3, 5);
    options_.sieb_meyer.measurement_mode = mode_;
    text_ = "T1\n";
    if (comes_up(4)) add_placement();
    for (int n = drawn(2, 8); n > 0; --n) {
      comes_up(3) ? add_section() : add_order();
      if (comes_up(8)) add_placement();
    }
    text_ += "G34\nM49,NOCAMA\nX1.Y1.T1\n";
  }

  std::string text() const { return sieb_meyer(text_); }
  const WalkOptions& options() const { return options_; }

 private:
  void add_holes(int n_most = 3) {
    for (int n = drawn(1, n_most); n > 0; --n) {
      text_ += drawn_place() + (comes_up(4) ? "" : fmt::format("T{}", drawn(1, 2))) + '\n';
    }
  }

  /// What turns and scales the program is in the places of a translation. A slot of mode 5 shows
  /// one coordinate of the board: it may be turned by quarters alone.
  void add_placement() {
    switch (drawn(1, 4)) {
      case 1:
        text_ += fmt::format("M49,RA{}.\n", mode_ == 5 ? 90 : *rc::gen::element(90, 2, -3));
        break;
      case 2:
        text_ += fmt::format("M49,SAX{}.Y{}.\nM93\n", drawn(100, 400), drawn(-300, 300));
        break;
      case 3:
        text_ += "M49,NORA\n";
        break;
      default:
        text_ += "M49,NOSA\n";
        break;
    }
  }

  void add_targets() {
    if (mode_ == 5) {
      text_ += "X5.Y5.G33\nX25.Y5.G32\nX5.Y45.G33\nX45.Y25.G32\n";
      return;
    }
    constexpr const char* kTargets[] = {"X5.Y5.", "X45.Y5.", "X5.Y45."};
    const int n_targets = drawn(1, 3);
    for (int i = 0; i < n_targets; ++i) {
      if (mode_ != 1 && comes_up()) text_ += kTargets[i] + std::string("G32\n");
      text_ += kTargets[i] + std::string(mode_ != 1 || comes_up() ? "G33\n" : "G32\n");
    }
  }

  void add_series() {
    if (comes_up()) text_ += "G34\n";
    add_targets();
    text_ += "G31\n";
    has_base_ = true;
  }

  void add_order() {
    switch (drawn(0, 12)) {
      case 0:
      case 1:
        return add_series();
      case 2:
        text_ += *rc::gen::element("G30\n", "G30\n", "G34\n", "G30\nG30\n");
        if (text_.ends_with("G34\n") || text_.ends_with("G30\nG30\n")) has_base_ = false;
        break;
      case 3:
        if (has_base_) text_ += fmt::format("G39,SAVE{}\n", last_set_ = 900 + drawn(1, 2));
        break;
      case 4:
        if (last_set_ > 0) {
          text_ += fmt::format("G39,LOAD{}\n", last_set_);
          has_base_ = true;
        }
        break;
      case 5:
        if (n_saved_ > 0) {
          text_ += fmt::format("G39,LOAD{}\n", drawn(1, n_saved_));
          has_base_ = true;
        }
        break;
      case 6:
        text_ += "M49,CAMA\n" + drawn_place() + "G36\n";
        break;
      case 7:
        text_ += "M49,NOCAMA\n" + drawn_place() + "T1G36\n";
        break;
      case 8:
        if (comes_up(3)) add_targets();  // they wait
        break;
      case 9:
        if (has_own_orders_ && has_base_) text_ += "G31\n";
        break;
      case 10:
        if (has_own_orders_) add_probe();
        break;
      case 11:
        text_ += fmt::format("G35,{}\n", drawn(1, 3));
        break;
      default:
        break;
    }
    if (comes_up()) add_holes();
  }

  void add_probe() {
    text_ += fmt::format("G71K.{}\n", drawn(1, 5)) + drawn_place() + "T1G73L1\n";
    add_holes();
    text_ += "G70\n";
  }

  /// Each copy measures and saves, or loads what a section before has saved, or works.
  void add_section() {
    const int n_copies = drawn(1, 4);
    const bool is_nested = comes_up(6);
    text_ += is_nested ? "M31M31\n" : "M31\n";
    if (comes_up(4)) add_holes();
    const int kind = drawn(0, 3);
    if (kind == 0) {
      constexpr const char* kOffset = "M49,CAMA\nX25.Y25.G36\n";
      const bool has_series = !comes_up(4);  // else an offset alone
      if (has_series) add_series();
      if (has_series && comes_up(6)) text_ += "G39,SAVE\n";
      if (!has_series || comes_up(4)) text_ += kOffset;
      if (comes_up()) add_holes();
      text_ += "G39,SAVE\n";
      n_saved_ = n_copies;
    } else if (kind == 1 && n_saved_ >= n_copies) {
      text_ += "G39,LOAD\n";
      has_base_ = true;
    } else {
      for (int n = drawn(0, 2); n > 0; --n) add_order();
    }
    if (comes_up(4)) add_order();
    add_holes();
    text_ += first_of(offsets_, n_copies);
    if (is_nested) text_ += comes_up() ? "X0Y0M50M30\n" : "X0Y0M50\nX100.Y0M50M30\n";
  }

  bool has_own_orders_;
  int mode_ = 1;
  WalkOptions options_;
  std::array<std::string, 4> offsets_ = drawn_offsets();
  std::string text_;
  bool has_base_ = false;
  int last_set_ = 0;
  int n_saved_ = 0;  ///< locations of copies
};

/// Both runs of a job, and its translation if all of it has a form.
struct Runs {
  explicit Runs(const MeasuringJob& job, Dialect to)
      : panel(small_boards()), panel_after(small_boards()) {
    BulgingBoard board;
    before = run_on(panel, board, job.text(), job.options());
    if (!before.errors.empty()) return;
    translation = translate(job.text(), to, job.options());
    RC_LOG(job.text());
    RC_LOG(translation.text);
    for (const std::string& loss : translation.losses) RC_LOG(loss);
    has_form = translation.errors.empty() && !translation.is_refused;
    if (!has_form) return;
    after = run_on(panel_after, board, translation.text, job.options());
    if (!after.errors.empty()) RC_LOG(after.errors.front());
    RC_ASSERT(after.errors.empty());
  }

  FunctionSource panel;
  FunctionSource panel_after;
  WorkRun before;
  WorkRun after;
  Translation translation;
  bool has_form = false;
};

/// Whatever is not refused drills the same holes.
TEST(RandomSets, SavedCorrectionsAreTheSameInExcellon) {
  check_compared("saved corrections in Excellon", 0.2, [] {
    const Runs runs(MeasuringJob(false), Dialect::Excellon);
    RC_CLASSIFY(!runs.before.errors.empty(), "not executable");
    RC_CLASSIFY(runs.has_form, "translated");
    if (!runs.has_form) return false;
    // Targets that G34 forgets are looked for in the source alone, at places that may come again.
    const double worst_um =
        distance_um(runs.before, runs.panel, runs.after, runs.panel_after, true);
    RC_LOG(std::to_string(worst_um));
    RC_ASSERT(worst_um >= 0);
    RC_ASSERT(worst_um < kSameFit_um);
    return true;
  });
}

/// The only refusals that a program may have in its own language.
bool is_of_written_out_copy(const std::string& refusal) {
  return refusal.find("ends with a copy that is written out") != std::string::npos;
}

TEST(RandomSets, SiebMeyerKeepsItsOwnSets) {
  check_compared("saved corrections in their own language", 0.2, [] {
    const Runs runs(MeasuringJob(true), Dialect::SiebMeyer);
    RC_CLASSIFY(!runs.before.errors.empty(), "not executable");
    RC_CLASSIFY(runs.has_form, "translated");
    RC_ASSERT(runs.translation.errors.empty());
    RC_ASSERT(std::ranges::all_of(runs.translation.losses, is_of_written_out_copy));
    if (!runs.has_form) return false;
    RC_ASSERT(asks_alike(runs.before, runs.after));
    const std::string difference = difference_of_work(runs.before, runs.after);
    RC_LOG(difference);
    RC_ASSERT(difference.empty());
    return true;
  });
}

}  // namespace
}  // namespace panelcal
