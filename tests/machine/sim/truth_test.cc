// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/truth.h"

#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::IsNearPosition;
using test::Reports;

MeasurementRequest request(std::int64_t seq, double x_mm, double y_mm, InstancePath path) {
  MeasurementRequest request;
  request.seq = seq;
  request.nominal = position_mm<frame::Nominal>(x_mm, y_mm);
  request.path = std::move(path);
  return request;
}

SimConfig shaken_panel() {
  SimConfig sim;
  sim.seed = 7;
  sim.panel_offset = displacement_mm<frame::Actual>(0.4, -0.2);
  sim.panel_rotation = rad(2e-3);
  sim.stretch_x_ppm = 200;
  sim.stretch_y_ppm = -100;
  sim.board_offset_sigma = um(50);
  sim.board_rotation_sigma = rad(0.5e-3);
  return sim;
}

std::vector<MeasurementRequest> two_boards() {
  return {request(0, 5, 5, {}),
          request(1, 10, 10, {0}),
          request(2, 60, 10, {0}),
          request(3, 110, 10, {1}),
          request(4, 160, 10, {1})};
}

TEST(Truth, PanelIsStretchedThenTurnedThenShifted) {
  const Truth truth = make_truth(shaken_panel(), {});
  const double c = std::cos(2e-3);
  const double s = std::sin(2e-3);
  const double x_mm = 100 * 1.0002;
  const double y_mm = 50 * 0.9999;
  EXPECT_THAT(truth.actual_from_nominal({})(position_mm<frame::Nominal>(100, 50)),
              IsNearPosition(
                  position_mm<frame::Actual>(c * x_mm - s * y_mm + 0.4, s * x_mm + c * y_mm - 0.2),
                  um(1e-6)));
}

TEST(Truth, BoardsScatterAndThePanelDoesNot) {
  const Truth truth = make_truth(shaken_panel(), two_boards());
  ASSERT_EQ(truth.instances.size(), 2u);
  EXPECT_EQ(truth.actual_from_nominal({}), truth.panel);
  const std::vector<int> first{0};
  const std::vector<int> second{1};
  const std::vector<int> unknown{0, 0};
  EXPECT_FALSE(truth.actual_from_nominal(first) == truth.actual_from_nominal(second));
  EXPECT_EQ(truth.actual_from_nominal(unknown), truth.panel);
}

TEST(Truth, BoardTurnsAboutItsFirstTarget) {
  SimConfig sim = shaken_panel();
  sim.board_offset_sigma = Length();
  const Truth truth = make_truth(sim, two_boards());
  const std::vector<int> second{1};
  const auto pivot = position_mm<frame::Nominal>(110, 10);
  EXPECT_THAT(truth.actual_from_nominal(second)(pivot),
              IsNearPosition(truth.panel(pivot), um(1e-6)));
  EXPECT_FALSE(truth.actual_from_nominal(second) == truth.panel);
}

TEST(Truth, BoardsDoNotDependOnWhatElseIsMeasured) {
  const std::vector<MeasurementRequest> all = two_boards();
  const Truth whole = make_truth(shaken_panel(), all);
  const Truth part = make_truth(shaken_panel(), std::span(all).last(2));
  const std::vector<int> second{1};
  EXPECT_EQ(whole.actual_from_nominal(second), part.actual_from_nominal(second));
}

TEST(Truth, RoundTripsToTheBit) {
  const test::TemporaryFolder folder;
  const Truth written = make_truth(shaken_panel(), two_boards());
  ASSERT_TRUE(write_truth_json(folder.path() / "truth.json", written));
  const auto read = read_truth_json(folder.path() / "truth.json");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read->seed, written.seed);
  EXPECT_EQ(read->panel, written.panel);
  EXPECT_EQ(read->instances, written.instances);
  ASSERT_EQ(read->targets.size(), written.targets.size());
  for (std::size_t i = 0; i < written.targets.size(); ++i) {
    EXPECT_EQ(read->targets[i].seq, written.targets[i].seq);
    EXPECT_EQ(read->targets[i].nominal, written.targets[i].nominal);
    EXPECT_EQ(read->targets[i].actual, written.targets[i].actual);
  }
  EXPECT_EQ(truth_text(*read), truth_text(written));
}

TEST(Truth, IsWrittenAsAgreed) {
  SimConfig sim;
  sim.seed = 3;
  const std::vector<MeasurementRequest> requests{request(0, 1.5, 2, {}), request(1, 3, 4, {0, 1})};
  EXPECT_EQ(truth_text(make_truth(sim, requests)),
            R"({"kind":"truth","version":1,"seed":3,
"panel":{"linear":[[1,0],[0,1]],"translation_mm":[0,0]},
"instances":[
{"path":[0,1],"linear":[[1,0],[0,1]],"translation_mm":[0,0]}],
"targets":[
{"seq":0,"nominal":[1.5,2],"actual":[1.5,2]},
{"seq":1,"nominal":[3,4],"actual":[3,4]}]}
)");
}

