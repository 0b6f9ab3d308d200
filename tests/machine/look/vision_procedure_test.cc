// SPDX-License-Identifier: Apache-2.0
// Every way of looking at a target, on the simulated machine against its hidden truth.
#include "machine/look/vision_procedure.h"

#include <cmath>
#include <string>

#include "machine/sim/sim_machine.h"
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/machine/one_target.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::IsNearPosition;
using test::kShaken;
using test::PanelSetup;
using testing::AllOf;
using testing::HasSubstr;

using VisionProcedureTest = test::OneTargetTest;

// --- four views --------------------------------------------------------------------------------

TEST_F(VisionProcedureTest, FourViewsWithOneTool) {
  set_up({.vision = "search_radius_mm = 0.9\n",
          .camera = "",
          .sim = std::string(kShaken),
          .orders = "G34,1,6.0"});
  expect_found(measure());
  ASSERT_EQ(seen_.size(), 4u);
  const auto middle = position_mm<frame::Machine>(120, 65);
  const double places[4][2] = {{6, 0}, {0, 6}, {-6, 0}, {0, -6}};
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(seen_[k].view.i_view, static_cast<int>(k));
    EXPECT_THAT(seen_[k].axis,
                IsNearPosition(middle + displacement_mm<frame::Machine>(places[k][0], places[k][1]),
                               um(0.001)));
  }
}

TEST_F(VisionProcedureTest, FourViewsWithFourToolsAtTheCorners) {
  set_up({.vision = "search_radius_mm = 0.9\nfour_views = \"corners\"\n",
          .camera = "",
          .sim = std::string(kShaken) + "neighbors = 2\n",
          .orders = "G34,1,2,3,4,5.0"});
  expect_found(measure());
  ASSERT_EQ(seen_.size(), 4u);
  EXPECT_THAT(seen_[1].axis, IsNearPosition(position_mm<frame::Machine>(115, 70), um(0.001)));
  EXPECT_EQ(seen_[3].view.i_tool, 3);
}

TEST_F(VisionProcedureTest, OneMarkThatIsMissingLosesTheTarget) {
  set_up(
      {.vision = "search_radius_mm = 0.9\n", .camera = "", .sim = "", .orders = "G34,1,2,3,4,5.0"});
  SimMachine machine = this->machine();
  MeasurementRequest request = measure(machine).request;
  request.settings.tools = {1, 2, 1, 4};
  const auto measurement = machine.measure(request);
  ASSERT_TRUE(measurement) << measurement.error().text();
  EXPECT_NE(measurement->status, MeasurementStatus::Found);
  EXPECT_EQ(measurement->reason.rfind("mark 3 of 4 (vision tool 1): ", 0), 0u)
      << measurement->reason;
}

TEST_F(VisionProcedureTest, MarksThatDisagreeAreRejected) {
  set_up({.vision = "search_radius_mm = 0.9\n",
          .camera = "",
          .sim = "stretch_ppm = [20000, 0]\n",  // 0.12 mm at a mark
          .orders = "G34,1,6.0"});
  const Measurement measurement = measure();
  EXPECT_EQ(measurement.status, MeasurementStatus::Rejected);
  EXPECT_EQ(measurement.reason.rfind("the four marks disagree: they are 0.1", 0), 0u)
      << measurement.reason;
  config_.vision.four_view_limit = mm(1);
  expect_found(measure());
}

TEST_F(VisionProcedureTest, ToolsAndDistanceBelongTogether) {
  set_up({});
  SimMachine machine = this->machine();
  MeasurementRequest request = measure(machine).request;
  request.settings.tools = {1, 2};
  EXPECT_THAT(machine.measure(request), FailsWith(Code::NotSupported, "2 vision tools"));
  request.settings.tools = {1, 2, 9, 4};
  request.settings.delta = mm(5);
  EXPECT_THAT(machine.measure(request), FailsWith(Code::VisionToolUndefined, "vision tool 9"));
}

// --- search ------------------------------------------------------------------------------------

TEST_F(VisionProcedureTest, SearchFindsATargetThreeMillimetersAway) {
  for (const double angle : {0.3, 1.9, 3.4, 5.0}) {
    seen_.clear();
    set_up({.vision = "search_radius_mm = 0.5\n",
            .camera = "",
            .sim = fmt::format("panel_offset_mm = [{}, {}]\nneighbors = 2\n",
                               3 * std::cos(angle),
                               3 * std::sin(angle)),
            .orders = "$uvis,search,on\n$uvis,searcharea,4\nG34,1"});
    const Measurement measurement = measure();
    expect_found(measurement);
    ASSERT_GT(seen_.size(), 1u);
    EXPECT_NE(seen_.front().status, DetectionStatus::Found);
    EXPECT_EQ(seen_.back().status, DetectionStatus::Found);
    EXPECT_LT(seen_.size(), 30u);
  }
}

TEST_F(VisionProcedureTest, SearchEndsWithTheFirstViewIfItIsThere) {
  set_up({.vision = "",
          .camera = "",
          .sim = std::string(kShaken),
          .orders = "$uvis,search,on\n$uvis,searcharea,4\nG34,1"});
  expect_found(measure());
  EXPECT_EQ(seen_.size(), 1u);
}

TEST_F(VisionProcedureTest, SearchDoesNotLeaveItsArea) {
  set_up({.vision = "",
          .camera = "",
          .sim = "panel_offset_mm = [3, 0]\n",
          .orders = "$uvis,search,on\n$uvis,searcharea,2.9\nG34,1"});
  const Measurement measurement = measure();
  EXPECT_EQ(measurement.status, MeasurementStatus::NotFound);
  EXPECT_EQ(measurement.reason.rfind(
                fmt::format("not in {0} of {0} views within 2.900 mm; view 1 of", seen_.size()), 0),
            0u)
      << measurement.reason;
  EXPECT_GT(seen_.size(), 4u);
}

