// SPDX-License-Identifier: Apache-2.0
// Nights that calibrate the table on a plate that is fixed to the machine.

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/table/calibration_file.h"
#include "machine/calibrate/kinds/kinds.h"
#include "machine/devices/table_stage.h"
#include "machine/nightly/nightly.h"
#include "machine/nightly/record/night_files.h"
#include "machine/plate/pictures.h"
#include "machine/sim/sim_plate.h"
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using testing::HasSubstr;

/// Half of the plate: 6 and 5 pitches of 20 mm.
const Eigen::Vector2d kHalf_mm(60, 50);

class TableNights : public ::testing::Test {
 protected:
  // Of the truth.
  double scale_x_ppm = 200;
  double squareness_urad = 100;
  // Content of the files.
  std::string certified = "true";
  std::string more_poses;
  std::string source = "camera = \"gige://192.168.1.10\"";
  std::string in_force;  ///< [table]
  std::string table = "[nightly.table]\nplate = \"plate.toml\"\nfile = \"table.cal.json\"\n";

  Expected<MachineConfig> config() const {
    const std::string toml = fmt::format(R"([machine]
name = "drill 1"
travel_low_mm = [0, 0]
travel_high_mm = [600, 500]
[ledger]
file = "drill.ledger"
[camera]
calibration = "camera.cal.json"
[spindle]
camera_offset_mm = [45.0, -3.0]
[nightly]
{}
calibrate = ["table"]
min_disk_mb = 0
{}
{}
[[vision.tool]]
number = 1
shape = "disc"
polarity = "dark"
size_mm = 0.4
[sim]
noise = 2
background = 0.6
target_level = 0.9
)",
                                         source,
                                         table,
                                         in_force);
    PANELCAL_CHECK(write_file(folder_.path() / "machine.toml", toml));
    PANELCAL_CHECK(write_file(folder_.path() / "plate.toml",
                              fmt::format(R"([plate]
columns = 7
rows = 6
pitch_mm = 20
dot_diameter_mm = 0.4
certified = {}
[[pose]]
origin_mm = [200, 100]
angle_deg = 0
{})",
                                          certified,
                                          more_poses)));
    return test::config_with_camera(folder_.path(), test::test_camera(160, 120), toml);
  }

  Expected<NightRecord> try_run() {
    PANELCAL_TRY(const MachineConfig config, this->config());
    PANELCAL_TRY(const CalibrationPlate plate, read_plate(folder_.path() / "plate.toml"));
    SimPlateOptions options;
    options.seed = ++seed_;
    options.stage_repeatability = um(0.3);
    // Beside where its file has it.
    const PlatePose lies = {0.0005, {200.05, 99.96}};
    for (const PlateDot& dot : plate.dots()) options.marks.push_back(place_in(lies, dot.place));
    options.error_mm = [this](const Position<frame::Machine>& p) -> Eigen::Vector2d {
      const Eigen::Vector2d c = p.in_mm() - Eigen::Vector2d(215, 153);
      return {1e-6 * (scale_x_ppm * c.x() + squareness_urad * c.y()), 0};
    };
    PANELCAL_TRY(SimPlate made, SimPlate::create(config, std::move(options)));
    const auto machine = std::make_shared<SimPlate>(std::move(made));
    const auto stage = measuring_stage(machine, config.walk.table);
    return run_nightly({config,
                        *config.nightly,
                        {*stage, *machine, *machine, {}, {}},
                        [this] { return now_; },
                        "panelcal test",
                        "timer"});
  }
  NightRecord run() {
    const auto record = try_run();
    if (!record) ADD_FAILURE() << record.error().text();
    now_ += std::chrono::days(1);
    return record ? *record : NightRecord{};
  }
  std::string file() const { return read_file(folder_.path() / "table.cal.json").value_or("none"); }

  test::TemporaryFolder folder_;
  std::uint64_t seed_ = 0;
  std::chrono::sys_seconds now_{std::chrono::seconds(1795302000)};
};

TEST_F(TableNights, MeasureInstallAndFollowTheTable) {
  NightRecord record = run();
  ASSERT_EQ(exit_code(record), 0) << record.verdict;
  const auto& axes = record.steps.at(0).axes;
  const double by_scale_mm = 1e-6 * scale_x_ppm * kHalf_mm.x();
  const double by_squareness_mm = 1e-6 * squareness_urad * kHalf_mm.y();
  EXPECT_NEAR(*axes.at(0).new_value, by_scale_mm + by_squareness_mm, 5 * *axes[0].new_sigma);
  EXPECT_NEAR(*axes.at(1).new_value, 0, 5 * *axes[1].new_sigma);
  EXPECT_LT(*axes[0].new_sigma, 0.001);
  const auto installed = read_table_calibration(folder_.path() / "table.cal.json");
  ASSERT_TRUE(installed) << installed.error().text();
  EXPECT_NEAR(installed->geometry.value[TableGeometry::ScaleX], 200e-6, 10e-6);
  // A warmer machine.
  scale_x_ppm = 300;
  record = run();
  EXPECT_EQ(exit_code(record), 0) << record.verdict;
  EXPECT_NEAR(*record.steps.at(0).change, 1e-4 * kHalf_mm.x(), 0.002);
  // Taken away, it comes back from the ledger.
  const std::string bytes = file();
  std::filesystem::remove(folder_.path() / "table.cal.json");
  record = run();
  EXPECT_EQ(exit_code(record), 0) << record.verdict;
  EXPECT_NE(file(), "none");
  EXPECT_THAT(record.notes, testing::Contains(HasSubstr("written again from the ledger")));
}