/// A good truth file with one piece replaced.
std::string refusal(std::string_view piece, std::string_view other) {
  SimConfig sim;
  sim.seed = 3;
  const std::vector<MeasurementRequest> requests{
      request(0, 1.5, 2, {}), request(1, 3, 4, {0, 1}), request(2, 3, 4, {1, 1})};
  std::string text = truth_text(make_truth(sim, requests));
  const auto at = text.find(piece);
  EXPECT_NE(at, std::string::npos) << piece;
  const auto truth = parse_truth(text.replace(at, piece.size(), other), "truth.json");
  return truth ? "accepted" : truth.error().text();
}

TEST(Truth, HolesOfRingsRoundTrip) {
  Truth written = make_truth(shaken_panel(), two_boards());
  written.targets[1].hole_offset = displacement_mm<frame::Actual>(0.1 + 0.2, -1.0 / 3);
  const auto read = parse_truth(truth_text(written), "truth.json");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_FALSE(read->targets[0].hole_offset);
  EXPECT_EQ(read->targets[1].hole_offset, written.targets[1].hole_offset);
  EXPECT_THAT(refusal("\"actual\":[1.5,2]", "\"actual\":[1.5,2],\"hole_offset\":[1]"),
              Reports("truth.json: error[truth-invalid]", "\"hole_offset\"", "target 0"));
}

TEST(Truth, SaysHowTheStageErrs) {
  SimConfig sim;
  EXPECT_THAT(truth_text(make_truth(sim, {})), testing::Not(testing::HasSubstr("table")));
  SimTable& table = sim.table.emplace();
  table.scale_x_ppm = 100;
  table.squareness = rad(50e-6);
  table.bow_x = um(30);
  table.bow_radius = mm(150);
  table.center = position_mm<frame::Machine>(20, 30);
  const std::string text = truth_text(make_truth(sim, {}));
  const auto read = parse_truth(text, "truth.json");
  ASSERT_TRUE(read) << read.error().text();
  ASSERT_TRUE(read->table);
  const auto at = position_mm<frame::Machine>(170, -20);
  EXPECT_LT((read->table->error_mm(at) - table.error_mm(at)).norm(), 1e-12);
  EXPECT_THAT(parse_truth(std::string(text).replace(
                              text.find("bow_radius_mm\":150"), 18, "bow_radius_mm\":0"),
                          "truth.json"),
              FailsWith(Code::TruthInvalid, "\"bow_radius_mm\""));
  EXPECT_THAT(parse_truth(std::string(text).replace(text.find("squareness_urad"), 15, "squareness"),
                          "truth.json"),
              FailsWith(Code::TruthInvalid, "squareness"));
}

TEST(Truth, RefusesWhatIsNoTruth) {
  EXPECT_THAT(refusal("\"truth\"", "\"camera\""),
              Reports("truth.json: error[truth-invalid]", "\"kind\"", "\"camera\""));
  EXPECT_THAT(refusal("\"version\":1", "\"version\":2"),
              Reports("truth.json: error[truth-invalid]", "\"version\"", "2"));
  EXPECT_THAT(refusal("\"seed\":3", "\"seed\":-3"),
              Reports("truth.json: error[truth-invalid]", "\"seed\"", "-3"));
  EXPECT_THAT(refusal("\"seed\":3", "\"sede\":3"),
              Reports("truth.json: error[truth-invalid]", "\"sede\""));
  EXPECT_THAT(refusal("[[1,0],[0,1]]", "[[1,0],[0,0]]"),
              Reports("truth.json: error[truth-invalid]", "\"linear\""));
  EXPECT_THAT(refusal("[[1,0],[0,1]]", "[[1,0]]"),
              Reports("truth.json: error[truth-invalid]", "\"linear\"", "2 arrays"));
  EXPECT_THAT(refusal("\"path\":[0,1]", "\"path\":[0,-1]"),
              Reports("truth.json: error[truth-invalid]", "\"path\"", "[0,-1]"));
  EXPECT_THAT(refusal("\"path\":[0,1]", "\"path\":[1,1]"),
              Reports("truth.json: error[truth-invalid]", "instance 1"));
  EXPECT_THAT(refusal("\"seq\":1", "\"seq\":0"),
              Reports("truth.json: error[truth-invalid]", "target 1"));
  EXPECT_THAT(refusal("\"nominal\":[3,4]", "\"nominal\":[3]"),
              Reports("truth.json: error[truth-invalid]", "\"nominal\"", "target 1"));
  EXPECT_EQ(refusal("\"targets\":[", "\"targets\":["), "accepted");
}

TEST(Truth, RefusesWhatIsNotJson) {
  EXPECT_THAT(parse_truth("{\"kind\":\n", "truth.json"),
              FailsWith(Code::JsonSyntax, "truth.json:"));
  EXPECT_THAT(read_truth_json("no/truth.json"), FailsWith(Code::FileUnreadable, "no/truth.json"));
}

}  // namespace
}  // namespace panelcal
