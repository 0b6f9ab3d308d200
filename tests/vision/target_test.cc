// SPDX-License-Identifier: Apache-2.0
#include "panelcal/vision/target.h"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace panelcal {
namespace {

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
  for (const Shape shape : {Shape::Disc, Shape::Ring}) {
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
  EXPECT_EQ(problem_of(target),
            "error[target-invalid]: vision tool 0: no size, expected one of size_mm and size_px");
  target = good();
  target.inner_size = mm(1.5);
  EXPECT_EQ(
      problem_of(target),
      "error[target-invalid]: vision tool 3: inner_size_mm = 1.5, expected a number between 0 "
      "and size_mm = 1");
  target = good();
  target.size_px = px(80);
  EXPECT_NE(problem_of(target).find("both given"), std::string::npos);
  target = good();
  target.size = mm(std::numeric_limits<double>::quiet_NaN());
  EXPECT_NE(problem_of(target).find("size_mm = nan"), std::string::npos);
  target = good();
  target.shape = Shape::Disc;
  EXPECT_NE(problem_of(target).find("not a ring"), std::string::npos);
  target = good();
  target.size_tolerance = 0.7;
  EXPECT_NE(problem_of(target).find("size_tolerance = 0.7"), std::string::npos);
}

}  // namespace
}  // namespace panelcal
