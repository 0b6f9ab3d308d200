// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/exchange/lens.h"

#include <algorithm>
#include <string>

#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

#include "tests/fuzz/changed_bytes.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

const std::string kOpenCv =
    "%YAML:1.0\n---\ncalibration_time: \"Sat 28 Nov 2026\"\nimage_width: 640\nimage_height: 480\n"
    "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
    "   data: [ 8.00e+02, 0., 320.5, 0., 800., 239.25, 0.,\n       0., 1. ]\n"
    "distortion_coefficients: !!opencv-matrix\n   rows: 5\n   cols: 1\n   dt: d\n"
    "   data: [ -0.1, 0.02, 0.001, -0.002, 0.003 ]\n";
const std::string kRos =
    "image_width: 640\nimage_height: 480\ncamera_name: narrow\ncamera_matrix:\n  rows: 3\n  cols: "
    "3\n"
    "  data: [800, 0, 320.5, 0, 800, 239.25, 0, 0, 1]\ndistortion_model: plumb_bob\n"
    "distortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.1, 0.02, 0.001, -0.002, 0.003]\n"
    "rectification_matrix:\n  rows: 3\n  cols: 3\n  data: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n";
const std::string kRosMessage =
    "header: \n  seq: 1\n  frame_id: \"camera\"\nheight: 480\nwidth: 640\ndistortion_model: "
    "\"plumb_bob\"\n"
    "D: [-0.1, 0.02, 0.001, -0.002, 0.003]\nK:\n- 800.0\n- 0.0\n- 320.5\n- 0.0\n- 800.0\n- "
    "239.25\n- 0.0\n- 0.0\n- 1.0\n"
    "roi: \n  x_offset: 0\n";
const std::string kMrcal =
    "# made by a test\n{\n    'lensmodel':  'LENSMODEL_OPENCV5',\n\n    # fx, fy, cx, cy and so "
    "on\n"
    "    'intrinsics': [ 800., 800, 320.5, 239.25, -0.1,\n  0.02, 0.001, -0.002, 0.003, ],\n"
    "    'valid_intrinsics_region': [\n [ 0, 0 ],\n [ 600, 0 ], ],\n    'extrinsics': [ "
    "0,0,0,0,0,0 ],\n"
    "    'imagersize': [ 640, 480,],\n    'optimization_inputs': b'a:{b,c}]',\n}\n";

void is_the_lens(const std::string& text, LensFormat format) {
  const auto found = parse_lens(text, "lens");
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_EQ(found->format, format);
  EXPECT_EQ(found->width_px, 640);
  EXPECT_EQ(found->height_px, 480);
  EXPECT_EQ(found->focal_px, Eigen::Vector2d(800, 800));
  EXPECT_EQ(found->center_px, Eigen::Vector2d(320.5, 239.25));
  EXPECT_EQ(found->k1, -0.1);
  EXPECT_EQ(found->k2, 0.02);
  EXPECT_EQ(found->p1, 0.001);
  EXPECT_EQ(found->p2, -0.002);
  EXPECT_EQ(found->k3, 0.003);
}

TEST(Lens, IsReadFromEachFormat) {
  is_the_lens(kOpenCv, LensFormat::OpenCvYaml);
  is_the_lens(kRos, LensFormat::RosCameraInfo);
  is_the_lens(kRosMessage, LensFormat::RosCameraInfo);
  is_the_lens(kMrcal, LensFormat::MrcalCameraModel);
}

TEST(Lens, ReadsBackWhatItWrites) {
  for (const LensFormat format :
       {LensFormat::OpenCvYaml, LensFormat::RosCameraInfo, LensFormat::MrcalCameraModel}) {
    Lens lens = *parse_lens(kMrcal, "lens");
    lens.format = format;
    is_the_lens(lens_text(lens, "a comment: with {braces}"), format);
  }
}

TEST(Lens, WritesNumbersThatYamlTakesForNumbers) {
  Lens lens = *parse_lens(kRos, "lens");
  lens.k2 = 1e-5;
  EXPECT_NE(lens_text(lens, "").find("data: [-0.1, 1.0e-05, 0.001, "), std::string::npos);
  EXPECT_NE(lens_text(lens, "").find("data: [800.0, 0.0, 320.5, "), std::string::npos);
}

std::string with(std::string text, const std::string& old, const std::string& other) {
  return text.replace(text.find(old), old.size(), other);
}

TEST(Lens, RefusesOtherModelsByTheirName) {
  const auto refused = [](const std::string& text, const char* message) {
    EXPECT_THAT(parse_lens(text, "lens"), FailsWith(Code::MeasurementFile, message));
  };
  refused(with(kMrcal, "LENSMODEL_OPENCV5", "LENSMODEL_CAHVOR"), "lens:3:5: ");
  refused(with(kMrcal, "LENSMODEL_OPENCV5", "LENSMODEL_SPLINED_STEREOGRAPHIC_order=3"), "SPLINED");
  refused(with(kRos, "plumb_bob", "equidistant"), "lens:8:1: ");
  refused(kOpenCv + "fisheye_model: 1\n", "fisheye");
  refused(with(kRos, "0.003]", "0.003, 0.5, 0, 0]"), "k4 = 0.5");
  EXPECT_TRUE(parse_lens(with(kRos, "0.003]", "0.003, 0, 0, 0]"), "lens"));
  refused(with(kRos, "[800, 0, 320.5", "[800, 3, 320.5"), "skew");
}

TEST(Lens, RefusesWhatIsNotWhole) {
  const auto refused = [](const std::string& text, const char* message) {
    EXPECT_THAT(parse_lens(text, "lens"), FailsWith(Code::MeasurementFile, message));
  };
  refused("hello\n", "lens:1:1: ");
  refused(with(kRos, "image_width: 640\n", ""), "image_width");
  refused(with(kRos, "image_width: 640", "image_width: 0"), "lens:1:1: ");
  refused(kRos + "image_width: 640\n", "lens:17:1: ");
  refused(with(kRos, "[800,", "[nan,"), "\"nan\"");
  refused(with(kRos, "[800,", "[-800,"), "above 0");
  refused(with(kRos, ", 0.003]", "]").replace(0, 0, "\xEF\xBB\xBF") + "x", "a key");
  refused(with(kRos, "-0.002, 0.003]", "-0.002, 0.003, 1]"), "6 distortion");
  refused(with(kMrcal, "0.02, ", ""), "8 intrinsics");
  refused(with(kMrcal, "[ 640, 480,]", "[ 640.5, 480,]"), "imagersize");
  refused(kMrcal.substr(0, kMrcal.size() - 3), "lens:");
}

TEST(Lens, AnyBytesGiveAValueOrADiagnostic) {
  constexpr int kChanged = 1000;
  Random random(25);
  for (const std::string& text : {kOpenCv, kRos, kRosMessage, kMrcal}) {
    for (int i = 0; i < kChanged; ++i) {
      const std::string other = fuzz::changed(random, text);
      const auto found = parse_lens(other, "lens");
      if (found) {
        EXPECT_GT(found->focal_px.minCoeff(), 0) << other;
        EXPECT_GE(std::min(found->width_px, found->height_px), 1) << other;
      } else {
        EXPECT_EQ(found.error().code, Code::MeasurementFile) << other;
        EXPECT_FALSE(found.error().what.empty()) << other;
      }
    }
  }
}

}  // namespace
}  // namespace panelcal
