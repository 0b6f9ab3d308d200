// SPDX-License-Identifier: Apache-2.0
// Random SIEB & MEYER programs in inch do what the same programs do in millimetres.
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <variant>
#include <vector>

#include <Eigen/Core>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/program/random/compared_share.h"
#include "tests/program/sieb_meyer/random_draws.h"
#include "tests/program/sieb_meyer/random_sm_job.h"
#include "tests/program/writers/translation/run.h"

namespace panelcal {
namespace {

using test::random_sm_job;
using test::run_nominally;
using test::SmJob;
using test::SmSpelling;
using test::SmTargets;
using test::SmUnit;
using test::text_of;
using test::Translation;
using test::WorkRun;

/// Both texts state the same lengths; doubles of up to 1 m, added up and turned a few times.
constexpr test::Tolerance kSameLengths = {.place_mm = 1e-6, .center_mm = 1e-6, .rate_mm_s = 1e-6};

/// With all digits, but rates are whole in Excellon.
constexpr test::Tolerance kWritten = {.place_mm = 1e-4, .center_mm = 1e-4, .rate_mm_s = 1};

/// Feeds stand in both texts as they are.
ReadOptions inch() {
  return {.forced_format = *parse_format("inch"), .inch_rates = RateUnit::MetersPerMinute};
}

SmJob any_job() {
  return *random_sm_job(test::one_in(3) ? SmTargets::OfTheBoard : SmTargets::None);
}

SmSpelling any_spelling(SmUnit unit) {
  SmSpelling spelling = test::any_sm_spelling();
  spelling.unit = unit;
  return spelling;
}

/// Lines and codes: columns and texts follow the program's own numbers.
std::vector<std::string> places_of(const std::vector<std::string>& errors) {
  std::vector<std::string> places;
  for (const std::string& error : errors) {
    const auto line_end = error.find(':', error.find(':') + 1);
    const auto code = error.find('[');
    places.push_back(error.substr(0, line_end) + error.substr(code, error.find(']') - code));
  }
  return places;
}

/// Holes and contours, and the tools that are taken. Half a circle may come in two parts, as its
/// doubles are rounded.
std::vector<test::Event> work_and_tools(const WorkRun& run) {
  std::vector<test::Event> events = test::work_of(run.events);
  for (const test::Event& event : run.events) {
    if (std::holds_alternative<ToolChange>(event.what)) events.push_back(event);
  }
  return events;
}

/// Exact, since a step of 0.0001 inch is 0.00254 mm: what does not follow the unit shows at once.
RC_GTEST_PROP(InchJob, DoesWhatItDoesInMillimetres, ()) {
  const SmJob job = any_job();
  const std::string in_inch = text_of(job, any_spelling(SmUnit::InchSteps));
  // With the same comments in the same lines, where errors are named.
  const std::string plain = text_of(job, {.unit = SmUnit::InchSteps});
  const std::string in_mm = text_of(job, {.unit = SmUnit::InchStepsInMetric});
  const WorkRun expected = run_nominally(in_mm);
  const WorkRun found = run_nominally(plain, {}, inch());
  RC_LOG(plain);
  RC_LOG(in_mm);
  RC_ASSERT(places_of(found.errors) == places_of(expected.errors));
  // Rows at 0.1 inch whose corner is just between two places, or a contour that is too short.
  RC_PRE(expected.errors.empty());
  const std::string difference =
      test::difference(work_and_tools(expected), work_and_tools(found), kSameLengths);
  RC_LOG(difference);
  RC_ASSERT(difference.empty());
  const WorkRun spelled = run_nominally(in_inch, {}, inch());
  RC_LOG(in_inch);
  RC_ASSERT(spelled.errors.empty());
  RC_ASSERT(spelled.events.size() == found.events.size());
}

/// SIEB & MEYER output is in millimetres, Excellon output in inch: both state it.
bool does_the_same_in(Dialect dialect) {
  const std::string text = text_of(*random_sm_job(SmTargets::None), {.unit = SmUnit::InchSteps});
  const WorkRun source = run_nominally(text, {}, inch());
  RC_PRE(source.errors.empty());
  const Translation written = test::translate(text, dialect, {}, inch());
  RC_ASSERT(written.errors.empty());
  if (written.is_refused) return false;
  RC_LOG(text);
  RC_LOG(written.text);
  // Whatever the control was set to before: the program states its format.
  for (const char* const setting : {"inch,lz", "metric,tz"}) {
    ReadOptions control;
    control.last_format = *parse_format(setting);
    const WorkRun again = run_nominally(written.text, {}, control);
    const bool is_too_short =
        !again.errors.empty() &&
        again.errors.front().find("an end away from the start") != std::string::npos;
    RC_PRE(!is_too_short);
    if (!again.errors.empty()) RC_LOG(again.errors.front());
    RC_ASSERT(again.errors.empty());
    const std::string difference =
        test::difference(test::work_of(source.events), test::work_of(again.events), kWritten);
    RC_LOG(difference);
    RC_ASSERT(difference.empty());
  }
  return true;
}

TEST(InchJob, DoesTheSameInSiebMeyer) {
  test::check_compared(
      "inch in SIEB & MEYER", 0.5, [] { return does_the_same_in(Dialect::SiebMeyer); });
}

TEST(InchJob, DoesTheSameInExcellon) {
  test::check_compared("inch in Excellon", 0.1, [] { return does_the_same_in(Dialect::Excellon); });
}

// --- converted -----------------------------------------------------------------------------------

constexpr double kHalfDigit_mm = 0.0001 * 25.4 / 2;

std::vector<Eigen::Vector2d> holes_of(const WorkRun& run) {
  std::vector<Eigen::Vector2d> places;
  for (const test::Event& event : run.events) {
    if (const auto* drill = std::get_if<Drill>(&event.what)) {
      places.push_back(drill->nominal.in_mm());
    }
  }
  return places;
}

/// Writes the same holes and offsets in both units; in inch to the nearest digit.
struct TwoTexts {
  std::string in_mm = "%%5000\n";
  std::string in_inch = "%%5000\n";

