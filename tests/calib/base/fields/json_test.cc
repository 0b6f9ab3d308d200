// SPDX-License-Identifier: Apache-2.0
#include "calib/base/fields/json.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <utility>

#include "calib/base/fields/page.h"
#include "calib/base/fields/slots.h"
#include "calib/base/json/strict_json.h"
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/support/matchers.h"

namespace panelcal::internal {
namespace {

using test::FailsWith;
using testing::HasSubstr;

constexpr Code kCode = Code::CalibrationInvalid;

struct JsonHole {
  Position<frame::Machine> place;
  std::optional<int> line;
  double depth_mm = 0;
};

/// A member of each kind.
struct JsonSample {
  std::string name = "a";
  bool is_on = true;
  std::uint64_t seed = 7;
  std::chrono::sys_seconds date{};
  Angle turn;
  std::optional<Length> rms;
  std::array<std::optional<double>, 2> backlash = {1.5, std::nullopt};
  Eigen::Matrix2d cov = Eigen::Matrix2d::Identity();
  std::vector<int> path = {1, 2};
  std::vector<std::string> words;
  std::vector<JsonHole> holes;
  std::optional<JsonHole> first;
  int nx = 3;
  int ny = 4;
};

constexpr std::array kHoleFields = {
    plain<&JsonHole::place>("place", {-10, 10}, "of the hole"),
    count<&JsonHole::line>("line", {0, 99}, "in the program").or_absent(),
    plain<&JsonHole::depth_mm>("depth", {0, 5}, "of it").or_absent(0),
};
constexpr JsonTable<JsonHole> kHole{"hole", kHoleFields};

constexpr auto kJsonSampleFields =
    joined(head_of<JsonSample>("\"sample\"", 1),
           std::array{
               field<&JsonSample::name>("name", "of it"),
               field<&JsonSample::is_on>("is_on", "whether"),
               field<&JsonSample::seed>("seed", "of all").of_kind(FieldKind::Counter),
               time<&JsonSample::date>("date", "of it"),
               field<&JsonSample::turn>("turn_urad", {-9, 9}, "about its middle"),
               field<&JsonSample::rms>("rms_um", {0, 9}, "of residuals"),
               field<&JsonSample::backlash>("backlash", {-9, 9}, "along x | y"),
               field<&JsonSample::cov>("covariance", {}, "of something").in_lines(),
               count<&JsonSample::path>("path", {0, 9}, "from outside"),
               field<&JsonSample::words>("words", "several"),
               inner<kHole, &JsonSample::holes>("holes", "drilled").in_lines(),
               inner<kHole, &JsonSample::first>("first", "of them").or_absent(),
               count_pair_in<JsonSample, &JsonSample::nx, &JsonSample::ny>(
                   "steps", {1, 9}, "along x and y"),
           });
constexpr JsonTable<JsonSample> kJsonSample{"the sample", kJsonSampleFields, JsonLayout::Lines};

struct JsonNumberSample {
  double value = 0;
  std::optional<double> more;
};
constexpr std::array kNumberFields = {
    plain<&JsonNumberSample::value>("value", {}, "a number"),
    plain<&JsonNumberSample::more>("more", {}, "another one").or_absent(),
};
constexpr JsonTable<JsonNumberSample> kNumber{"the number", kNumberFields};

constexpr const char* kText = R"({
  "kind": "sample",
  "version": 1,
  "name": "a \"b\" \u00e4",
  "is_on": true,
  "seed": 18446744073709551615,
  "date": "1970-01-01T00:00:00Z",
  "turn_urad": 2,
  "rms_um": null,
  "backlash": [1.5, null],
  "covariance": [
    [1, 0],
    [0, 1]
  ],
  "path": [1, 2],
  "words": [],
  "holes": [
    {"place": [1, -2.5], "line": 7},
    {"place": [0, 0], "depth": 0.5}
  ],
  "steps": [3, 4]
}
)";

JsonSample sample() {
  JsonSample out;
  out.name = "a \"b\" \u00e4";
  out.seed = std::numeric_limits<std::uint64_t>::max();
  out.turn = rad(2e-6);
  out.holes = {{position_mm<frame::Machine>(1, -2.5), 7, 0},
               {position_mm<frame::Machine>(-0.0, 0), std::nullopt, 0.5}};
  return out;
}

