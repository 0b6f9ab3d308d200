// SPDX-License-Identifier: Apache-2.0
#include "program/walk/survey.h"

#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>

namespace panelcal {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// Two targets of a panel that lies displaced by this, held against the default gates.
Survey survey_of(double x_mm, double y_mm, int turned_deg = 0) {
  auto fit = std::make_shared<BaseFit>();
  for (const Eigen::Vector2d& nominal_mm : {Eigen::Vector2d(0, 0), Eigen::Vector2d(100, 0)}) {
    TargetPair<frame::Base, frame::Nominal> pair;
    pair.nominal = position_mm<frame::Nominal>(nominal_mm);
    const Eigen::Vector2d meant_mm = turned_by(nominal_mm, turned_deg);
    pair.measured.position =
        position_mm<frame::Base>(Eigen::Vector2d(meant_mm + Eigen::Vector2d(x_mm, y_mm)));
    fit->pairs.push_back(pair);
    fit->residuals.emplace_back();
  }
  Survey survey;
  SeriesResult& series = survey.series.emplace_back();
  series.limits = default_gate_limits();
  series.limits.turned_deg = turned_deg;
  series.base = std::move(fit);
  return survey;
}

TEST(Survey, NamesAFarPanelThatNoOffsetGateHolds) {
  EXPECT_THAT(survey_of(6, 8).gates_off(), IsEmpty());
  EXPECT_THAT(survey_of(99'800, 0).gates_off(),
              ElementsAre("offset (targets lie 99800.0 mm from their programmed places)"));
  EXPECT_THAT(survey_of(8, 8).gates_off(),
              ElementsAre("offset (targets lie 11.3 mm from their programmed places)"));
}

TEST(Survey, CountsTheOffsetFromHowThePanelIsMeantToLie) {
  EXPECT_THAT(survey_of(6, 8, 180).gates_off(), IsEmpty());
}

TEST(Survey, LeavesAnOffsetThatIsGatedToItsGate) {
  Survey survey = survey_of(99'800, 0);
  survey.series.front().limits.offset = mm(2);
  EXPECT_THAT(survey.gates_off(), IsEmpty());
  survey.series.front().base.reset();
  survey.series.front().limits.offset.reset();
  EXPECT_THAT(survey.gates_off(), IsEmpty());
}

}  // namespace
}  // namespace panelcal
