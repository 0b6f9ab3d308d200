// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/read_tags.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "vision/fit/detector.h"
#include "vision/tag/family.h"
#include "vision/tag/search.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"
#include "tests/vision/tag/trial.h"

namespace panelcal::test {
namespace {

constexpr double kSide_px = 60;
/// Quads are not fitted; they only have to say which tag lies where.
constexpr double kNear_px = 0.7;

Target tag_target(double side_px = kSide_px) {
  Target target;
  target.shape = Shape::AprilTag;
  target.size_px = px(side_px);
  return target;
}

/// Turned by `turn_rad` clockwise as the picture shows it, its middle at a place.
TagScene scene_of(int id, double x_px, double y_px, double turn_rad, double side_px = kSide_px) {
  TagScene scene;
  scene.pattern = *tag_pattern("tag36h11", id);
  scene.width = 320;
  scene.height = 240;
  const double c = side_px * std::cos(turn_rad);
  const double s = side_px * std::sin(turn_rad);
  scene.image_from_tag << c, -s, x_px, s, c, y_px, 0, 0, 1;
  return scene;
}

Image picture_of(const std::vector<TagScene>& scenes) {
  Random random(7);
  Image image = tag_picture(scenes.front(), random);
  for (std::size_t k = 1; k < scenes.size(); ++k) {
    const Image other = tag_picture(scenes[k], random);
    for (std::size_t i = 0; i < image.pixels().size(); ++i) {
      const auto around = static_cast<float>(scenes.front().around);
      const bool is_other =
          std::abs(other.pixels()[i] - around) > std::abs(image.pixels()[i] - around);
      if (is_other) image.pixels()[i] = other.pixels()[i];
    }
  }
  return image;
}

TEST(ReadTags, ReadsEveryTagWhereItLies) {
  const std::vector<TagScene> scenes = {
      scene_of(4, 60, 70, 0.1), scene_of(5, 160, 120, 1.7), scene_of(200, 260, 180, -2.9)};
  const auto tags = read_tags(picture_of(scenes), tag_target());
  ASSERT_TRUE(tags) << tags.error().text();
  ASSERT_EQ(tags->size(), 3U);
  const int ids[] = {4, 5, 200};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto tag = std::ranges::find(*tags, ids[k], &ReadTag::id);
    ASSERT_NE(tag, tags->end()) << ids[k];
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_LT((tag->corners[i].in_px() - scenes[k].corners_px()[i]).norm(), kNear_px)
          << ids[k] << " corner " << i;
    }
  }
}

TEST(ReadTags, ATagThatTheFirstViewMissesIsReadBesideOneThatItReads) {
  // Reduced for tags of 60 px, cells of 2.6 px leave too few pixels.
  const std::vector<TagScene> scenes = {scene_of(4, 60, 70, 0.1), scene_of(5, 200, 120, 0.4, 21)};
  const Image image = picture_of(scenes);
  const auto tags = read_tags(image, tag_target());
  ASSERT_TRUE(tags) << tags.error().text();
  ASSERT_EQ(tags->size(), 2U);  // and the large one once, though all views read it
  EXPECT_EQ((*tags)[0].id, 4);
  EXPECT_EQ((*tags)[1].id, 5);
  const TagFamily family = *find_tag_family("tag36h11");
  const Target target = tag_target();
  const LocateOptions options;
  const internal::DetectorInput input{
      image, target, nullptr, options, internal::SearchArea(options)};
  EXPECT_EQ(internal::search_tags(input, family, internal::TagsSought::One).size(), 1U);
}

TEST(ReadTags, AMirroredTagIsNone) {
  TagScene scene = scene_of(4, 160, 120, 0.3);
  scene.image_from_tag.col(0) *= -1;
  const auto tags = read_tags(picture_of({scene}), tag_target());
  ASSERT_TRUE(tags) << tags.error().text();
  EXPECT_TRUE(tags->empty());
}

TEST(ReadTags, RefusesWhatIsNoTag) {
  const Image image = picture_of({scene_of(4, 160, 120, 0)});
  Target target = tag_target();
  target.shape = Shape::Disc;
  EXPECT_THAT(read_tags(image, target), FailsWith(Code::TargetInvalid, "no tag"));
  target = tag_target();
  target.tag_family = "tag99h9";
  EXPECT_THAT(read_tags(image, target), FailsWith(Code::TargetInvalid, "tag99h9"));
}

}  // namespace
}  // namespace panelcal::test
