// SPDX-License-Identifier: Apache-2.0
#include "tools/report/focus.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal::report {
namespace {

using testing::HasSubstr;
using testing::Not;

Survey focused(bool is_found) {
  FocusResult focus;
  focus.request.line = 9;
  focus.request.expected = position_mm<frame::Actual>(20, 15);
  focus.is_found = is_found;
  focus.z = mm(0.7371);
  focus.sigma = um(1.2);
  focus.reason = is_found ? "" : "nothing <to> be seen";
  for (int i = 0; i < 5; ++i) focus.curve.push_back({mm(0.2 * i), 0.001 * (5 - i)});
  Survey survey;
  survey.focus = {focus};
  return survey;
}

TEST(FocusSection, IsLeftOutWithoutFocusing) {
  EXPECT_EQ(focus_section({}), "");
}

TEST(FocusSection, ShowsTheCurveAndItsPeak) {
  const std::string section = focus_section(focused(true));
  EXPECT_THAT(section, HasSubstr("z = <b>0.7371 mm</b>, sigma 1.2 &#181;m"));
  EXPECT_THAT(section, HasSubstr("line 9"));
  std::size_t n_points = 0;
  for (auto at = section.find("<circle"); at != std::string::npos;
       at = section.find("<circle", at + 1)) {
    ++n_points;
  }
  EXPECT_EQ(n_points, 5u);
}

TEST(FocusSection, SaysWhyThereIsNoFocus) {
  const std::string section = focus_section(focused(false));
  EXPECT_THAT(section, HasSubstr("<b>not focused</b>, nothing &lt;to&gt; be seen"));
  EXPECT_THAT(section, Not(HasSubstr("class=\"before\"")));
}

}  // namespace
}  // namespace panelcal::report
