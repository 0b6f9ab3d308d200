// SPDX-License-Identifier: Apache-2.0
#include "tools/report/input/views.h"

#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace panelcal::report {
namespace {

using testing::HasSubstr;
using testing::Not;

ReportView view(int i_view, double x_mm, MeasurementStatus status) {
  ReportView view;
  view.i_view = i_view;
  view.status = status;
  view.frame_mm = {{x_mm, 1}, {x_mm + 3, 1}, {x_mm + 3, -1}, {x_mm, -1}};
  if (status == MeasurementStatus::Found) {
    view.seen_mm = {{x_mm + 2, 0}};
    view.crop_png = "png" + std::to_string(i_view);
  }
  return view;
}

Measurement searched() {
  Measurement measurement;
  measurement.request.settings.search_area = mm(4);
  measurement.status = MeasurementStatus::Found;
  measurement.measured.position = position_mm<frame::Actual>(4, 0);
  return measurement;
}

std::ptrdiff_t count(const std::string& text, std::string_view part) {
  std::ptrdiff_t n = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST(ViewsFigure, ASingleViewHasNone) {
  const std::vector<ReportView> one = {view(0, -1, MeasurementStatus::Found)};
  EXPECT_EQ(views_figure(searched(), one), "");
  // Inspections of one view are no more than that.
  const std::vector<ReportView> two = {one[0], one[0]};
  EXPECT_EQ(views_figure(searched(), two), "");
  EXPECT_EQ(views_figure(searched(), {}), "");
}

TEST(ViewsFigure, ShowsEveryFrameTheAreaAndWhatWasSeen) {
  const std::vector<ReportView> views = {view(0, -1, MeasurementStatus::NotFound),
                                         view(1, 1, MeasurementStatus::NotFound),
                                         view(2, 2, MeasurementStatus::Found)};
  const std::string figure = views_figure(searched(), views);
  EXPECT_EQ(count(figure, "Z\"/>"), 3);
  EXPECT_EQ(count(figure, "<circle"), 1);
  EXPECT_EQ(count(figure, "<img"), 1);
  EXPECT_THAT(figure, HasSubstr("title=\"view 3\""));
  EXPECT_THAT(figure, HasSubstr("3 views"));
  EXPECT_EQ(count(figure, "<"), count(figure, ">"));
}

TEST(ViewsFigure, FourMarksHaveNoSearchedArea) {
  std::vector<ReportView> views;
  for (int i = 0; i < 4; ++i) views.push_back(view(i, 10 * i, MeasurementStatus::Found));
  Measurement measurement = searched();
  measurement.request.settings.delta = mm(10);
  const std::string figure = views_figure(measurement, views);
  EXPECT_THAT(figure, Not(HasSubstr("<circle")));
  EXPECT_EQ(count(figure, "<img"), 4);
}

}  // namespace
}  // namespace panelcal::report