TEST_F(VisionProcedureTest, WithoutAutosearchOneViewDecides) {
  for (const char* orders : {"$uvis,searcharea,4\nG34,1",
                             "$uvis,search,off\n$uvis,searcharea,4\nG34,1",
                             "$uvis,search,on\nG34,1"}) {
    seen_.clear();
    set_up({.vision = "", .camera = "", .sim = "panel_offset_mm = [3, 0]\n", .orders = orders});
    EXPECT_EQ(measure().status, MeasurementStatus::NotFound);
    EXPECT_EQ(seen_.size(), 1u);
  }
  config_.vision.search_area = mm(4);
  expect_found(measure());
}

TEST_F(VisionProcedureTest, FourViewsAreShiftedAsTheSearchOfTheFirstSays) {
  set_up({.vision = "search_radius_mm = 0.5\n",
          .camera = "",
          .sim = "panel_offset_mm = [1.9, -1.2]\n",
          .orders = "$uvis,search,on\n$uvis,searcharea,3\nG34,1,6.0"});
  expect_found(measure());
  EXPECT_GT(seen_.size(), 4u);
}

// --- camera orders -----------------------------------------------------------------------------

TEST_F(VisionProcedureTest, LampMakesPicturesBrighter) {
  set_up({.vision = "", .camera = "", .sim = "lamp = 40\n", .orders = "G34,1"});
  measure();
  const double usual = mean_level_;
  set_up({.vision = "", .camera = "", .sim = "lamp = 40\n", .orders = "$uvis,lamp,20\nG34,1"});
  expect_found(measure());
  EXPECT_NEAR(mean_level_ / usual, 0.5, 0.01);
  set_up({.vision = "", .camera = "", .sim = "lamp = 40\n", .orders = "$uvis,lamp,0\nG34,1"});
  EXPECT_EQ(measure().status, MeasurementStatus::NotFound);
}

TEST_F(VisionProcedureTest, ZoomHasACalibrationOfItsOwn) {
  CameraCalibration closer = test::test_camera(320, 280);
  closer.parameters.scale_mm_per_px = 0.004;
  ASSERT_TRUE(write_camera_calibration(folder_.path() / "zoom7.cal.json", closer));
  const PanelSetup panel{.vision = "",
                         .camera = "[[camera.zoom]]\nlevel = 7\ncalibration = \"zoom7.cal.json\"\n",
                         .sim = "panel_offset_mm = [0.1, -0.08]\n",
                         .orders = "$uvis,zoom,7\nG34,1"};
  set_up(panel);
  expect_found(measure());
  PanelSetup other = panel;
  other.orders = "$uvis,zoom,3\nG34,1";
  set_up(other);
  EXPECT_THAT(SimMachine::create(config_, program_), FailsWith(Code::ConfigValue, "zoom 3"));
}

TEST_F(VisionProcedureTest, UnknownAlgorithmIsRefused) {
  set_up({.vision = "", .camera = "", .sim = "", .orders = "$uvis,alg,2,1\nG34,1"});
  EXPECT_THAT(SimMachine::create(config_, program_), FailsWith(Code::NotSupported, "algorithm 2"));
  config_.vision.algorithms = {0, 2};
  expect_found(measure());
}

// --- focus -------------------------------------------------------------------------------------

TEST_F(VisionProcedureTest, FocusIsFoundAndKept) {
  const PanelSetup panel{.vision = "",
                         .camera = "focus_range_mm = [-1, 2]\n",
                         .sim = "focus_z_mm = 0.737\nfocus_depth_mm = 0.08\n",
                         .orders = "$uvis,focus,x20.0y15.0\nG34,1"};
  set_up(panel);
  expect_found(measure());
  ASSERT_EQ(survey_.focus.size(), 1u) << diagnostics_;
  const FocusResult& focus = survey_.focus.front();
  EXPECT_TRUE(focus.is_found);
  EXPECT_GT(focus.sigma, Length());
  EXPECT_LT(focus.sigma, um(5));
  EXPECT_LT(std::abs(focus.z.in_mm() - 0.737), std::max(4 * focus.sigma.in_mm(), 0.002));
  EXPECT_EQ(focus.curve.size(), 25u);
  EXPECT_EQ(diagnostics_, "");
  PanelSetup blurred = panel;
  blurred.orders = "G34,1";
  set_up(blurred);
  EXPECT_NE(measure().status, MeasurementStatus::Found);
}

TEST_F(VisionProcedureTest, FocusOnNothingIsRefused) {
  set_up({.vision = "",
          .camera = "focus_range_mm = [-1, 2]\n",
          .sim = "focus_z_mm = 0.737\nfocus_depth_mm = 0.08\n",
          .orders = "$uvis,focus,x50.0y50.0\nG34,1"});
  SimMachine machine = this->machine();
  DiagnosticLog log;
  survey(program_, config_.walk, machine, log);
  EXPECT_THAT(test::all_text(log),
              AllOf(HasSubstr("error[focus-not-found]"), HasSubstr("(50.0000, 50.0000) mm")))
      << test::all_text(log);
}

TEST_F(VisionProcedureTest, WithoutAFocusAxisTheOrderIsPassedOn) {
  set_up({.vision = "", .camera = "", .sim = "", .orders = "$uvis,focus,x20.0y15.0\nG34,1"});
  expect_found(measure());
  EXPECT_TRUE(survey_.focus.empty());
  EXPECT_NE(diagnostics_.find("warning[calibration-not-performed]"), std::string::npos);
}

}  // namespace
}  // namespace panelcal
