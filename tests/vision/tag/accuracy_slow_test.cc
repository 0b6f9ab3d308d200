// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdint>

#include "vision/locate/locate.h"
#include <gtest/gtest.h>

#include "tests/vision/tag/accuracy.h"

namespace panelcal::test {
namespace {

constexpr std::uint64_t kSeed = 20261121;

void expect_at_the_limit(const TagAccuracy& r) {
  // Three standard deviations of the rmse of 640 coordinates are 8 % of it.
  constexpr double kOfBound = 1.08;
  constexpr double kBetter = 3;
  EXPECT_EQ(r.first_failure, "");
  ASSERT_GT(r.library.n_found, 160) << "nothing to compare with";
  const double best_center = std::min(r.library.center.value(), r.opencv.center.value());
  const double best_corner = std::min(r.library.corners.value(), r.opencv.corners.value());
  EXPECT_LT(kBetter * r.ours.center.value(), best_center);
  EXPECT_LT(kBetter * r.ours.corners.value(), best_corner);
  EXPECT_LT(r.ours.center.value(), kOfBound * r.center_bound.value());
  EXPECT_LT(r.ours.corners.value(), kOfBound * r.corner_bound.value());
  EXPECT_GT(r.center_chi_square, 0.9);
  EXPECT_LT(r.center_chi_square, 1.1);
  EXPECT_GT(r.corner_chi_square, 0.9);
  EXPECT_LT(r.corner_chi_square, 1.1);
}

TEST(TagAccuracy, CleanPicturesAreAtTheBound) {
  expect_at_the_limit(run_tag_trials(clean_tag_scene(), {.seed = kSeed, .n = 320, .id = 7}));
}

TEST(TagAccuracy, TypicalPicturesAreAtTheBound) {
  expect_at_the_limit(run_tag_trials(typical_tag_scene(), {.seed = kSeed, .n = 320, .id = 250}));
}

/// Poor light, in which the library finds almost no tag at full resolution.
TEST(TagAccuracy, PoorLightHidesNoTag) {
  constexpr int kDark = 100;
  const TagAccuracy r = run_tag_trials(dim_tag_scene(), {.seed = kSeed, .n = kDark, .id = 99});
  EXPECT_GE(r.ours.n_found, 99) << r.first_failure;
  EXPECT_LT(r.library.n_found, 50);
  // Four standard deviations of the mean of 100 values of variance 1.
  EXPECT_NEAR(r.center_chi_square, 1, 0.4);
}

/// Frames like a tag's with a code of no tag: it must not be corrected into a tag.
TEST(TagAccuracy, WrongCodesAreNeverReported) {
  for (const char* name : {"tag36h11", "tag25h9", "tagStandard41h12"}) {
    const TagFamily family = *find_tag_family(name);
    Target target;
    target.shape = Shape::AprilTag;
    target.size_px = px(80);
    target.size_tolerance = 0.2;
    target.tag_family = name;
    for (int i = 0; i < 200; ++i) {
      Random random = Random(kSeed).fork(static_cast<std::uint64_t>(i));
      TagScene scene;
      scene.width = scene.height = 240;
      const int id = static_cast<int>(random.uniform() * family.n_tags());
      scene.pattern = family.pattern(id);
      // Half of them are a tag with as many wrong bits as make it nearest to none or another.
      for (const TagFamily::Bit& bit : family.bits) {
        const bool is_flipped = random.uniform() < (i % 2 == 0 ? 0.5 : 0.15);
        TagCell& cell =
            scene.pattern.levels[static_cast<std::size_t>(bit.row * family.n_cells + bit.column)];
        if (is_flipped) cell = cell == TagCell::White ? TagCell::Black : TagCell::White;
      }
      int n_wrong = 0;
      const TagPattern truth = family.pattern(id);
      for (std::size_t k = 0; k < truth.levels.size(); ++k) {
        n_wrong += truth.levels[k] != scene.pattern.levels[k];
      }
      scene.image_from_tag = random_pose(scene, 80, 0.3, random);
      const Detection detection = locate(tag_picture(scene, random), target);
      if (n_wrong <= 1) {
        ASSERT_EQ(detection.status, DetectionStatus::Found) << name << " " << i;
        EXPECT_EQ(detection.best->tag_id, id);
      } else {
        EXPECT_NE(detection.status, DetectionStatus::Found) << name << " " << i;
      }
    }
  }
}

}  // namespace
}  // namespace panelcal::test
