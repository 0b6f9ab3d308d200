// SPDX-License-Identifier: Apache-2.0
#include <vector>

#include "vision/suggest/seen_mark.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

SeenMark mark_of_size(double size_px, Shape shape = Shape::Disc, double contrast = 0.3) {
  SeenMark mark;
  mark.shape = shape;
  mark.size = px(size_px);
  mark.contrast = contrast;
  mark.quality = 0.9;
  return mark;
}

TEST(MarkGroups, PutLikeMarksTogetherTheMostUsefulFirst) {
  const auto groups = group_marks({mark_of_size(61),
                                   mark_of_size(30),
                                   mark_of_size(60),
                                   mark_of_size(62),
                                   mark_of_size(60.5, Shape::Square),
                                   mark_of_size(29.5)});
  ASSERT_EQ(groups.size(), 3U);
  EXPECT_EQ(groups[0].marks.size(), 3U);
  EXPECT_EQ(groups[0].size.in_px(), 61);
  EXPECT_EQ(groups[0].min_size.in_px(), 60);
  EXPECT_EQ(groups[1].marks.size(), 2U);
  EXPECT_EQ(groups[2].best().shape, Shape::Square);
}

TEST(MarkGroups, PutTagsFirstAndFaintMarksLast) {
  SeenMark tag = mark_of_size(50, Shape::AprilTag, 0.05);
  tag.family = "tag36h11";
  const auto groups =
      group_marks({mark_of_size(20, Shape::Disc, 0.04), mark_of_size(20, Shape::Square, 0.2), tag});
  ASSERT_EQ(groups.size(), 3U);
  EXPECT_EQ(groups[0].best().family, "tag36h11");
  EXPECT_EQ(groups[1].best().shape, Shape::Square);
  EXPECT_TRUE(group_marks({}).empty());
}

}  // namespace
}  // namespace panelcal
