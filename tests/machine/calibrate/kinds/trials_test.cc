// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/kinds/trials.h"

#include <chrono>
#include <cmath>
#include <string>

#include "calib/base/files/atomic_file.h"
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using testing::HasSubstr;

constexpr std::chrono::sys_seconds kDate{std::chrono::seconds(1795302000)};

FocusResult focus_at(double z_mm, double sigma_mm) {
  FocusResult result;
  result.is_found = true;
  result.z = mm(z_mm);
  result.sigma = mm(sigma_mm);
  result.curve = {{mm(-1), 0.1}, {mm(0), 0.4}, {mm(1), 0.2}};
  return result;
}

SettleRun settled_after(double wait_s, double sigma_s) {
  SettleRun run;
  run.settle.emplace();
  run.settle->wait = seconds(wait_s);
  run.settle->sigma = seconds(sigma_s);
  return run;
}

class PlaceRecord : public ::testing::Test {
 protected:
  void SetUp() override {
    config_.file = folder_.path() / "machine.toml";
    ASSERT_TRUE(write_file(config_.file, "[machine]\n"));
    words_.date = kDate;
    words_.verdict = LedgerVerdict::Installed;
    words_.asked_by = "Ann";
    words_.software = "panelcal test";
    words_.temperature_degC = 21.5;
    auto ledger = Ledger::open(folder_.path() / "a.ledger", [] { return kDate; });
    ASSERT_TRUE(ledger) << ledger.error().text();
    ledger_.emplace(*std::move(ledger));
  }

  LedgerEntry append(const TrialValue& found) {
    const auto draft = trial_draft(config_, {position_mm<frame::Machine>(3, 4), 7}, found, words_);
    EXPECT_TRUE(draft) << draft.error().text();
    const auto entry = ledger_->append(*draft);
    EXPECT_TRUE(entry) << entry.error().text();
    return *entry;
  }
  std::string otherwise(LedgerKind kind) const {
    const auto words = stated_otherwise(config_, *ledger_, kind);
    EXPECT_TRUE(words) << words.error().text();
    return *words;
  }

  test::TemporaryFolder folder_;
  MachineConfig config_;
  RecordWords words_;
  std::optional<Ledger> ledger_;
};

TEST_F(PlaceRecord, KeepsTheNumberItsSigmaAndWhatItWasMadeFrom) {
  const LedgerEntry entry = append(trial_value(focus_at(0.137, 0.004)));
  const LedgerRecord& record = entry.record;
  EXPECT_EQ(record.key, trial_key(config_, LedgerKind::Focus));
  EXPECT_EQ(word(record.key.kind), "focus");
  EXPECT_EQ(record.verdict, LedgerVerdict::Installed);
  ASSERT_EQ(record.parameters.size(), 1u);
  EXPECT_EQ(record.parameters[0], (LedgerParameter{"height", 0.137, "mm"}));
  EXPECT_NEAR((*record.covariance)(0, 0), 0.004 * 0.004, 1e-15);
  ASSERT_EQ(record.inputs.size(), 1u);
  EXPECT_EQ(record.inputs[0].name, "machine.toml");
  EXPECT_EQ(record.temperature_degC, 21.5);
  const auto number = trial_number(entry);
  ASSERT_TRUE(number);
  EXPECT_EQ(number->value, 0.137);
  EXPECT_NEAR(number->sigma, 0.004, 1e-12);
  const auto text = ledger_->result(entry.id);
  ASSERT_TRUE(text);
  const nlohmann::json result = nlohmann::json::parse(*text);
  EXPECT_EQ(result["kind"], "focus");
  EXPECT_EQ(result["tool"], 7);
  EXPECT_EQ(result["mark_mm"], (nlohmann::json{3.0, 4.0}));
  EXPECT_EQ(result["curve"].size(), 3u);
}

