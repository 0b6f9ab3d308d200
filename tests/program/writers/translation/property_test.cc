// SPDX-License-Identifier: Apache-2.0
// Translations of whole jobs do the same work: the same holes in the same order, the same contours.
#include <string>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/program/random/random_job.h"
#include "tests/program/writers/translation/run.h"

namespace panelcal {
namespace {

using test::difference_of_work;
using test::random_job;
using test::run_nominally;
using test::Spelling;
using test::text_of;
using test::translate;
using test::Translation;
using test::WorkRun;

void require_same_work(const std::string& source, const Translation& translation) {
  if (!translation.errors.empty()) RC_LOG(translation.errors.front());
  RC_ASSERT(translation.errors.empty());
  const WorkRun before = run_nominally(source);
  const WorkRun after = run_nominally(translation.text);
  RC_LOG(translation.text);
  if (!after.errors.empty()) RC_LOG(after.errors.front());
  RC_ASSERT(after.errors.empty());
  const std::string difference = difference_of_work(before, after);
  RC_LOG(difference);
  RC_ASSERT(difference.empty());
}

std::string any_job() {
  const std::string text = text_of(*random_job(), Spelling{});
  RC_PRE(run_nominally(text).errors.empty());
  return text;
}

RC_GTEST_PROP(Translation, DoesTheSameWorkInSiebMeyer, ()) {
  const std::string text = any_job();
  require_same_work(text, translate(text, Dialect::SiebMeyer));
}

RC_GTEST_PROP(Translation, LeadsThereAndBack, ()) {
  const std::string text = any_job();
  const Translation there = translate(text, Dialect::SiebMeyer);
  RC_ASSERT(there.errors.empty());
  require_same_work(text, translate(there.text, Dialect::Excellon));
}

RC_GTEST_PROP(Translation, KeepsExcellonInItsOwnLanguage, ()) {
  const std::string text = any_job();
  const Translation same = translate(text, Dialect::Excellon);
  RC_PRE(same.errors.empty());  // tool data of the body have no form in a plain program
  RC_ASSERT(same.losses.empty());
  require_same_work(text, same);
}

RC_GTEST_PROP(Translation, KeepsSiebMeyerInItsOwnLanguage, ()) {
  const Translation there = translate(any_job(), Dialect::SiebMeyer);
  const Translation again = translate(there.text, Dialect::SiebMeyer);
  RC_ASSERT(again.losses.empty());
  require_same_work(there.text, again);
}

}  // namespace
}  // namespace panelcal
