// SPDX-License-Identifier: Apache-2.0
#include "machine/plate/tagged_pose.h"

#include <algorithm>
#include <cstddef>
#include <numbers>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal::internal {
namespace {

using test::FailsWith;

/// 4 x 3 tags between 9 x 9 dots; tag 0 about cell (0.5, 0.5).
constexpr std::string_view kPlate = R"([plate]
columns = 9
rows = 9
pitch_mm = 10
[tags]
size_mm = 5
first_cell = [0.5, 0.5]
step_cells = [2, 3]
columns = 4
rows = 3
)";
/// A corner of a quad without a fit, through a camera of 0.02 mm a pixel.
constexpr double kCorner_mm = 0.01;

CalibrationPlate plate_of(std::string_view text = kPlate) {
  const auto plate = parse_plate(text, "plate.toml");
  EXPECT_TRUE(plate) << plate.error().text();
  return plate.value_or(CalibrationPlate());
}

class Sights {
 public:
  Sights(CalibrationPlate plate, const PlatePose& lies) : plate_(std::move(plate)), lies_(lies) {}

  /// A tag as it lies, or as if another one's id stood there.
  TagSight of(int id, std::size_t i_picture, int read_as = -1) {
    TagSight sight{i_picture, read_as < 0 ? id : read_as, {}};
    const auto corners = corners_of(*plate_.tags, *plate_.tags->find(id));
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Eigen::Vector2d noise_mm(kCorner_mm * random_.normal(), kCorner_mm * random_.normal());
      sight.corners[i] = place_in(lies_, corners[i]) + displacement_mm<frame::Machine>(noise_mm);
    }
    return sight;
  }
  /// Every tag in a picture of its own.
  std::vector<TagSight> all() {
    std::vector<TagSight> sights;
    for (const PlateTag& tag : plate_.tags->tags) sights.push_back(of(tag.id, sights.size()));
    return sights;
  }

  const CalibrationPlate& plate() const { return plate_; }
  const PlatePose& lies() const { return lies_; }

 private:
  CalibrationPlate plate_;
  PlatePose lies_;
  Random random_{11};
};

/// No dot of the plate is farther from where it lies than that.
double worst_mm(const Sights& sights, const PlatePose& found) {
  double worst = 0;
  for (const PlateDot& dot : sights.plate().dots()) {
    const auto off = place_in(found, dot.place) - place_in(sights.lies(), dot.place);
    worst = std::max(worst, off.in_mm().norm());
  }
  return worst;
}

TEST(TaggedPose, IsWhatMostTagsSay) {
  for (const double angle_rad : {0.0, 0.35, 1.6, std::numbers::pi, -2.5}) {
    Sights sights(plate_of(), {angle_rad, {-30, 400}});
    const auto found = pose_from_tags(sights.plate(), sights.all());
    ASSERT_TRUE(found) << found.error().text();
    EXPECT_TRUE(found->contradictions.empty());
    // 48 corners of 10 um each.
    EXPECT_LT(worst_mm(sights, found->pose), 0.01) << angle_rad;
  }
}

TEST(TaggedPose, OneTagIsEnoughOfASafeFamily) {
  Sights sights(plate_of(), {1.0, {5, 6}});
  const auto found = pose_from_tags(sights.plate(), {sights.of(7, 0)});
  ASSERT_TRUE(found) << found.error().text();
  // Its angle is good to 3 mrad, over 80 mm.
  EXPECT_LT(worst_mm(sights, found->pose), 1);
}

TEST(TaggedPose, OneTagIsNotEnoughOfAnEasilyMisreadOne) {
  Sights sights(plate_of(std::string(kPlate) + "family = \"tag16h5\"\n"), {1.0, {5, 6}});
  EXPECT_THAT(pose_from_tags(sights.plate(), {sights.of(7, 0), sights.of(7, 1)}),
              FailsWith(Code::CalibrationData, "tag 7"));
  EXPECT_TRUE(pose_from_tags(sights.plate(), {sights.of(7, 0), sights.of(3, 0)}));
}

TEST(TaggedPose, APictureWithAMisreadTagIsLeftOut) {
  Sights sights(plate_of(), {0.4, {100, 80}});
  auto all = sights.all();
  all[5].id = 6;  // as if the lattice were two pitches on
  const auto found = pose_from_tags(sights.plate(), all);
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(found->contradictions.size(), 1U);
  EXPECT_EQ(found->contradictions[0].i_picture, 5U);
  EXPECT_THAT(found->contradictions[0].why, ::testing::HasSubstr("tag 6 lies "));
  EXPECT_THAT(found->agreeing, ::testing::ElementsAre(0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 11));
  EXPECT_LT(worst_mm(sights, found->pose), 0.01);
}

TEST(TaggedPose, APictureAgreesOnceAndOnlyIfAllItsTagsDo) {
  Sights sights(plate_of(), {0.4, {100, 80}});
  auto all = sights.all();
  for (std::size_t i = 0; i < all.size(); ++i) all[i].i_picture = i / 4;
  all[5].id = 6;
  const auto found = pose_from_tags(sights.plate(), all);
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(found->contradictions.size(), 1U);
  EXPECT_EQ(found->contradictions[0].i_picture, 1U);
  EXPECT_THAT(found->agreeing, ::testing::ElementsAre(0, 2));
}

