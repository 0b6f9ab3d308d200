// SPDX-License-Identifier: Apache-2.0
// Boards with rows of equal pads, from pictures to the assignment of the series.
#include <array>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/statistics/random.h"
#include "machine/look/vision_procedure.h"
#include "machine/sources/measurement_file_source.h"
#include "program/walk/series_assignment.h"
#include "vision/render/render.h"
#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;

constexpr double kPad_mm = 0.9;
constexpr double kPitch_mm = 1.27;

/// A panel of pads, and the camera above it.
class PadCamera final : public ViewTaker {
 public:
  PadCamera(std::vector<Vector2d> pads_mm, const CameraCalibration& calibration)
      : pads_mm_(std::move(pads_mm)), camera_{.mapping = calibration.mapping()}, random_(11) {
    camera_.noise = 2;
  }

  Expected<TakenPicture> take(const MeasurementRequest&, const View& view) override {
    Scene scene;
    for (const Vector2d& pad_mm : pads_mm_) {
      const Vector2d at_mm = pad_mm - view.axis.in_mm();
      if (at_mm.norm() > 9) continue;
      Feature disc;
      disc.center = position_mm<frame::Optical>(at_mm);
      disc.size = mm(kPad_mm);
      disc.level = 0.75;
      scene.features.push_back(disc);
    }
    return TakenPicture{render(scene, camera_, random_), view.axis, "", ""};
  }

 private:
  std::vector<Vector2d> pads_mm_;
  Camera camera_;
  Random random_;
};

CameraCalibration wide_camera() {
  CameraCalibration camera = test::test_camera(640, 480);
  camera.parameters.scale_mm_per_px = 0.02;
  return camera;
}

class EqualPadsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    auto config = test::config_with_camera(folder_.path(), wide_camera(), R"([vision]
search_radius_mm = 4.1
[[vision.tool]]
number = 1
shape = "disc"
size_mm = 0.9
[camera]
calibration = "camera.cal.json"
[gates]
rotation_mrad = 4
stretch_ppm = 400
residual_um = 40
)");
    ASSERT_TRUE(config) << config.error().text();
    config_ = *std::move(config);
  }

  /// Looks at the three targets of a board that is shifted and turned, whose targets stand in these
  /// rows (offsets in pitches, the target's own left out).
  std::optional<SeriesAssignment> assigned(const std::vector<std::vector<Vector2d>>& rows,
                                           const Vector2d& shift_mm,
                                           double rotation_rad) {
    const std::vector<Vector2d> places_mm = {{0, 0}, {120, 0}, {0, 90}};
    Eigen::Matrix2d turn;
    turn << 1, -rotation_rad, rotation_rad, 1;
    std::vector<Vector2d> pads_mm;
    for (std::size_t i = 0; i < places_mm.size(); ++i) {
      pads_mm.emplace_back(turn * places_mm[i] + shift_mm);
      for (const Vector2d& off : rows[i]) {
        pads_mm.emplace_back(turn * (places_mm[i] + kPitch_mm * off) + shift_mm);
      }
    }
    PadCamera camera(pads_mm, wide_camera());
    auto procedure = VisionProcedure::create(config_);
    EXPECT_TRUE(procedure) << procedure.error().text();
    measured_.clear();
    for (const Vector2d& place_mm : places_mm) {
      MeasurementRequest request;
      request.seq = static_cast<std::int64_t>(measured_.size());
      request.command = "G36";
      request.settings.tools = {1};
      request.nominal = position_mm<frame::Nominal>(place_mm);
      request.expected = position_mm<frame::Actual>(place_mm);
      auto measurement = procedure->measure(request, camera);
      EXPECT_TRUE(measurement) << measurement.error().text();
      measured_.push_back(*std::move(measurement));
    }
    auto assignment = assign_series(measured_, config_.walk.base_limits);
    if (assignment) settle(*assignment, measured_);
    if (assignment) expect_replay(*assignment);
    for (std::size_t i = 0; i < 3; ++i) truth_mm_[i] = turn * places_mm[i] + shift_mm;
    return assignment;
  }

  /// A recording of what was decided is decided in the same way.
  void expect_replay(const SeriesAssignment& assignment) const {
    std::string lines;
    for (const Measurement& m : measured_) lines += to_json(m) + "\n";
    const auto recorded = parse_measurements(lines, "m.jsonl");
    ASSERT_TRUE(recorded) << recorded.error().text();
    std::vector<Measurement> replayed;
    for (const auto& one : recorded->measurements) replayed.push_back(one.answer);
    const auto again = assign_series(replayed, config_.walk.base_limits);
    ASSERT_TRUE(again);
    EXPECT_EQ(again->text(), assignment.text());
    settle(*again, replayed);
    for (std::size_t i = 0; i < replayed.size(); ++i) {
      EXPECT_EQ(to_json(replayed[i]), to_json(measured_[i]));
    }
  }

  int n_wrong() const {
    int n = 0;
    for (std::size_t i = 0; i < measured_.size(); ++i) {
      const bool is_found = measured_[i].status == MeasurementStatus::Found;
      n += is_found && (measured_[i].measured.position.in_mm() - truth_mm_[i]).norm() > 0.02;
    }
    return n;
  }

  test::TemporaryFolder folder_;
  MachineConfig config_;
  std::vector<Measurement> measured_;
  std::array<Vector2d, 3> truth_mm_;
};

const std::vector<Vector2d> kAlongX = {{-2, 0}, {-1, 0}, {1, 0}, {2, 0}, {3, 0}};
const std::vector<Vector2d> kAlongY = {{0, -2}, {0, -1}, {0, 1}};

TEST_F(EqualPadsTest, FindsEveryShiftAmongDifferentNeighbours) {
  for (int k = -3; k <= 3; ++k) {
    const Vector2d shift_mm(k * kPitch_mm + 0.01, 0.02 * k);
    const auto assignment = assigned({kAlongX, kAlongY, {}}, shift_mm, 1e-3 * k);
    EXPECT_EQ(n_wrong(), 0) << k;
    ASSERT_TRUE(assignment) << k;
    EXPECT_TRUE(assignment->is_certain()) << k << ": " << assignment->text();
    for (const Measurement& m : measured_) EXPECT_EQ(m.status, MeasurementStatus::Found) << k;
  }
}

TEST_F(EqualPadsTest, HoldsEqualNeighbours) {
  for (int k = -2; k <= 2; ++k) {
    const Vector2d shift_mm(k * kPitch_mm, 0.1);
    const auto assignment = assigned({kAlongX, kAlongX, kAlongX}, shift_mm, 5e-4);
    ASSERT_TRUE(assignment) << k;
    EXPECT_FALSE(assignment->is_certain()) << k << ": " << assignment->text();
    EXPECT_EQ(n_wrong(), 0) << k;
  }
}

}  // namespace
}  // namespace panelcal
