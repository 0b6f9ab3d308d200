// SPDX-License-Identifier: Apache-2.0
#include "calib/base/fields/field.h"

#include <array>
#include <numbers>
#include <string>

#include "calib/base/fields/page.h"
#include "calib/base/fields/slots.h"
#include <gmock/gmock.h>

namespace panelcal::internal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A member of each kind.
struct FieldSample {
  Length width = um(2);
  Angle turn;
  Time wait;
  std::optional<Length> limit = um(5);
  int count = 3;
  bool is_on = true;
  std::string name;
  Position<frame::Machine> place;
  std::vector<Length> steps = {um(1), um(2)};
  double low = 1;
  double high = 2;
};

std::optional<int> number_of_word(std::string_view word) {
  return word == "one" ? std::optional(1) : std::nullopt;
}

constexpr std::array kSampleFields = {
    field<&FieldSample::width>("width_um", {0, 10, true}, "from side to side"),
    field<&FieldSample::turn>("turn_deg", {-360, 360}, "about its middle"),
    field<&FieldSample::wait>("wait_days", {0, 9}, "until then"),
    field<&FieldSample::limit>("limit_um", {0, 9}, "most | of it").or_off(),
    count<&FieldSample::count>("count", {1, 9}, "of them"),
    field<&FieldSample::is_on>("is_on", "whether"),
    field<&FieldSample::name>("name", "of it").required("name = \"A\""),
    field<&FieldSample::place>("place_mm", {-9, 9}, "there"),
    field<&FieldSample::steps>("steps_um", {0, 9}, "one by one"),
    pair<&FieldSample::low, &FieldSample::high>("range", {0, 9}, "from and to"),
    word<number_of_word, &FieldSample::count>("word", "\"one\"", "in words").without("three"),
};
constexpr Table<FieldSample> kSample{"sample.part", "A part.", kSampleFields};

const Field& field_of(std::string_view key) {
  for (const Field& field : kSample.fields) {
    if (field.key == key) return field;
  }
  throw std::out_of_range(std::string(key));
}

FieldSample with(std::string_view key, const FieldValue& value) {
  FieldSample sample;
  EXPECT_TRUE(field_of(key).store(&sample, value)) << key;
  return sample;
}

TEST(Field, HasTheUnitAtItsKeysEnd) {
  EXPECT_DOUBLE_EQ(field_of("width_um").unit.stored(3), 0.003);
  EXPECT_DOUBLE_EQ(field_of("turn_deg").unit.stored(180), std::numbers::pi);
  EXPECT_EQ(field_of("wait_days").unit.stored(2), 2 * 86400.0);
  EXPECT_EQ(field_of("range").unit.stored(2), 2);
}

TEST(Field, PutsItsValueIntoItsMember) {
  FieldValue value;
  value.number = 0.004;
  EXPECT_EQ(with("width_um", value).width, um(4));
  EXPECT_EQ(with("limit_um", value).limit, um(4));
  value.is_off = true;
  EXPECT_FALSE(with("limit_um", value).limit);
  value.whole = 7;
  EXPECT_EQ(with("count", value).count, 7);
  value.numbers = {4, 5};
  EXPECT_EQ(with("place_mm", value).place.in_mm(), Eigen::Vector2d(4, 5));
  EXPECT_THAT(with("steps_um", value).steps, ElementsAre(mm(4), mm(5)));
  EXPECT_EQ(with("range", value).high, 5);
  value.text = "one";
  EXPECT_EQ(with("word", value).count, 1);
}

TEST(Field, RefusesAWordThatItDoesNotKnow) {
  FieldSample sample;
  FieldValue value;
  value.text = "two";
  EXPECT_FALSE(field_of("word").store(&sample, value));
}

TEST(Field, StatesItsInitialValueAsItIsWritten) {
  EXPECT_EQ(kSample.initial_text(field_of("width_um")), "2");
  EXPECT_EQ(kSample.initial_text(field_of("turn_deg")), "0");
  EXPECT_EQ(kSample.initial_text(field_of("steps_um")), "[1, 2]");
  EXPECT_EQ(kSample.initial_text(field_of("range")), "[1, 2]");
  EXPECT_EQ(kSample.initial_text(field_of("is_on")), "true");
  EXPECT_EQ(kSample.initial_text(field_of("name")), "");
}

TEST(FileDescription, KnowsTheKeysAndTablesOfATable) {
  const FileDescription file{"the file", {&kSample}};
  EXPECT_THAT(file.known_keys(""), testing::IsEmpty());
  EXPECT_THAT(file.known_keys("sample"), ElementsAre("part"));
  EXPECT_EQ(file.known_keys("sample.part").size(), kSampleFields.size());
  EXPECT_EQ(file.known_keys("sample.part").front(), "count");
}

TEST(FilePage, HasARowForEachKey) {
  const std::string page = page_of({"the file", {&kSample}});
  EXPECT_THAT(page, HasSubstr("## `[sample.part]`\n\nA part.\n"));
  EXPECT_THAT(page,
              HasSubstr("| `width_um` | a number above 0 and at most 10 | `2` | from side to side "
                        "|\n"));
  EXPECT_THAT(page, HasSubstr("| `name` | a text | required | of it |\n"));
  EXPECT_THAT(page, HasSubstr("most \\| of it"));
  EXPECT_THAT(page, HasSubstr("| `word` | \"one\" | three | in words |\n"));
}

}  // namespace
}  // namespace panelcal::internal
