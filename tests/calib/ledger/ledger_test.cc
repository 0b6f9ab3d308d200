// SPDX-License-Identifier: Apache-2.0
#include "calib/ledger/ledger.h"

#include <cmath>
#include <functional>
#include <limits>

#include <gmock/gmock.h>

#include "tests/calib/ledger/drafts.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::first_night;
using test::kFirstNight;
using test::offset_draft;
using test::spindle;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

class LedgerTest : public test::LedgerFolder {};

std::vector<std::int64_t> ids(const Expected<std::vector<LedgerEntry>>& entries) {
  std::vector<std::int64_t> out;
  if (!entries) ADD_FAILURE() << entries.error().text();
  for (const LedgerEntry& entry : entries.value()) out.push_back(entry.id);
  return out;
}

/// 0 if nothing is in force.
std::int64_t in_force(const Ledger& ledger, const LedgerKey& key) {
  const Expected<std::optional<LedgerEntry>> entry = ledger.in_force(key);
  if (!entry) ADD_FAILURE() << entry.error().text();
  return *entry ? (*entry)->id : 0;
}

TEST_F(LedgerTest, GivesBackEveryFieldAfterReopening) {
  LedgerDraft draft = offset_draft(0.1 + 0.2);
  draft.record.key.subject = "Spindel \xc3\xbc \"2\"";
  draft.record.reason = "two\nlines\tand \\ a backslash";
  draft.record.parameters.push_back({"tiny", 4.9e-324, "1"});
  draft.record.parameters.push_back({"huge", 1.7976931348623157e308, "1"});
  draft.record.covariance = Eigen::MatrixXd::Identity(4, 4) / 3.0;
  ASSERT_TRUE(test::LedgerFolder::opened().append(draft));

  const Ledger ledger = opened();
  const Expected<LedgerEntry> entry = ledger.entry(1);
  ASSERT_TRUE(entry) << entry.error().text();
  EXPECT_EQ(entry->id, 1);
  EXPECT_EQ(entry->time, kFirstNight);
  EXPECT_EQ(entry->record.key, draft.record.key);
  EXPECT_EQ(entry->record.verdict, LedgerVerdict::Installed);
  EXPECT_EQ(entry->record.reason, draft.record.reason);
  EXPECT_EQ(entry->record.asked_by, "timer");
  EXPECT_EQ(entry->record.software, "panelcal 0.1.0");
  EXPECT_EQ(entry->record.temperature_degC, 21.25);
  EXPECT_EQ(entry->record.inputs, draft.record.inputs);
  EXPECT_EQ(entry->record.parameters, draft.record.parameters);
  ASSERT_TRUE(entry->record.covariance);
  EXPECT_EQ(*entry->record.covariance, *draft.record.covariance);
  EXPECT_EQ(entry->record.replaces, std::nullopt);
  EXPECT_EQ(entry->restores, std::nullopt);
  EXPECT_EQ(entry->result_bytes, draft.result.size());
  EXPECT_EQ(entry->result_sha256, sha256(draft.result));
  EXPECT_EQ(ledger.result(1).value(), draft.result);
}

TEST_F(LedgerTest, ChainsTheHashes) {
  Ledger ledger = opened();
  EXPECT_EQ(ledger.head().value(), (LedgerHead{0, ""}));
  const LedgerEntry first = ledger.append(offset_draft(1)).value();
  const LedgerEntry second = ledger.append(offset_draft(2)).value();
  // As docs/decisions/ledger.md says it: anybody can check it with sha256sum.
  EXPECT_EQ(first.hash, sha256(std::string(64, '0') + "\n" + ledger_entry_json(first)));
  EXPECT_EQ(second.hash, sha256(first.hash + "\n" + ledger_entry_json(second)));
  EXPECT_EQ(ledger.head().value(), (LedgerHead{2, second.hash}));
  EXPECT_EQ(ledger.verify().value(), (LedgerHead{2, second.hash}));
}

