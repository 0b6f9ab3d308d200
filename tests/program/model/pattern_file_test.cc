// SPDX-License-Identifier: Apache-2.0
#include "program/model/pattern_file.h"

#include <string>

#include "program/model/calibration_order.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

const std::string kOne(64, '1');
const std::string kOther(64, '2');

TEST(PatternFile, IsTheSameWhereverItsContentLies) {
  EXPECT_TRUE(is_same_pattern({"PINS", kOne}, {"boards/PINS", kOne}));
  EXPECT_TRUE(is_same_pattern({"PINS", kOne}, {"boards/PINS.exc", kOne}));
  EXPECT_FALSE(is_same_pattern({"PINS", kOne}, {"PINS", kOther}));
}

TEST(PatternFile, WithoutContentGoesByItsNameWithoutFolders) {
  EXPECT_TRUE(is_same_pattern({"PINS", ""}, {"boards/PINS", kOne}));
  EXPECT_TRUE(is_same_pattern({"/a/PINS", kOne}, {"../b/PINS", ""}));
  EXPECT_FALSE(is_same_pattern({"PINS", ""}, {"boards/HOLES", kOne}));
  EXPECT_FALSE(is_same_pattern({"boards/PINS", ""}, {"PINS/boards", ""}));
}

TEST(PatternFile, IsNotTheProgramItself) {
  EXPECT_TRUE(is_same_pattern({}, {}));
  EXPECT_FALSE(is_same_pattern({"PINS", kOne}, {}));
  EXPECT_FALSE(is_same_pattern({}, {"PINS", ""}));
}

TEST(PatternFile, IsWrittenWithItsContentWhereThatIsKnown) {
  CalibrationOrder order;
  EXPECT_EQ(to_json(order), R"({"calibration":0,"line":0,"command":"","path":[]})");
  order.file = "a\"b";
  EXPECT_EQ(to_json(order), R"({"calibration":0,"line":0,"command":"","path":[],"file":"a\"b"})");
  order.file = "/a/boards/PINS";
  order.file_sha256 = kOne;
  EXPECT_EQ(to_json(order),
            R"({"calibration":0,"line":0,"command":"","path":[],"file":"PINS","file_sha256":")" +
                kOne + "\"}");
}

TEST(PatternFile, IsNamedWithTheBeginningOfItsDigest) {
  EXPECT_EQ(pattern_text({"PINS", kOne}), "\"PINS\", sha256 111111111111");
  EXPECT_EQ(pattern_text({"PINS", ""}), "\"PINS\"");
  EXPECT_EQ(pattern_text({}), "(the program itself)");
}

}  // namespace
}  // namespace panelcal
