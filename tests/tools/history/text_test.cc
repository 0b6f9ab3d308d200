// SPDX-License-Identifier: Apache-2.0
#include "tools/history/text.h"

#include "tools/history/facts.h"
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/calib/ledger/drafts.h"
#include "tests/support/matchers.h"

namespace panelcal::history {
namespace {

using test::FailsWith;
using test::offset_draft;
using testing::HasSubstr;

LedgerEntry entry_of(std::int64_t id, double x_mm) {
  LedgerEntry entry;
  entry.id = id;
  entry.time = test::kFirstNight;
  entry.record = offset_draft(x_mm).record;
  return entry;
}

TEST(HistoryText, EntryIsOneLineOfJsonWithItsResult) {
  const std::string result = "{\n \"a\": [1,\r\n 2],\n \"text\": \"line\\nend \\\" quote\"\n}\n";
  const std::string text = entry_json(entry_of(7, 1), true, result);
  EXPECT_EQ(text.find('\n'), text.size() - 1);
  const nlohmann::json json = nlohmann::json::parse(text);
  EXPECT_EQ(json["id"], 7);
  EXPECT_EQ(json["in_force"], true);
  EXPECT_EQ(json["result"], nlohmann::json::parse(result));
}

TEST(HistoryText, WordsOfOthersStayOnTheirLine) {
  LedgerEntry entry = entry_of(7, 1);
  entry.record.reason = "two\nlines and \x1b[31m colour";
  const std::string line = entry_line(entry, false);
  EXPECT_EQ(line.find('\n'), line.size() - 1);
  EXPECT_EQ(line.find('\x1b'), std::string::npos);
}

TEST(HistoryText, ChangesCarryTheSigmaOfADifference) {
  LedgerEntry before = entry_of(1, 50.0);
  LedgerEntry after = entry_of(2, 50.003);
  before.record.covariance = Eigen::Vector2d(9e-6, 1e-6).asDiagonal();
  after.record.covariance = Eigen::Vector2d(16e-6, 1e-6).asDiagonal();
  after.record.parameters.push_back({"tilt", 0.5, "rad"});
  after.record.covariance.reset();
  auto changes = changes_between(before, after, "x.ledger");
  ASSERT_TRUE(changes) << changes.error().text();
  ASSERT_EQ(changes->size(), 3u);
  EXPECT_EQ((*changes)[0].sigma, std::nullopt);
  EXPECT_EQ((*changes)[2].before, std::nullopt);
  EXPECT_EQ((*changes)[2].change(), std::nullopt);

  after.record.parameters.pop_back();
  after.record.covariance = Eigen::Vector2d(16e-6, 1e-6).asDiagonal();
  changes = changes_between(before, after, "x.ledger");
  ASSERT_TRUE(changes);
  EXPECT_NEAR(*(*changes)[0].sigma, 0.005, 1e-15);  // 3, 4, 5
  EXPECT_NEAR(*(*changes)[0].change(), 0.003, 1e-12);
  EXPECT_THAT(changes_text(*changes), HasSubstr(" 0.6 mm"));
  EXPECT_EQ(changes_facts(*changes).size(), 2u);
}

TEST(HistoryText, RefusesToCompareWhatIsNotAlike) {
  const LedgerEntry before = entry_of(1, 1);
  LedgerEntry after = entry_of(2, 1);
  after.record.parameters[1].unit = "um";
  EXPECT_THAT(changes_between(before, after, "x.ledger"),
              FailsWith(Code::LedgerEntryInvalid, "\"offset_y\""));
  after.record.key.kind = LedgerKind::Camera;
  EXPECT_THAT(changes_between(before, after, "x.ledger"),
              FailsWith(Code::LedgerEntryInvalid, "entry 2"));
}

}  // namespace
}  // namespace panelcal::history
