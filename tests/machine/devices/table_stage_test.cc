// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/table_stage.h"

#include <map>
#include <memory>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "calib/table/calibration_file.h"
#include "machine/calibrate/spindle/camera_run.h"
#include "machine/look/mark_sights.h"
#include "machine/sim/pictures/recording.h"
#include "machine/sim/sim_table.h"
#include "machine/sources/device_set.h"
#include "machine/sources/picture_source.h"
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/calib/table/table_of.h"
#include "tests/machine/small_panel.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;
using test::FailsWith;
using test::IsNearPosition;

/// Error that iterations leave.
constexpr double kRounding_um = 1e-4;

Position<frame::Machine> at(double x_mm, double y_mm) {
  return position_mm<frame::Machine>(x_mm, y_mm);
}

/// 30 um and more over the small panel.
SimTable errs() {
  SimTable table;
  table.scale_x_ppm = 150;
  table.scale_y_ppm = -100;
  table.squareness = rad(60e-6);
  table.bow_x = um(30);
  table.bow_y = um(-20);
  table.bow_radius = mm(50);
  table.center = at(80, 60);
  return table;
}

/// The map of exactly that.
std::shared_ptr<const TableCorrection> calibrated() {
  const TableGrid grid{Vector2d(0, 0), Vector2d(400, 300), 8, 6};
  return std::make_shared<const TableCorrection>(test::table_of(grid, [](const Vector2d& c_mm) {
    return errs().error_mm(position_mm<frame::Machine>(c_mm));
  }));
}

/// Remembers where it was sent to.
class ListeningStage final : public Stage {
 public:
  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    told.push_back(spindle);
    return spindle;
  }
  std::vector<Position<frame::Machine>> told;
};

TEST(SimTable, ErrsAsItsPageSays) {
  const SimTable table = errs();
  EXPECT_EQ(table.error_mm(table.center), Vector2d::Zero());
  // 50 mm to the right: 150 ppm in x, the bow of the x axis in y.
  EXPECT_LT((table.error_mm(at(130, 60)) - Vector2d(0.0075, 0.03)).norm(), 1e-12);
  // 50 mm up: out of square and bowed in x, -100 ppm in y.
  EXPECT_LT((table.error_mm(at(80, 110)) - Vector2d(0.003 - 0.02, -0.005)).norm(), 1e-12);
}

TEST(TableStage, TellsCommandsAndSaysPlaces) {
  const auto listening = std::make_shared<ListeningStage>();
  TableStage stage(listening, calibrated());
  const auto standing = stage.move_to(at(120, 90));
  ASSERT_TRUE(standing);
  EXPECT_THAT(*standing, IsNearPosition(at(120, 90), um(kRounding_um)));
  ASSERT_EQ(listening->told.size(), 1u);
  const Position<frame::Machine>& told = listening->told[0];
  EXPECT_THAT(told + displacement_mm<frame::Machine>(errs().error_mm(told)),
              IsNearPosition(at(120, 90), um(kRounding_um)));
  EXPECT_GT((told - at(120, 90)).in_mm().norm(), 0.01);
  // Nothing moves to where the map says nothing.
  EXPECT_THAT(stage.move_to(at(-50, 90)), FailsWith(Code::TravelExceeded));
  EXPECT_EQ(listening->told.size(), 1u);
}

TEST(TableStage, IsNotThereWithoutATable) {
  const auto listening = std::make_shared<ListeningStage>();
  EXPECT_EQ(measuring_stage(listening, nullptr), listening);
  EXPECT_EQ(simulated_stage(listening, std::nullopt), listening);
  MachineConfig config;
  EXPECT_EQ(*axis_from_listed(config, at(-1e5, 3)), at(-1e5, 3));
  EXPECT_EQ(*listed_from_axis(config, at(-1e5, 3)), at(-1e5, 3));
}