  void both(const std::string& text) {
    in_mm += text;
    in_inch += text;
  }
  void number(char letter, long um) {
    const bool has_point = test::one_in(2);
    const double value_inch = static_cast<double>(um) / 25'400;
    in_mm += fmt::format("{}{}", letter, um);
    in_inch += has_point ? fmt::format("{}{:.4f}", letter, value_inch)
                         : fmt::format("{}{}", letter, std::lround(value_inch * 10'000));
  }
  void place(test::Microns p) {
    number('X', p.x);
    number('Y', p.y);
  }
};

/// A hole's place adds up of two numbers: its own, and the offset of its section.
RC_GTEST_PROP(InchJob, HasItsHolesWithinHalfADigitOfEachNumber, ()) {
  TwoTexts texts;
  const int n_holes = test::any(1, 20);
  for (int i = 0; i < n_holes; ++i) {
    texts.place(test::any_place());
    texts.both(i == 0 ? "T1M31\n" : "\n");
  }
  const int n_offsets = test::any(1, 5);
  for (int i = 0; i < n_offsets; ++i) {
    texts.place(test::any_place());
    const std::array<const char*, 5> kinds = {"M50", "M60", "M70", "M80", "M90"};
    texts.both(test::any_of(kinds) + (i + 1 == n_offsets ? "M30\n" : "\n"));
  }
  texts.both("$\nT1D.04\n$\n");
  const WorkRun metric = run_nominally(texts.in_mm);
  const WorkRun converted = run_nominally(texts.in_inch, {}, inch());
  RC_ASSERT(metric.errors.empty());
  RC_ASSERT(converted.errors.empty());
  const auto expected = holes_of(metric);
  const auto found = holes_of(converted);
  RC_ASSERT(static_cast<int>(expected.size()) == n_holes * n_offsets);
  RC_ASSERT(found.size() == expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    RC_ASSERT((found[i] - expected[i]).cwiseAbs().maxCoeff() <= 2 * kHalfDigit_mm + 1e-9);
  }
}

}  // namespace
}  // namespace panelcal
