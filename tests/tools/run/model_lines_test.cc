// SPDX-License-Identifier: Apache-2.0
#include "tools/run/model_lines.h"

#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

ModelScore score(PanelModel model, double parameters, double chi_square, double left_out_um) {
  ModelScore s;
  s.model = model;
  s.parameters = parameters;
  s.chi_square = chi_square;
  s.criterion = chi_square + 2 * parameters;
  if (left_out_um > 0) s.left_out_mm = left_out_um * 1e-3;
  s.is_eligible = left_out_um > 0;
  return s;
}

/// Rigid is chosen, stretch in force.
SeriesResult compared() {
  SeriesResult series;
  series.model = PanelModel::Stretch;
  series.compared = {score(PanelModel::Offset, 2, 40, 21),
                     score(PanelModel::Rigid, 3, 3.25, 6.5),
                     score(PanelModel::Stretch, 5, 1.5, 8.25),
                     score(PanelModel::Affine, 6, 0, 0)};
  series.compared[1].is_chosen = true;
  return series;
}

TEST(ModelLine, SaysWhichModelAndWhy) {
  SeriesResult series = compared();
  EXPECT_THAT(model_line(series), IsEmpty());  // not left to the targets
  series.chose_model = true;
  series.model = PanelModel::Rigid;
  EXPECT_EQ(
      model_line(series),
      "  model \"rigid\", criterion 9.25; \"stretch\" has 11.50, which is worse; left-out rms "
      "6.50 um\n");
  series.compared[2].chi_square = -2;
  series.compared[2].criterion = 8;
  EXPECT_THAT(model_line(series), HasSubstr("too little better to be softer for"));
}

TEST(ModelLine, CallsASmoothModelSmooth) {
  SeriesResult series = compared();
  series.chose_model = true;
  series.model = PanelModel::Affine;
  for (ModelScore& other : series.compared) other.is_chosen = false;
  ModelScore smooth = score(PanelModel::Affine, 9.5, -30, 2.5);
  smooth.is_smooth = smooth.is_eligible = smooth.is_chosen = true;
  series.compared.push_back(smooth);
  EXPECT_THAT(model_line(series), HasSubstr("  model \"smooth\", criterion"));
}

TEST(NestedModelsLine, CountsThem) {
  Survey survey;
  EXPECT_THAT(nested_models_line(survey), IsEmpty());
  for (int i = 0; i < 3; ++i) {
    SeriesResult series = compared();
    series.nested = std::make_shared<const NestedFit>();
    series.chose_model = true;
    series.model = i < 2 ? PanelModel::Rigid : PanelModel::Offset;
    survey.series.push_back(series);
  }
  EXPECT_EQ(nested_models_line(survey), "models of 3 nested fits: 1 offset, 2 rigid\n");
}

}  // namespace
}  // namespace panelcal