TEST_F(LedgerTest, NewestInstalledIsInForce) {
  Ledger ledger = opened();
  EXPECT_EQ(in_force(ledger, spindle(1)), 0);
  ASSERT_TRUE(ledger.append(offset_draft(1)));
  ASSERT_TRUE(ledger.append(offset_draft(2)));
  ASSERT_TRUE(ledger.append(offset_draft(3, LedgerVerdict::Refused)));
  ASSERT_TRUE(ledger.append(offset_draft(4, LedgerVerdict::Measured)));
  ASSERT_TRUE(ledger.append(offset_draft(5, LedgerVerdict::Installed, 2)));
  EXPECT_EQ(in_force(ledger, spindle(1)), 2);
  EXPECT_EQ(in_force(ledger, spindle(2)), 5);
  LedgerKey other_machine = spindle(1);
  other_machine.machine = "drill 2";
  EXPECT_EQ(in_force(ledger, other_machine), 0);
  LedgerKey other_kind = spindle(1);
  other_kind.kind = LedgerKind::Camera;
  EXPECT_EQ(in_force(ledger, other_kind), 0);
  EXPECT_THAT(ids(ledger.all_in_force("drill 1")), ElementsAre(2, 5));
  EXPECT_EQ(ledger.entry(2)->record.replaces, 1);
  EXPECT_EQ(ledger.entry(3)->record.replaces, std::nullopt);
}

TEST_F(LedgerTest, RollsBackFurtherEachTime) {
  Ledger ledger = opened();
  for (const double x_mm : {1.0, 2.0, 3.0}) ASSERT_TRUE(ledger.append(offset_draft(x_mm)));
  const Ledger::RollBack request{spindle(1), std::nullopt, "holes are off", "night shift", "test"};
  const Expected<LedgerEntry> once = ledger.roll_back(request);
  ASSERT_TRUE(once) << once.error().text();
  EXPECT_EQ(once->record.verdict, LedgerVerdict::RolledBack);
  EXPECT_EQ(once->record.replaces, 3);
  EXPECT_EQ(once->restores, 2);
  EXPECT_EQ(in_force(ledger, spindle(1)), 2);
  EXPECT_THAT(ids(ledger.all_in_force("drill 1")), ElementsAre(2));
  ASSERT_TRUE(ledger.roll_back(request));
  EXPECT_EQ(in_force(ledger, spindle(1)), 1);
  EXPECT_THAT(ledger.roll_back(request), FailsWith(Code::LedgerEntryInvalid, "entry 1"));
  EXPECT_EQ(in_force(ledger, spindle(1)), 1);
  // Nothing was deleted on the way, and the next one replaces what is in force now.
  EXPECT_EQ(ledger.list({})->size(), 5u);
  EXPECT_EQ(ledger.append(offset_draft(6))->record.replaces, 1);
  ASSERT_TRUE(ledger.verify());
}

TEST_F(LedgerTest, RollsBackOnlyToWhatWasInstalledForTheSame) {
  Ledger ledger = opened();
  ASSERT_TRUE(ledger.append(offset_draft(1)));
  ASSERT_TRUE(ledger.append(offset_draft(2, LedgerVerdict::Refused)));
  ASSERT_TRUE(ledger.append(offset_draft(3, LedgerVerdict::Installed, 2)));
  ASSERT_TRUE(ledger.append(offset_draft(4)));
  Ledger::RollBack request{spindle(1), 2, "holes are off", "night shift", "test"};
  EXPECT_THAT(ledger.roll_back(request), FailsWith(Code::LedgerEntryInvalid, "entry 2"));
  request.to = 3;
  EXPECT_THAT(ledger.roll_back(request), FailsWith(Code::LedgerEntryInvalid, "spindle 2"));
  request.to = 4;
  EXPECT_THAT(ledger.roll_back(request), FailsWith(Code::LedgerEntryInvalid, "entry 4"));
  request.to = 99;
  EXPECT_THAT(ledger.roll_back(request), FailsWith(Code::LedgerEntryUnknown, "entry 99"));
  request.to = 1;
  request.reason = "";
  EXPECT_THAT(ledger.roll_back(request), FailsWith(Code::LedgerEntryInvalid, "reason"));
  request.reason = "holes are off";
  request.key.subject = "spindle 9";
  EXPECT_THAT(ledger.roll_back(request), FailsWith(Code::LedgerEntryInvalid));
  EXPECT_EQ(ledger.head()->id, 4);
  request.key = spindle(1);
  ASSERT_TRUE(ledger.roll_back(request));
  EXPECT_EQ(in_force(ledger, spindle(1)), 1);
}

