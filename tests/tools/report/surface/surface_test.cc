// SPDX-License-Identifier: Apache-2.0
#include "tools/report/surface/surface.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal {
namespace {

using ::testing::HasSubstr;

TEST(ReportHtml, ShowsEveryProbedSurface) {
  Survey survey;
  ProbeRequest request;
  request.seq = 3;
  request.line = 12;
  request.command = "G73";
  request.nominal = position_mm<frame::Nominal>(20, 30);
  request.memory = 7;
  request.reference = mm(1.6);
  survey.probes.push_back(
      {request, ProbeStatus::Found, {{mm(1.6125), um(2)}, {mm(1.5), um(2)}}, ""});
  request.seq = 4;
  request.memory.reset();
  survey.probes.push_back({request, ProbeStatus::NotFound, {}, "no <contact>"});
  const std::string html = report::surface_section(survey, "");
  EXPECT_THAT(html,
              HasSubstr("<tr><td>#3</td><td>G73 in line 12</td><td>L7</td><td class=\"num\">"
                        "(20.000, 30.000)</td><td class=\"num\">1.6125</td><td class=\"num\">"
                        "1.5000</td><td class=\"num\">+12.5</td></tr>"));
  EXPECT_THAT(html, HasSubstr("<td colspan=\"3\"><b>not found</b> no &lt;contact&gt;</td></tr>"));
  EXPECT_EQ(report::surface_section(Survey(), ""), "");
  EXPECT_THAT(report::surface_section(Survey(), "2 depths count from the map"),
              HasSubstr("<p>2 depths count from the map.</p>"));
}

}  // namespace
}  // namespace panelcal
