// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <memory>

#include "vision/locate/locate.h"
#include <gtest/gtest.h>

#include "tests/vision/template/trial.h"

namespace panelcal::test {
namespace {

constexpr double kLevel = 210.0 / 255;

TemplateTrial one_trial(TemplateTrialOptions options = {}) {
  Random random(11);
  return draw_template_trial(options, random);
}

Detection locate(const TemplateTrial& trial, const LocateOptions& options = {}) {
  return panelcal::locate(trial.image, trial.target, &trial.camera.mapping, options);
}

/// Paints the trial's picture again from a changed scene.
Detection locate_in(const Scene& scene, const TemplateTrial& trial) {
  Random random(12);
  return panelcal::locate(render(scene, trial.camera, random), trial.target, &trial.camera.mapping);
}

void expect_near(const Detection& d, const Eigen::Vector2d& truth_px, double tolerance_px) {
  ASSERT_EQ(d.status, DetectionStatus::Found) << d.reason;
  EXPECT_LT((d.best->center.position.in_px() - truth_px).norm(), tolerance_px);
}

/// Ten sigmas of a clean fit.
constexpr double kNearPx = 0.04;

TEST(TemplateDetector, FillsWhatItFound) {
  const TemplateTrial trial = one_trial();
  const Detection d = locate(trial);
  expect_near(d, trial.pose.center_px, kNearPx);
  const TargetFit& fit = *d.best;
  EXPECT_NEAR(fit.angle.in_rad(), trial.pose.turn, 0.002);
  EXPECT_GT(fit.angle_sigma.in_rad(), 0);
  EXPECT_LT(fit.angle_sigma.in_rad(), 0.001);
  ASSERT_TRUE(fit.size_mm);
  EXPECT_NEAR(fit.size_mm->in_mm(), trial.target.size->in_mm(), 0.002);
  EXPECT_GT(fit.score, 0.98);
  EXPECT_GT(fit.visible, 0.99);
  EXPECT_NEAR(fit.background, 70, 3);
  // Picture and template have the noise 2 both.
  EXPECT_NEAR(fit.noise, std::sqrt(8), 0.4);
  EXPECT_EQ(fit.outlines_px.size(), 1u);
  ASSERT_TRUE(fit.center_optical);
  const auto back = trial.camera.mapping(fit.center.position);
  EXPECT_LT((back - fit.center_optical->position).in_mm().norm(), 1e-9);
}

TEST(TemplateDetector, SeesAllAnglesIfAsked) {
  TemplateTrialOptions options;
  for (const double turn : {35.0, 120.0, -160.0}) {
    TemplateTrial trial = one_trial(options);
    trial.target.angle_tolerance = deg(180);
    trial.pose.turn = deg(turn).in_rad();
    trial.scene.features = mark(trial.camera, trial.pose, kLevel);
    const Detection d = locate_in(trial.scene, trial);
    expect_near(d, trial.pose.center_px, kNearPx);
    EXPECT_NEAR(d.best->angle.in_deg(), turn, 0.1);
  }
}

TEST(TemplateDetector, RejectsTurnBeyondTheTolerance) {
  TemplateTrial trial = one_trial();
  trial.target.angle_tolerance = deg(2);
  trial.pose.turn = deg(4).in_rad();
  trial.scene.features = mark(trial.camera, trial.pose, kLevel);
  const Detection d = locate_in(trial.scene, trial);
  EXPECT_EQ(d.status, DetectionStatus::Rejected) << d.reason;
  EXPECT_NE(d.reason.find("it is turned by +4.0"), std::string::npos) << d.reason;
}

TEST(TemplateDetector, RejectsSizeBeyondTheTolerance) {
  TemplateTrialOptions options;
  options.size_change = 0.05;
  TemplateTrial trial = one_trial(options);
  trial.target.size_tolerance = 0.03;
  const Detection d = locate(trial);
  EXPECT_EQ(d.status, DetectionStatus::Rejected) << d.reason;
  EXPECT_NE(d.reason.find("+5.0 % from 0.92; 3.0 % are allowed"), std::string::npos) << d.reason;
  trial.target.size_tolerance = 0.08;
  expect_near(locate(trial), trial.pose.center_px, kNearPx);
}

TEST(TemplateDetector, NegativeIsFoundOnlyIfItIsAskedFor) {
  TemplateTrial trial = one_trial();
  for (float& v : trial.image.pixels()) v = 255 - v;
  EXPECT_EQ(locate(trial).status, DetectionStatus::NotFound);
  trial.target.polarity = Polarity::Dark;
  const Detection d = locate(trial);
  expect_near(d, trial.pose.center_px, kNearPx);
  EXPECT_LT(d.best->contrast, 0);
}

TEST(TemplateDetector, TwoMarksAreAmbiguous) {
  TemplateTrialOptions options;
  TemplateTrial trial = one_trial(options);
  Camera camera = trial.camera;
  camera.width = 320;
  trial.camera = camera;
  const MarkPose left{{60, 80}, 0, 1};
  const MarkPose right{{200.3, 90.7}, 0, 1};
  trial.scene.features = mark(camera, left, kLevel);
  const auto more = mark(camera, right, kLevel);
  trial.scene.features.insert(trial.scene.features.end(), more.begin(), more.end());
  const Detection d = locate_in(trial.scene, trial);
  EXPECT_EQ(d.status, DetectionStatus::Ambiguous) << d.reason;
  EXPECT_EQ(d.n_candidates, 2);
  // A search area that holds one of them decides.
  LocateOptions near;
  near.search_center = position_px<frame::Image>(right.center_px);
  near.search_radius = px(20);
  Random random(12);
  expect_near(
      panelcal::locate(render(trial.scene, camera, random), trial.target, &camera.mapping, near),
      right.center_px,
      kNearPx);
}

TEST(TemplateDetector, OtherMarksAreNotFound) {
  const TemplateTrial trial = one_trial();
  // The mark without its long bar, without its ring, with a disc for the ring; a mirror image.
  for (int kind = 0; kind < 4; ++kind) {
    Scene scene = trial.scene;
    auto& features = scene.features;
    if (kind == 0) features.erase(features.begin() + 2);
    if (kind == 1) features.erase(features.begin());
    if (kind == 2) features[0].shape = Feature::Shape::Rectangle;
    if (kind == 3) {
      const double middle_mm =
          trial.camera.mapping(position_px<frame::Image>(trial.pose.center_px)).in_mm().x();
      for (Feature& feature : features) {
        const Eigen::Vector2d at = feature.center.in_mm();
        feature.center =
            position_mm<frame::Optical>(Eigen::Vector2d(2 * middle_mm - at.x(), at.y()));
        feature.angle = -feature.angle;
      }
    }
    const Detection d = locate_in(scene, trial);
    EXPECT_NE(d.status, DetectionStatus::Found) << kind;
    EXPECT_NE(d.status, DetectionStatus::Ambiguous) << kind;
  }
  Scene empty = trial.scene;
  empty.features.clear();
  EXPECT_EQ(locate_in(empty, trial).status, DetectionStatus::NotFound);
}

TEST(TemplateDetector, RejectsMarksAtTheBorder) {
  TemplateTrial trial = one_trial();
  trial.pose = {{38, 100}, 0, 1};
  trial.scene.features = mark(trial.camera, trial.pose, kLevel);
  const Detection d = locate_in(trial.scene, trial);
  EXPECT_EQ(d.status, DetectionStatus::Rejected) << d.reason;
  EXPECT_NE(d.reason.find("at the border"), std::string::npos) << d.reason;
}

TEST(TemplateDetector, ReferenceMayBeAnywhere) {
  TemplateTrial trial = one_trial();
  auto picture = std::make_shared<TemplatePicture>(*trial.target.picture);
  const Eigen::Vector2d shift(60, -20);  // px of the template, outside of it
  picture->reference_px += shift;
  trial.target.picture = picture;
  const Detection d = locate(trial);
  // y points down in pictures, turns are counted in Optical.
  const double c = std::cos(-trial.pose.turn);
  const double s = std::sin(-trial.pose.turn);
  const Eigen::Vector2d moved(c * shift.x() - s * shift.y(), s * shift.x() + c * shift.y());
  expect_near(d, trial.pose.center_px + moved, 2 * kNearPx);
  // The lever of the angle's uncertainty.
  EXPECT_GT(d.best->center.cov.trace(), locate(one_trial()).best->center.cov.trace());
}

/// A finer template: twice the pixels of the same mark.
TEST(TemplateDetector, TemplateMayBeFinerThanThePicture) {
  TemplateTrial trial = one_trial();
  CameraMapping::Parameters parameters = trial.camera.mapping.parameters();
  parameters.scale_mm_per_px *= 0.4;
  parameters.axis_px << 115, 105;
  Camera fine{CameraMapping(parameters), 231, 211};
  fine.blur_px = 2.5;
  fine.noise = 2;
  Scene scene;
  scene.background = 70.0 / 255;
  const MarkPose pose{{115.3, 104.8}, 0, 1};
  scene.features = mark(fine, pose, kLevel);
  Random random(5);
  trial.target.picture = std::make_shared<TemplatePicture>(
      TemplatePicture{"fine.png", render(scene, fine, random), pose.center_px});
  trial.target.size = mm(231 * parameters.scale_mm_per_px);
  expect_near(locate(trial), trial.pose.center_px, kNearPx);
}

TEST(TemplateDetector, RefusesTemplatesWithoutStructure) {
  TemplateTrial trial = one_trial();
  const auto reason_with = [&](const Image& image) {
    trial.target.picture =
        std::make_shared<TemplatePicture>(TemplatePicture{"t.png", image, {30, 20}});
    trial.target.size = mm(image.width() * 0.01);
    const Detection d = locate(trial);
    EXPECT_EQ(d.status, DetectionStatus::Rejected);
    return d.reason;
  };
  Image flat(60, 40, 255, 90);
  EXPECT_EQ(reason_with(flat).find("the template t.png will not do: its levels differ by"), 0u);
  Random random(3);
  for (float& v : flat.pixels()) v = static_cast<float>(std::round(90 + 5 * random.normal()));
  EXPECT_NE(reason_with(flat).find("as good as flat"), std::string::npos);
  Image stripes(60, 40, 255, 90);
  for (int y = 0; y < 40; ++y) {
    for (int x = 20; x < 40; ++x) stripes.at(x, y) = 200;
  }
  EXPECT_NE(reason_with(stripes).find("parallel edges only"), std::string::npos);
  for (float& v : stripes.pixels()) v += static_cast<float>(std::round(5 * random.normal()));
  EXPECT_NE(reason_with(stripes).find("parallel edges only"), std::string::npos);
  EXPECT_NE(reason_with(Image(5, 40, 255, 90)).find("it has 5 x 40 px"), std::string::npos);
  EXPECT_NE(reason_with(Image(5000, 4000, 255, 90)).find("larger than the picture"),
            std::string::npos);
  Image hole(60, 40, 255, 90);
  hole.at(3, 3) = std::nanf("");
  EXPECT_NE(reason_with(hole).find("no numbers"), std::string::npos);
}

}  // namespace
}  // namespace panelcal::test
