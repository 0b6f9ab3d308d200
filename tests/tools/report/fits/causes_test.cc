// SPDX-License-Identifier: Apache-2.0
#include "tools/report/fits/causes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

Survey survey_of_two() {
  Survey survey;
  survey.measurements.resize(2);
  survey.measurements[1].request.seq = 1;
  survey.measurements[1].request.command = "G36";
  survey.measurements[1].request.line = 9;
  return survey;
}

TEST(ReportCauses, SaysNothingOfAHealthySeries) {
  EXPECT_EQ(report::causes_block(survey_of_two(), SeriesResult()), "");
}

TEST(ReportCauses, ListsWhatCannotBeToldApart) {
  SeriesResult series;
  series.fault.emplace();
  series.fault->p_value = 1e-7;
  series.fault->degrees_of_freedom = 3;
  series.fault->false_alarm = 1e-3;
  series.fault->suspicions = {{FaultCause::TurnedHalf, {}, 0.6, "turned <so>"},
                              {FaultCause::Mirrored, {}, 0.4, "mirrored"}};
  const std::string html = report::causes_block(survey_of_two(), series);
  EXPECT_THAT(html, HasSubstr("do not separate"));
  EXPECT_THAT(html, HasSubstr("turned &lt;so&gt;"));
  EXPECT_THAT(html, HasSubstr("0.600"));
  EXPECT_THAT(html, HasSubstr("less than 0.0001; they are accused below 0.001"));
  EXPECT_THAT(html, Not(HasSubstr("Left out")));
}

TEST(ReportCauses, NamesWhatWasLeftOut) {
  SeriesResult series;
  series.fault.emplace();
  series.fault->suspicions = {{FaultCause::DamagedMark, 1, 0.9999, "off"}};
  series.dropped = {1};
  const std::string html = report::causes_block(survey_of_two(), series);
  EXPECT_THAT(html, HasSubstr("Left out of the fit"));
  EXPECT_THAT(html, HasSubstr("#target-1"));
  EXPECT_THAT(html, HasSubstr("above 0.999"));
  EXPECT_THAT(html, Not(HasSubstr("do not separate")));
}

}  // namespace
}  // namespace panelcal
