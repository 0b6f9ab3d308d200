// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/night_quality.h"

#include <cmath>
#include <limits>

#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr int kNights = 20;

/// Of 16 degrees of freedom.
double variance_of(Random& random, double sigma) {
  double squares = 0;
  for (int i = 0; i < 16; ++i) squares += std::pow(sigma * random.normal(), 2);
  return squares / 16;
}

QualityNight night(int day, Random& random, double sigma = 0.003, double contrast = 0.5) {
  QualityNight out;
  out.time = std::chrono::sys_seconds(std::chrono::seconds(1'790'000'000)) + std::chrono::days(day);
  out.spreads = {{"holes", "mm", variance_of(random, sigma), 16}};
  out.levels = {{"contrast", "1", contrast * std::exp(0.005 * random.normal()), true}};
  return out;
}

std::vector<QualityNight> healthy(Random& random) {
  std::vector<QualityNight> nights;
  for (int day = 0; day < kNights; ++day) nights.push_back(night(day, random));
  return nights;
}

QualityVerdict judged(const std::vector<QualityNight>& nights, const QualityNight& tonight) {
  const auto verdict = judge_qualities(nights, tonight, {});
  if (!verdict) ADD_FAILURE() << verdict.error().text();
  return verdict ? *verdict : QualityVerdict{};
}

TEST(NightQuality, AHealthyNightPasses) {
  Random random(1);
  const auto nights = healthy(random);
  const QualityVerdict verdict = judged(nights, night(kNights, random));
  EXPECT_THAT(verdict.gates, IsEmpty());
  EXPECT_THAT(verdict.alarms, IsEmpty());
  ASSERT_THAT(verdict.qualities, SizeIs(2));
  EXPECT_NEAR(*verdict.qualities[0].usual, 0.003, 0.0005);
  EXPECT_NEAR(*verdict.qualities[1].usual, 0.5, 0.01);
  EXPECT_THAT(verdict.qualities[0].text, HasSubstr("20 nights"));
}

TEST(NightQuality, AWornDrillIsRefused) {
  Random random(2);
  const auto nights = healthy(random);
  const QualityVerdict verdict = judged(nights, night(kNights, random, 0.008));
  ASSERT_THAT(verdict.gates, SizeIs(1));
  EXPECT_EQ(verdict.gates[0].name, "holes");
  EXPECT_FALSE(verdict.gates[0].passed);
  EXPECT_TRUE(verdict.qualities[0].is_alarm);
  EXPECT_FALSE(verdict.qualities[1].is_alarm);
}

TEST(NightQuality, ADirtyLensIsRefusedAndACleanedOneSaid) {
  Random random(3);
  const auto nights = healthy(random);
  const QualityVerdict dirty = judged(nights, night(kNights, random, 0.003, 0.45));
  ASSERT_THAT(dirty.gates, SizeIs(1));
  EXPECT_THAT(dirty.gates[0].text, HasSubstr("bad side"));
  const QualityVerdict clean = judged(nights, night(kNights, random, 0.003, 0.55));
  EXPECT_THAT(clean.gates, IsEmpty());
  EXPECT_THAT(clean.alarms, SizeIs(1));
}

TEST(NightQuality, NightsThatWereRefusedDoNotBecomeUsual) {
  Random random(4);
  auto nights = healthy(random);
  for (int i = 0; i < 10; ++i) {
    nights.push_back(night(kNights + i, random, 0.009, 0.3));
    nights.back().is_left_out = true;
  }
  EXPECT_THAT(judged(nights, night(kNights + 10, random, 0.009, 0.3)).gates, SizeIs(2));
}

TEST(NightQuality, AfterAFreshStartNightsBeforeSayNothing) {
  Random random(5);
  const auto nights = healthy(random);
  QualityNight tonight = night(kNights, random, 0.009, 0.3);
  tonight.is_fresh_start = true;
  EXPECT_THAT(judged(nights, tonight).gates, IsEmpty());
}

TEST(NightQuality, RefusesWhatIsNoNumber) {
  Random random(6);
  const auto nights = healthy(random);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity(), -1.0}) {
    QualityNight tonight = night(kNights, random);
    tonight.spreads[0].variance = bad;
    EXPECT_THAT(judge_qualities(nights, tonight, {}),
                test::FailsWith(Code::CalibrationInvalid, "holes"));
    tonight = night(kNights, random);
    tonight.levels[0].value = bad;
    EXPECT_THAT(judge_qualities(nights, tonight, {}),
                test::FailsWith(Code::CalibrationInvalid, "contrast"));
  }
}

}  // namespace
}  // namespace panelcal
