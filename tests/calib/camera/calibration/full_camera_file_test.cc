// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <filesystem>
#include <limits>
#include <string>

#include "calib/base/statistics/random.h"
#include "calib/camera/calibration/calibration_file.h"
#include <gmock/gmock.h>

#include "tests/calib/camera/simulated_camera.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using testing::HasSubstr;

FullCamera good_camera() {
  FullCamera camera;
  camera.form = CameraForm::Tangential;
  camera.parameters = test::bent_camera();
  camera.covariance.diagonal() << 1e-14, 1e-10, 1e-6, 1e-6, 1e-20, 1e-32, 1e-14, 1e-14;
  camera.covariance(0, 4) = camera.covariance(4, 0) = -9e-18;
  camera.undetermined = {CameraParameter::P1, CameraParameter::TiltY};
  camera.zoom = 3;
  camera.rms_px = 0.0121;
  camera.held_out_rms_px = 0.0134;
  return camera;
}

CameraCalibration good() {
  CameraCalibration c = calibration_of(good_camera(), 640, 480);
  c.date = std::chrono::sys_days(std::chrono::year(2026) / 11 / 21) + std::chrono::seconds(31058);
  c.provenance = "25 views of one mark";
  return c;
}

Expected<CameraCalibration> parse(const std::string& text) {
  return parse_camera_calibration(text, "c.cal.json");
}

/// The good file with one piece of text exchanged.
std::string text_with(const std::string& old_text, const std::string& new_text) {
  std::string text = camera_calibration_text(good());
  const std::size_t at = text.find(old_text);
  EXPECT_NE(at, std::string::npos) << old_text << " in\n" << text;
  return at == std::string::npos ? text : text.replace(at, old_text.size(), new_text);
}

