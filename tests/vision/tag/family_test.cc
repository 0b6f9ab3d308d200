// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/family.h"

#include <array>
#include <cstdlib>
#include <memory>
#include <string>
#include <utility>

#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h10.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagCircle21h7.h>
#include <apriltag/tagCircle49h12.h>
#include <apriltag/tagCustom48h12.h>
#include <apriltag/tagStandard41h12.h>
#include <apriltag/tagStandard52h13.h>
#include <gtest/gtest.h>

namespace panelcal::test {
namespace {

using Create = apriltag_family_t* (*)();
using Destroy = void (*)(apriltag_family_t*);

/// The library does not export its own function for this.
struct Freed {
  void operator()(image_u8_t* image) const {
    std::free(image->buf);
    std::free(image);
  }
};

constexpr std::array kFamilies = {
    std::pair<Create, Destroy>{tag36h11_create, tag36h11_destroy},
    std::pair<Create, Destroy>{tag36h10_create, tag36h10_destroy},
    std::pair<Create, Destroy>{tag25h9_create, tag25h9_destroy},
    std::pair<Create, Destroy>{tag16h5_create, tag16h5_destroy},
    std::pair<Create, Destroy>{tagCircle21h7_create, tagCircle21h7_destroy},
    std::pair<Create, Destroy>{tagCircle49h12_create, tagCircle49h12_destroy},
    std::pair<Create, Destroy>{tagCustom48h12_create, tagCustom48h12_destroy},
    std::pair<Create, Destroy>{tagStandard41h12_create, tagStandard41h12_destroy},
    std::pair<Create, Destroy>{tagStandard52h13_create, tagStandard52h13_destroy},
};

TEST(TagFamily, PatternsAreThoseThatTheLibraryDraws) {
  EXPECT_EQ(tag_family_names().size(), kFamilies.size());
  for (const auto& [create, destroy] : kFamilies) {
    const std::unique_ptr<apriltag_family_t, Destroy> library(create(), destroy);
    const auto family = find_tag_family(library->name);
    ASSERT_TRUE(family) << library->name;
    ASSERT_EQ(family->n_tags(), static_cast<int>(library->ncodes));
    EXPECT_EQ(family->hamming_distance, static_cast<int>(library->h));
    for (const int id : {0, 1, family->n_tags() / 2, family->n_tags() - 1}) {
      const std::unique_ptr<image_u8_t, Freed> drawing(apriltag_to_image(library.get(), id));
      const TagPattern pattern = family->pattern(id);
      ASSERT_EQ(pattern.n_cells, drawing->width);
      int n_known = 0;
      for (int row = 0; row < pattern.n_cells; ++row) {
        for (int column = 0; column < pattern.n_cells; ++column) {
          if (pattern.at(column, row) == TagCell::Any) continue;
          ++n_known;
          const bool is_white = drawing->buf[row * drawing->stride + column] > 0;
          EXPECT_EQ(pattern.at(column, row), is_white ? TagCell::White : TagCell::Black)
              << library->name << " " << id << " column " << column << " row " << row;
        }
      }
      // A frame of two rings, and the bits.
      const int n = family->n_on_side;
      EXPECT_EQ(n_known, 4 * (n - 1) + 4 * (n + 1) + static_cast<int>(library->nbits))
          << library->name;
    }
  }
}

TEST(TagFamily, CornersAreOnLinesOfTheGrid) {
  for (const std::string_view name : tag_family_names()) {
    const TagPattern pattern = *tag_pattern(name, 0);
    ASSERT_EQ(pattern.lines.size(), static_cast<std::size_t>(pattern.n_cells) + 1);
    const auto first = static_cast<std::size_t>((pattern.n_cells - pattern.n_on_side) / 2);
    EXPECT_DOUBLE_EQ(pattern.lines[first], -0.5) << name;
    EXPECT_DOUBLE_EQ(pattern.lines[first + static_cast<std::size_t>(pattern.n_on_side)], 0.5)
        << name;
  }
}

/// The promise of the distance holds for tags turned against each other as well.
TEST(TagFamily, TurnedPatternsDifferByTheHammingDistance) {
  for (const std::string_view name : {"tag25h9", "tag16h5", "tagCircle21h7"}) {
    const TagFamily family = *find_tag_family(name);
    for (int a = 0; a < family.n_tags(); ++a) {
      const TagPattern pa = family.pattern(a);
      for (int b = 0; b < family.n_tags(); ++b) {
        TagPattern turned = family.pattern(b);
        for (int quarters = 0; quarters < 4; ++quarters) {
          int n_different = 0;
          for (std::size_t i = 0; i < pa.levels.size(); ++i) {
            n_different += pa.levels[i] != turned.levels[i];
          }
          if (a != b || quarters > 0) {
            EXPECT_GE(n_different, family.hamming_distance) << name << a << b << quarters;
          }
          TagPattern next = turned;
          const int n = turned.n_cells;
          for (int row = 0; row < n; ++row) {
            for (int column = 0; column < n; ++column) {
              next.levels[static_cast<std::size_t>(row * n + column)] =
                  turned.at(row, n - 1 - column);
            }
          }
          turned = next;
        }
      }
    }
  }
}

TEST(TagFamily, UnknownNamesAndIdsAreEmpty) {
  EXPECT_FALSE(find_tag_family("tag36h12"));
  EXPECT_FALSE(find_tag_family(""));
  EXPECT_FALSE(tag_pattern("tag36h11", -1));
  EXPECT_FALSE(tag_pattern("tag36h11", 587));
  EXPECT_TRUE(tag_pattern("tag36h11", 586));
}

}  // namespace
}  // namespace panelcal::test
