// SPDX-License-Identifier: Apache-2.0
#include "vision/show/overlay.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "vision/picture/files/image_io.h"
#include "vision/render/scene_marks.h"
#include "vision/show/overlay_legend.h"
#include <gtest/gtest.h>

#include "tests/vision/trial.h"

namespace panelcal::test {
namespace {

using internal::Ink;
using internal::legend_of;
using internal::LegendLine;

/// A level that nothing in the pictures here has, so that whatever differs was drawn.
constexpr double kGround = 30000;

Target disc_target(double diameter_px = 40) {
  Target target;
  target.size_px = px(diameter_px);
  return target;
}

Image picture_of(const std::vector<Feature>& features, const Camera& camera) {
  Scene scene;
  scene.features = features;
  Random random(1);
  return render(scene, camera, random);
}

Image disc_picture(const Camera& camera) {
  return picture_of({disc_at(camera, 70, 50, 20, 0.7)}, camera);
}

Image decoded(const Expected<std::string>& png) {
  EXPECT_TRUE(png.has_value()) << png.error().text();
  const auto read = decode_image(*png, "overlay");
  EXPECT_TRUE(read.has_value()) << read.error().text();
  return *read;
}

bool has_line(const std::vector<LegendLine>& lines, std::string_view part) {
  return std::ranges::any_of(
      lines, [&](const LegendLine& line) { return line.text.find(part) != std::string::npos; });
}

/// Number of pixels that are drawn on, of a row or column of a picture of one level.
int n_drawn(const Image& overlay, int x0, int y0, int x1, int y1) {
  const float ground = overlay.at(0, 0);
  int n = 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) n += std::abs(overlay.at(x, y) - ground) > 5;
  }
  return n;
}

TEST(Overlay, ShowsTheTargetEnlarged) {
  const Image image = disc_picture(plain_camera(200, 120));
  const Detection detection = locate(image, disc_target());
  ASSERT_EQ(detection.status, DetectionStatus::Found);
  const Image overlay =
      decoded(encode_overlay(image, detection, {.half_width = px(30), .with_legend = false}));
  EXPECT_EQ(overlay.width(), 61 * 7);
  EXPECT_EQ(overlay.height(), 61 * 7);
}

TEST(Overlay, TheLegendIsUnderThePicture) {
  const Image image = disc_picture(plain_camera(200, 120));
  const Detection detection = locate(image, disc_target());
  const Image bare =
      decoded(encode_overlay(image, detection, {.half_width = px(30), .with_legend = false}));
  const Image overlay = decoded(encode_overlay(image, detection, {.half_width = px(30)}));
  EXPECT_EQ(overlay.width(), bare.width());
  ASSERT_GT(overlay.height(), bare.height() + 150);
  for (int y = 0; y < bare.height(); ++y) {
    ASSERT_TRUE(std::ranges::equal(bare.row(y), overlay.row(y))) << y;
  }
}

TEST(Overlay, DrawsOutlinesWhereTheyAre) {
  // Two edges of a slot: they are lines, not polygons.
  Detection detection;
  detection.status = DetectionStatus::Found;
  TargetFit& fit = detection.best.emplace();
  fit.center.position = position_px(50, 50);
  fit.center.cov.setIdentity();
  fit.size = px(20);
  fit.outlines_px = {{{0, 40}, {99, 40}}, {{0, 60}, {99, 60}}};
  const Image image(100, 100, 65535, kGround);
  const Image overlay = decoded(encode_overlay(
      image, detection, {.half_width = px(50), .min_side = 1, .with_legend = false}));
  ASSERT_EQ(overlay.width(), 100);
  // Pixel centres stay pixel centres: all that is drawn of an edge is in its row.
  EXPECT_EQ(n_drawn(overlay, 1, 40, 100, 41), 99);
  EXPECT_EQ(n_drawn(overlay, 1, 60, 100, 61), 99);
  EXPECT_EQ(n_drawn(overlay, 1, 1, 100, 38), 0);
  EXPECT_EQ(n_drawn(overlay, 1, 63, 100, 100), 0);
  // Between them only the cross at the centre, which lies on both axes.
  EXPECT_GT(n_drawn(overlay, 40, 50, 61, 51), 10);
  EXPECT_EQ(n_drawn(overlay, 1, 43, 40, 58), 0);
}

