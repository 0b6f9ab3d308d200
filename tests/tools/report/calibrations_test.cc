// SPDX-License-Identifier: Apache-2.0
#include "tools/report/calibrations.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal::report {
namespace {

using testing::HasSubstr;
using testing::Not;

Survey calibrated(int n) {
  Survey survey;
  for (int i = 0; i < n; ++i) {
    CalibrationAnswer answer;
    answer.order.line = 7 + i;
    answer.order.command = "G39";
    answer.text = "found <it>";
    survey.calibrations.push_back(answer);
  }
  return survey;
}

TEST(CalibrationsSection, IsLeftOutWithoutCalibrations) {
  EXPECT_EQ(calibrations_section({}), "");
}

TEST(CalibrationsSection, SaysWhatEachOrderFound) {
  const std::string section = calibrations_section(calibrated(2));
  EXPECT_THAT(section, HasSubstr("<tr><td>7</td><td>G39</td><td>found &lt;it&gt;</td></tr>"));
  EXPECT_THAT(section, HasSubstr("<td>8</td>"));
  EXPECT_THAT(section, HasSubstr("Nothing is installed"));
  EXPECT_THAT(section, Not(HasSubstr(" more.")));
}

TEST(CalibrationsSection, IsCutOffWhereNobodyReadsOn) {
  const std::string section = calibrations_section(calibrated(53));
  EXPECT_THAT(section, HasSubstr("<td>56</td>"));
  EXPECT_THAT(section, Not(HasSubstr("<td>57</td>")));
  EXPECT_THAT(section, HasSubstr("And 3 more."));
}

}  // namespace
}  // namespace panelcal::report