TEST_F(LedgerTest, ReplacesIsACondition) {
  Ledger ledger = opened();
  ASSERT_TRUE(ledger.append(offset_draft(1)));
  LedgerDraft draft = offset_draft(2);
  draft.record.replaces = 1;
  ASSERT_TRUE(ledger.append(draft));
  EXPECT_THAT(ledger.append(draft), FailsWith(Code::LedgerEntryInvalid, "entry 2"));
  EXPECT_EQ(ledger.head()->id, 2);
}

TEST_F(LedgerTest, RecordsSeveralOrNone) {
  Ledger ledger = opened();
  std::vector<LedgerDraft> night = {offset_draft(1), offset_draft(2), offset_draft(3)};
  night[2].record.replaces = 17;
  EXPECT_THAT(ledger.append_all(night), FailsWith(Code::LedgerEntryInvalid, "entry 2"));
  EXPECT_EQ(ledger.head()->id, 0);
  night[2].record.replaces = 2;
  ASSERT_TRUE(ledger.append_all(night));
  EXPECT_EQ(ledger.head()->id, 3);
  EXPECT_EQ(ledger.append_all({})->size(), 0u);
}

TEST_F(LedgerTest, FiltersEntries) {
  std::chrono::sys_seconds now = kFirstNight;
  Ledger ledger = opened([&now] { return now; });
  for (int i = 0; i < 6; ++i) {
    LedgerDraft draft = offset_draft(i, LedgerVerdict::Installed, 1 + i % 2);
    if (i == 3) draft.record.key.kind = LedgerKind::Camera;
    if (i == 5) draft.record.key.machine = "drill 2";
    ASSERT_TRUE(ledger.append(draft));
    now += std::chrono::days(1);
  }
  EXPECT_THAT(ids(ledger.list({})), ElementsAre(1, 2, 3, 4, 5, 6));
  EXPECT_THAT(ids(ledger.list({.machine = "drill 1"})), ElementsAre(1, 2, 3, 4, 5));
  EXPECT_THAT(ids(ledger.list({.kind = LedgerKind::Camera})), ElementsAre(4));
  EXPECT_THAT(ids(ledger.list({.subject = spindle(2).subject})), ElementsAre(2, 4, 6));
  EXPECT_THAT(ids(ledger.list({.since = kFirstNight + std::chrono::days(4)})), ElementsAre(5, 6));
  EXPECT_THAT(ids(ledger.list({.last = 2})), ElementsAre(5, 6));
  EXPECT_THAT(
      ids(ledger.list({.machine = "drill 1", .kind = LedgerKind::SpindleCamera, .last = 1})),
      ElementsAre(5));
  EXPECT_THAT(ids(ledger.list({.last = 0})), IsEmpty());
  EXPECT_THAT(ids(ledger.list({.machine = "' OR 1=1 --"})), IsEmpty());
}

TEST_F(LedgerTest, KeepsTheOrderWhenTheClockIsSetBack) {
  std::chrono::sys_seconds now = kFirstNight;
  Ledger ledger = opened([&now] { return now; });
  ASSERT_TRUE(ledger.append(offset_draft(1)));
  now -= std::chrono::days(400);
  ASSERT_TRUE(ledger.append(offset_draft(2)));
  EXPECT_EQ(in_force(ledger, spindle(1)), 2);
  EXPECT_THAT(ids(ledger.list({})), ElementsAre(1, 2));
  EXPECT_TRUE(ledger.verify());
}