TEST(Overlay, ShowsTheWholePictureIfNothingWasFound) {
  const Image image(400, 350, 65535, kGround);
  const Image overlay = decoded(encode_overlay(image, Detection{}, {.with_legend = false}));
  EXPECT_EQ(overlay.width(), 400);
  EXPECT_EQ(overlay.height(), 350);
  EXPECT_EQ(n_drawn(overlay, 0, 0, 400, 350), 0);
}

TEST(Overlay, AHugePictureIsScaledDown) {
  const Image image(6000, 30, 255, 90);
  const Image overlay = decoded(encode_overlay(image, Detection{}, {.with_legend = false}));
  EXPECT_EQ(overlay.width(), 2048);
  EXPECT_EQ(overlay.height(), 10);
}

TEST(Overlay, ShowsWhereWasSearched) {
  const Image image(200, 200, 255, 90);
  const OverlayOptions options{.min_side = 1,
                               .with_legend = false,
                               .search_center = position_px(100, 100),
                               .search_radius = px(50)};
  const Image overlay = decoded(encode_overlay(image, Detection{}, options));
  EXPECT_GT(n_drawn(overlay, 149, 90, 152, 110), 10);
  EXPECT_EQ(n_drawn(overlay, 60, 95, 140, 105), 0);
}

TEST(Overlay, EquallyGoodCandidatesAreBothShownAndListed) {
  const Camera camera = plain_camera(300, 150);
  const Image image =
      picture_of({disc_at(camera, 60, 70, 20, 0.7), disc_at(camera, 240, 80, 20, 0.7)}, camera);
  const Detection detection = locate(image, disc_target());
  ASSERT_EQ(detection.status, DetectionStatus::Ambiguous);
  ASSERT_EQ(other_candidates(detection).size(), 2U);
  const internal::Legend legend = legend_of(detection, "");
  ASSERT_EQ(legend.candidates.size(), 2U);
  EXPECT_EQ(legend.candidates[0].ink, Ink::Bad);
  EXPECT_EQ(legend.candidates[1].ink, Ink::Other);
  EXPECT_TRUE(has_line(legend.verdict, "ambiguous: 2 candidates are equally good"));
  // Wide enough for the one at the other end.
  const Image overlay =
      decoded(encode_overlay(image, detection, {.min_side = 1, .with_legend = false}));
  EXPECT_GT(overlay.width(), 200);
}

TEST(Overlay, SaysWhyACandidateDoesNotCount) {
  const Camera camera = plain_camera(200, 120);
  const Image image = disc_picture(camera);
  const Detection detection = locate(image, disc_target(43));
  ASSERT_EQ(detection.status, DetectionStatus::Rejected);
  ASSERT_EQ(other_candidates(detection).size(), detection.candidates.size());
  const internal::Legend legend = legend_of(detection, "a title");
  EXPECT_EQ(legend.verdict.front().text, "a title");
  EXPECT_EQ(legend.verdict.back().ink, Ink::Bad);
  EXPECT_TRUE(has_line(legend.candidates, "1  at 70.0, 50.0, size 40.0 px"))
      << legend.candidates.front().text;
  EXPECT_TRUE(has_line(legend.candidates, detection.reason));
}

TEST(Overlay, TheOneFoundIsNotAmongTheOthers) {
  const Image image = disc_picture(plain_camera(200, 120));
  const Detection detection = locate(image, disc_target());
  ASSERT_EQ(detection.status, DetectionStatus::Found);
  EXPECT_EQ(other_candidates(detection).size(), detection.candidates.size() - 1);
  const internal::Legend legend = legend_of(detection, "");
  EXPECT_EQ(legend.verdict.front().text, "found");
  EXPECT_TRUE(has_line(legend.facts, "centre 7")) << legend.facts.front().text;
  EXPECT_TRUE(has_line(legend.facts, "100 % of the rim seen"));
}

