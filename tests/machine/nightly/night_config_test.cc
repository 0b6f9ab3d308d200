// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <string_view>

#include "machine/config/machine_config.h"
#include <gmock/gmock.h>

namespace panelcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Reads [nightly] of a machine.toml in the folder "there".
Expected<std::optional<NightlyConfig>> parse(std::string_view text) {
  PANELCAL_TRY(const MachineConfig config, parse_machine_config(text, "there/machine.toml"));
  return config.nightly;
}

std::string refusal(const std::string& lines) {
  const auto config = parse("[nightly]\nmachine_driver = \"sim\"\n" + lines);
  return config ? "accepted" : config.error().text();
}

TEST(NightConfig, IsAbsentWithoutItsTable) {
  const auto config = parse("");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_FALSE(*config);
}

TEST(NightConfig, ReadsEveryKey) {
  const auto read = parse(R"([nightly]
calibrate = ["spindle-camera", "camera"]
camera = "v4l2:/dev/video0"
warm_up_s = 600
warm_up_limit_um = 3
mark_mm = [10, 20.5]
mark_tool = 3
reports = "nights"
temperature_command = ["./thermometer", "--celsius"]
min_disk_mb = 50
noon_utc_h = 4
[nightly.gates]
sigma_um = 2
change_um = 30
min_holes = 7
max_outliers = 2
structure_chance = 0.01
nights_per_refusal = 500
temperature_c = [18, 26]
[nightly.drift]
tolerance_um = 12
probability = 0.01
horizon_days = 14
trusted_days = 3
expected_c = 22
nights_per_false_alarm = 300
moved_um = 5
drift_um = 0.4
repeatability_um = 0.6
per_kelvin_um = 2
reference_c = 21
min_nights = 10
[nightly.focus]
tolerance_um = 60
[nightly.light]
range = [20, 80]
levels = 13
[nightly.settle]
limit_um = 2
longest_s = 3
tolerance_s = 0.1
[nightly.table]
plate = "plate.toml"
file = "table.cal.json"
)");
  ASSERT_TRUE(read) << read.error().text();
  const NightlyConfig& config = **read;
  EXPECT_THAT(config.calibrate, ElementsAre("spindle-camera", "camera"));
  EXPECT_EQ(config.camera, "v4l2:/dev/video0");
  EXPECT_FALSE(config.is_simulated);
  EXPECT_EQ(config.warm_up, seconds(600));
  EXPECT_EQ(config.warm_up_limit, um(3));
  EXPECT_EQ(config.mark->in_mm(), Eigen::Vector2d(10, 20.5));
  EXPECT_EQ(config.mark_tool, 3);
  EXPECT_EQ(config.reports, "there/nights");
  EXPECT_THAT(config.temperature_command, ElementsAre("there/./thermometer", "--celsius"));
  EXPECT_EQ(config.min_disk_mb, 50);
  EXPECT_EQ(config.noon_utc_h, 4);
  EXPECT_DOUBLE_EQ(config.limits.sigma, 0.002);
  EXPECT_DOUBLE_EQ(config.limits.change, 0.030);
  EXPECT_EQ(config.limits.min_used, 7);
  EXPECT_EQ(config.limits.max_outliers, 2);
  EXPECT_EQ(config.limits.structure_chance, 0.01);
  EXPECT_EQ(config.limits.nights_per_refusal, 500);
  EXPECT_EQ(config.limits.min_temperature_c, 18);
  EXPECT_EQ(config.limits.max_temperature_c, 26);
  EXPECT_DOUBLE_EQ(config.limits.old.tolerance, 0.012);
  EXPECT_EQ(config.limits.old.probability, 0.01);
  EXPECT_EQ(config.limits.old.horizon, seconds(14 * 86400.0));
  EXPECT_EQ(config.limits.old.trusted, seconds(3 * 86400.0));
  EXPECT_EQ(config.limits.old.temperature_c, 22);
  EXPECT_EQ(config.watch.nights_per_false_alarm, 300);
  EXPECT_DOUBLE_EQ(*config.watch.moved, 0.005);
  EXPECT_DOUBLE_EQ(config.drift.priors.drift, 0.0004);
  EXPECT_DOUBLE_EQ(config.drift.priors.repeatability, 0.0006);
  EXPECT_DOUBLE_EQ(config.drift.priors.per_kelvin, 0.002);
  EXPECT_EQ(config.drift.reference_c, 21);
  EXPECT_EQ(config.drift.min_nights, 10);
  EXPECT_EQ(config.trials.focus_tolerance, um(60));
  EXPECT_EQ(config.trials.lamp_low, 20);
  EXPECT_EQ(config.trials.lamp_high, 80);
  EXPECT_DOUBLE_EQ(config.trials.lamp_step(), 5);
  EXPECT_EQ(config.trials.settle_limit, um(2));
  EXPECT_EQ(config.trials.settle_longest, seconds(3));
  EXPECT_EQ(config.trials.settle_tolerance, seconds(0.1));
  EXPECT_EQ(config.table.plate, "there/plate.toml");
  EXPECT_EQ(config.table.file, "there/table.cal.json");
  EXPECT_TRUE(config.limits.validate());
  EXPECT_TRUE(config.drift.validate());
  EXPECT_TRUE(config.watch.validate());
}

