// SPDX-License-Identifier: Apache-2.0
#include "machine/config/machine_config.h"

#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

/// Without [camera]: what needs no other file.
Expected<MachineConfig> parse(std::string_view toml) {
  return parse_machine_config(toml, "machine.toml");
}

Expected<MachineConfig> parse_with_camera(std::string_view toml) {
  const test::TemporaryFolder folder;
  return test::config_with_camera(folder.path(), test::test_camera(320, 240), toml);
}

/// The whole diagnostic, as a user sees it.
std::string refusal(std::string_view toml) {
  const auto config = parse(toml);
  return config ? "accepted" : test::brief(config.error());
}

TEST(MachineConfig, EmptyFileHasTheDefaults) {
  const auto config = parse("");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->walk.series_size, 3);
  EXPECT_FALSE(config->walk.model);
  EXPECT_EQ(gates_text(config->walk.base_limits), gates_text(default_gate_limits()));
  EXPECT_EQ(gates_text(config->walk.nested_limits), gates_text(default_gate_limits()));
  EXPECT_FALSE(config->vision.search_radius);
  EXPECT_TRUE(config->vision_tools.empty());
  EXPECT_FALSE(config->camera);
  EXPECT_FALSE(config->sim);
}

TEST(MachineConfig, ReadsEveryKey) {
  const auto config = parse_with_camera(R"(
[machine]
name = "drill 3"
[vision]
rotate = 4
model = "rigid"
search_radius_mm = 1.5
min_score = 0.7
min_contrast = 0.1
ambiguity_margin = 0.2
[[vision.tool]]
number = 1
shape = "disc"
size_mm = 2
[[vision.tool]]
number = 7
shape = "ring"
size_mm = 1.5
inner_mm = 0.5
polarity = "dark"
size_tolerance = 0.1
[camera]
calibration = "camera.cal.json"
[spindle]
camera_offset_mm = [45.5, -3]
camera_offset_sigma_um = 2
[gates]
residual_um = 25
rotation_mrad = 5
stretch_ppm = 600
offset_mm = 1.5
[gates.nested]
residual_um = 15
[program]
work_zero_mm = [100, 200.5]
absolute_zero_mm = [-1, 2]
)");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->name, "drill 3");
  EXPECT_EQ(config->walk.series_size, 4);
  EXPECT_EQ(config->walk.model, PanelModel::Rigid);
  EXPECT_EQ(config->vision.search_radius, mm(1.5));
  EXPECT_EQ(config->locate.min_score, 0.7);
  EXPECT_EQ(config->locate.min_contrast, 0.1);
  EXPECT_EQ(config->locate.ambiguity_margin, 0.2);
  ASSERT_EQ(config->vision_tools.size(), 2u);
  EXPECT_EQ(config->vision_tools.at(1).size, mm(2));
  EXPECT_EQ(config->vision_tools.at(1).polarity, Polarity::Bright);
  const Target& ring = config->vision_tools.at(7);
  EXPECT_EQ(ring.shape, Shape::Ring);
  EXPECT_EQ(ring.inner_size, mm(0.5));
  EXPECT_EQ(ring.polarity, Polarity::Dark);
  EXPECT_EQ(ring.size_tolerance, 0.1);
  ASSERT_TRUE(config->camera);
  EXPECT_EQ(config->camera->picture_width_px, 320);
  EXPECT_EQ(config->spindle_camera.offset.in_mm(), Eigen::Vector2d(45.5, -3));
  EXPECT_DOUBLE_EQ(config->spindle_camera.cov_mm2(1, 1), 4e-6);
  EXPECT_EQ(config->walk.work_zero.in_mm(), Eigen::Vector2d(100, 200.5));
  EXPECT_EQ(config->walk.absolute_zero.in_mm(), Eigen::Vector2d(-1, 2));
}