TEST(Overlay, TagsHaveNumberAndCorners) {
  const Camera camera = plain_camera(240, 240);
  Target target;
  target.shape = Shape::AprilTag;
  target.size_px = px(120);
  MarkLook look;
  look.center = position_mm<frame::Optical>(Eigen::Vector2d(0.03, 0.05));
  Camera noisy = camera;
  noisy.noise = 2;
  const Image image = picture_of(mark_features(target, look, camera.mapping), noisy);
  const Detection detection = locate(image, target);
  ASSERT_EQ(detection.status, DetectionStatus::Found) << detection.reason;
  const internal::Legend legend = legend_of(detection, "");
  EXPECT_TRUE(has_line(legend.facts, "id 0"));
  EXPECT_TRUE(has_line(legend.facts, "corner 3: "));
}

TEST(Overlay, SlotsSayWhatWasNotMeasured) {
  Detection detection;
  detection.status = DetectionStatus::Found;
  TargetFit& fit = detection.best.emplace();
  fit.center.cov = Eigen::Vector2d(40.0 * 40.0, 0.01 * 0.01).asDiagonal();
  fit.blind_direction = deg(0);
  const internal::Legend legend = legend_of(detection, "");
  EXPECT_TRUE(has_line(legend.facts, "sigma across 0.01 px"));
  EXPECT_TRUE(has_line(legend.facts, "nothing measured along 0.00 deg"));
}

TEST(Overlay, TheEllipseHoldsNineteenOfTwenty) {
  // In two dimensions a share 1 - exp(-k^2 / 2) lies within k sigma.
  const double k = std::sqrt(-2 * std::log(0.05));
  Eigen::Matrix2d cov;
  cov << 4, 0, 0, 9;
  const auto ellipse = internal::uncertainty_ellipse(cov);
  EXPECT_NEAR(ellipse.major_px.norm(), 3 * k, 1e-6);
  EXPECT_NEAR(ellipse.minor_px.norm(), 2 * k, 1e-6);
  EXPECT_NEAR(std::abs(ellipse.major_px.y()), 3 * k, 1e-6);
}

TEST(Overlay, ScaleBarsAreRoundLengths) {
  EXPECT_DOUBLE_EQ(internal::round_length(0.0049), 0.002);
  EXPECT_DOUBLE_EQ(internal::round_length(0.0051), 0.005);
  EXPECT_DOUBLE_EQ(internal::round_length(19), 10);
}

TEST(Overlay, ManyCandidatesDoNotMakeAnEndlessLegend) {
  Detection detection;
  detection.candidates.resize(1000);
  for (Candidate& c : detection.candidates) c.reason = "too small";
  const internal::Legend legend = legend_of(detection, "");
  EXPECT_LT(legend.candidates.size(), 20U);
  EXPECT_TRUE(has_line(legend.candidates, "and 988 more"));
}

TEST(Overlay, OddCasesAreNoTrouble) {
  EXPECT_FALSE(encode_overlay(Image(), Detection{}).has_value());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double odd : {1e12, -1e300, nan}) {
    Detection detection;
    detection.reason = std::string(5000, 'x');
    detection.best.emplace();
    detection.best->center.position = position_px(odd, -1e12);
    detection.best->center.cov.setConstant(odd);
    detection.best->size = px(1e9);
    detection.best->outlines_px = {{}, {{odd, odd}}, {{0, 0}, {odd, 1}, {1e9, 1e9}}};
    detection.candidates.resize(2);
    detection.candidates[0].center = position_px(odd, odd);
    detection.candidates[1].size = px(odd);
    EXPECT_TRUE(encode_overlay(Image(1, 1, 255, 9), detection).has_value()) << odd;
    OverlayOptions options;
    options.half_width = px(odd);
    options.min_side = -5;
    options.title = "\xff\xfe title";
    EXPECT_TRUE(encode_overlay(Image(30, 3, 255, 9), detection, options).has_value()) << odd;
  }
}

}  // namespace
}  // namespace panelcal::test
