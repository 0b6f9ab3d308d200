// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/record/night_history.h"

#include <gmock/gmock.h>

#include "tests/machine/nightly/fake_night.h"

namespace panelcal {
namespace {

/// Writes entries as nights and people do.
class NightHistoryTest : public test::NightTest {
 protected:
  LedgerDraft draft(double x_mm, LedgerVerdict verdict) const {
    LedgerDraft draft;
    LedgerRecord& record = draft.record;
    record.key = calibration_.key();
    record.verdict = verdict;
    record.reason = "because";
    record.asked_by = "timer";
    record.software = "panelcal test";
    record.parameters = {{"offset_x", x_mm, "mm"}, {"offset_y", -3.7, "mm"}};
    record.covariance = 1e-6 * Eigen::Matrix2d::Identity();
    draft.result = "{}";
    return draft;
  }

  void night(double x_mm, LedgerVerdict verdict, int used_up = 0) {
    Ledger ledger = this->ledger();
    CalibrationResult measurement;
    measurement.spreads = {{"holes", "mm", 9e-6, 16}};
    measurement.levels = {{"contrast", "1", 0.5, true}, {"blur", "px", 1.1, false}};
    const LedgerDraft one = draft(x_mm, verdict);
    const bool installs = verdict == LedgerVerdict::Installed;
    const std::array<LedgerDraft, 2> both = {
        one,
        companion_draft(one.record,
                        night_of(now_, 12),
                        &measurement,
                        used_up,
                        installs ? NightState::Installed : NightState::KeptOld,
                        "words")};
    const auto entries = ledger.append_all(both);
    ASSERT_TRUE(entries) << entries.error().text();
    next_night();
  }

  void by_hand(double x_mm) {
    Ledger ledger = this->ledger();
    const auto entry = ledger.append(draft(x_mm, LedgerVerdict::Installed));
    ASSERT_TRUE(entry) << entry.error().text();
    next_night();
  }