TEST(TableStage, TakesTheErrorOutOfListedAxesWhereTheSpindleStood) {
  MachineConfig config;
  config.spindle_camera.offset = displacement_mm<frame::Machine>(45, -3);
  config.walk.table = calibrated();
  const Vector2d error_mm = errs().error_mm(at(55, 103));
  const auto axis = axis_from_listed(config, at(100, 100));
  ASSERT_TRUE(axis);
  EXPECT_THAT(*axis, IsNearPosition(at(100 + error_mm.x(), 100 + error_mm.y()), um(kRounding_um)));
  EXPECT_THAT(*listed_from_axis(config, *axis), IsNearPosition(at(100, 100), um(kRounding_um)));
  MarkSights sights;
  sights.data.views = {{at(100, 100), 0}, {at(40, 100), 0}};
  EXPECT_THAT(correct_views(config, sights), FailsWith(Code::TravelExceeded, "(-5.000, 103.000)"));
  sights.data.views = {{at(100, 100), 0}};
  ASSERT_TRUE(correct_views(config, sights));
  EXPECT_EQ(sights.data.views[0].axis_at, *axis);
}

/// The small panel on a stage that errs, calibrated or not.
MachineConfig machine(const test::TemporaryFolder& folder, bool is_calibrated) {
  MachineConfig config = test::small_config(folder.path());
  config.sim->table = errs();
  // Chi square sees what the table adds.
  config.walk.base_limits.false_alarm.reset();
  config.walk.nested_limits.false_alarm.reset();
  if (is_calibrated) config.walk.table = calibrated();
  return config;
}

/// The largest difference of what is measured from where it is, um.
double worst_um(const Survey& survey, const Truth& truth) {
  double worst = 0;
  EXPECT_EQ(survey.measurements.size(), truth.targets.size());
  for (std::size_t i = 0; i < survey.measurements.size(); ++i) {
    EXPECT_EQ(survey.measurements[i].status, MeasurementStatus::Found);
    const Vector2d error_mm =
        survey.measurements[i].measured.position.in_mm() - truth.targets[i].actual.in_mm();
    worst = std::max(worst, 1e3 * error_mm.norm());
  }
  return worst;
}

TEST(TableStage, TargetsAreMeasuredWhereTheyAre) {
  const test::TemporaryFolder folder;
  const Program program = test::program_of(std::string(test::kSmallProgram));
  for (const bool is_calibrated : {false, true}) {
    const MachineConfig config = machine(folder, is_calibrated);
    auto sim = SimMachine::create(config, program);
    ASSERT_TRUE(sim) << sim.error().text();
    DiagnosticLog log;
    const double live_um = worst_um(survey(program, config.walk, *sim, log), sim->truth());
    // The same by way of a folder, whose list says where the axis was sent to.
    const auto pictures = folder.path() / (is_calibrated ? "calibrated" : "not");
    const auto recording = record_pictures(program, config, *sim, pictures, log);
    ASSERT_TRUE(recording) << recording.error().text();
    auto read = read_picture_folder(pictures);
    ASSERT_TRUE(read) << read.error().text();
    auto source = PictureSource::create(config, *std::move(read));
    ASSERT_TRUE(source) << source.error().text();
    const double recorded_um = worst_um(survey(program, config.walk, *source, log), sim->truth());
    EXPECT_FALSE(log.has_errors()) << test::all_text(log);
    EXPECT_NEAR(live_um, recorded_um, 1e-3);
    if (is_calibrated) {
      EXPECT_LT(live_um, 1);
      // Sent a little beside the targets, which are seen in the middle all the same.
      EXPECT_GT((recording->rows[2].axis.in_mm() -
                 recording->survey.measurements[2].request.expected_in_machine().in_mm())
                    .norm(),
                0.01);
    } else {
      EXPECT_GT(live_um, 20);
    }
  }
}

constexpr std::string_view kCoupon = R"([coupon]
origin_mm = [150, 100]
columns = 6
rows = 6
pitch_mm = 8
rows_per_run = 6
)";

