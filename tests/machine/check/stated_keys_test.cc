// SPDX-License-Identifier: Apache-2.0
#include "machine/check/stated_keys.h"

#include <string>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

constexpr std::string_view kText =
    "[coupon]\n"
    "pitch_mm = 2\n"
    "[[vision.tool]]\n"
    "number = 7\n"
    "size_mm = 0.8\n"
    "[[depth]]\n"
    "drill_mm = 1\n"
    "[nightly]\n"
    "gates.min_holes = 50\n";

std::string place_of(std::string_view key, std::string_view text = kText) {
  const Place place = StatedKeys::of_text(text, "machine.toml").place(key);
  return place.file + ":" + std::to_string(place.line) + ":" + std::to_string(place.column);
}

TEST(StatedKeys, AreAtTheirValues) {
  EXPECT_EQ(place_of("coupon.pitch_mm"), "machine.toml:2:12");
  EXPECT_EQ(place_of("nightly.gates.min_holes"), "machine.toml:9:19");
}

TEST(StatedKeys, OfARowAreFoundByItsNumberOrElseByItsPlace) {
  EXPECT_EQ(place_of("vision.tool.7.size_mm"), "machine.toml:5:11");
  EXPECT_EQ(place_of("depth.0.drill_mm"), "machine.toml:7:12");
}

TEST(StatedKeys, ThatAreMissingAreAtTheirTable) {
  EXPECT_EQ(place_of("coupon.rows"), "machine.toml:1:1");
  EXPECT_EQ(place_of("gates.max_dropped"), "machine.toml:0:0");
  const StatedKeys keys = StatedKeys::of_text(kText, "machine.toml");
  EXPECT_TRUE(keys.has("coupon.pitch_mm"));
  EXPECT_FALSE(keys.has("coupon.rows"));
}

TEST(StatedKeys, OfAFileThatIsNoTomlAreNone) {
  EXPECT_EQ(place_of("coupon.pitch_mm", "[coupon\n"), "machine.toml:0:0");
  EXPECT_FALSE(StatedKeys::of_file("no/such/machine.toml").has("coupon"));
}

}  // namespace
}  // namespace panelcal
