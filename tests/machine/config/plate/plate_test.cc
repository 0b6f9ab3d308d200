// SPDX-License-Identifier: Apache-2.0
#include "machine/config/plate/plate.h"

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::IsNearPosition;
using ::testing::StartsWith;

constexpr std::string_view kDots = R"([plate]
columns = 5
rows = 4
pitch_mm = 10
dot_diameter_mm = 2
)";
constexpr std::string_view kTags = R"([tags]
size_mm = 6
)";
constexpr std::string_view kLattice = R"(columns = 2
rows = 2
first_cell = [0.5, 0.5]
step_cells = [2, 1.5]
)";

/// The whole diagnostic as a user sees it; [tags] is line 6 of the file.
std::string refusal(const std::string& tags) {
  const auto plate = parse_plate(std::string(kDots) + tags, "plate.toml");
  return plate ? "accepted" : test::brief(plate.error());
}

CalibrationPlate plate_of(const std::string& tags) {
  const auto plate = parse_plate(std::string(kDots) + tags, "plate.toml");
  EXPECT_TRUE(plate) << plate.error().text();
  return plate.value_or(CalibrationPlate());
}

TEST(PlateConfig, AnEarlierFileHasNoTags) {
  const auto plate = parse_plate(kDots, "plate.toml");
  ASSERT_TRUE(plate) << plate.error().text();
  EXPECT_FALSE(plate->tags);
  EXPECT_EQ(plate->covered_dots(), std::vector<bool>(20, false));
}

TEST(PlateConfig, StatesWhatItsCertificateSays) {
  const CalibrationPlate plate =
      plate_of("certified = true\ncertificate = \"123 of 2026\"\nexpanded_uncertainty_um = 0.5\n");
  EXPECT_EQ(plate.certificate, "123 of 2026");
  EXPECT_EQ(plate.expanded_uncertainty, um(0.5));
  EXPECT_EQ(plate.coverage_factor, 2);
  EXPECT_THAT(refusal("expanded_uncertainty_um = 0.5\n"),
              StartsWith("plate.toml:6:27: error[config-value]"));
  EXPECT_THAT(refusal("certified = true\nexpanded_uncertainty_um = 0\n"),
              StartsWith("plate.toml:7:27: error[config-value]"));
}

TEST(PlateConfig, TagsAreCountedAlongXFirst) {
  const CalibrationPlate plate = plate_of(std::string(kTags) + std::string(kLattice) +
                                          "first_id = 30\npolarity = \"dark\"\nangle_deg = 90\n");
  ASSERT_TRUE(plate.tags);
  EXPECT_EQ(plate.tags->family, "tag36h11");
  EXPECT_EQ(plate.tags->size, mm(6));
  EXPECT_EQ(plate.tags->polarity, Polarity::Dark);
  ASSERT_EQ(plate.tags->tags.size(), 4U);
  const PlateTag* second = plate.tags->find(31);
  const PlateTag* third = plate.tags->find(32);
  ASSERT_TRUE(second != nullptr && third != nullptr);
  EXPECT_THAT(second->center, IsNearPosition(position_mm<frame::Plate>(25, 5), um(1e-6)));
  EXPECT_THAT(third->center, IsNearPosition(position_mm<frame::Plate>(5, 20), um(1e-6)));
  EXPECT_EQ(plate.tags->find(34), nullptr);
  // The tag's bottom left is at the plate's bottom right after a quarter turn.
  const auto corners = corners_of(*plate.tags, *second);
  EXPECT_THAT(corners[0], IsNearPosition(position_mm<frame::Plate>(28, 2), um(1e-6)));
  EXPECT_THAT(corners[1], IsNearPosition(position_mm<frame::Plate>(28, 8), um(1e-6)));
}

TEST(PlateConfig, TagsMayStandOneByOne) {
  const CalibrationPlate plate =
      plate_of(std::string(kTags) + std::string(kLattice) +
               "family = \"tag25h9\"\n[[tag]]\nid = 9\ncell = [-1, 3]\nangle_deg = 45\n");
  ASSERT_TRUE(plate.tags);
  ASSERT_EQ(plate.tags->tags.size(), 5U);
  const PlateTag* tag = plate.tags->find(9);
  ASSERT_NE(tag, nullptr);
  EXPECT_THAT(tag->center, IsNearPosition(position_mm<frame::Plate>(-10, 30), um(1e-6)));
  EXPECT_DOUBLE_EQ(tag->turn.in_deg(), 45);
}

TEST(PlateConfig, ATagStandsInPlaceOfDots) {
  // 6 mm between corners are 7.5 mm with the quiet zone of tag36h11; dots are 2 mm wide.
  const auto covered = [](const std::string& tag) {
    const CalibrationPlate plate = plate_of(std::string(kTags) + "[[tag]]\nid = 0\n" + tag);
    std::string map;
    for (const bool is : plate.covered_dots()) map += is ? 'x' : '.';
    return map;
  };
  EXPECT_EQ(covered("cell = [1, 2]\n"), "...........x........");
  EXPECT_EQ(covered("cell = [1.5, 2]\n"), "....................");
  EXPECT_EQ(covered("cell = [1.53, 2]\n"), "............x.......");
  EXPECT_EQ(covered("cell = [1.5, 1.5]\n"), "....................");
  // On its tip it reaches 5.3 mm to each side, but not to dots half a pitch aside.
  EXPECT_EQ(covered("cell = [1.5, 2]\nangle_deg = 45\n"), "...........xx.......");
  EXPECT_EQ(covered("cell = [-0.4, 0]\n"), "x...................");
  EXPECT_EQ(covered("cell = [9, 9]\n"), "....................");
}

TEST(PlateConfig, WhatIsWrongWithTagsHasAPlace) {
  const std::string lattice = std::string(kTags) + std::string(kLattice);
  EXPECT_THAT(refusal("[tags]\nfamily = \"tag36h10x\"\nsize_mm = 6\n"),
              StartsWith("plate.toml:7:10: error[config-value]"));
  EXPECT_EQ(refusal("[tags]\ncolumns = 2\n"), "plate.toml:6:1: error[config-value]");
  EXPECT_EQ(refusal(std::string(kTags)), "plate.toml:6:1: error[config-value]");
  EXPECT_EQ(refusal(std::string(kTags) + "first_id = 3\n"), "plate.toml:8:12: error[config-value]");
  EXPECT_EQ(refusal(std::string(kTags) + "columns = 2\nrows = 2\nfirst_cell = [0, 0]\n"),
            "plate.toml:6:1: error[config-value]");
  EXPECT_EQ(refusal(lattice + "first_id = 585\n"), "plate.toml:12:12: error[config-value]");
  EXPECT_EQ(refusal(lattice + "[[tag]]\nid = 3\ncell = [9, 9]\n"),
            "plate.toml:13:6: error[config-value]");
  EXPECT_EQ(refusal(lattice + "[[tag]]\nid = 4\ncell = [0.6, 0.5]\n"),
            "plate.toml:14:8: error[config-value]");
  EXPECT_EQ(refusal("[[tag]]\nid = 4\ncell = [0.6, 0.5]\n"), "plate.toml:1:1: error[config-value]");
  EXPECT_EQ(refusal("[tags]\nsize_mm = 90\n[[tag]]\nid = 4\ncell = [2, 1.5]\n"),
            "plate.toml:1:1: error[config-value]");
}

}  // namespace
}  // namespace panelcal
