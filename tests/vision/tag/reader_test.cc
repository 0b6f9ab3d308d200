// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/reader.h"

#include <cmath>

#include "calib/base/statistics/random.h"
#include "vision/tag/frame_search.h"
#include <gtest/gtest.h>

#include "tests/vision/tag/accuracy.h"
#include "tests/vision/tag/dirt.h"

namespace panelcal::test {
namespace {

using internal::TagWord;

std::uint64_t random_bits(Random& random, std::size_t n) {
  std::uint64_t bits = 0;
  for (std::size_t i = 0; i < n; ++i) bits = bits << 1 | (random.uniform() < 0.5 ? 1U : 0U);
  return bits;
}

/// Random words that read as a tag.
int n_false_tags(const TagFamily& family, std::optional<int> id, int n) {
  const std::uint64_t all = ~std::uint64_t{0} >> (64 - family.bits.size());
  Random random(20261123);
  int n_false = 0;
  for (int i = 0; i < n; ++i) {
    std::array<TagWord, 4> words;
    for (TagWord& word : words) word = {random_bits(random, family.bits.size()), all};
    n_false += internal::decoded(family, words, id).has_value();
  }
  return n_false;
}

TEST(TagReader, RandomGridsReadAsTagsAsOftenAsStated) {
  // tag25h9 with any id: 4 * 35 * 26 / 2^25 = 1.08e-4, less what is as near to a second tag.
  constexpr int kWords = 200'000;
  const int n = n_false_tags(*find_tag_family("tag25h9"), std::nullopt, kWords);
  EXPECT_NEAR(n, 21.7, 4 * std::sqrt(21.7));
  // tag36h11: 1.3e-6, so 0.03 are to be expected of so many words.
  EXPECT_LE(n_false_tags(*find_tag_family("tag36h11"), std::nullopt, 20'000), 1);
}

TEST(TagReader, AllowsFourWrongBitsOfANamedTagOnly) {
  const TagFamily family = *find_tag_family("tag36h11");
  EXPECT_EQ(internal::tolerable_wrong_bits(family, true, 36), 4);
  EXPECT_EQ(internal::tolerable_wrong_bits(family, false, 36), 1);
  EXPECT_EQ(internal::tolerable_wrong_bits(family, true, 28), 3);
  EXPECT_EQ(internal::tolerable_wrong_bits(family, true, 8), -1);
  const std::uint64_t all = ~std::uint64_t{0} >> (64 - 36);
  const std::uint64_t wrong = family.codes[7] ^ 0b1000'0100'0010'0001U;
  const std::array<TagWord, 4> words = {
      TagWord{wrong, all}, TagWord{~wrong & all, all}, TagWord{0, all}, TagWord{all, all}};
  const auto named = internal::decoded(family, words, 7);
  ASSERT_TRUE(named.has_value());
  EXPECT_EQ(named->id, 7);
  EXPECT_EQ(named->wrong_bits, 4);
  EXPECT_FALSE(internal::decoded(family, words, std::nullopt).has_value());
  EXPECT_FALSE(internal::decoded(family, words, 8).has_value());
}

TEST(TagFrameSearch, SeesATagThroughNoiseWithACornerCovered) {
  TagScene scene = dim_tag_scene();
  scene.pattern = *tag_pattern("tag36h11", 7);
  Random random(3);
  scene.image_from_tag = random_pose(scene, 120, 0.3, random);
  std::vector<double> levels = tag_levels(scene);
  const Patch cover{scene.corners_px()[2], {12, 12}, 0.3, 200, false};
  paint(scene, {cover}, levels);
  const Image image = noisy_picture(scene, levels, random);
  const auto quads = internal::find_tag_frames(image,
                                               {0, 0, image.width(), image.height()},
                                               *find_tag_family("tag36h11"),
                                               {120, 0.1, false});
  ASSERT_FALSE(quads.empty());
  double worst_px = 0;
  for (const Eigen::Vector2d& truth : scene.corners_px()) {
    double nearest_px = 1e9;
    for (const Eigen::Vector2d& c : quads.front().corners_px) {
      nearest_px = std::min(nearest_px, (c - truth).norm());
    }
    worst_px = std::max(worst_px, nearest_px);
  }
  EXPECT_LT(worst_px, 4) << "a quarter of a cell";
}

}  // namespace
}  // namespace panelcal::test