TEST(TableStage, TheOffsetIsThatOfTheHolesAndNotOfTheTable) {
  const test::TemporaryFolder folder;
  const std::string toml = test::small_config_text("", "") + std::string(kCoupon);
  for (const bool is_calibrated : {false, true}) {
    auto config = test::config_with_camera(folder.path() / "", test::test_camera(280, 240), toml);
    ASSERT_TRUE(config) << config.error().text();
    config->coupon->state_file = folder.path() / fmt::format("coupon{}.json", is_calibrated);
    config->sim->table = errs();
    if (is_calibrated) config->walk.table = calibrated();
    const auto devices = DeviceSet::simulated(*config);
    ASSERT_TRUE(devices) << devices.error().text();
    const auto run = calibrate_spindle_camera(*config, devices->devices());
    ASSERT_TRUE(run) << run.error().text();
    const double error_um = 1e3 * (run->fit.offset.offset.in_mm() - Vector2d(45, -3)).norm();
    // Uncalibrated, drilling and looking err by what the table errs over the 45 mm between them.
    if (is_calibrated) {
      EXPECT_LT(error_um, 0.5);
    } else {
      EXPECT_GT(error_um, 5);
    }
  }
}

TEST(TableConfig, NamesACalibration) {
  const test::TemporaryFolder folder;
  TableCalibration calibration;
  calibration.map = calibrated()->map();
  calibration.geometry.cov.setIdentity();
  calibration.sigma = um(0.7);
  calibration.rms = um(1);
  calibration.provenance = "made up for a test";
  ASSERT_TRUE(write_table_calibration(folder.path() / "table.cal.json", calibration));
  const auto read = [&](const std::string& toml) {
    return parse_machine_config(toml, folder.path() / "machine.toml");
  };
  const auto config = read("[table]\ncalibration = \"table.cal.json\"\nhold_mm = 5\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->table_file, folder.path() / "table.cal.json");
  EXPECT_EQ(config->walk.uncertainty.table_map, um(0.7));
  ASSERT_NE(config->walk.table, nullptr);
  EXPECT_EQ(config->walk.table->hold(), mm(5));
  EXPECT_EQ(config->walk.table->map().coefficients_mm(), calibration.map.coefficients_mm());
  EXPECT_EQ(read("")->walk.table, nullptr);
  EXPECT_THAT(read("[table]\n"), FailsWith(Code::ConfigValue, "calibration = \"NAME.cal.json\""));
  EXPECT_THAT(read("[table]\ncalibration = \"\"\n"), FailsWith(Code::ConfigValue, "calibration"));
  EXPECT_THAT(read("[table]\ncalibration = \"none.cal.json\"\n"),
              FailsWith(Code::FileUnreadable, "none.cal.json"));
  EXPECT_THAT(read("[table]\ncalibrations = \"table.cal.json\"\n"),
              FailsWith(Code::ConfigKeyUnknown, "calibration"));
  EXPECT_THAT(read("[table]\ncalibration = \"table.cal.json\"\nhold_mm = -1\n"),
              FailsWith(Code::ConfigValue, "hold_mm"));
}

TEST(TableConfig, ReadsTheVirtualStage) {
  const auto read = [](const std::string& keys) {
    return parse_machine_config("[sim]\n[sim.table]\n" + keys, "machine.toml");
  };
  const auto config = read(
      "scale_ppm = [150, -100]\nsquareness_urad = 60\nbow_um = [30, -20]\nbow_radius_mm = 50\n"
      "center_mm = [80, 60]\n");
  ASSERT_TRUE(config) << config.error().text();
  ASSERT_TRUE(config->sim->table);
  const Vector2d difference_mm =
      config->sim->table->error_mm(at(200, 10)) - errs().error_mm(at(200, 10));
  EXPECT_LT(difference_mm.norm(), 1e-12);
  EXPECT_FALSE(parse_machine_config("[sim]\n", "machine.toml")->sim->table);
  EXPECT_THAT(read("bow_radius_mm = 0\n"), FailsWith(Code::ConfigValue, "bow_radius_mm"));
  EXPECT_THAT(read("scale_ppm = 3\n"), FailsWith(Code::ConfigValue, "scale_ppm"));
  EXPECT_THAT(read("squareness = 3\n"), FailsWith(Code::ConfigKeyUnknown, "squareness_urad"));
}

}  // namespace
}  // namespace panelcal