TEST(NightConfig, DefaultsAreThoseOfTheLibrary) {
  const auto read = parse("[nightly]\nmachine_driver = \"sim\"\n");
  ASSERT_TRUE(read) << read.error().text();
  const NightlyConfig& config = **read;
  EXPECT_TRUE(config.is_simulated);
  EXPECT_THAT(config.calibrate, ElementsAre("spindle-camera"));
  EXPECT_DOUBLE_EQ(config.limits.sigma, NightLimits{}.sigma);
  EXPECT_DOUBLE_EQ(config.limits.old.tolerance, ForecastLimits{}.tolerance);
  EXPECT_EQ(config.limits.old.horizon, ForecastLimits{}.horizon);
  EXPECT_EQ(config.limits.old.trusted, ForecastLimits{}.trusted);
  EXPECT_DOUBLE_EQ(*config.watch.moved, *WatchOptions{}.moved);
  EXPECT_DOUBLE_EQ(config.drift.priors.drift, DriftPriors{}.drift);
  EXPECT_EQ(config.place.line, 1);
}

TEST(NightConfig, RefusesWhatMakesNoSense) {
  EXPECT_EQ(refusal(""), "accepted");
  EXPECT_THAT(refusal("warmup_s = 3"), HasSubstr("warm_up_s"));
  EXPECT_THAT(refusal("warm_up_limit_um = 3"), HasSubstr("warm_up_s"));
  EXPECT_THAT(refusal("warm_up_s = 9\nwarm_up_limit_um = 3"), HasSubstr("mark_mm"));
  EXPECT_THAT(refusal("warm_up_s = 9\nmark_mm = [1, 2]\nwarm_up_limit_um = 0"),
              HasSubstr("warm_up_limit_um"));
  EXPECT_THAT(refusal("calibrate = [\"tables\"]"), HasSubstr("\"table\""));
  EXPECT_THAT(refusal("calibrate = [\"table\"]"), HasSubstr("[nightly.table] plate"));
  EXPECT_THAT(refusal("[nightly.table]\nfile = \"f\""), HasSubstr("plate"));
  EXPECT_THAT(refusal("calibrate = [\"spindle-camera\", \"spindle-camera\"]"),
              HasSubstr("error[config-value]"));
  EXPECT_THAT(refusal("calibrate = []"), HasSubstr("spindle-camera"));
  EXPECT_THAT(refusal("calibrate = [\"camera\"]"), HasSubstr("mark_mm"));
  EXPECT_THAT(refusal("calibrate = [\"settle\"]"), HasSubstr("settle"));
  EXPECT_THAT(refusal("[nightly.focus]\ntolerance_um = 0"), HasSubstr("tolerance_um"));
  EXPECT_THAT(refusal("[nightly.light]\nrange = [80, 20]"), HasSubstr("range"));
  EXPECT_THAT(refusal("[nightly.light]\nlevels = 2"), HasSubstr("levels"));
  EXPECT_THAT(refusal("[nightly.settle]\nlongest_s = 0"), HasSubstr("longest_s"));
  EXPECT_THAT(refusal("camera = \"v4l2:0\""), HasSubstr("camera"));
  EXPECT_THAT(refusal("mark_tool = 2"), HasSubstr("mark_tool"));
  EXPECT_THAT(refusal("temperature_file = \"t\"\ntemperature_command = [\"t\"]"),
              HasSubstr("error[config-value]"));
  EXPECT_THAT(refusal("temperature_command = []"), HasSubstr("PROGRAM"));
  EXPECT_THAT(refusal("noon_utc_h = 24"), HasSubstr("noon_utc_h"));
  EXPECT_THAT(refusal("[nightly.gates]\nsigma_um = 0"), HasSubstr("sigma_um"));
  EXPECT_THAT(refusal("[nightly.gates]\ntemperature_c = [26, 18]"), HasSubstr("temperature_c"));
  EXPECT_THAT(refusal("[nightly.drift]\nprobability = 0.6"), HasSubstr("probability"));
  EXPECT_THAT(refusal("[nightly.drift]\nmin_nights = 1"), HasSubstr("min_nights"));
  const auto neither = parse("[nightly]\n");
  ASSERT_FALSE(neither);
  EXPECT_THAT(neither.error().text(), HasSubstr("machine_driver"));
}

}  // namespace
}  // namespace panelcal
