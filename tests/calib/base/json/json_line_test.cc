// SPDX-License-Identifier: Apache-2.0
#include "calib/base/json/json_line.h"

#include <array>
#include <bit>
#include <cstdint>
#include <limits>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal::internal {
namespace {

constexpr Code kCode = Code::MeasurementFile;

std::string refusal(std::string_view text) {
  const auto line = JsonLine::parse(text, {"f", 3, 1});
  return line ? "accepted" : test::brief(line.error());
}

TEST(JsonLine, ReadsEveryKindOfValue) {
  const auto line = JsonLine::parse(
      R"( {"a" : -1.5e2, "b":"x\n\u00e4\ud83d\ude00", "c":true,"d":[ 1 , 2.5 ],"e":[]} )",
      {"f", 1, 1});
  ASSERT_TRUE(line) << line.error().text();
  EXPECT_EQ(line->number("a", kCode).value(), -150);
  EXPECT_EQ(line->text("b", kCode).value(), "x\n\xc3\xa4\xf0\x9f\x98\x80");
  EXPECT_TRUE(line->truth_value("c", kCode).value());
  EXPECT_EQ(line->numbers("d", 2, kCode).value(), (std::vector{1.0, 2.5}));
  EXPECT_TRUE(line->integers("e", 0, 9, 4, kCode).value().empty());
}

TEST(JsonLine, NumbersReadBackToTheBit) {
  for (const auto& [text, value] : {std::pair{"-0", -0.0},
                                    {"0.1", 0.1},
                                    {"5e-324", std::numeric_limits<double>::denorm_min()},
                                    {"1.7976931348623157e+308", std::numeric_limits<double>::max()},
                                    {"9007199254740993", 9007199254740992.0}}) {
    const std::string json = "{\"a\":" + std::string(text) + "}";
    const auto line = JsonLine::parse(json, {"f", 1, 1});
    ASSERT_TRUE(line) << text;
    EXPECT_EQ(std::bit_cast<std::uint64_t>(line->number("a", kCode).value()),
              std::bit_cast<std::uint64_t>(value))
        << text;
  }
}

TEST(JsonLine, RefusesWhatIsNotJsonAtItsColumn) {
  EXPECT_EQ(refusal(""), "f:3:1: error[json-syntax]");
  EXPECT_EQ(refusal("[1]"), "f:3:1: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":1"), "f:3:7: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":1} x"), "f:3:9: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":1,}"), "f:3:8: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\" 1}"), "f:3:6: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":01}"), "f:3:7: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":+1}"), "f:3:6: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":1.}"), "f:3:8: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":1e}"), "f:3:8: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":NaN}"), "f:3:6: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":nul}"), "f:3:6: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":null,\"a\":1}"), "f:3:11: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":{}}"), "f:3:6: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":[[1]]}"), "f:3:7: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":[1 2]}"), "f:3:9: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":\"b"), "f:3:8: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":\"\t\"}"), "f:3:7: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":\"\\q\"}"), "f:3:8: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":\"\\u12g4\"}"), "f:3:9: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":\"\\ud800\"}"), "f:3:13: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":\"\\udc00\"}"), "f:3:13: error[json-syntax]");
  EXPECT_EQ(refusal("{\"a\":1,\"a\":2}"), "f:3:8: error[json-syntax]");
}

TEST(JsonLine, RefusesValuesOfTheWrongKind) {
  const auto line = JsonLine::parse(R"({"a":1.5,"b":"x","c":[1,-2],"d":1e999})", {"f", 3, 1});
  ASSERT_TRUE(line) << line.error().text();
  EXPECT_EQ(test::brief(line->integer("a", 0, 9, kCode).error()), "f:3:6: error[measurement-file]");
  EXPECT_EQ(test::brief(line->number("b", kCode).error()), "f:3:14: error[measurement-file]");
  EXPECT_EQ(test::brief(line->number("d", kCode).error()), "f:3:33: error[measurement-file]");
  EXPECT_EQ(test::brief(line->text("a", kCode).error()), "f:3:6: error[measurement-file]");
  EXPECT_EQ(test::brief(line->truth_value("a", kCode).error()), "f:3:6: error[measurement-file]");
  EXPECT_EQ(test::brief(line->numbers("c", 3, kCode).error()), "f:3:22: error[measurement-file]");
  EXPECT_EQ(test::brief(line->integers("c", 0, 9, 4, kCode).error()),
            "f:3:22: error[measurement-file]");
  EXPECT_EQ(test::brief(line->number("e", kCode).error()), "f:3:1: error[measurement-file]");
}

TEST(JsonLine, AKeyThatIsNullIsAbsent) {
  const auto line = JsonLine::parse(R"({"a":null,"b":1})", {"f", 3, 1});
  ASSERT_TRUE(line) << line.error().text();
  EXPECT_FALSE(line->has("a"));
  EXPECT_TRUE(line->has("b"));
  EXPECT_EQ(test::brief(line->number("a", kCode).error()), "f:3:1: error[measurement-file]");
  constexpr std::array<std::string_view, 1> kKnown = {"b"};
  EXPECT_EQ(test::brief(line->check_keys(kKnown, kCode).error()), "f:3:2: error[measurement-file]");
}

TEST(JsonLine, SurvivesDeepNesting) {
  EXPECT_NE(refusal("{\"a\":" + std::string(100'000, '[')), "accepted");
}

}  // namespace
}  // namespace panelcal::internal