TEST_F(LedgerTest, GivesAParameterOverTime) {
  std::chrono::sys_seconds now = kFirstNight;
  Ledger ledger = opened([&now] { return now; });
  ASSERT_TRUE(ledger.append(offset_draft(1)));
  now += std::chrono::hours(24);
  LedgerDraft second = offset_draft(2, LedgerVerdict::Refused);
  second.record.temperature_degC.reset();
  second.record.covariance.reset();
  ASSERT_TRUE(ledger.append(second));
  ASSERT_TRUE(ledger.append(offset_draft(3, LedgerVerdict::Installed, 2)));
  const Expected<LedgerSeries> x = ledger.series(spindle(1), "offset_x");
  ASSERT_TRUE(x) << x.error().text();
  EXPECT_EQ(x->unit, "mm");
  ASSERT_EQ(x->points.size(), 2u);
  EXPECT_EQ(x->points[0].id, 1);
  EXPECT_EQ(x->points[0].time, kFirstNight);
  EXPECT_EQ(x->points[0].value, 1);
  EXPECT_EQ(x->points[0].sigma, std::sqrt(4e-6));
  EXPECT_EQ(x->points[0].temperature_degC, 21.25);
  EXPECT_EQ(x->points[1].time, kFirstNight + std::chrono::hours(24));
  EXPECT_EQ(x->points[1].value, 2);
  EXPECT_EQ(x->points[1].sigma, std::nullopt);
  EXPECT_EQ(x->points[1].temperature_degC, std::nullopt);
  EXPECT_EQ(x->points[1].verdict, LedgerVerdict::Refused);
  EXPECT_EQ(ledger.series(spindle(1), "offset_y")->points[0].sigma, std::sqrt(9e-6));
  EXPECT_THAT(ledger.series(spindle(1), "offset_z")->points, IsEmpty());
}

TEST_F(LedgerTest, RefusesASeriesWhoseUnitChanges) {
  Ledger ledger = opened();
  ASSERT_TRUE(ledger.append(offset_draft(1)));
  LedgerDraft draft = offset_draft(1000);
  draft.record.parameters[0].unit = "um";
  ASSERT_TRUE(ledger.append(draft));
  EXPECT_THAT(ledger.series(spindle(1), "offset_x"),
              FailsWith(Code::LedgerEntryInvalid, "entry 2"));
}