// The stage is then sent to places, and told what leads there: what is measured must be the whole
// error all the same, or every night would take back the one before.
TEST_F(TableNights, FindTheWholeErrorThroughTheMapInForce) {
  ASSERT_EQ(exit_code(run()), 0);
  in_force = "[table]\ncalibration = \"table.cal.json\"\nhold_mm = 50\n";
  table = "[nightly.table]\nplate = \"plate.toml\"\n";
  for (int i = 0; i < 2; ++i) {
    const NightRecord record = run();
    ASSERT_EQ(exit_code(record), 0) << record.verdict;
    EXPECT_LT(*record.steps.at(0).change, 0.002);
    const auto installed = read_table_calibration(folder_.path() / "table.cal.json");
    ASSERT_TRUE(installed) << installed.error().text();
    EXPECT_NEAR(installed->geometry.value[TableGeometry::ScaleX], 200e-6, 10e-6);
  }
}

TEST_F(TableNights, ATableThatHasJumpedIsNotTakenOver) {
  ASSERT_EQ(exit_code(run()), 0);
  const std::string before = file();
  scale_x_ppm = 1500;
  const NightRecord record = run();
  EXPECT_EQ(record.steps.at(0).state, NightState::Held) << record.verdict;
  EXPECT_THAT(record.verdict, HasSubstr("the map is up to"));
  EXPECT_EQ(file(), before);
}

TEST_F(TableNights, SayWhatTheyLack) {
  certified = "false";
  EXPECT_THAT(try_run(), FailsWith(Code::ConfigValue, "certified"));
  certified = "true";
  more_poses = "[[pose]]\norigin_mm = [200, 100]\nangle_deg = 90\n";
  EXPECT_THAT(try_run(), FailsWith(Code::ConfigValue, "one [[pose]]"));
  more_poses.clear();
  table = "[nightly.table]\nplate = \"plate.toml\"\n";
  EXPECT_THAT(try_run(), FailsWith(Code::ConfigValue, "file"));
  table.clear();
  EXPECT_THAT(try_run(), FailsWith(Code::ConfigValue, "[nightly.table]"));
  table = "[nightly.table]\nplate = \"plate.toml\"\nfile = \"table.cal.json\"\n";
  source = "machine_driver = \"sim\"";
  EXPECT_THAT(try_run(), FailsWith(Code::ConfigValue, "plate"));
}

TEST_F(TableNights, ADamagedResultOfTheLedgerIsNamedThoughTheFileHasIt) {
  run();
  const auto config = this->config();
  ASSERT_TRUE(config) << config.error().text();
  const auto kind = table_kind(std::make_shared<MachineConfig>(*config),
                               NightlyConfig(),
                               CalibrationPlate(),
                               folder_.path() / "table.cal.json");
  auto ledger = Ledger::open(config->ledger_file, fixed_clock(now_));
  ASSERT_TRUE(ledger) << ledger.error().text();
  EXPECT_EQ(kind->is_installed(*ledger), true);
  LedgerDraft draft;
  draft.record.key = kind->key();
  draft.record.verdict = LedgerVerdict::Installed;
  draft.record.asked_by = "a person";
  draft.record.software = "panelcal test";
  draft.result = "{}";
  const auto entry = ledger->append(draft);
  ASSERT_TRUE(entry) << entry.error().text();
  ASSERT_TRUE(write_file(kind->file(), draft.result));
  const std::string name = fmt::format("ledger entry {}", entry->id);
  EXPECT_THAT(kind->is_installed(*ledger), FailsWith(Code::CalibrationInvalid, name));
  EXPECT_THAT(kind->write_in_force(*ledger), FailsWith(Code::CalibrationInvalid, name));
}

TEST_F(TableNights, ADamagedTableOfJobsComesBackFromTheLedger) {
  run();
  const std::string good = file();
  in_force = "[table]\ncalibration = \"table.cal.json\"\n";
  ASSERT_TRUE(config());
  std::filesystem::remove(folder_.path() / "table.cal.json");
  EXPECT_FALSE(config()) << "machine.toml is not readable without it";
  const auto files = find_night_files(folder_.path() / "machine.toml");
  ASSERT_TRUE(files) << files.error().text();
  EXPECT_THAT(restore_damaged_files(*files).value(),
              testing::ElementsAre(HasSubstr("table.cal.json")));
  EXPECT_EQ(file(), good);
  EXPECT_TRUE(config());
}

}  // namespace
}  // namespace panelcal
