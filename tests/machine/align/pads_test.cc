// SPDX-License-Identifier: Apache-2.0
#include "machine/align/pads.h"

#include <string>

#include "calib/base/files/atomic_file.h"
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"

namespace panelcal {
namespace {

MachineConfig machine_with(std::initializer_list<std::pair<const int, double>> sizes_mm) {
  MachineConfig machine;
  for (const auto& [number, size_mm] : sizes_mm) {
    machine.vision_tools[number] = {.number = number, .size = mm(size_mm)};
  }
  return machine;
}

std::string refusal(const Expected<PadList>& pads) {
  return pads ? "none" : pads.error().text();
}

Expected<PadList> pads_of_text(const std::string& text,
                               const PadChoice& choice,
                               const MachineConfig& machine) {
  const test::TemporaryFolder folder;
  const std::string file = (folder.path() / "a.exc").string();
  EXPECT_TRUE(write_file(file, text));
  return read_pads(file, choice, machine);
}

TEST(Pads, AreAListOfPlaces) {
  const auto list = read_pads("5,5.5; -7.25,8", {}, machine_with({{3, 1}}));
  ASSERT_TRUE(list) << list.error().text();
  ASSERT_EQ(list->pads.size(), 2U);
  EXPECT_EQ(list->pads[1].nominal.in_mm(), Eigen::Vector2d(-7.25, 8));
  EXPECT_EQ(list->pads[1].line, 2);
  EXPECT_EQ(list->pads[1].settings.tools, std::vector<int>{3}) << "the only one";
}

TEST(Pads, RefusesListsThatAreNone) {
  const MachineConfig machine = machine_with({{1, 1}});
  EXPECT_NE(refusal(read_pads("5,5;6", {}, machine)).find("PADS:2: error[usage]"),
            std::string::npos);
  EXPECT_NE(refusal(read_pads("5,5;5,5", {}, machine)).find("pad 2 lies where pad 1"),
            std::string::npos);
  EXPECT_NE(refusal(read_pads("5,5", {}, machine_with({{1, 1}, {2, 2}}))).find("--tool"),
            std::string::npos);
}

TEST(Pads, OfAProgramAreTheTargetsOfThePanel) {
  MachineConfig machine = machine_with({{1, 1}, {2, 2}});
  machine.walk.series_size = 2;
  const auto list = pads_of_text(
      "M48\nMETRIC,TZ\nVER,1\n%\nG34,2\n$uvis,lamp,4\nG36X1.0Y2.0\nG36X30.0Y2.0\nM30\n",
      {},
      machine);
  ASSERT_TRUE(list) << list.error().text();
  ASSERT_EQ(list->pads.size(), 2U);
  EXPECT_EQ(list->pads[0].line, 7);
  EXPECT_EQ(list->pads[0].settings.tools, std::vector<int>{2});
  EXPECT_EQ(list->pads[0].settings.lamp, 4);
  const auto twice = pads_of_text(
      "M48\nMETRIC,TZ\nVER,1\n%\nG34,2\nG36X1.0Y2.0\nG36X30.0Y2.0\nG37\nG36X1.0Y2.0\n"
      "G36X30.0Y9.0\nM30\n",
      {},
      machine);
  EXPECT_NE(refusal(twice).find("a second series"), std::string::npos) << refusal(twice);
}

TEST(Pads, OfAProgramCountFromTheMachinesZero) {
  MachineConfig machine = machine_with({{1, 1}});
  machine.walk.series_size = 2;
  machine.walk.absolute_zero = position_mm<frame::Machine>(-1000, 20);
  machine.walk.work_zero = position_mm<frame::Machine>(100, 50);
  const auto pads_of = [&](const std::string& header) {
    return pads_of_text(
        "M48\nMETRIC,TZ\nVER,1\n" + header + "%\nG34,1\nG36X1.0Y2.0\nG36X30.0Y2.0\nM30\n",
        {},
        machine);
  };
  EXPECT_EQ(refusal(pads_of("")), "none");
  EXPECT_NE(refusal(pads_of("ZC,X101.0Y50.0\n")).find("another work zero"), std::string::npos);
}

TEST(Pads, OfAutoAreTheCornersOfTheHoles) {
  std::string text = "M48\nMETRIC\nT1C0.8\n%\nT1\n";
  for (int x = 0; x <= 60; x += 10) {
    for (int y = 0; y <= 40; y += 10) text += fmt::format("X{}.0Y{}.0\n", x, y);
  }
  const auto list = pads_of_text(text + "M30\n", {.n_best_holes = 4}, machine_with({{1, 1}}));
  ASSERT_TRUE(list) << list.error().text();
  ASSERT_EQ(list->pads.size(), 4U);
  for (const Pad& pad : list->pads) {
    const Eigen::Vector2d at_mm = pad.nominal.in_mm();
    EXPECT_TRUE((at_mm.x() == 0 || at_mm.x() == 60) && (at_mm.y() == 0 || at_mm.y() == 40))
        << at_mm;
  }
}

TEST(Pads, ComeBackFromTheirProgram) {
  std::vector<Pad> pads(2);
  pads[0] = {
      .nominal = position_mm<frame::Nominal>(1.123456, -2),
      .settings = {
          .tools = {4, 4, 5, 5}, .delta = mm(1.5), .inspections = 3, .search = true, .lamp = 7}};
  pads[1] = pads[0];
  pads[1].nominal = position_mm<frame::Nominal>(1e-7, 1234.5);
  pads[1].settings = {.tools = {2}, .search_area = mm(0.5), .zoom = 2};
  WalkOptions walk;
  walk.series_size = 2;
  walk.inspections = 9;
  NominalSource panel;
  DiagnosticLog log;
  const Survey survey = panelcal::survey(test::program_of(pad_program(pads)), walk, panel, log);
  EXPECT_FALSE(log.has_errors()) << test::all_text(log);
  ASSERT_EQ(survey.measurements.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) {
    const MeasurementRequest& request = survey.measurements[i].request;
    EXPECT_NEAR((request.nominal - pads[i].nominal).in_mm().norm(), 0, 1e-9);
    EXPECT_EQ(request.settings.tools, pads[i].settings.tools);
    EXPECT_EQ(request.settings.delta.has_value(), pads[i].settings.delta.has_value());
    EXPECT_EQ(request.settings.inspections, pads[i].settings.inspections);
  }
  EXPECT_EQ(survey.measurements[0].request.settings.lamp, 7);
  EXPECT_EQ(survey.measurements[1].request.settings.zoom, 2);
  EXPECT_EQ(survey.measurements[1].request.settings.search_area, mm(0.5));
}

}  // namespace
}  // namespace panelcal