TEST(FullCameraFile, ReadsBackWhatItWroteExactly) {
  const auto path = std::filesystem::path(testing::TempDir()) / "full_camera_file_test.cal.json";
  const CameraCalibration written = good();
  ASSERT_TRUE(write_camera_calibration(path, written));
  const Expected<CameraCalibration> read = read_camera_calibration(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(read) << read.error().text();
  ASSERT_TRUE(read->full);
  const CameraModel::Parameters& p = read->full->parameters;
  const CameraModel::Parameters& q = written.full->parameters;
  EXPECT_EQ(p.scale_mm_per_px, q.scale_mm_per_px);
  EXPECT_EQ(p.rotation_rad, q.rotation_rad);
  EXPECT_EQ(p.axis_px, q.axis_px);
  EXPECT_EQ(p.tilt, q.tilt);
  EXPECT_EQ(p.k1_per_px2, q.k1_per_px2);
  EXPECT_EQ(p.k2_per_px4, q.k2_per_px4);
  EXPECT_EQ(p.p1_per_px, q.p1_per_px);
  EXPECT_EQ(p.p2_per_px, q.p2_per_px);
  EXPECT_EQ(p.focal_px, q.focal_px);
  EXPECT_EQ(read->full->covariance, written.full->covariance);
  EXPECT_EQ(read->full->form, CameraForm::Tangential);
  EXPECT_EQ(read->full->undetermined, written.full->undetermined);
  EXPECT_EQ(read->full->zoom, 3.0);
  EXPECT_EQ(read->full->rms_px, 0.0121);
  EXPECT_EQ(read->full->held_out_rms_px, 0.0134);
  EXPECT_EQ(read->date, written.date);
  EXPECT_EQ(read->provenance, written.provenance);
}

TEST(FullCameraFile, AnAbsentNumberIsNull) {
  FullCamera camera = good_camera();
  camera.parameters.focal_px = std::numeric_limits<double>::infinity();
  camera.zoom = camera.held_out_rms_px = std::nullopt;
  const std::string text = camera_calibration_text(calibration_of(camera, 640, 480));
  EXPECT_THAT(text, HasSubstr("\"focal_px\": null"));
  EXPECT_THAT(text, HasSubstr("\"zoom\": null"));
  const auto read = parse(text);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_TRUE(std::isinf(read->full->parameters.focal_px));
  EXPECT_FALSE(read->full->zoom);
  EXPECT_FALSE(read->full->held_out_rms_px);
}

TEST(FullCameraFile, KeepsTheSimplePartForSearching) {
  const auto read = parse(camera_calibration_text(good()));
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_TRUE(read->needs_model());
  EXPECT_EQ(read->parameters.scale_mm_per_px, 0.0101);
  EXPECT_EQ(read->parameters.k1_per_px2, 1.6e-8);
  EXPECT_EQ(read->covariance(4, 0), -9e-18);
  FullCamera flat;
  flat.parameters = test::straight_camera();
  EXPECT_FALSE(calibration_of(flat, 640, 480).needs_model());
}

TEST(FullCameraFile, RefusesWhatIsNoCamera) {
  const auto refuse =
      [](const std::string& old_text, const std::string& new_text, const std::string& part) {
        EXPECT_THAT(parse(text_with(old_text, new_text)), FailsWith(Code::CalibrationInvalid, part))
            << new_text;
      };
  refuse("\"tangential\"", "\"bent\"", "tilted-radial");
  refuse("\"version\": 2", "\"version\": 3", "version");
  refuse("\"version\": 2", "\"version\": 1", "key");
  refuse("\"p2_per_px\"", "\"p3_per_px\"", "p3_per_px");
  refuse("\"tilt y\"", "\"tilt z\"", "undetermined");
  refuse("\"tilt y\"", "\"p1\"", "undetermined");
  refuse("[\"p1\", \"tilt y\"]", "\"p1\"", "undetermined");
  refuse("\"zoom\": 3", "\"zoom\": \"3\"", "zoom");
  refuse("\"rms_px\": 0.0121", "\"rms_px\": -1", "rms");
  refuse("\"focal_px\": 5000", "\"focal_px\": 0", "focal");
  refuse("\"scale_mm_per_px\": 0.0101", "\"scale_mm_per_px\": -0.0101", "scale");
  refuse("[640, 480]", "[640, 0]", "picture_px");
  refuse("\"tilt\": [0.03, -0.018]", "\"tilt\": [0.03]", "tilt");
}

TEST(FullCameraFile, RefusesALensOrTiltThatDoesNotSeeTheWholePicture) {
  // p1 bends as strongly as the picture is wide; q . w reaches the focal length; k1 folds by
  // itself.
  EXPECT_THAT(parse(text_with("\"p1_per_px\": 5e-07", "\"p1_per_px\": 0.003")),
              FailsWith(Code::CalibrationInvalid));
  EXPECT_THAT(parse(text_with("\"focal_px\": 5000", "\"focal_px\": 9")),
              FailsWith(Code::CalibrationInvalid));
  EXPECT_THAT(parse(text_with("\"k1_per_px2\": 1.6e-08", "\"k1_per_px2\": -3e-06")),
              FailsWith(Code::CalibrationInvalid));
}

TEST(FullCameraFile, RefusesWhatIsNoCovariance) {
  CameraCalibration c = good();
  c.full->covariance(0, 4) = 9e-18;
  EXPECT_THAT(parse(camera_calibration_text(c)), FailsWith(Code::CalibrationInvalid, "symmetric"));
  c = good();
  c.full->covariance(7, 7) = -1e-14;
  EXPECT_THAT(parse(camera_calibration_text(c)),
              FailsWith(Code::CalibrationInvalid, "positive semidefinite"));
  c = good();
  c.full->covariance.row(5).setZero();
  c.full->covariance.col(5).setZero();
  EXPECT_TRUE(parse(camera_calibration_text(c))) << "a parameter may be held";
}

TEST(FullCameraFile, IsNotWrittenUnlessItCouldBeRead) {
  const auto path = std::filesystem::path(testing::TempDir()) / "full_camera_refused.cal.json";
  CameraCalibration c = good();
  c.full->parameters.p2_per_px = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(write_camera_calibration(path, c), FailsWith(Code::CalibrationInvalid, "finite"));
  c = good();
  c.full->held_out_rms_px = std::numeric_limits<double>::infinity();
  EXPECT_THAT(write_camera_calibration(path, c), FailsWith(Code::CalibrationInvalid, "rms"));
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(FullCameraFile, AnswersAnyBytes) {
  // 3000 damaged files: never an exception or a crash.
  Random random(82);
  const std::string text = camera_calibration_text(good());
  int n_read = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    std::string damaged = text;
    for (int i = 0; i < 1 + trial % 4; ++i) {
      const auto at =
          static_cast<std::size_t>(random.uniform() * static_cast<double>(damaged.size()));
      if (trial % 3 == 0) damaged[at] = static_cast<char>(static_cast<int>(random.uniform(0, 256)));
      if (trial % 3 == 1) damaged.erase(at, 1 + static_cast<std::size_t>(random.uniform(0, 20)));
      if (trial % 3 == 2) damaged.insert(at, 1, damaged[damaged.size() - 1 - at]);
    }
    if (parse(damaged)) ++n_read;
  }
  EXPECT_GT(n_read, 10);
  EXPECT_LT(n_read, 1500);
}

}  // namespace
}  // namespace panelcal