TEST(TaggedPose, ItDoesNotMatterWhichTagIsWrong) {
  for (std::size_t wrong = 0; wrong < 12; ++wrong) {
    Sights sights(plate_of(), {0.4, {100, 80}});
    auto all = sights.all();
    all[wrong].id = (all[wrong].id + 1) % 12;
    const auto found = pose_from_tags(sights.plate(), all);
    ASSERT_TRUE(found) << found.error().text();
    ASSERT_EQ(found->contradictions.size(), 1U);
    EXPECT_EQ(found->contradictions[0].i_picture, wrong);
    EXPECT_LT(worst_mm(sights, found->pose), 0.01);
  }
}

TEST(TaggedPose, ATurnedTagAndAStrangeOneContradict) {
  Sights sights(plate_of(), {0.4, {100, 80}});
  auto all = sights.all();
  std::ranges::rotate(all[3].corners, all[3].corners.begin() + 1);
  all[8].id = 40;
  const auto found = pose_from_tags(sights.plate(), all);
  ASSERT_TRUE(found) << found.error().text();
  ASSERT_EQ(found->contradictions.size(), 2U);
  EXPECT_EQ(found->contradictions[0].why, "tag 3 is turned by 90 degrees against the others");
  EXPECT_EQ(found->contradictions[1].why,
            "tag 40 lies on the plate at cell (0.5, 6.5), and [tags] does not have it");
}

TEST(TaggedPose, AStrangeTagBesideThePlateIsOfNoMatter) {
  Sights sights(plate_of(), {0.4, {100, 80}});
  auto all = sights.all();
  TagSight strange = sights.of(0, 0, 40);
  for (auto& corner : strange.corners) corner = corner - displacement_mm<frame::Machine>(20, 0);
  all.push_back(strange);
  const auto found = pose_from_tags(sights.plate(), all);
  ASSERT_TRUE(found) << found.error().text();
  EXPECT_TRUE(found->contradictions.empty());
}

TEST(TaggedPose, RefusesTagsThatContradictOneAnother) {
  Sights sights(plate_of(), {0.4, {100, 80}});
  EXPECT_THAT(pose_from_tags(sights.plate(), {sights.of(0, 0), sights.of(1, 0, 2)}),
              FailsWith(Code::CalibrationData, "tag 2"));
  // Many tags beside the plate do not outvote them.
  std::vector<TagSight> two = {sights.of(0, 0), sights.of(1, 0, 2)};
  for (int i = 0; i < 10; ++i) {
    two.push_back(sights.of(0, 0, 40 + i));
    for (auto& corner : two.back().corners) {
      corner = corner - displacement_mm<frame::Machine>(500, 0);
    }
  }
  EXPECT_THAT(pose_from_tags(sights.plate(), two), FailsWith(Code::CalibrationData, "1 of 2 tags"));
  // Of a plate that is mirrored against its file every tag alone is as good as the others.
  auto all = sights.all();
  for (TagSight& sight : all) sight.id += 3 - 2 * (sight.id % 4);
  EXPECT_THAT(pose_from_tags(sights.plate(), all), FailsWith(Code::CalibrationData, "tags"));
}

TEST(TaggedPose, FewerWrongTagsThanRightOnesNeverShiftTheLattice) {
  const CalibrationPlate plate = plate_of();
  Random random(2611);
  const auto below = [&](int n) { return static_cast<int>(random.uniform(0, n)); };
  int n_accepted = 0;
  int n_said = 0;
  for (int draw = 0; draw < 1000; ++draw) {
    const double angle_rad = random.uniform(-3, 3);
    Sights sights(plate, {angle_rad, {random.uniform(-500, 500), random.uniform(-500, 500)}});
    const int n = 1 + below(20);
    const int n_wrong = below((n + 1) / 2);
    std::vector<TagSight> all;
    for (int i = 0; i < n; ++i) {
      const int id = below(12);
      TagSight sight = sights.of(id, static_cast<std::size_t>(i));
      if (i < n_wrong && i % 2 == 0) sight.id = (id + 1 + below(11)) % 12;
      if (i < n_wrong && i % 2 == 1) {  // a stop that was a pitch off
        for (auto& corner : sight.corners) corner = corner + displacement_mm<frame::Machine>(10, 0);
      }
      all.push_back(sight);
    }
    const auto found = pose_from_tags(plate, all);
    if (!found) continue;
    ++n_accepted;
    n_said += static_cast<int>(found->contradictions.size());
    EXPECT_EQ(found->contradictions.size(), static_cast<std::size_t>(n_wrong)) << draw;
    EXPECT_LT(worst_mm(sights, found->pose), 0.25 * 10) << draw;
  }
  // Not all are refused, nor all without anything wrong.
  EXPECT_GT(n_accepted, 400);
  EXPECT_GT(n_said, 400);
}

TEST(TaggedPose, RefusesWhatShowsNoTagOfThePlate) {
  Sights sights(plate_of(), {0, {0, 0}});
  EXPECT_THAT(pose_from_tags(sights.plate(), {}), FailsWith(Code::CalibrationData));
  EXPECT_THAT(pose_from_tags(sights.plate(), {sights.of(3, 0, 77)}),
              FailsWith(Code::CalibrationData, "tag 77"));
}

}  // namespace
}  // namespace panelcal::internal
