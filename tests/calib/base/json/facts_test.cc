// SPDX-License-Identifier: Apache-2.0
#include "calib/base/json/facts.h"

#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include <gtest/gtest.h>

namespace panelcal::facts {
namespace {

TEST(Facts, BeginWithTheirKindAndVersions) {
  const Json head = envelope("job", 3);
  EXPECT_EQ(head["facts"], "job");
  EXPECT_EQ(head["version"], 3);
  EXPECT_TRUE(text(head).starts_with("{\"facts\":\"job\",\"version\":3,\"panelcal\":\""));
}

TEST(Facts, HaveNullWhereJsonHasNoNumber) {
  for (const double none : {std::nan(""), HUGE_VAL, -std::numeric_limits<double>::infinity()}) {
    EXPECT_TRUE(number(none).is_null());
  }
  EXPECT_TRUE(number(std::optional<double>()).is_null());
  EXPECT_EQ(number(std::optional<double>(0.5)), 0.5);
  EXPECT_EQ(point({1, std::nan("")}).dump(), "[1.0,null]");
  Eigen::Matrix2d matrix;
  matrix << 1, 2, 2, 3;
  EXPECT_EQ(covariance(matrix).dump(), "[1.0,2.0,3.0]");
}

TEST(Facts, ReplaceBytesThatAreNoUtf8) {
  EXPECT_EQ(text(Json("a\xff\xc3z\n")), "\"a\xef\xbf\xbd\xef\xbf\xbdz\\n\"\n");
}

/// IEEE 754: 1.0f is 0x3f800000, here from its lowest byte on: 00 00 80 3f.
TEST(Facts, PackColumnsInLittleEndianBytes) {
  const Json floats = packed(std::array{1.0F, std::nanf("")});
  EXPECT_EQ(floats["type"], "float32");
  EXPECT_EQ(floats["base64"], base64(std::string("\0\0\x80\x3f\0\0\xc0\x7f", 8)));
  EXPECT_EQ(packed(std::array{0x01020304U}).dump(),
            "{\"type\":\"uint32\",\"base64\":\"" + base64("\x04\x03\x02\x01") + "\"}");
}

/// RFC 4648, section 10.
TEST(Facts, EncodeBase64AsItsRfcDoes) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace panelcal::facts
