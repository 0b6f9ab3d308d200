// SPDX-License-Identifier: Apache-2.0
#include "tools/locate/suggestion.h"

#include <vector>

#include "machine/config/machine_config.h"
#include "tools/locate/located_json.h"
#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

namespace panelcal {
namespace {

using nlohmann::json;
using testing::HasSubstr;

SeenMark mark(Shape shape, double size_px, double x_px = 50) {
  SeenMark mark;
  mark.shape = shape;
  mark.center = position_px<frame::Image>(Eigen::Vector2d(x_px, 40));
  mark.size = px(size_px);
  mark.contrast = 0.5;
  mark.quality = 0.9;
  return mark;
}

std::vector<PictureMarks> two_pictures() {
  SeenMark tag = mark(Shape::AprilTag, 120);
  tag.family = "tag36h11";
  tag.tag_id = 5;
  SeenMark hole = mark(Shape::Disc, 80);
  hole.polarity = Polarity::Dark;
  return {{"a.png", {mark(Shape::Disc, 61), mark(Shape::Disc, 62, 150), tag}},
          {"b \"2\".png", {mark(Shape::Disc, 60), hole}}};
}

TEST(Suggestion, IsAListAndBlocksToPaste) {
  const std::string text = suggestion_toml(two_pictures(), std::nullopt);
  EXPECT_THAT(text, HasSubstr("# 5 marks in 2 pictures"));
  const auto config = parse_machine_config(text, "pasted");
  ASSERT_TRUE(config) << config.error().text() << text;
  ASSERT_EQ(config->vision_tools.size(), 3u) << text;
  EXPECT_EQ(config->vision_tools.at(1).shape, Shape::AprilTag) << "tags come first";
  EXPECT_EQ(config->vision_tools.at(1).tag_id, 5);
  EXPECT_EQ(config->vision_tools.at(2).shape, Shape::Disc);
  EXPECT_NEAR(config->vision_tools.at(2).size_px->in_px(), 61, 0.1) << "the median";
  EXPECT_EQ(config->vision_tools.at(3).polarity, Polarity::Dark);
}

TEST(Suggestion, GivesSizesInMmIfThePixelIsKnown) {
  const std::string text = suggestion_toml(two_pictures(), mm(0.01));
  EXPECT_THAT(text, HasSubstr("size_mm = 0.61"));
  EXPECT_THAT(text, Not(HasSubstr("size_px")));
}

TEST(Suggestion, OfNothingSaysSo) {
  const std::string text = suggestion_toml({{"empty.png", {}}}, std::nullopt);
  EXPECT_THAT(text, Not(HasSubstr("[[vision.tool]]")));
  EXPECT_THAT(text, testing::StartsWith("#"));
}

TEST(Suggestion, JsonHoldsEveryMark) {
  const json answer = json::parse(facts::text(suggested_row(two_pictures()[1])));
  EXPECT_EQ(answer["image"], "b \"2\".png");
  ASSERT_EQ(answer["groups"].size(), 2u);
  const json& group = answer["groups"][0];
  EXPECT_EQ(group["shape"], "disc");
  EXPECT_EQ(group["marks"][0]["center_px"], json({50.0, 40.0}));
}

}  // namespace
}  // namespace panelcal