Expected<JsonSample> read(const std::string& text) {
  PANELCAL_TRY(const nlohmann::json document, parse_strict_json(text, "s.json"));
  return read_json(kJsonSample, document, kCode, "s.json");
}

Expected<JsonSample> read_with(const std::string& old_text, const std::string& new_text) {
  std::string text = kText;
  const std::size_t at = text.find(old_text);
  EXPECT_NE(at, std::string::npos) << old_text;
  return read(text.replace(at, old_text.size(), new_text));
}

TEST(JsonFields, WriteAFileAsItIsDocumented) {
  EXPECT_EQ(json_text(kJsonSample, sample(), JsonStyle::File), kText);
}

TEST(JsonFields, WriteALineWithoutSpaces) {
  constexpr JsonTable<JsonHole> kLine{"hole", kHoleFields};
  const JsonHole hole = {position_mm<frame::Machine>(-0.0, 1), 3, 0};
  EXPECT_EQ(json_text(kLine, hole, JsonStyle::Line), R"({"place":[-0,1],"line":3})");
  EXPECT_EQ(json_text(kLine, hole, JsonStyle::Compact), R"({"place":[0,1],"line":3})");
}

TEST(JsonFields, ReadWhatTheyWrote) {
  const auto back = read(kText);
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ(json_text(kJsonSample, *back, JsonStyle::File), kText);
  EXPECT_EQ(back->seed, std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(back->turn, rad(2e-6));
  EXPECT_FALSE(back->backlash[1]);
  EXPECT_EQ(back->holes[1].depth_mm, 0.5);
  EXPECT_FALSE(back->first);
}

TEST(JsonFields, ReadAnOptionalObject) {
  const auto back = read_with("\"steps\"", "\"first\": {\"place\": [3, 4]}, \"steps\"");
  ASSERT_TRUE(back) << back.error().text();
  EXPECT_EQ(back->first->place.in_mm(), Eigen::Vector2d(3, 4));
}

TEST(JsonFields, WriteNoNumberThatIsNotFinite) {
  JsonSample bad = sample();
  bad.cov(0, 1) = std::numeric_limits<double>::quiet_NaN();
  const std::string text = json_text(kJsonSample, bad, JsonStyle::File);
  EXPECT_THAT(text, HasSubstr("[1, \"nan\"]"));
  EXPECT_THAT(read(text), FailsWith(kCode, "\"covariance\""));
}

TEST(JsonFields, RefuseKeysWithTheNearestKnownOne) {
  EXPECT_THAT(read_with("\"name\"", "\"nane\""),
              FailsWith(kCode, "unknown key \"nane\" in the sample; did you mean \"name\"?"));
  EXPECT_THAT(read_with("\"line\"", "\"lime\""), FailsWith(kCode, "\"lime\" in hole 0"));
  EXPECT_THAT(read_with("  \"is_on\": true,\n", ""), FailsWith(kCode, "missing key \"is_on\""));
  EXPECT_THAT(read_with("\"place\": [0, 0], ", ""), FailsWith(kCode, "hole 1: missing key"));
}

TEST(JsonFields, RefuseValuesWithWhatTheyTake) {
  const auto refuse =
      [](const std::string& old_text, const std::string& new_text, const std::string& words) {
        EXPECT_THAT(read_with(old_text, new_text), FailsWith(kCode, words)) << new_text;
      };
  refuse("\"sample\"", "\"other\"", "\"kind\" of the sample is \"other\"");
  refuse("\"version\": 1", "\"version\": 2", "a whole number from 1 to 1");
  refuse("true", "1", "true or false");
  refuse("18446744073709551615", "-1", "a whole number from 0 to");
  refuse("1970-01-01T00:00:00Z", "yesterday", "is \"yesterday\"");
  refuse("\"turn_urad\": 2", "\"turn_urad\": 10", "a number from -9 to 9");
  refuse("\"rms_um\": null", "\"rms_um\": -1", "a number from 0 to 9, or null");
  refuse("[1.5, null]", "[1.5]", "an array of 2 numbers");
  refuse("[1.5, null]", "[1.5, 10]", "each a number from -9 to 9");
  refuse("[0, 1]", "[0]", "2 arrays of 2 numbers");
  refuse("[1, 2]", "[1, 2.5]", "a whole number from 0 to 9");
  refuse("\"words\": []", "\"words\": [1]", "a list of texts");
  refuse("[1, -2.5]", "[1, -25]", "\"place\" of hole 0");
  refuse("\"line\": 7", "\"line\": 1e300", "a whole number from 0 to 99");
  refuse("\"line\": 7", "\"line\": 18446744073709551615", "a whole number from 0 to 99");
  refuse("\"name\": \"a \\\"b\\\" \\u00e4\"", "\"name\": null", "is null");
  EXPECT_THAT(read("[]"), FailsWith(kCode, "the sample is no JSON object"));
}

TEST(JsonFields, ReadALineAtItsColumn) {
  const auto read_hole = [](std::string_view text) {
    const auto line = JsonLine::parse(text, {"f", 3, 1});
    const auto hole = read_line(kHole, *line, kCode);
    return hole ? "accepted" : test::brief(hole.error());
  };
  EXPECT_EQ(read_hole(R"({"place":[1,2],"line":null})"), "accepted");
  EXPECT_EQ(read_hole(R"({"place":[1,2],"line":100})"), "f:3:23: error[calibration-invalid]");
  EXPECT_EQ(read_hole(R"({"place":[1,1e999]})"), "f:3:10: error[calibration-invalid]");
  EXPECT_EQ(read_hole(R"({"line":1})"), "f:3:1: error[calibration-invalid]");
  EXPECT_EQ(read_hole(R"({"place":[1,2],"lime":1})"), "f:3:16: error[calibration-invalid]");
}

TEST(JsonFields, ALineKeepsTheSignOfZero) {
  const auto line = JsonLine::parse(R"({"place":[-0,0]})", {"f", 1, 1});
  const auto hole = read_line(kHole, *line, kCode);
  ASSERT_TRUE(hole);
  EXPECT_TRUE(std::signbit(hole->place.in_mm().x()));
}

TEST(JsonFields, NumbersOfALineReadBackToTheBit) {
  for (const auto& [text, value] : {std::pair{"-0", -0.0},
                                    {"0.1", 0.1},
                                    {"1e0", 1.0},
                                    {"5e-324", std::numeric_limits<double>::denorm_min()},
                                    {"1.7976931348623157e+308", std::numeric_limits<double>::max()},
                                    {"9007199254740993", 9007199254740992.0},
                                    {"36893488147419103232", 0x1p65}}) {
    const std::string row = "{\"value\":" + std::string(text) + "}";
    const auto line = JsonLine::parse(row, {"f", 1, 1});
    const auto number = read_line(kNumber, *line, kCode);
    ASSERT_TRUE(number) << text;
    EXPECT_EQ(std::bit_cast<std::uint64_t>(number->value), std::bit_cast<std::uint64_t>(value))
        << text;
  }
}

TEST(JsonFields, ANumberThatNoDoubleHoldsIsNotTakenForNone) {
  const auto line = JsonLine::parse(R"({"value":1,"more":1e999})", {"f", 1, 1});
  EXPECT_THAT(read_line(kNumber, *line, kCode), FailsWith(kCode, "1e999"));
}

TEST(JsonFields, PageHasARowForEachKey) {
  const std::string page = page_of(JsonFile{"sample.json", "A sample.", {&kJsonSample}});
  EXPECT_THAT(page, HasSubstr("## sample.json\n\nA sample.\n"));
  EXPECT_THAT(page, HasSubstr("| `rms_um` | a number from 0 to 9, or null | of residuals |\n"));
  EXPECT_THAT(page, HasSubstr("| `holes[].line` | a whole number from 0 to 99; may be absent |"));
  EXPECT_THAT(page, HasSubstr("along x \\| y"));
}

TEST(JsonFields, SchemaHasTheRangesOfTheRows) {
  const std::string text = schema_of(JsonFile{"sample.json", "", {&kJsonSample}, true});
  const nlohmann::json form = nlohmann::json::parse(text)["anyOf"][0];
  EXPECT_EQ(form["properties"]["kind"]["enum"], nlohmann::json::array({"sample"}));
  EXPECT_EQ(form["properties"]["holes"]["items"]["required"], nlohmann::json::array({"place"}));
  EXPECT_EQ(form["properties"]["words"]["items"]["type"], "string");
  EXPECT_EQ(form["properties"]["steps"]["minItems"], 2);
  EXPECT_EQ(form["properties"]["rms_um"]["anyOf"][0]["maximum"], 9);
  EXPECT_EQ(form["properties"]["ledger"]["anyOf"].size(), 2U);
  EXPECT_FALSE(form["additionalProperties"]);
}

}  // namespace
}  // namespace panelcal::internal