TEST_F(LedgerTest, RefusesWhatItCannotHold) {
  struct Case {
    const char* part;
    std::function<void(LedgerDraft&)> spoil;
  };
  const std::vector<Case> cases = {
      {"machine", [](LedgerDraft& d) { d.record.key.machine = ""; }},
      {"machine", [](LedgerDraft& d) { d.record.key.machine = std::string(201, 'a'); }},
      {"subject", [](LedgerDraft& d) { d.record.key.subject = "two\nlines"; }},
      {"subject", [](LedgerDraft& d) { d.record.key.subject = "\xff\xfe"; }},
      {"asked_by", [](LedgerDraft& d) { d.record.asked_by = ""; }},
      {"software", [](LedgerDraft& d) { d.record.software = ""; }},
      {"reason", [](LedgerDraft& d) { d.record.reason = std::string("a\0b", 3); }},
      {"reason",
       [](LedgerDraft& d) {
         d.record.verdict = LedgerVerdict::Refused;
         d.record.reason = "";
       }},
      {"rolled-back", [](LedgerDraft& d) { d.record.verdict = LedgerVerdict::RolledBack; }},
      {"temperature", [](LedgerDraft& d) { d.record.temperature_degC = kNan; }},
      {"sha256", [](LedgerDraft& d) { d.record.inputs[0].sha256 = "1234"; }},
      {"sha256", [](LedgerDraft& d) { d.record.inputs[0].sha256 = std::string(64, 'F'); }},
      {"bytes", [](LedgerDraft& d) { d.record.inputs[0].bytes = ~std::uint64_t{0}; }},
      {"offset_x", [](LedgerDraft& d) { d.record.parameters[0].value = kNan; }},
      {"twice", [](LedgerDraft& d) { d.record.parameters[1].name = "offset_x"; }},
      {"unit", [](LedgerDraft& d) { d.record.parameters[1].unit = ""; }},
      {"3 x 3", [](LedgerDraft& d) { d.record.covariance = Eigen::MatrixXd::Identity(3, 3); }},
      {"covariance", [](LedgerDraft& d) { (*d.record.covariance)(0, 1) = 2e-6; }},
      {"covariance", [](LedgerDraft& d) { (*d.record.covariance)(0, 0) = -4e-6; }},
      {"covariance", [](LedgerDraft& d) { (*d.record.covariance)(1, 1) = kNan; }},
      {"covariance",
       [](LedgerDraft& d) {  // a correlation of 7/6
         (*d.record.covariance)(0, 1) = (*d.record.covariance)(1, 0) = 7e-6;
       }},
      {"covariance",
       [](LedgerDraft& d) {  // correlated with what is exactly known
         (*d.record.covariance)(0, 0) = 0;
       }},
      {"JSON", [](LedgerDraft& d) { d.result = "{\"kind\": "; }},
      {"JSON", [](LedgerDraft& d) { d.result = ""; }},
      {"JSON", [](LedgerDraft& d) { d.result = R"({"a": 1, "a": 2})"; }},
      {"replaces",
       [](LedgerDraft& d) {
         d.record.verdict = LedgerVerdict::Measured;
         d.record.replaces = 1;
       }},
      {"parameters",
       [](LedgerDraft& d) {
         d.record.covariance.reset();
         for (int i = 0; i < 500; ++i) d.record.parameters.push_back({"p", 0, "1"});
       }},
  };
  Ledger ledger = opened();
  for (const Case& c : cases) {
    LedgerDraft draft = offset_draft(1);
    c.spoil(draft);
    EXPECT_THAT(ledger.append(draft), FailsWith(Code::LedgerEntryInvalid, c.part));
  }
  EXPECT_EQ(ledger.head()->id, 0);
}

TEST_F(LedgerTest, RefusesATimeThatCannotBeWritten) {
  Ledger ledger = opened(fixed_clock(std::chrono::sys_seconds(std::chrono::days(5000000))));
  EXPECT_THAT(ledger.append(offset_draft(1)), FailsWith(Code::LedgerEntryInvalid, "clock"));
}

TEST_F(LedgerTest, KnowsNoEntryThatIsNotThere) {
  const Ledger ledger = opened();
  for (const std::int64_t id : {std::int64_t{-1}, std::int64_t{0}, std::int64_t{1}}) {
    EXPECT_THAT(ledger.entry(id), FailsWith(Code::LedgerEntryUnknown));
    EXPECT_THAT(ledger.result(id), FailsWith(Code::LedgerEntryUnknown));
  }
}

TEST(LedgerWords, ReadBackAsWhatTheyAre) {
  for (const std::string_view text : ledger_kind_words()) {
    ASSERT_TRUE(ledger_kind(text)) << text;
    EXPECT_EQ(word(*ledger_kind(text)), text);
  }
  EXPECT_EQ(word(LedgerKind::SelfTest), "self-test");
  EXPECT_EQ(word(LedgerKind::Night), "night");
  EXPECT_EQ(word(LedgerVerdict::RolledBack), "rolled-back");
  EXPECT_EQ(ledger_verdict("refused"), LedgerVerdict::Refused);
  EXPECT_EQ(ledger_kind("Camera"), std::nullopt);
}

}  // namespace
}  // namespace panelcal
