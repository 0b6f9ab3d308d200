// SPDX-License-Identifier: Apache-2.0
#include "vision/fit/target.h"

#include <cmath>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::Reports;

Target good() {
  Target target;
  target.number = 3;
  target.shape = Shape::Ring;
  target.size = mm(1);
  target.inner_size = mm(0.5);
  return target;
}

std::string problem_of(const Target& target) {
  const auto valid = target.validate();
  return valid ? "" : valid.error().text();
}

TEST(Target, NamesReadBack) {
  for (const Shape shape : {Shape::Disc,
                            Shape::Hole,
                            Shape::Ring,
                            Shape::Square,
                            Shape::Diamond,
                            Shape::Cross,
                            Shape::Slot,
                            Shape::Dots,
                            Shape::Template,
                            Shape::AprilTag}) {
    EXPECT_EQ(shape_from_name(name(shape)), shape);
  }
  for (const Polarity polarity : {Polarity::Bright, Polarity::Dark}) {
    EXPECT_EQ(polarity_from_name(name(polarity)), polarity);
  }
  EXPECT_EQ(shape_from_name("Disc"), std::nullopt);
  EXPECT_EQ(polarity_from_name(""), std::nullopt);
}

TEST(Target, GoodOnesAreValid) {
  EXPECT_EQ(problem_of(good()), "");
  Target in_px;
  in_px.size_px = px(80);
  EXPECT_EQ(problem_of(in_px), "");
}

TEST(Target, ProblemsNameFieldValueAndBound) {
  Target target;
  EXPECT_THAT(problem_of(target), Reports("error[target-invalid]", "size_mm"));
  target = good();
  target.inner_size = mm(1.5);
  EXPECT_THAT(problem_of(target), Reports("error[target-invalid]", "inner_size_mm = 1.5"));
  target = good();
  target.size_px = px(80);
  EXPECT_THAT(problem_of(target), Reports("error[target-invalid]", "size_px"));
  target = good();
  target.size = mm(std::numeric_limits<double>::quiet_NaN());
  EXPECT_NE(problem_of(target).find("size_mm = nan"), std::string::npos);
  target = good();
  target.shape = Shape::Disc;
  EXPECT_THAT(problem_of(target), Reports("error[target-invalid]", "inner_size"));
  target = good();
  target.size_tolerance = 0.7;
  EXPECT_NE(problem_of(target).find("size_tolerance = 0.7"), std::string::npos);
}

void expect_problem(const Target& target, std::string_view part) {
  EXPECT_NE(problem_of(target).find(part), std::string::npos) << problem_of(target);
}

Target of_shape(Shape shape) {
  Target target;
  target.shape = shape;
  target.size_px = px(40);
  return target;
}

TEST(Target, ACrossNeedsTheWidthOfItsBars) {
  Target cross = of_shape(Shape::Cross);
  expect_problem(cross, "width_mm or width_px");
  cross.width_px = px(9);
  EXPECT_EQ(problem_of(cross), "");
  cross.width_px = px(40);
  expect_problem(cross, "width_px = 40");
  cross.width_px = px(9);
  cross.width = mm(0.1);
  expect_problem(cross, "one unit");
  Target square = of_shape(Shape::Square);
  square.width_px = px(9);
  expect_problem(square, "not a cross");
}

TEST(Target, DotsLieApartAndAreTwoTo64) {
  Target dots = of_shape(Shape::Dots);
  expect_problem(dots, "0 dots");
  dots.dots = {{0, 0}, {41, 0}};
  EXPECT_EQ(problem_of(dots), "");
  dots.dots.push_back({41, 39});
  expect_problem(dots, "dots 2 and 3 overlap");
  dots.dots[2] = {std::numeric_limits<double>::infinity(), 0};
  expect_problem(dots, "finite");
  dots.dots.clear();
  for (int i = 0; i < 65; ++i) dots.dots.emplace_back(50 * i, 0);
  expect_problem(dots, "65 dots");
  Target disc = of_shape(Shape::Disc);
  disc.dots = {{0, 0}, {41, 0}};
  expect_problem(disc, "not a dot-code");
}

TEST(Target, TemplatesAndOnlyTheseHaveAPicture) {
  Target target = of_shape(Shape::Template);
  expect_problem(target, "without its picture");
  target.picture = std::make_shared<TemplatePicture>();
  EXPECT_EQ(problem_of(target), "");
  target.shape = Shape::Square;
  expect_problem(target, "not a template");
}

TEST(Target, AnglesAreBounded) {
  Target target = of_shape(Shape::Square);
  target.angle = deg(400);
  expect_problem(target, "angle");
  target.angle = deg(-360);
  EXPECT_EQ(problem_of(target), "");
  target.angle_tolerance = deg(-1);
  expect_problem(target, "angle_tolerance");
  target.angle_tolerance = rad(std::numeric_limits<double>::quiet_NaN());
  expect_problem(target, "angle_tolerance");
}

}  // namespace
}  // namespace panelcal
