// SPDX-License-Identifier: Apache-2.0
#include "vision/suggest/find_marks.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "vision/tag/family.h"
#include <gtest/gtest.h>

#include "tests/vision/suggest/drawn.h"

namespace panelcal {
namespace {

using Eigen::Vector2d;

/// To a pixel: thresholds cut rims, and nothing is fitted.
constexpr double kSuggestedPlace_px = 0.6;
constexpr double kSuggestedSize_px = 1.2;
/// Levels are taken beside a rim that was blurred, and noise widens them.
constexpr double kSuggestedContrast = 0.04;

const SeenMark* mark_near(const std::vector<SeenMark>& marks, const Vector2d& at_px) {
  const auto found = std::ranges::find_if(marks, [&](const SeenMark& mark) {
    return (mark.center.in_px() - at_px).norm() < kSuggestedPlace_px;
  });
  return found == marks.end() ? nullptr : &*found;
}

TEST(FindMarks, TellsShapeSizeAndPolarity) {
  struct Drawn {
    test::Inside inside;
    Vector2d at_px;
    float level;
    Shape shape;
    double size_px;
  };
  const double eighth = std::numbers::pi / 4;
  const std::vector<Drawn> drawn = {
      {test::disc_of(31), {60.3, 50.8}, 190, Shape::Disc, 31},
      {test::disc_of(22), {150.1, 52.4}, 30, Shape::Disc, 22},
      {test::square_of(30), {245.5, 55.2}, 180, Shape::Square, 30},
      {test::turned(test::square_of(30), eighth), {60.2, 150.7}, 40, Shape::Diamond, 30},
      {test::cross_of(44, 12), {150.4, 150.3}, 185, Shape::Cross, 44},
      {test::turned(test::cross_of(44, 10), 0.2), {245.8, 149.6}, 35, Shape::Cross, 44}};
  for (const double noise : {0.0, 4.0}) {
    Image image(310, 210, Image::kFullScale8, 100);
    for (const Drawn& d : drawn) test::draw(image, d.inside, d.at_px, d.level);
    test::add_noise(image, noise, 5);
    const auto marks = find_marks(image);
    EXPECT_EQ(marks.size(), drawn.size());
    for (const Drawn& d : drawn) {
      const SeenMark* const mark = mark_near(marks, d.at_px);
      ASSERT_NE(mark, nullptr) << d.at_px.transpose() << " noise " << noise;
      EXPECT_EQ(mark->shape, d.shape) << d.at_px.transpose();
      EXPECT_EQ(mark->polarity, d.level > 100 ? Polarity::Bright : Polarity::Dark);
      EXPECT_NEAR(mark->size.in_px(), d.size_px, kSuggestedSize_px) << d.at_px.transpose();
      EXPECT_NEAR(mark->contrast, std::abs(d.level - 100) / 255, kSuggestedContrast);
    }
    EXPECT_NEAR(mark_near(marks, drawn[5].at_px)->angle.in_rad(), 0.2, 0.03);
    EXPECT_NEAR(mark_near(marks, drawn[4].at_px)->detail->in_px(), 12, 1.5);
  }
}

TEST(FindMarks, SeesPadsWithTracksAndTellsRings) {
  Image image(260, 120, Image::kFullScale8, 60);
  test::draw(image, test::disc_of(40), {60, 60}, 180);
  const auto track = [](const Vector2d& v) { return v.x() > 0 && std::abs(v.y()) < 5; };
  test::draw(
      image, [&](const Vector2d& v) { return track(v) && v.x() < 55; }, {60, 60}, 180);
  test::draw(image, test::disc_of(50), {190, 60}, 180);
  test::draw(image, test::disc_of(24), {190, 60}, 40);
  const auto marks = find_marks(image);
  const auto pad = std::ranges::find_if(marks, [](const SeenMark& m) {
    return (m.center.in_px() - Vector2d(60, 60)).norm() < 1 && m.shape == Shape::Disc;
  });
  ASSERT_NE(pad, marks.end());
  EXPECT_NEAR(pad->size.in_px(), 40, kSuggestedSize_px);
  const auto ring =
      std::ranges::find_if(marks, [](const SeenMark& m) { return m.shape == Shape::Ring; });
  ASSERT_NE(ring, marks.end());
  EXPECT_NEAR(ring->size.in_px(), 50, kSuggestedSize_px);
  EXPECT_NEAR(ring->detail->in_px(), 24, kSuggestedSize_px);
}

TEST(FindMarks, ReadsTags) {
  const auto pattern = tag_pattern("tag36h11", 17);
  ASSERT_TRUE(pattern.has_value());
  Image image(200, 200, Image::kFullScale8, 200);
  constexpr double kSide = 96;
  for (int row = 0; row < pattern->n_cells; ++row) {
    for (int column = 0; column < pattern->n_cells; ++column) {
      if (pattern->at(column, row) != TagCell::Black) continue;
      const auto line = [&](int i) {
        return 100 + kSide * pattern->lines[static_cast<std::size_t>(i)];
      };
      const auto inside = [&](const Vector2d& u) {
        return u.x() > line(column) && u.x() < line(column + 1) && u.y() > line(row) &&
               u.y() < line(row + 1);
      };
      test::draw(image, inside, {0, 0}, 30);
    }
  }
  const auto marks = find_marks(image);
  ASSERT_EQ(marks.size(), 1U);
  EXPECT_EQ(marks[0].shape, Shape::AprilTag);
  EXPECT_EQ(marks[0].family, "tag36h11");
  EXPECT_EQ(marks[0].tag_id, 17);
  EXPECT_NEAR(marks[0].size.in_px(), kSide, 2);
}

TEST(FindMarks, SeesNothingInNoiseAndInEmptyPictures) {
  EXPECT_TRUE(find_marks(Image()).empty());
  EXPECT_TRUE(find_marks(Image(50, 50, 255, 7)).empty());
  EXPECT_TRUE(find_marks(Image(1, 1, 65535, 7)).empty());
  Image image(320, 240, Image::kFullScale8, 100);
  test::add_noise(image, 20, 3);
  EXPECT_TRUE(find_marks(image).empty());
}

}  // namespace
}  // namespace panelcal
