// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include "tools/nightly/report.h"
#include "tools/page/page.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/tools/sample_night.h"

namespace panelcal::nightly {
namespace {

using test::sample_hold;
using test::sample_night;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kHostile = "<script>alert(\"1\")</script> & 'x' \xff\x01";

/// Everything that a person or a file may have named.
NightRecord hostile_night() {
  NightRecord record = sample_hold();
  for (std::string* text : {&record.machine, &record.verdict, &record.asked_by, &record.software}) {
    *text = kHostile;
  }
  record.notes = record.changes = {kHostile};
  record.checks.front().name = record.checks.front().text = kHostile;
  NightStep& step = record.steps.front();
  step.kind = step.subject = step.summary = step.since_when = step.forecast_text = kHostile;
  step.axes.front().name = step.axes.front().unit = kHostile;
  step.alarms = step.fit_report = {kHostile};
  step.qualities.front().name = step.qualities.front().text = kHostile;
  step.decision->gates.front() = {kHostile, false, kHostile};
  step.decision->reasons = {kHostile};
  step.problem = Diagnostic{Code::DeviceStage, {kHostile, 0, 0}, kHostile, kHostile};
  return record;
}

/// Ten looks at the mark of a machine that came 8 um nearer meanwhile.
NightWarmUp sample_warm_up() {
  NightWarmUp seen;
  seen.limit = um(2);
  seen.is_warm = true;
  seen.text = "warm after 6.9 min: then less than 2.0 um of 8.0 um were still to come";
  WarmUp& fit = seen.fit.emplace();
  fit.is_seen = true;
  fit.time_constant = seconds(300);
  fit.wait = seconds(416);
  fit.warm = Eigen::Vector2d(300, 200);
  fit.cold_offset = Eigen::Vector2d(0.008, 0);
  for (int i = 0; i < 10; ++i) {
    const Time since = seconds(60.0 * i);
    const Eigen::VectorXd at_mm = fit.warm + std::exp(-i / 5.0) * fit.cold_offset;
    seen.looks.push_back({since, at_mm, 0.0003});
  }
  return seen;
}

std::size_t count(std::string_view text, std::string_view part) {
  std::size_t n = 0;
  for (auto at = text.find(part); at != std::string_view::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST(NightFacts, HaveHowTheMachineWarmedUp) {
  NightRecord record = sample_night();
  EXPECT_TRUE(night_facts(record, {})["warm_up"].is_null());
  record.warm_up = sample_warm_up();
  const facts::Json warm_up = night_facts(record, {})["warm_up"];
  EXPECT_EQ(warm_up["looks"].size(), 10U);
  EXPECT_EQ(warm_up["fit"]["time_constant_s"], 300);
  EXPECT_EQ(warm_up["limit_mm"], 0.002);
}

TEST(NightFacts, HaveNullForWhatIsNoNumber) {
  NightRecord record = sample_night();
  NightStep& step = record.steps.front();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  step.series[3].value = {nan, 1};
  step.holes[0].residual_mm.x() = nan;
  step.axes[0].expected_sigma = nan;
  step.axes[1].new_value.reset();
  const facts::Json json = night_facts(record, {})["steps"][0];
  EXPECT_TRUE(json["series"][3]["value"][0].is_null());
  EXPECT_EQ(json["series"][3]["value"][1], 1);
  EXPECT_TRUE(json["holes"][0]["residual_mm"][0].is_null());
  EXPECT_TRUE(json["axes"][0]["expected_sigma"].is_null());
  EXPECT_TRUE(json["axes"][1]["new"].is_null());
}

/// Who has put a value into force, and how far off it may be.
TEST(NightFacts, NameTheEntryOfEveryNight) {
  NightRecord record = sample_night();
  NightStep& step = record.steps.front();
  step.tolerance = 0.010;
  step.series[0].ledger_id = 60;
  step.series[0].asked_by = "Ann";
  step.series[0].is_by_hand = true;
  const facts::Json json = night_facts(record, {})["steps"][0];
  EXPECT_EQ(json["tolerance"], 0.010);
  EXPECT_EQ(json["series"][0]["ledger_id"], 60);
  EXPECT_EQ(json["series"][0]["asked_by"], "Ann");
  EXPECT_EQ(json["series"][0]["by_hand"], true);
  EXPECT_TRUE(json["series"][1]["ledger_id"].is_null());
}

TEST(NightFacts, AreNoMarkupInAPage) {
  const std::string page = page_html(kHostile, facts::text(night_facts(hostile_night(), {})));
  EXPECT_THAT(page, Not(HasSubstr("<script>alert")));
  EXPECT_EQ(page.find('\xff'), std::string::npos);
  EXPECT_EQ(facts::Json::parse(facts::in_page(page))["may_drill"], false);
  EXPECT_EQ(night_text(hostile_night()).find('\x01'), std::string::npos);
}

TEST(NightFacts, AreThoseOfTheRecord) {
  const NightRecord record = sample_hold();
  const facts::Json json = night_facts(record, {{"made by", "panelcal 0.1.0"}});
  EXPECT_EQ(json["facts"], "night");
  EXPECT_EQ(json["version"], 1);
  EXPECT_EQ(json["may_drill"], false);
  EXPECT_TRUE(json["drill_until"].is_null());
  EXPECT_EQ(json["outcome"], "refused");
  EXPECT_EQ(json["exit_code"], 1);
  EXPECT_EQ(json["verdict"], record.verdict);
  EXPECT_EQ(json["checks"][1]["name"], "mark contrast");
  EXPECT_EQ(json["checks"][1]["value"], 0.42);
  EXPECT_TRUE(json["checks"][1]["limit"].is_null());
  const facts::Json& step = json["steps"][0];
  EXPECT_EQ(step["state"], "hold");
  EXPECT_EQ(step["axes"][0]["new"], *record.steps[0].axes[0].new_value);
  EXPECT_EQ(step["decision"]["gates"][2]["passed"], false);
  EXPECT_EQ(step["series"].size(), static_cast<std::size_t>(test::kNights));
  EXPECT_EQ(step["series"][45]["refused"], true);
  EXPECT_EQ(step["forecast"]["answer"], "no");
  EXPECT_TRUE(step["forecast"]["until"].is_null());
  EXPECT_EQ(step["holes"][4]["outlier"], true);
  EXPECT_EQ(step["holes"][4]["place_mm"][0], 205.0);
  EXPECT_EQ(json["ledger_head"]["id"], 240);
  EXPECT_EQ(json["provenance"]["made by"], "panelcal 0.1.0");
}

/// A night that never began, and one with bytes that are no text.
TEST(NightFacts, AreAlwaysJson) {
  for (const NightRecord& record : {NightRecord{}, hostile_night()}) {
    const std::string text = facts::text(night_facts(record, {{kHostile, kHostile}}));
    const facts::Json json = facts::Json::parse(text, nullptr, false);
    ASSERT_FALSE(json.is_discarded());
    EXPECT_EQ(json["may_drill"], false);
  }
}

TEST(NightText, FiveLinesSayItAll) {
  NightRecord record = sample_night();
  record.notes = {"two\nlines"};
  const std::string text = night_text(record);
  EXPECT_EQ(count(text, "\n"), 5U);
  EXPECT_THAT(text, HasSubstr("self-test: 2 checks passed\n"));
  EXPECT_THAT(text, HasSubstr("note: two lines\n"));
  record.checks[0].passed = false;
  EXPECT_THAT(night_text(record),
              HasSubstr("self-test: 1 of 2 checks failed: disk: 20000 MB free"));
}

}  // namespace
}  // namespace panelcal::nightly
