// SPDX-License-Identifier: Apache-2.0
// Random SIEB & MEYER jobs do the same work in the other language, and back in their own.
#include <string>
#include <string_view>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/program/program_run.h"
#include "tests/program/random/compared_share.h"
#include "tests/program/sieb_meyer/random_sm_job.h"
#include "tests/program/writers/translation/run.h"

namespace panelcal {
namespace {

using test::check_compared;
using test::FunctionSource;
using test::random_sm_job;
using test::run_nominally;
using test::run_on;
using test::SmTargets;
using test::text_of;
using test::translate;
using test::Translation;
using test::work_of;
using test::WorkRun;

/// A tenth of a micrometre; rates are whole in Excellon.
constexpr test::Tolerance kRounding = {.place_mm = 1e-4, .center_mm = 1e-4, .rate_mm_s = 1};

void require_same_work(const std::string& source,
                       const Translation& translation,
                       MeasurementSource& panel) {
  if (!translation.errors.empty()) RC_LOG(translation.errors.front());
  RC_ASSERT(translation.errors.empty());
  const WorkRun before = run_on(panel, source);
  const WorkRun after = run_on(panel, translation.text);
  RC_LOG(source);
  RC_LOG(translation.text);
  if (!after.errors.empty()) RC_LOG(after.errors.front());
  // Excellon has no arc whose ends are nearer than their rounding, and says so.
  const bool is_too_short =
      !after.errors.empty() &&
      after.errors.front().find("an end away from the start") != std::string::npos;
  RC_PRE(!is_too_short);
  RC_ASSERT(after.errors.empty());
  const std::string difference =
      test::difference(work_of(before.events), work_of(after.events), kRounding);
  RC_LOG(difference);
  RC_ASSERT(difference.empty());
}

void require_same_work(const std::string& source, const Translation& translation) {
  NominalSource panel;
  require_same_work(source, translation, panel);
}

/// The job turned (RA) or scaled (SA) as a whole, now and then. Alike in x and y: else arcs become
/// ellipses, whose pieces have centres of their own.
std::string moved(std::string text) {
  constexpr std::string_view kBegin = "%%5000\n";
  if (!text.starts_with(kBegin)) return text;
  const char* const command =
      *rc::gen::element("", "", "M49,RA90.\n", "M49,RA7.\n", "M49,SAX200.Y200.\nM93\n");
  return text.insert(kBegin.size(), command);
}

/// Some jobs are written for controls that leave slashed lines out; these execute them.
std::string any_job() {
  const std::string text = moved(text_of(*random_sm_job(SmTargets::None), {}));
  RC_PRE(run_nominally(text).errors.empty());
  return text;
}

RC_GTEST_PROP(SmTranslation, KeepsTheLanguage, ()) {
  const std::string text = any_job();
  const Translation same = translate(text, Dialect::SiebMeyer);
  RC_PRE(!same.is_refused);  // a depth that is left to the control behind one that is stated
  require_same_work(text, same);
}

/// A panel that lies turned and moved, and has grown alike in x and y: else arcs become ellipses,
/// whose pieces have centres of their own.
FunctionSource turned_panel() {
  return FunctionSource([](const MeasurementRequest& request) -> Eigen::Vector2d {
    const Eigen::Vector2d p = request.nominal.in_mm();
    return {1.0003 * p.x() - 0.02 * p.y() + 0.5, 0.02 * p.x() + 1.0003 * p.y() - 0.3};
  });
}

void measures_the_same_targets(Dialect to, double min_share) {
  check_compared(std::string("targets in ") + std::string(name(to)), min_share, [to] {
    const std::string text = text_of(*random_sm_job(SmTargets::OfTheBoard), {});
    FunctionSource panel = turned_panel();
    RC_PRE(run_on(panel, text).errors.empty());
    const Translation translation = translate(text, to);
    if (translation.is_refused) return false;
    require_same_work(text, translation, panel);
    return true;
  });
}

TEST(SmTranslation, MeasuresTheSameTargets) {
  measures_the_same_targets(Dialect::SiebMeyer, 0.5);
}

TEST(SmTranslation, MeasuresTheSameTargetsInExcellon) {
  measures_the_same_targets(Dialect::Excellon, 0.1);
}

/// Depths have no form in Excellon; whatever is not refused does the same work.
RC_GTEST_PROP(SmTranslation, LeadsThereAndBack, ()) {
  const std::string text = any_job();
  const Translation there = translate(text, Dialect::Excellon);
  RC_PRE(!there.is_refused);
  require_same_work(text, there);
  const Translation back = translate(there.text, Dialect::SiebMeyer);
  RC_ASSERT(!back.is_refused);
  require_same_work(text, back);
}

}  // namespace
}  // namespace panelcal
