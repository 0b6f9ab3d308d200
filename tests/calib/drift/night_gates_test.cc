// SPDX-License-Identifier: Apache-2.0
#include "calib/drift/night_gates.h"

#include <cmath>
#include <functional>
#include <ostream>

#include "calib/base/clock.h"
#include <gmock/gmock.h>

#include "tests/calib/drift/simulated_nights.h"

namespace panelcal {
namespace {

using test::SimulatedNights;
using testing::HasSubstr;

/// 40 healthy nights, one more, and what is in force: the truth of the last of them.
struct Machine {
  explicit Machine(int n_nights = 40) {
    SimulatedNights nights({.temperature_sigma = 0.5}, Random(1));
    for (int night = 0; night < n_nights; ++night) history.points.push_back(nights.next());
    in_force = nights.truth();
    tonight.point = nights.next();
    tonight.n_used = 9;
    tonight.structure_chance = 0.4;
    limits.min_temperature_c = 15;
    limits.max_temperature_c = 30;
  }

  NightDecision decide() const {
    const auto decision = decide_night(tonight, in_force, history, options, limits);
    EXPECT_TRUE(decision.has_value());
    return decision ? *decision : NightDecision{};
  }

  DriftSeries history = {{"x", "y"}, "mm", {}};
  DriftOptions options;
  NightLimits limits;
  NightResult tonight;
  std::optional<Eigen::VectorXd> in_force;
};

TEST(NightGates, InstallWhatPassesEveryOne) {
  const NightDecision decision = Machine().decide();
  EXPECT_EQ(decision.verdict, NightVerdict::Install) << decision.summary();
  EXPECT_EQ(decision.summary(), "install");
  EXPECT_EQ(decision.gates.size(), 8U);  // change counts twice: the forecast, the one in force
}

/// A way to spoil a night, the gate that has to refuse it, and words that have to be in the reason.
struct Spoiled {
  std::string gate;
  std::string words;
  std::function<void(Machine&)> spoil;
};

void PrintTo(const Spoiled& spoiled, std::ostream* out) {
  *out << spoiled.gate << ": " << spoiled.words;
}

class EachNightGate : public testing::TestWithParam<Spoiled> {};

TEST_P(EachNightGate, RefusesAndKeepsTheOldOne) {
  Machine machine;
  GetParam().spoil(machine);
  const NightDecision decision = machine.decide();
  EXPECT_EQ(decision.verdict, NightVerdict::KeepOld) << decision.summary();
  EXPECT_THAT(decision.summary(), HasSubstr(GetParam().words));
  EXPECT_THAT(decision.summary(), HasSubstr("the one in force: yes"));
  for (const NightGate& gate : decision.gates) {
    EXPECT_EQ(gate.passed, gate.name != GetParam().gate) << gate.text;
  }
}

INSTANTIATE_TEST_SUITE_P(
    OfAll,
    EachNightGate,
    testing::Values(Spoiled{"uncertainty",
                            "sigma of the result is 4.",
                            [](Machine& m) { m.tonight.point.cov *= 16; }},
                    Spoiled{"holes",
                            "4 holes were used, at least 5 are needed",
                            [](Machine& m) { m.tonight.n_used = 4; }},
                    Spoiled{"outliers",
                            "2 holes were left out as outliers, limit 1",
                            [](Machine& m) { m.tonight.n_outliers = 2; }},
                    Spoiled{"structure",
                            "probability of 0.0001, limit 0.001",
                            [](Machine& m) { m.tonight.structure_chance = 1e-4; }},
                    Spoiled{"structure",
                            "structure",
                            [](Machine& m) { m.tonight.structure_chance = std::nan(""); }},
                    Spoiled{"temperature",
                            "allowed 15.0 to 20.0",
                            [](Machine& m) { m.limits.max_temperature_c = 20; }},
                    Spoiled{"temperature",
                            "not known",
                            [](Machine& m) { m.tonight.point.temperature_c.reset(); }},
                    Spoiled{"numbers",
                            "not finite",
                            [](Machine& m) { m.tonight.point.value(0) = std::nan(""); }},
                    Spoiled{"numbers",
                            "not positive semidefinite",
                            [](Machine& m) { m.tonight.point.cov(1, 1) = -1; }},
                    Spoiled{"numbers", "no result this night", [](Machine& m) {
                              m.tonight.point.is_left_out = true;
                            }}));

TEST(NightGates, HoldWhereTheMachineHasMoved) {
  Machine machine;
  machine.tonight.point.value.x() += 0.020;
  const NightDecision decision = machine.decide();
  EXPECT_EQ(decision.verdict, NightVerdict::Hold);
  EXPECT_THAT(decision.summary(), HasSubstr("40 nights"));
  EXPECT_THAT(decision.summary(), HasSubstr("the one in force may be wrong"));
}

TEST(NightGates, HoldWhereABadNightContradictsTheOldOne) {
  Machine machine;
  machine.tonight.point.value.x() += 0.020;
  machine.tonight.n_outliers = 5;
  EXPECT_EQ(machine.decide().verdict, NightVerdict::Hold);
}

TEST(NightGates, HoldWhereThereIsNothingToFallBackOn) {
  Machine machine;
  machine.in_force.reset();
  EXPECT_EQ(machine.decide().verdict, NightVerdict::Install);
  machine.tonight.n_used = 3;
  const NightDecision decision = machine.decide();
  EXPECT_EQ(decision.verdict, NightVerdict::Hold);
  EXPECT_THAT(decision.summary(), HasSubstr("no calibration in force"));
}

TEST(NightGates, HoldWhereTheOldOneHasDriftedAway) {
  Machine machine;
  *machine.in_force += Eigen::Vector2d(0.009, 0);
  EXPECT_EQ(machine.decide().verdict, NightVerdict::Install);
  machine.tonight.n_used = 3;
  const NightDecision decision = machine.decide();
  EXPECT_EQ(decision.verdict, NightVerdict::Hold);
  EXPECT_THAT(decision.summary(), HasSubstr("the one in force: no"));
}

/// Nights that see nothing do not go on for ever: a forecast knows the drift, and not what blinds
/// the camera.
TEST(NightGates, TrustTheOldOneForSoManyDaysAndSaySo) {
  Machine machine;
  machine.limits.old.trusted = seconds(4.5 * 86400);
  const auto last = machine.history.points.back().time;
  machine.tonight.point.is_left_out = true;
  for (int days = 1; days <= 6; ++days) {
    machine.tonight.point.time = last + std::chrono::days(days);
    const NightDecision decision = machine.decide();
    const bool is_trusted = days <= 3;  // until the next night
    EXPECT_EQ(decision.verdict, is_trusted ? NightVerdict::KeepOld : NightVerdict::Hold) << days;
    EXPECT_THAT(decision.summary(), HasSubstr("it was last measured " + iso_8601(last)));
    EXPECT_THAT(decision.summary(), HasSubstr("trusted for 4.5 days after that"));
    const DrillAnswer answer = is_trusted  ? DrillAnswer::BeyondHorizon
                               : days == 4 ? DrillAnswer::Until
                                           : DrillAnswer::No;
    ASSERT_TRUE(decision.old);
    EXPECT_EQ(decision.old->answer, answer) << days;
    if (days == 4) {
      EXPECT_EQ(decision.old->until, last + std::chrono::hours(108));
    }
  }
}

TEST(NightGates, HoldWhereTheLastGoodNightIsLongAgo) {
  Machine machine;
  machine.tonight.n_used = 3;
  machine.tonight.point.time += std::chrono::hours(24 * 300);
  EXPECT_EQ(machine.decide().verdict, NightVerdict::Hold);
}

TEST(NightGates, GoByTheOneInForceWhileHistoryIsShort) {
  Machine machine(5);
  EXPECT_EQ(machine.decide().verdict, NightVerdict::Install);
  machine.tonight.point.value.y() -= 0.060;
  NightDecision decision = machine.decide();
  EXPECT_EQ(decision.verdict, NightVerdict::Hold);
  EXPECT_THAT(decision.summary(), HasSubstr("from the one in force, limit 50.0 um"));
  machine.tonight.point.value.y() += 0.060;
  machine.tonight.n_used = 3;
  decision = machine.decide();
  EXPECT_EQ(decision.verdict, NightVerdict::Hold);
  EXPECT_THAT(decision.summary(), HasSubstr("not enough history"));
}

TEST(NightGates, TakeThePersonsWordForAFreshStart) {
  Machine machine;
  machine.tonight.point.value.x() += 0.040;
  EXPECT_EQ(machine.decide().verdict, NightVerdict::Hold);
  machine.tonight.point.is_fresh_start = true;
  EXPECT_EQ(machine.decide().verdict, NightVerdict::Install);
}

TEST(NightGates, HoldAFreshStartToTheLargestChangeAllTheSame) {
  Machine machine;
  machine.tonight.point.value.x() += 0.060;
  machine.tonight.point.is_fresh_start = true;
  const NightDecision decision = machine.decide();
  EXPECT_EQ(decision.verdict, NightVerdict::Hold);
  EXPECT_THAT(decision.summary(), HasSubstr("from the one in force, limit 50.0 um"));
  machine.limits.change = 0.070;
  EXPECT_EQ(machine.decide().verdict, NightVerdict::Install);
}

TEST(NightGates, HoldToTheCalibrationsOwnLimits) {
  Machine machine;
  machine.tonight.further = {{"corners", true, "the corners are sure"}};
  EXPECT_EQ(machine.decide().verdict, NightVerdict::Install);
  machine.tonight.further = {{"corners", false, "the corners are not sure"}};
  const NightDecision decision = machine.decide();
  EXPECT_EQ(decision.verdict, NightVerdict::KeepOld) << decision.summary();
  EXPECT_THAT(decision.summary(), HasSubstr("the corners are not sure"));
  machine.tonight.further = {{"change", false, "a corner has moved"}};
  EXPECT_EQ(machine.decide().verdict, NightVerdict::Hold);
}

TEST(NightGates, PassOverNightsThatFoundNothing) {
  Machine machine;
  DriftPoint empty;
  empty.is_left_out = true;
  machine.history.points.insert(machine.history.points.begin() + 20, empty);
  EXPECT_EQ(machine.decide().verdict, NightVerdict::Install);
}

TEST(NightGates, RefuseLimitsThatAreNone) {
  Machine machine;
  machine.limits.sigma = 0;
  EXPECT_FALSE(decide_night(
      machine.tonight, machine.in_force, machine.history, machine.options, machine.limits));
  machine.limits = {};
  machine.in_force = Eigen::VectorXd::Zero(3);
  EXPECT_FALSE(decide_night(
      machine.tonight, machine.in_force, machine.history, machine.options, machine.limits));
}

}  // namespace
}  // namespace panelcal
