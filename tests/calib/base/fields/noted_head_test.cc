// SPDX-License-Identifier: Apache-2.0
#include "calib/base/fields/noted_head.h"

#include <string>

#include "calib/base/json/strict_json.h"
#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal::internal {
namespace {

using test::FailsWith;

const std::string kHash(64, 'a');

TEST(NotedHead, IsTheLastMemberOfACalibration) {
  EXPECT_EQ(
      with_noted_head("{\n  \"kind\": \"x\",\n  \"a\": {\"b\": 1}\n}\n",
                      {NotedHead::Use::Head, 7, kHash}),
      "{\n  \"kind\": \"x\",\n  \"a\": {\"b\": 1},\n  \"ledger\": {\"head\": 7, \"hash\": \"" +
          kHash + "\"}\n}\n");
}

TEST(NotedHead, OfALedgerWithoutEntriesHasNoHash) {
  EXPECT_EQ(with_noted_head("{\"kind\": \"x\"}", {NotedHead::Use::RecordedAfter, 0, ""}),
            "{\"kind\": \"x\",\n  \"ledger\": {\"recorded_after\": 0}\n}\n");
}

TEST(NotedHead, IsReadAsItIsWritten) {
  for (const NotedHead& head : {NotedHead{NotedHead::Use::Head, 0, ""},
                                NotedHead{NotedHead::Use::RecordedAfter, 0, ""},
                                NotedHead{NotedHead::Use::RecordedAfter, 123456789, kHash}}) {
    auto document = parse_strict_json(with_noted_head("{\"kind\": \"x\"}", head), "a.json");
    ASSERT_TRUE(document) << document.error().text();
    const auto found = take_noted_head(*document, "a.json");
    ASSERT_TRUE(found) << found.error().text();
    EXPECT_EQ(*found, head);
    EXPECT_EQ(document->dump(), R"({"kind":"x"})");
  }
}

TEST(NotedHead, ReadersOfCalibrationsDoNotSeeIt) {
  const auto document =
      parse_calibration_json(with_noted_head("{\"kind\": \"x\"}", {{}, 7, kHash}), "a.json");
  ASSERT_TRUE(document) << document.error().text();
  EXPECT_EQ(document->dump(), R"({"kind":"x"})");
  EXPECT_EQ(parse_calibration_json("[1]", "a.json")->dump(), "[1]");
}

TEST(NotedHead, OfAnyOtherFormIsRefused) {
  const std::string hash = "\"hash\": \"" + kHash + "\"";
  for (const std::string& note : {std::string("7"),
                                  std::string("null"),
                                  "{" + hash + "}",
                                  "{\"head\": -1, " + hash + "}",
                                  "{\"head\": 1.5, " + hash + "}",
                                  "{\"head\": 1e300, " + hash + "}",
                                  "{\"head\": 7, \"recorded_after\": 7, " + hash + "}",
                                  "{\"head\": 0, " + hash + "}",
                                  std::string("{}"),
                                  std::string("{\"head\": 7}"),
                                  std::string("{\"recorded_after\": 7}"),
                                  std::string("{\"head\": 0, \"hash\": \"\"}"),
                                  std::string("{\"head\": 7, \"hash\": \"abc\"}"),
                                  "{\"head\": 7, \"hash\": \"" + std::string(64, 'A') + "\"}"}) {
    EXPECT_THAT(parse_calibration_json("{\"ledger\": " + note + "}", "a.json"),
                FailsWith(Code::CalibrationInvalid, "ledger"))
        << note;
  }
}

}  // namespace
}  // namespace panelcal::internal
