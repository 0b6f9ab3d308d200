// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/rim_profile.h"

#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/vision/trial.h"

namespace panelcal::internal {
namespace {

constexpr int kProfileSide = 200;
constexpr double kProfileRadius_px = 40;
constexpr double kProfileNoise = 4;
constexpr double kFewSigmas = 4;
const Eigen::Vector2d kProfileCenter(99.3, 100.8);

Image scene_of(std::vector<Feature> features, double weave) {
  Camera camera = test::plain_camera(kProfileSide, kProfileSide);
  camera.noise = kProfileNoise;
  Scene scene;
  scene.background = 80.0 / 255;
  scene.weave.amplitude = weave / 255;
  scene.features = std::move(features);
  Random random(1);
  return render(scene, camera, random);
}

Image disc_among(std::vector<Feature> others, double weave = 0) {
  const Camera camera = test::plain_camera(kProfileSide, kProfileSide);
  others.insert(
      others.begin(),
      test::disc_at(
          camera, kProfileCenter.x(), kProfileCenter.y(), kProfileRadius_px, 180.0 / 255));
  return scene_of(std::move(others), weave);
}

RimSearch search_from(const Eigen::Vector2d& off_px, double radius_px) {
  RimSearch search;
  search.start.head<2>() = off_px;
  search.start[kRadius] = radius_px;
  search.start[kSigma] = 1.2;
  search.least_contrast = 20;
  return search;
}

std::optional<RimProfile> measured(const Image& image, const RimSearch& search) {
  RimWindow window(image, FitFrame(nullptr, kProfileCenter), search.start, 34, false);
  return measure_rim(window, search);
}

double error_in_sigmas(const RimProfile& rim) {
  const Eigen::Vector2d error = rim.parameters.head<2>();
  return std::sqrt(error.dot(rim.center_cov.inverse() * error));
}

TEST(RimProfile, MeasuresAPlainDisc) {
  const auto rim = measured(disc_among({}), search_from({1, -0.5}, 40.7));
  ASSERT_TRUE(rim);
  EXPECT_TRUE(rim->is_settled);
  EXPECT_LT(error_in_sigmas(*rim), kFewSigmas);
  // Cramer and Rao: noise / contrast sqrt(2 s / (sqrt(pi) R)), times what own waves may hide.
  const double bound_px =
      kProfileNoise / 100 *
      std::sqrt(2 * std::hypot(1, 0.3) / (std::sqrt(std::numbers::pi) * kProfileRadius_px));
  EXPECT_LT(rim->parameters.head<2>().norm(), kFewSigmas * bound_px);
  EXPECT_LT(std::sqrt(rim->center_cov(0, 0)), 4 * bound_px);
  EXPECT_NEAR(rim->parameters[kRadius], kProfileRadius_px, 0.05);
  EXPECT_GT(rim->used, 0.95);
  EXPECT_GT(rim->correlation, 0.95);
  EXPECT_EQ(rim->n_lobes, 0);
}

/// The strip has as many sectors from the first pass to the last, though the radius changes.
TEST(RimProfile, AnswersTheSameFromEveryRadius) {
  const Image image = disc_among({}, 15);
  const auto best = measured(image, search_from({0, 0}, kProfileRadius_px));
  ASSERT_TRUE(best);
  for (const double radius_px : {37.2, 38.9, 41.3, 43.1}) {
    const auto rim = measured(image, search_from({0.4, 0.3}, radius_px));
    ASSERT_TRUE(rim) << radius_px;
    EXPECT_LT((rim->parameters - best->parameters).head<2>().norm(), 0.03) << radius_px;
  }
}

TEST(RimProfile, LeavesOutWhatCoversTheRim) {
  const Camera camera = test::plain_camera(kProfileSide, kProfileSide);
  const Eigen::Vector2d dirt =
      kProfileCenter + kProfileRadius_px * Eigen::Vector2d(std::cos(0.7), std::sin(0.7));
  const auto rim = measured(disc_among({test::disc_at(camera, dirt.x(), dirt.y(), 14, 60.0 / 255)}),
                            search_from(Eigen::Vector2d::Zero(), 40));
  ASSERT_TRUE(rim);
  EXPECT_LT(error_in_sigmas(*rim), kFewSigmas);
  EXPECT_LT(rim->parameters.head<2>().norm(), 0.05);
  EXPECT_NEAR(rim->used, 1 - 2 * 14 / (2 * std::numbers::pi * kProfileRadius_px), 0.08);
}

/// A disc whose edge's slope, `band_px` wide, is lit from the left: brighter there, darker
/// opposite.
Image disc_lit_from_the_left(double band_px, double band_level) {
  constexpr double kBlur_px = 0.9;
  Image image(kProfileSide, kProfileSide, Image::kFullScale8);
  Random random(2);
  const auto share = [](double inside_px) {
    return 0.5 * std::erfc(-inside_px / (kBlur_px * std::numbers::sqrt2));
  };
  for (int y = 0; y < kProfileSide; ++y) {
    for (int x = 0; x < kProfileSide; ++x) {
      const Eigen::Vector2d at = Eigen::Vector2d(x, y) - kProfileCenter;
      const double inside_px = kProfileRadius_px - at.norm();
      const double band = share(inside_px) - share(inside_px - band_px);
      const double towards_lamp = -at.x() / std::max(1.0, at.norm());
      image.row(y)[static_cast<std::size_t>(x)] =
          static_cast<float>(80 + 100 * share(inside_px) + band_level * towards_lamp * band +
                             kProfileNoise * random.normal());
    }
  }
  return image;
}

TEST(RimProfile, SaysWhatASlopeThatIsLitFromOneSideMayHide) {
  for (const double band_level : {-30.0, 30.0}) {
    const auto rim =
        measured(disc_lit_from_the_left(1.5, band_level), search_from({0.5, 0.5}, 40.5));
    ASSERT_TRUE(rim);
    EXPECT_GT(std::abs(rim->parameters[kCenterX]), 0.2) << "there is nothing to be said";
    EXPECT_LT(error_in_sigmas(*rim), kFewSigmas);
    EXPECT_LT(rim->center_cov(1, 1), 0.2 * rim->center_cov(0, 0));
  }
}

constexpr double kPaintedBlur_px = 0.9;

/// A disc with an oval and three waves of its own, whose colours the lens shifts by `colours_px`
/// to either side: a third of the light each, and the green one where the disc is.
Image uneven_disc(double oval_px, double third_px, const Eigen::Vector2d& colours_px) {
  Image image(kProfileSide, kProfileSide, Image::kFullScale8);
  Random random(3);
  for (int y = 0; y < kProfileSide; ++y) {
    for (int x = 0; x < kProfileSide; ++x) {
      double light = 0;
      for (const double side : {-1.0, 0.0, 1.0}) {
        const Eigen::Vector2d at = Eigen::Vector2d(x, y) - kProfileCenter - side * colours_px;
        const double phi = std::atan2(at.y(), at.x());
        const double rim_px =
            kProfileRadius_px + oval_px * std::cos(2 * phi) + third_px * std::sin(3 * phi);
        light +=
            0.5 / 3 * std::erfc((at.norm() - rim_px) / (kPaintedBlur_px * std::numbers::sqrt2));
      }
      image.row(y)[static_cast<std::size_t>(x)] =
          static_cast<float>(80 + 100 * light + kProfileNoise * random.normal());
    }
  }
  return image;
}

TEST(RimProfile, MeasuresAllOfARimOutOfRoundIfItsToleranceIsWide) {
  const Image image = uneven_disc(0.8, 0.3, Eigen::Vector2d::Zero());
  RimSearch search = search_from({0.5, 0.5}, 40.5);
  search.least_used = 0.6;
  const auto arc = measured(image, search);
  ASSERT_TRUE(arc);
  EXPECT_GT(arc->parameters.head<2>().norm(), 0.2) << "an arc must be off, or nothing is tested";
  search.own_shape = 0.05;
  const auto whole = measured(image, search);
  ASSERT_TRUE(whole);
  EXPECT_LT(whole->parameters.head<2>().norm(), 0.05);
  EXPECT_LT(error_in_sigmas(*whole), kFewSigmas);
  EXPECT_GT(whole->used, 0.95);
  EXPECT_NEAR(whole->parameters[kOval], 0.8 / kProfileRadius_px, 0.002);
}

/// The mean edge about a circle would be blurred by the rim's deviations, to 1.1 px here.
TEST(RimProfile, SeesTheEdgeOfARimOutOfRoundAsSharpAsItIs) {
  RimSearch search = search_from({0.2, 0.2}, 40);
  search.own_shape = 0.05;
  const auto rim = measured(uneven_disc(0.8, 0.3, Eigen::Vector2d::Zero()), search);
  ASSERT_TRUE(rim);
  EXPECT_NEAR(rim->parameters[kSigma], kPaintedBlur_px, 0.05);
}

TEST(RimProfile, SaysThatShiftedColoursMayHideAShift) {
  const Eigen::Vector2d along = Eigen::Vector2d(2, 1).normalized();
  const auto sharp = measured(uneven_disc(0, 0, Eigen::Vector2d::Zero()), search_from({0, 0}, 40));
  const auto colours = measured(uneven_disc(0, 0, 1.2 * along), search_from({0, 0}, 40));
  ASSERT_TRUE(sharp && colours);
  const auto sigma_px = [](const RimProfile& rim, const Eigen::Vector2d& direction) {
    return std::sqrt(direction.dot(rim.center_cov * direction));
  };
  // A spread of 2/3 1.2^2 = 0.96 px^2 along, of whose square 0.1^2 are any lens's; a third of it.
  EXPECT_NEAR(sigma_px(*colours, along), std::sqrt(std::sqrt(0.96 * 0.96 - 0.1 * 0.1) / 3), 0.06);
  EXPECT_LT(sigma_px(*colours, {-along.y(), along.x()}), 0.05);
  EXPECT_LT(sigma_px(*sharp, along), 0.05);
}

/// A disc on an uneven board, by a camera that sharpens: blurred by 1.2 px more, the picture's
/// difference from itself is added twice.
Image sharpened_disc() {
  constexpr double kLens_px = 0.65;
  constexpr double kSharpened_px = 1.2;
  constexpr double kAmount = 2;
  const auto share = [](double inside_px, double blur_px) {
    return 0.5 * std::erfc(-inside_px / (blur_px * std::numbers::sqrt2));
  };
  Image image(kProfileSide, kProfileSide, Image::kFullScale8);
  Random random(4);
  for (int y = 0; y < kProfileSide; ++y) {
    for (int x = 0; x < kProfileSide; ++x) {
      const Eigen::Vector2d at = Eigen::Vector2d(x, y) - kProfileCenter;
      const double inside_px = kProfileRadius_px - at.norm();
      const double edge = share(inside_px, kLens_px);
      const double beside = share(inside_px, std::hypot(kLens_px, kSharpened_px));
      const double board = 6 * std::sin(x / 9.0) * std::sin(y / 11.0);
      image.row(y)[static_cast<std::size_t>(x)] = static_cast<float>(
          80 + 100 * (edge + kAmount * (edge - beside)) + board + kProfileNoise * random.normal());
    }
  }
  return image;
}

TEST(RimProfile, ASharpenedEdgesOwnBandsAreNoOtherRings) {
  const auto rim = measured(sharpened_disc(), search_from({0.5, -0.4}, 40.3));
  ASSERT_TRUE(rim);
  EXPECT_TRUE(rim->is_settled);
  EXPECT_LT(rim->parameters.head<2>().norm(), 0.03);
  EXPECT_LT(error_in_sigmas(*rim), kFewSigmas);
  EXPECT_NEAR(rim->parameters[kRadius], kProfileRadius_px, 0.2);
}

TEST(RimProfile, FindsARimThatItsStartIsFarFrom) {
  RimSearch search = search_from({2, -1}, 32);
  const Image image = disc_among({});
  EXPECT_FALSE(measured(image, search));
  search.far = 0.3;
  const auto rim = measured(image, search);
  ASSERT_TRUE(rim);
  EXPECT_TRUE(rim->is_settled);
  EXPECT_NEAR(rim->parameters[kRadius], kProfileRadius_px, 0.1);
  EXPECT_LT(error_in_sigmas(*rim), kFewSigmas);
}

TEST(RimProfile, SeesThatASquareHasFourLobes) {
  for (const double turn_deg : {0.0, 20.0, 45.0}) {
    Feature square;
    square.shape = Feature::Shape::Rectangle;
    square.size = square.inner_size = mm(0.01 * 68);
    square.angle = deg(turn_deg);
    square.level = 180.0 / 255;
    const Camera camera = test::plain_camera(kProfileSide, kProfileSide);
    square.center = camera.mapping(position_px<frame::Image>(kProfileCenter));
    RimSearch search = search_from(Eigen::Vector2d::Zero(), 37);
    const auto rim = measured(scene_of({square}, 15), search);
    ASSERT_TRUE(rim) << turn_deg;
    EXPECT_EQ(rim->n_lobes, 4) << turn_deg;
    EXPECT_GT(rim->lobes, LocateOptions{}.max_lobes) << turn_deg;
  }
}

TEST(RimProfile, FindsNoStepOfTheOtherSignNorInNoise) {
  RimSearch dark = search_from(Eigen::Vector2d::Zero(), 40);
  dark.sign = -1;
  EXPECT_FALSE(measured(disc_among({}), dark));
  RimSearch elsewhere = search_from(Eigen::Vector2d::Zero(), 20);
  elsewhere.outer_px = elsewhere.inner_px = 10;
  EXPECT_FALSE(measured(disc_among({}), elsewhere));
}

}  // namespace
}  // namespace panelcal::internal
