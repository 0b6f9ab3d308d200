// SPDX-License-Identifier: Apache-2.0
#include "calib/base/json/json_line.h"

#include <array>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

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
  EXPECT_EQ(std::get<JsonNumber>(line->find("a")->value).text, "-1.5e2");
  EXPECT_EQ(std::get<std::string>(line->find("b")->value), "x\n\xc3\xa4\xf0\x9f\x98\x80");
  EXPECT_TRUE(std::get<bool>(line->find("c")->value));
  EXPECT_EQ(std::get<std::vector<JsonNumber>>(line->find("d")->value)[1].text, "2.5");
  EXPECT_TRUE(std::get<std::vector<JsonNumber>>(line->find("e")->value).empty());
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

TEST(JsonLine, StatesWhatIsWrongAtTheValue) {
  const auto line = JsonLine::parse(R"({"a":1.5,"b":"x"})", {"f", 3, 1});
  ASSERT_TRUE(line) << line.error().text();
  const Diagnostic problem = line->problem("b", kCode, "y");
  EXPECT_EQ(test::brief(problem), "f:3:14: error[measurement-file]");
  EXPECT_EQ(problem.what, "\"b\" is \"x\"");
}

TEST(JsonLine, AKeyThatIsNullIsAbsent) {
  const auto line = JsonLine::parse(R"({"a":null,"b":1})", {"f", 3, 1});
  ASSERT_TRUE(line) << line.error().text();
  EXPECT_FALSE(line->has("a"));
  EXPECT_TRUE(line->has("b"));
  EXPECT_EQ(test::brief(line->missing("a", kCode)), "f:3:1: error[measurement-file]");
  constexpr std::array<std::string_view, 1> kKnown = {"b"};
  EXPECT_EQ(test::brief(line->check_keys(kKnown, kCode).error()), "f:3:2: error[measurement-file]");
}

TEST(JsonLine, SurvivesDeepNesting) {
  EXPECT_NE(refusal("{\"a\":" + std::string(100'000, '[')), "accepted");
}

}  // namespace
}  // namespace panelcal::internal
