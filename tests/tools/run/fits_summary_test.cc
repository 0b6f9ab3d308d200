// SPDX-License-Identifier: Apache-2.0
#include "tools/run/fits_summary.h"

#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(FitsSummary, CountsTheModelsOfNestedFits) {
  Survey survey;
  EXPECT_THAT(fits_summary(survey), Not(HasSubstr("nested fit")));
  for (int i = 0; i < 3; ++i) {
    SeriesResult& series = survey.series.emplace_back();
    series.level = CorrectionLevel::Nested;
    series.nested = std::make_shared<const NestedFit>();
    series.chose_model = true;
    series.model = i < 2 ? PanelModel::Rigid : PanelModel::Offset;
  }
  EXPECT_THAT(fits_summary(survey), HasSubstr("models of 3 nested fits: 1 offset, 2 rigid\n"));
}

}  // namespace
}  // namespace panelcal