TEST(MachineConfig, NestedGatesOverrideOnlyWhatTheyName) {
  const auto config =
      parse("[gates]\nresidual_um = 25\noffset_mm = 1\n[gates.nested]\nresidual_um = 10\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->walk.base_limits.residual, um(25));
  EXPECT_EQ(config->walk.nested_limits.residual, um(10));
  EXPECT_EQ(config->walk.nested_limits.offset, mm(1));
  EXPECT_EQ(config->walk.nested_limits.rotation, deg(3));
}

TEST(MachineConfig, TakesAGateAway) {
  const auto config = parse(
      "[gates]\nresidual_um = \"off\"\nfalse_alarm = \"off\"\nmirror = \"off\"\n"
      "[gates.nested]\nresidual_um = 50\nrotation_mrad = \"off\"\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_THAT(gates_off(config->walk.base_limits),
              testing::ElementsAre("residual", "false alarm", "mirror"));
  EXPECT_THAT(gates_off(config->walk.nested_limits),
              testing::ElementsAre("rotation", "false alarm"));
  EXPECT_EQ(config->walk.nested_limits.residual, um(50));
}

TEST(MachineConfig, DeclaresTheQuarterTurnOfAPanelAndOfNoBoard) {
  const auto config = parse("[gates]\nturned_deg = 270\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->walk.base_limits.turned_deg, 270);
  EXPECT_EQ(config->walk.nested_limits.turned_deg, 0);
}

TEST(MachineConfig, RefusesGatesOfOtherWords) {
  EXPECT_EQ(refusal("[gates]\nresidual_um = \"of\"\n"), "machine.toml:2:15: error[config-value]");
  EXPECT_EQ(refusal("[gates]\nmirror = \"on\"\n"), "machine.toml:2:10: error[config-value]");
  EXPECT_EQ(refusal("[gates]\nturned_deg = 45\n"), "machine.toml:2:14: error[config-value]");
  EXPECT_EQ(refusal("[gates.nested]\nturned_deg = 90\n"),
            "machine.toml:2:1: error[config-key-unknown]");
}

TEST(MachineConfig, NestedGatesAreTheBaseOnesIfAbsent) {
  const auto config = parse("[gates]\nrotation_mrad = 5\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->walk.nested_limits.rotation, rad(5e-3));
}

TEST(MachineConfig, ModelAutoLeavesItToTheTargets) {
  const auto config = parse("[vision]\nmodel = \"auto\"\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_FALSE(config->walk.model);
  EXPECT_TRUE(config->walk.chooses_model);
}

TEST(MachineConfig, WithoutAModelTheManualRules) {
  const auto config = parse("[vision]\nrotate = 3\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_FALSE(config->walk.model);
  EXPECT_FALSE(config->walk.chooses_model);
}

TEST(MachineConfig, ReadsHowSiebMeyerProgramsMeasure) {
  const auto config = parse("[vision]\nmode = 5\ncama = true\nscale = true\ndefault_tool = 7\n");
  ASSERT_TRUE(config) << config.error().text();
  const sieb_meyer::Settings& settings = config->walk.sieb_meyer;
  EXPECT_EQ(settings.measurement_mode, 5);
  EXPECT_TRUE(settings.pattern_mode);
  EXPECT_TRUE(settings.fits_scale);
  EXPECT_EQ(settings.vision_tool, 7);
  // An absent key leaves what the control does by itself.
  const auto silent = parse("[vision]\n");
  ASSERT_TRUE(silent) << silent.error().text();
  EXPECT_EQ(silent->walk.sieb_meyer.measurement_mode, 1);
  EXPECT_FALSE(silent->walk.sieb_meyer.pattern_mode);
  EXPECT_FALSE(silent->walk.sieb_meyer.fits_scale);
  EXPECT_EQ(silent->walk.sieb_meyer.vision_tool, 1);
}

/// The manual has modes 1, 2, 3 and 5.
TEST(MachineConfig, RefusesMeasurementModesThatDoNotExist) {
  for (const std::string_view mode : {"4", "0", "6"}) {
    EXPECT_EQ(refusal("[vision]\nmode = " + std::string(mode) + "\n"),
              "machine.toml:2:8: error[config-value]");
  }
}

TEST(MachineConfig, NamesTheNearestKnownKey) {
  EXPECT_EQ(refusal("[vision]\nrotate = 3\nserch_radius_mm = 2\n"),
            "machine.toml:3:1: error[config-key-unknown]");
  EXPECT_EQ(refusal("[visoin]\n"), "machine.toml:1:2: error[config-key-unknown]");
  EXPECT_EQ(refusal("[gates]\nbanana = 2\n"), "machine.toml:2:1: error[config-key-unknown]");
  EXPECT_EQ(refusal("vision.tool = [{numbr = 1}]"), "machine.toml:1:17: error[config-key-unknown]");
}

TEST(MachineConfig, SaysWhatIsPlannedButNotSupported) {
  EXPECT_EQ(refusal("[machine]\ndrivers = 2\n"), "machine.toml:2:1: error[not-supported]");
  EXPECT_EQ(refusal("[[vision.tool]]\nnumber = 1\nalgorithm = 1\n"),
            "machine.toml:3:1: error[not-supported]");
}

TEST(MachineConfig, RefusesWrongTypes) {
  EXPECT_EQ(refusal("[vision]\nrotate = \"3\"\n"), "machine.toml:2:10: error[config-value]");
  EXPECT_EQ(refusal("[vision]\nrotate = 3.0\n"), "machine.toml:2:10: error[config-value]");
  EXPECT_EQ(refusal("[vision]\nmin_score = true\n"), "machine.toml:2:13: error[config-value]");
  EXPECT_EQ(refusal("[spindle]\ncamera_offset_mm = 45\n"),
            "machine.toml:2:20: error[config-value]");
  EXPECT_EQ(refusal("[spindle]\ncamera_offset_mm = [45]\n"),
            "machine.toml:2:20: error[config-value]");
  EXPECT_EQ(refusal("[spindle]\ncamera_offset_mm = [45, \"3\"]\n"),
            "machine.toml:2:25: error[config-value]");
  EXPECT_EQ(refusal("vision = 3\n"), "machine.toml:1:10: error[config-value]");
  EXPECT_EQ(refusal("[vision]\ntool = 3\n"), "machine.toml:2:8: error[config-value]");
  EXPECT_EQ(refusal("[vision]\ntool = [3]\n"), "machine.toml:2:9: error[config-value]");
  EXPECT_EQ(refusal("[machine]\nname = 3\n"), "machine.toml:2:8: error[config-value]");
}

TEST(MachineConfig, RefusesNumbersOutsideTheirRange) {
  EXPECT_EQ(refusal("[vision]\nrotate = 0\n"), "machine.toml:2:10: error[config-value]");
  EXPECT_EQ(refusal("[vision]\nmin_score = 1.5\n"), "machine.toml:2:13: error[config-value]");
  EXPECT_EQ(refusal("[vision]\nsearch_radius_mm = 0\n"), "machine.toml:2:20: error[config-value]");
  EXPECT_EQ(refusal("[gates]\nresidual_um = -1\n"), "machine.toml:2:15: error[config-value]");
  EXPECT_EQ(refusal("[gates]\nresidual_um = nan\n"), "machine.toml:2:15: error[config-value]");
  EXPECT_EQ(refusal("[gates]\nresidual_um = inf\n"), "machine.toml:2:15: error[config-value]");
  EXPECT_EQ(refusal("[vision]\nmodel = \"elastic\"\n"), "machine.toml:2:9: error[config-value]");
}

/// A limit of 0 holds every panel; one that no panel breaks is `"off"`.
TEST(MachineConfig, RefusesGatesThatNothingKeepsOrBreaks) {
  EXPECT_EQ(refusal("[gates]\nresidual_um = 0\n"), "machine.toml:2:15: error[config-value]");
  EXPECT_EQ(refusal("[gates]\nresidual_um = 1000001\n"), "machine.toml:2:15: error[config-value]");
  EXPECT_EQ(refusal("[gates]\nrotation_mrad = 0\n"), "machine.toml:2:17: error[config-value]");
  EXPECT_EQ(refusal("[gates]\nrotation_mrad = 3143\n"), "machine.toml:2:17: error[config-value]");
  EXPECT_EQ(refusal("[gates]\nstretch_ppm = 0\n"), "machine.toml:2:15: error[config-value]");
  EXPECT_EQ(refusal("[gates]\nstretch_ppm = 1e9\n"), "machine.toml:2:15: error[config-value]");
  EXPECT_EQ(refusal("[gates]\noffset_mm = 0\n"), "machine.toml:2:13: error[config-value]");
  EXPECT_TRUE(parse("[gates]\nresidual_um = 1e6\nstretch_ppm = 1e5\nrotation_mrad = 3142\n"));
}

TEST(MachineConfig, InspectionsHoldUntilAProgramSaysOtherwise) {
  const auto config = parse("[vision]\ninspections = 4\n");
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_EQ(config->walk.inspections, 4);
  EXPECT_EQ(parse("")->walk.inspections, 1);
  for (const char* wrong : {"0", "101", "2.0"}) {
    EXPECT_EQ(refusal(std::string("[vision]\ninspections = ") + wrong + "\n"),
              "machine.toml:2:15: error[config-value]");
  }
}

TEST(MachineConfig, RefusesVisionToolsThatMakeNoSense) {
  const std::string tool = "[[vision.tool]]\nnumber = 1\nshape = \"disc\"\n";
  EXPECT_EQ(refusal("[[vision.tool]]\nshape = \"disc\"\n"),
            "machine.toml:1:1: error[config-value]");
  EXPECT_EQ(refusal("[[vision.tool]]\nnumber = 1\n"), "machine.toml:1:1: error[config-value]");
  EXPECT_EQ(refusal("[[vision.tool]]\nnumber = 1\nshape = \"blob\"\n"),
            "machine.toml:3:9: error[config-value]");
  EXPECT_EQ(refusal(tool), "machine.toml:1:1: error[config-value]");
  EXPECT_EQ(refusal(tool + "size_mm = 1\n"), "machine.toml:4:11: error[config-value]");
  EXPECT_EQ(refusal(tool + "size_mm = 1\nsize_px = 100\n"),
            "machine.toml:5:11: error[config-value]");
  EXPECT_EQ(refusal(tool + "size_px = -5\n"), "machine.toml:4:11: error[config-value]");
  EXPECT_EQ(refusal(tool + "size_px = 100\ninner_px = 50\n"),
            "machine.toml:5:12: error[config-value]");
  EXPECT_EQ(refusal(tool + "size_px = 100\n" + tool + "size_px = 50\n"),
            "machine.toml:6:10: error[config-value]");
  EXPECT_EQ(refusal("[[vision.tool]]\nnumber = 1\nshape = \"ring\"\nsize_px = 9\ninner_px = 9\n"),
            "machine.toml:5:12: error[config-value]");
  EXPECT_EQ(refusal("[[vision.tool]]\nnumber = 1\nshape = \"ring\"\nsize_px = 9\ninner_mm = 1\n"),
            "machine.toml:5:12: error[config-value]");
  EXPECT_EQ(refusal(tool + "size_px = 100\npolarity = \"shiny\"\n"),
            "machine.toml:5:12: error[config-value]");
  EXPECT_EQ(refusal(tool + "size_px = 100\nsize_tolerance = 0\n"),
            "machine.toml:5:18: error[config-value]");
}

TEST(MachineConfig, RefusesWhatIsNotToml) {
  // The words behind the place are the TOML library's.
  EXPECT_THAT(parse("[vision\n"), FailsWith(Code::TomlSyntax, "machine.toml:1:8: "));
  EXPECT_THAT(parse("name = drill\n"), FailsWith(Code::TomlSyntax, "machine.toml:1:8: "));
  EXPECT_THAT(parse("[vision]\nrotate = 3\nrotate = 4\n"),
              FailsWith(Code::TomlSyntax, "machine.toml:3:10: "));
  EXPECT_THAT(parse("[machine]\nname = \"\xff\"\n"),
              FailsWith(Code::TomlSyntax, "machine.toml:2:8: "));
}

TEST(MachineConfig, ColumnsCountCharacters) {
  EXPECT_EQ(refusal("[machine]\nname = \"Fr\xc3\xa4se\"\n[camera]\n\"calibr\xc3\xa4tion\" = 1\n"),
            "machine.toml:4:1: error[config-key-unknown]");
}

TEST(MachineConfig, SurvivesDeepNesting) {
  EXPECT_THAT(parse(std::string(500, '[')), FailsWith(Code::TomlSyntax));
  std::string dotted;
  for (int i = 0; i < 400; ++i) dotted += "a.";
  EXPECT_THAT(parse(dotted + "a = 1"), FailsWith(Code::ConfigKeyUnknown, "\"a\""));
  EXPECT_THAT(parse(std::string(5000, 'a')), FailsWith(Code::TomlSyntax));
}

TEST(MachineConfig, MissingFilesAreNamed) {
  EXPECT_THAT(read_machine_config("no/such/machine.toml"),
              FailsWith(Code::FileUnreadable, "no/such/machine.toml"));
  EXPECT_THAT(parse("[camera]\ncalibration = \"no_such.cal.json\"\n"),
              FailsWith(Code::FileUnreadable, "no_such.cal.json"));
  EXPECT_EQ(refusal("[camera]\n"), "machine.toml:1:1: error[config-value]");
}

TEST(MachineConfig, CalibrationIsLookedForBesideTheFile) {
  const test::TemporaryFolder folder;
  ASSERT_TRUE(
      write_camera_calibration(folder.path() / "camera.cal.json", test::test_camera(320, 240)));
  const auto file = folder.path() / "machine.toml";
  ASSERT_TRUE(write_file(file, "[camera]\ncalibration = \"camera.cal.json\"\n"));
  const auto config = read_machine_config(file);
  ASSERT_TRUE(config) << config.error().text();
  EXPECT_TRUE(config->camera);
  EXPECT_EQ(config->file, file);
}

}  // namespace
}  // namespace panelcal