TEST_F(PlaceRecord, WhatFindsNothingIsRefusedAndChangesNothing) {
  append(trial_value(focus_at(0.137, 0.004)));
  FocusResult none;
  none.reason = "the sharpest picture is at the end of the range";
  const LedgerEntry entry = append(trial_value(none));
  EXPECT_EQ(entry.record.verdict, LedgerVerdict::Refused);
  EXPECT_EQ(entry.record.reason, none.reason);
  EXPECT_FALSE(trial_number(entry));
  const auto in_force = ledger_->in_force(trial_key(config_, LedgerKind::Focus));
  ASSERT_TRUE(in_force);
  EXPECT_EQ((*in_force)->id, 1);
}

TEST_F(PlaceRecord, ALevelIsAsSureAsItsNeighboursAreClose) {
  LightRun run;
  for (const double level : {10., 20., 40., 50.}) run.samples.push_back({level, 0.1, 0});
  run.best = LampLevel{40, 0.5, false};
  // From 20 to 40: a uniform density over 20 has this standard deviation.
  EXPECT_NEAR(trial_value(run).sigma, 20 / std::sqrt(12.0), 1e-12);
  run.best->level = 50;
  EXPECT_NEAR(trial_value(run).sigma, 10 / std::sqrt(12.0), 1e-12);
}

TEST_F(PlaceRecord, SaysWhatMachineTomlShouldSay) {
  EXPECT_EQ(stated_line(LedgerKind::Focus, {-0.1372, 0.004}), "[camera] focus_mm = -0.137");
  EXPECT_EQ(stated_line(LedgerKind::Light, {42.5, 3}), "[camera] lamp = 42.5");
  // 0.2 + 2 x 0.0103 = 0.2206: rounded up, since a shorter wait is not enough.
  EXPECT_EQ(stated_line(LedgerKind::Settle, {0.2, 0.0103}), "[machine] settle_s = 0.221");
}

TEST_F(PlaceRecord, SaysWhereMachineTomlAndTheLedgerDisagree) {
  EXPECT_EQ(otherwise(LedgerKind::Focus), "");
  append(trial_value(focus_at(0.137, 0.004)));
  EXPECT_THAT(otherwise(LedgerKind::Focus), HasSubstr("says no focus_mm, and entry 1"));
  config_.vision.focus = mm(0);
  EXPECT_THAT(otherwise(LedgerKind::Focus), HasSubstr("write [camera] focus_mm = 0.137"));
  // 100 um are tolerated unless [nightly.focus] says otherwise.
  config_.vision.focus = mm(0.04);
  EXPECT_EQ(otherwise(LedgerKind::Focus), "");
  config_.nightly.emplace();
  config_.nightly->trials.focus_tolerance = um(50);
  EXPECT_THAT(otherwise(LedgerKind::Focus), HasSubstr("focus_mm = 0.04"));
}

TEST_F(PlaceRecord, AWaitMayBeLongerThanNeededAndNotShorter) {
  append(trial_value(settled_after(0.2, 0.01)));
  config_.settle = seconds(0.19);
  EXPECT_THAT(otherwise(LedgerKind::Settle), HasSubstr("write [machine] settle_s = 0.220"));
  config_.settle = seconds(0.22);
  EXPECT_EQ(otherwise(LedgerKind::Settle), "");
  config_.settle = seconds(3);
  EXPECT_EQ(otherwise(LedgerKind::Settle), "");
}

TEST_F(PlaceRecord, AfterGoingBackTheEarlierOneCounts) {
  append(trial_value(focus_at(0.1, 0.004)));
  append(trial_value(focus_at(0.9, 0.004)));
  config_.vision.focus = mm(0.1);
  EXPECT_THAT(otherwise(LedgerKind::Focus), HasSubstr("entry 2"));
  ASSERT_TRUE(ledger_->roll_back({trial_key(config_, LedgerKind::Focus), {}, "no", "Ann", "test"}));
  EXPECT_EQ(otherwise(LedgerKind::Focus), "");
}

}  // namespace
}  // namespace panelcal