  NightHistory history(const std::string& night = "none") const {
    const Ledger ledger = this->ledger();
    auto history = read_night_history(ledger, calibration_, night, now_);
    if (!history) ADD_FAILURE() << history.error().text();
    return history ? *history : NightHistory{};
  }
};

TEST_F(NightHistoryTest, IsEmptyForAnEmptyLedger) {
  const NightHistory history = this->history();
  EXPECT_TRUE(history.series.points.empty());
  EXPECT_FALSE(history.in_force);
  EXPECT_FALSE(history.tonight);
  EXPECT_FALSE(history.used_up);
  EXPECT_FALSE(history.is_fresh_start);
}

TEST_F(NightHistoryTest, LeavesOutWhatWasRefusedAndKnowsWhatIsInForce) {
  night(51.200, LedgerVerdict::Installed, 3);
  night(51.240, LedgerVerdict::Refused, 6);
  night(51.201, LedgerVerdict::Installed, 9);
  const NightHistory history = this->history();
  ASSERT_EQ(history.series.points.size(), 3u);
  EXPECT_FALSE(history.series.points[0].is_left_out);
  EXPECT_TRUE(history.series.points[1].is_left_out);
  EXPECT_FALSE(history.series.points[2].is_left_out);
  EXPECT_EQ(history.series.points[1].value, Eigen::Vector2d(51.240, -3.7));
  ASSERT_EQ(history.in_force_values.size(), 3u);
  EXPECT_EQ((*history.in_force_values[1])(0), 51.200);
  EXPECT_EQ(history.in_force_value->value(0), 51.201);
  EXPECT_EQ(history.used_up, 9);
  ASSERT_EQ(history.qualities.size(), 3u);
  EXPECT_TRUE(history.qualities[1].is_left_out);
  ASSERT_EQ(history.qualities[0].spreads.size(), 1u);
  EXPECT_EQ(history.qualities[0].spreads[0].name, "holes");
  EXPECT_EQ(history.qualities[0].spreads[0].unit, "mm");
  EXPECT_EQ(history.qualities[0].spreads[0].variance, 9e-6);
  EXPECT_EQ(history.qualities[0].spreads[0].degrees_of_freedom, 16);
  ASSERT_EQ(history.qualities[0].levels.size(), 2u);
  EXPECT_TRUE(history.qualities[0].levels[0].low_is_bad);
  EXPECT_FALSE(history.qualities[0].levels[1].low_is_bad);
}

TEST_F(NightHistoryTest, AFreshStartWaitsForTheFirstGoodNight) {
  night(51.2, LedgerVerdict::Installed);
  fresh_start();
  EXPECT_TRUE(history().is_fresh_start);
  night(51.3, LedgerVerdict::Refused);
  EXPECT_TRUE(history().is_fresh_start);
  night(51.24, LedgerVerdict::Installed);
  const NightHistory history = this->history();
  EXPECT_FALSE(history.is_fresh_start);
  EXPECT_FALSE(history.series.points[0].is_fresh_start);
  EXPECT_TRUE(history.series.points[2].is_fresh_start);
}

TEST_F(NightHistoryTest, WhoInstallsByHandWhatANightRefusedHasAcceptedIt) {
  night(51.2, LedgerVerdict::Installed);
  by_hand(51.201);
  night(51.24, LedgerVerdict::Refused);
  by_hand(51.24);
  const NightHistory history = this->history();
  ASSERT_EQ(history.series.points.size(), 4u);
  EXPECT_FALSE(history.series.points[1].is_fresh_start);
  EXPECT_TRUE(history.series.points[3].is_fresh_start);
}

TEST_F(NightHistoryTest, KnowsWhatTonightHasDoneUnlessAPersonHasStartedAnew) {
  night(51.2, LedgerVerdict::Installed);
  now_ -= std::chrono::days(1);
  const std::string tonight = night_of(now_, 12);
  ASSERT_TRUE(history(tonight).tonight);
  EXPECT_EQ(history(tonight).tonight->entry.id, 1);
  EXPECT_EQ(history(tonight).tonight->state, NightState::Installed);
  EXPECT_EQ(history(tonight).tonight->summary, "words");
  EXPECT_FALSE(history("1999-01-01").tonight);
  fresh_start();
  EXPECT_FALSE(history(tonight).tonight);
}

TEST_F(NightHistoryTest, RemembersAWeekAgoThroughARollback) {
  night(51.2, LedgerVerdict::Installed);
  night(51.3, LedgerVerdict::Installed);
  {
    Ledger ledger = this->ledger();
    const auto back = ledger.roll_back({calibration_.key(), {}, "wrong", "operator", "test"});
    ASSERT_TRUE(back) << back.error().text();
  }
  now_ += std::chrono::days(8);
  night(51.25, LedgerVerdict::Installed);
  const NightHistory history = this->history();
  ASSERT_TRUE(history.week_ago);
  EXPECT_EQ(history.week_ago->value(0), 51.2);
  EXPECT_EQ(history.in_force_value->value(0), 51.25);
}

TEST_F(NightHistoryTest, TimesAscendAlsoWhereAClockWasSetBack) {
  night(51.2, LedgerVerdict::Installed);
  now_ -= std::chrono::days(30);
  night(51.2, LedgerVerdict::Installed);
  const NightHistory history = this->history();
  EXPECT_EQ(history.series.points[1].time - history.series.points[0].time, std::chrono::seconds(1));
  EXPECT_LT(history.qualities[0].time, history.qualities[1].time);
}

TEST_F(NightHistoryTest, WhatIsAheadOfTheClockIsToldUntilAFreshStart) {
  night(51.2, LedgerVerdict::Installed);
  EXPECT_FALSE(history().ahead);
  now_ += std::chrono::days(300);
  night(51.2, LedgerVerdict::Installed);
  now_ -= std::chrono::days(300);  // one day after the first night
  EXPECT_EQ(history().ahead, std::chrono::days(299));
  EXPECT_EQ(history().ahead_id, 3) << "the second night's";
  fresh_start();
  NightHistory history = this->history();
  EXPECT_FALSE(history.ahead);
  ASSERT_EQ(history.series.points.size(), 2u);
  EXPECT_LT(history.series.points[0].time, history.series.points[1].time);
  EXPECT_LT(history.series.points[1].time, now_);
  EXPECT_LT(history.qualities[1].time, now_);
  night(51.2, LedgerVerdict::Installed);
  history = this->history();
  EXPECT_FALSE(history.ahead);
  EXPECT_TRUE(history.series.points[2].is_fresh_start);
  EXPECT_EQ(history.series.points[2].time, now_ - std::chrono::days(1));
}

TEST_F(NightHistoryTest, ClocksMayDifferByLessThanAnHour) {
  night(51.2, LedgerVerdict::Installed);
  now_ -= std::chrono::days(1) + std::chrono::minutes(59);
  EXPECT_FALSE(history().ahead);
  now_ -= std::chrono::minutes(2);
  EXPECT_EQ(history().ahead, std::chrono::minutes(61));
}

TEST_F(NightHistoryTest, WhatWasRolledBackIsLeftOut) {
  const auto roll_back_to = [&](std::int64_t id) {
    Ledger ledger = this->ledger();
    const auto back = ledger.roll_back({calibration_.key(), id, "wrong", "operator", "test"});
    ASSERT_TRUE(back) << back.error().text();
  };
  const auto left_out = [&] {
    const NightHistory history = this->history();
    std::vector<bool> out;
    for (std::size_t i = 0; i < history.series.points.size(); ++i) {
      out.push_back(history.series.points[i].is_left_out);
      EXPECT_EQ(history.qualities[i].is_left_out, out[i]);
    }
    return out;
  };
  night(51.2, LedgerVerdict::Installed);  // entries 1, 3, 5 with their companions
  night(51.3, LedgerVerdict::Installed);
  night(51.31, LedgerVerdict::Installed);
  EXPECT_EQ(left_out(), (std::vector<bool>{false, false, false}));
  roll_back_to(1);
  EXPECT_EQ(left_out(), (std::vector<bool>{false, true, true}));
  // On second thoughts.
  roll_back_to(3);
  EXPECT_EQ(left_out(), (std::vector<bool>{false, false, true}));
}

TEST_F(NightHistoryTest, AFarMoveByHandIsAFreshStart) {
  night(51.2, LedgerVerdict::Installed);
  by_hand(51.23);
  by_hand(51.29);
  night(51.35, LedgerVerdict::Installed);
  NightHistory history = this->history();
  accept_moves_by_hand(history, 0.05);
  ASSERT_EQ(history.series.points.size(), 4u);
  EXPECT_FALSE(history.series.points[1].is_fresh_start);
  EXPECT_TRUE(history.series.points[2].is_fresh_start);
  // A night is held against its own gate.
  EXPECT_FALSE(history.series.points[3].is_fresh_start);
}

TEST_F(NightHistoryTest, ALedgerBegunAnewHasToBeConfirmed) {
  {
    Ledger ledger = this->ledger();
    const auto begun = ledger.append(begun_anew_draft(
        "drill 1", "old.ledger", {.date = now_, .asked_by = "timer", .software = "test"}));
    ASSERT_TRUE(begun) << begun.error().text();
  }
  EXPECT_TRUE(history().is_unconfirmed);
  fresh_start();
  EXPECT_FALSE(history().is_unconfirmed);
}

}  // namespace
}  // namespace panelcal
