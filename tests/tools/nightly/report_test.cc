// SPDX-License-Identifier: Apache-2.0
#include "tools/nightly/report.h"

#include <cmath>
#include <limits>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

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

/// Empty if every tag is closed in its order.
std::string unclosed(std::string_view html) {
  std::vector<std::string> open;
  for (auto at = html.find('<'); at != std::string_view::npos; at = html.find('<', at + 1)) {
    const auto end = html.find('>', at);
    if (end == std::string_view::npos) return "a tag without an end";
    std::string_view tag = html.substr(at + 1, end - at - 1);
    if (tag.find('<') != std::string_view::npos) return "a tag in a tag";
    if (tag.starts_with('!') || tag.ends_with('/')) continue;
    const bool is_end = tag.starts_with('/');
    if (is_end) tag.remove_prefix(1);
    const std::string name(tag.substr(0, tag.find_first_of(" \n")));
    if (!is_end) {
      open.push_back(name);
    } else if (open.empty() || open.back() != name) {
      return "</" + name + "> out of order";
    } else {
      open.pop_back();
    }
  }
  return open.empty() ? "" : open.back() + " is never closed";
}

std::size_t count(std::string_view text, std::string_view part) {
  std::size_t n = 0;
  for (auto at = text.find(part); at != std::string_view::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST(NightlyReport, SaysFirstWhetherToDrill) {
  const std::string html = night_html(sample_night(), {});
  const auto word = html.find("<div class=\"word\">DRILL</div>");
  ASSERT_NE(word, std::string::npos);
  EXPECT_LT(word, html.find("<h2>"));
  EXPECT_THAT(html, HasSubstr("2026-11-24 21:00 UTC"));
  EXPECT_THAT(html, HasSubstr("x +1.2 um (sigma 1.6 um)"));
  EXPECT_THAT(night_text(sample_night()),
              testing::StartsWith("drill 1, night of 2026-11-20: drill, until"));

  const std::string hold = night_html(sample_hold(), {});
  EXPECT_THAT(hold, HasSubstr("<div class=\"word\">HOLD</div>"));
  EXPECT_THAT(hold, Not(HasSubstr(">DRILL<")));
  EXPECT_THAT(hold, HasSubstr("<dt>may drill until</dt><dd>do not drill<"));
  EXPECT_THAT(hold, HasSubstr("152 sigma from what was predicted, limit 3.9"));
}

/// A refused gate is told apart from those that passed, by a word and not by colour alone.
TEST(NightlyReport, NamesEveryGateWithItsNumber) {
  const std::string html = night_html(sample_hold(), {});
  EXPECT_THAT(html, HasSubstr("<span class=\"chip refused\">refused</span></td><td>change</td>"));
  EXPECT_THAT(html, HasSubstr("<span class=\"chip\">passed</span></td><td>uncertainty</td>"));
  EXPECT_THAT(html, HasSubstr("sigma 1.2 um, limit 3.0 um"));
}

/// Sixty nights an axis, of which one lies beyond the picture and says so.
TEST(NightlyReport, DrawsEveryNight) {
  const std::string html = night_html(sample_night(), {});
  EXPECT_EQ(count(html, "<svg class=\"drift\""), 2U);
  // And one in the legend of each.
  EXPECT_EQ(count(html, "<circle class=\"dot\""), 2U * (test::kNights - 1) + 1);
  EXPECT_EQ(count(html, "<path class=\"refused\""), 2U + 1);
  EXPECT_EQ(count(html, "<text class=\"bad"), 1U);
  EXPECT_EQ(count(html, "<rect class=\"band\""), 2U + 1);
  EXPECT_EQ(count(html, "<g class=\"mark"), 9U);
  EXPECT_EQ(count(html, "<g class=\"mark refused"), 1U);
}

TEST(NightlyReport, DrawsHowTheMachineWarmedUp) {
  NightRecord record = sample_night();
  EXPECT_THAT(night_html(record, {}), Not(HasSubstr("Warming up")));
  EXPECT_TRUE(nlohmann::json::parse(night_json(record, {}))["warm_up"].is_null());
  record.warm_up = sample_warm_up();
  const std::string html = night_html(record, {});
  EXPECT_EQ(unclosed(html), "");
  EXPECT_THAT(html, HasSubstr("Warming up<span class=\"chip\">warm</span>"));
  EXPECT_THAT(html, HasSubstr("warm after 6.9 min"));
  EXPECT_EQ(count(html, "<circle class=\"dot\""), 2U * (test::kNights - 1) + 1 + 10);
  const auto json = nlohmann::json::parse(night_json(record, {}))["warm_up"];
  EXPECT_EQ(json["looks"].size(), 10U);
  EXPECT_EQ(json["fit"]["time_constant_s"], 300);
  record.warm_up->looks.resize(1);
  record.warm_up->is_warm = false;
  EXPECT_THAT(night_html(record, {}), HasSubstr("<span class=\"chip refused\">not known</span>"));
}

TEST(NightlyReport, SurvivesWhatHasNoNumbers) {
  NightRecord record = sample_night();
  NightStep& step = record.steps.front();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  step.series[3].value = {nan, nan};
  step.series[4].sigma = {};
  step.series[5] = {};
  step.holes[0].residual_mm.x() = nan;
  step.axes[0].expected_sigma = nan;
  step.axes[1].new_value.reset();
  for (const std::string& html : {night_html(record, {}), night_html(NightRecord{}, {})}) {
    EXPECT_EQ(unclosed(html), "");
    EXPECT_THAT(html, Not(HasSubstr("\"nan")));
    EXPECT_THAT(html, Not(HasSubstr("nan\"")));
    EXPECT_THAT(html, Not(HasSubstr("Mnan")));
  }
  step.series.clear();
  step.holes.clear();
  EXPECT_THAT(night_html(record, {}), Not(HasSubstr("<svg")));
}

TEST(NightlyReport, EscapesTheWordsOfOthers) {
  const std::string html = night_html(hostile_night(), {{kHostile, kHostile}});
  EXPECT_EQ(unclosed(html), "");
  EXPECT_THAT(html, Not(HasSubstr("<script")));
  EXPECT_THAT(html, HasSubstr("&lt;script&gt;alert(&quot;1&quot;)"));
  EXPECT_EQ(html.find('\xff'), std::string::npos);
  EXPECT_EQ(html.find('\x01'), std::string::npos);
  const std::string text = night_text(hostile_night());
  EXPECT_EQ(text.find('\x01'), std::string::npos);
}

TEST(NightlyReport, NeedsNothingFromElsewhere) {
  const std::string html = night_html(sample_hold(), {});
  EXPECT_EQ(unclosed(html), "");
  EXPECT_EQ(count(html, "http"), count(html, "xmlns=\"http"));
  for (const char* forbidden : {"<script", "<link", "<img", "url(", "@import"}) {
    EXPECT_THAT(html, Not(HasSubstr(forbidden)));
  }
}

TEST(NightlyReport, JsonHasTheSameFacts) {
  const NightRecord record = sample_hold();
  const std::string text = night_json(record, {{"made by", "panelcal 0.1.0"}});
  EXPECT_EQ(text.back(), '\n');
  const nlohmann::json json = nlohmann::json::parse(text);
  EXPECT_EQ(json["panelcal"], "night");
  EXPECT_EQ(json["version"], 1);
  EXPECT_EQ(json["may_drill"], false);
  EXPECT_TRUE(json["drill_until"].is_null());
  EXPECT_EQ(json["outcome"], "refused");
  EXPECT_EQ(json["exit_code"], 1);
  EXPECT_EQ(json["verdict"], record.verdict);
  EXPECT_EQ(json["checks"][1]["name"], "mark contrast");
  EXPECT_EQ(json["checks"][1]["value"], 0.42);
  EXPECT_TRUE(json["checks"][1]["limit"].is_null());
  const nlohmann::json& step = json["steps"][0];
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
TEST(NightlyReport, JsonIsAlwaysJson) {
  for (const NightRecord& record : {NightRecord{}, hostile_night()}) {
    const nlohmann::json json =
        nlohmann::json::parse(night_json(record, {{kHostile, kHostile}}), nullptr, false);
    ASSERT_FALSE(json.is_discarded());
    EXPECT_EQ(json["may_drill"], false);
  }
  NightRecord record = sample_night();
  record.steps[0].axes[0].new_sigma = std::numeric_limits<double>::infinity();
  const nlohmann::json json = nlohmann::json::parse(night_json(record, {}));
  EXPECT_TRUE(json["steps"][0]["axes"][0]["sigma"].is_null());
}

TEST(NightlyReport, FiveLinesSayItAll) {
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
