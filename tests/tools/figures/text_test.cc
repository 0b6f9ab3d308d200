// SPDX-License-Identifier: Apache-2.0
#include "tools/figures/text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal {
namespace {

TEST(ReportText, KeepsUtf8AndShowsWhatIsNone) {
  EXPECT_EQ(report::escaped("Pr\xc3\xbc"
                            "fung"),
            "Pr\xc3\xbc"
            "fung");
  EXPECT_EQ(report::escaped("\xc3"), "\\xc3");
  EXPECT_EQ(report::escaped("\xc0\xaf"), "\\xc0\\xaf") << "overlong";
  EXPECT_EQ(report::escaped("\xed\xa0\x80"), "\\xed\\xa0\\x80") << "surrogate";
  EXPECT_EQ(report::escaped("\xe2\x80\xae"), "\\xe2\\x80\\xae") << "right-to-left override";
}

TEST(ReportText, WritesNumbersAsPeopleReadThem) {
  EXPECT_EQ(report::grouped(-1234567), "-1,234,567");
  EXPECT_EQ(report::grouped(999), "999");
  EXPECT_EQ(report::shortest(0.5), "0.5");
  EXPECT_EQ(report::shortest(20000), "20,000");
  EXPECT_EQ(report::fixed(-0.0004, 3), "0.000");
  EXPECT_EQ(report::fixed_signed(0.25, 2), "+0.25");
  EXPECT_EQ(report::with_sigma(201.2, 0.92, "ppm"), "+201.20 &#177; 0.92 ppm");
}

}  // namespace
}  // namespace panelcal
