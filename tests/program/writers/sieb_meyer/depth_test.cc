// SPDX-License-Identifier: Apache-2.0
// The depth state of the control in written SIEB & MEYER programs, and in the languages that have
// no form for it.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "program/writers/excellon/writer.h"
#include "program/writers/gcode/writer.h"
#include <gmock/gmock.h>
#include <rapidcheck/gtest.h>

#include "tests/program/sieb_meyer/random_draws.h"
#include "tests/program/writers/sieb_meyer/depth_run.h"
#include "tests/support/matchers.h"

namespace panelcal::written_depth {
namespace {

using test::DepthRun;
using test::run_and_write;
using test::run_to_sieb_meyer;
using test::Stroke;
using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

const std::string kTools = "$\nT1D1.F1.2\nT2D2.F1.2\n$\n";

std::string program(const std::string& body) {
  return "%%5000\n" + body + kTools;
}

/// Between the begin of the program, with the CNC commands that stand there, and its tool table.
std::string body_in(const std::string& text) {
  std::string body = text.substr(text.find("%%5000\n") + 7);
  body.resize(std::min(body.size(), body.find("$\n")));
  while (body.starts_with("M49,")) body.erase(0, body.find('\n') + 1);
  return body;
}

/// The body as it is written; the program has to be free of errors.
std::string body_of(const std::string& body) {
  const DepthRun run = run_to_sieb_meyer(program(body));
  EXPECT_THAT(run.errors, IsEmpty());
  EXPECT_EQ(run.failure, "");
  return body_in(run.text);
}

DepthRun to_excellon(const std::string& body) {
  StringSink bytes;
  return run_and_write(
      program(body), std::make_unique<ExcellonWriter>(bytes, ProgramWriterOptions{}), bytes);
}

DepthRun to_gcode(const std::string& body, std::optional<Length> table_z = Length()) {
  StringSink bytes;
  GcodeSetting setting;
  setting.safe_z = mm(20);
  setting.table_z = table_z;
  setting.board_z = mm(1.6);
  setting.usual.drill_z = setting.usual.rout_z = mm(-0.2);
  setting.usual.infeed = setting.usual.feed = mm_per_s(10);
  setting.usual.speed = rpm(20000);
  return run_and_write(
      program(body), std::make_unique<GcodeWriter>(bytes, ProgramWriterOptions{}, setting), bytes);
}

// --- what G83, K and Z say (8.2, 11) -----------------------------------------------------------

/// "If no K-value is programmed, the manually entered K-value is used as plunge depth."
TEST(SiebMeyerDepth, DepthControlWithoutAKLeavesItToTheOperator) {
  const DepthRun run = run_to_sieb_meyer(program("X1.Y1.T1G83\nX2.Y1.G82\n"));
  ASSERT_EQ(run.strokes.size(), 2U);
  EXPECT_EQ(run.strokes[0].cut.control, DepthControl::Depth);
  EXPECT_FALSE(run.strokes[0].cut.depth);
  EXPECT_TRUE(run.strokes[1].cut.is_empty());
  EXPECT_EQ(body_of("X1.Y1.T1G83\nX2.Y1.G82\n"), "X1.Y1.T1G83\nX2.Y1.G82\n");
}

TEST(SiebMeyerDepth, ContoursKeepIt) {
  EXPECT_EQ(body_of("X1.Y1.T1T0G83\nX2.Y1.G1\nX2.Y1.T0\nX3.Y1.G82T0\nX4.Y1.G1\nX4.Y1.T0\n"),
            "X1.Y1.T1T0G83\nX2.Y1.G1\nX2.Y1.T0\nX3.Y1.T0G82\nX4.Y1.G1\nX4.Y1.T0\n");
}

/// The example of G82 and G83, whose depth changes within a contour: two contours, since "every
/// routing contour is started and finished by the T0 commands".
TEST(SiebMeyerDepth, AChangeInAContourEndsItAndBeginsTheNext) {
  EXPECT_EQ(body_of("X20.Y30.T5T0Z3.\nX20.Y30.G1F1.2\nX40.Y30.\nX40.Y30.G83K2.\nX60.Y50.\n"
                    "X90.Y80.T0G82\n"),
            "X20.Y30.T5T0Z3.\nX20.Y30.G1F1.2\nX40.Y30.G1\nX40.Y30.T0\nX40.Y30.T0G83K2.\n"
            "X60.Y50.G1\nX60.Y50.T0\nX90.Y80.T0\n");
  EXPECT_EQ(body_of("X1.Y1.T1T0Z3.\nX2.Y1.G1F1.2\nX2.Y1.T0\nX2.Y1.T0\nX3.Y1.G1\nX3.Y1.T0\n"),
            "X1.Y1.T1T0Z3.\nX2.Y1.G1F1.2\nX2.Y1.T0\nX2.Y1.T0\nX3.Y1.G1\nX3.Y1.T0\n");
}

/// "For the depth control (relative working plane) the Z-value is the minimum limit for lowering
/// the Z-axis."
TEST(SiebMeyerDepth, ZUnderDepthControlIsTheLowerLimit) {
  const DepthRun run = run_to_sieb_meyer(program("X10.Y10.T1Z1.3G83K.4\nX20.Y10.\n"));
  for (const Stroke& stroke : run.strokes) {
    EXPECT_EQ(stroke.cut.depth, mm(0.4));
    EXPECT_EQ(stroke.cut.lower_limit, mm(1.3));
    EXPECT_FALSE(stroke.cut.z);
  }
  EXPECT_EQ(body_of("X10.Y10.T1Z1.3G83K.4\nX20.Y10.\n"), "X10.Y10.T1G83K0.4Z1.3\nX20.Y10.\n");
  EXPECT_EQ(body_of("X1.Y1.T1Z3.\nX2.Y1.G83K2.\nX3.Y1.Z1.\nX4.Y1.G82\n"),
            "X1.Y1.T1Z3.\nX2.Y1.G83K2.\nX3.Y1.Z1.\nX4.Y1.G82\n");
}

TEST(SiebMeyerDepth, TheUpperLimitHoldsForEveryStrokeBehindIt) {
  const DepthRun run = run_to_sieb_meyer(program("X1.Y1.T1\nX2.Y1.H20.\nX3.Y1.G83\n"));
  ASSERT_EQ(run.strokes.size(), 3U);
  EXPECT_FALSE(run.strokes[0].cut.upper_limit);
  EXPECT_EQ(run.strokes[1].cut.upper_limit, mm(20));
  EXPECT_EQ(run.strokes[2].cut.upper_limit, mm(20));
}

// --- surface detection (10.1) ------------------------------------------------------------------

/// The example "Measurement" of G70: the last hole has the plane that was set by hand, which no Z
/// may have replaced.
TEST(SiebMeyerDepth, TheMeasurementExampleIsWritten) {
  const std::string body =
      "G71\nX165.Y15.G73L1\nG75\nX110.Y10.G73L2\nG75\nG71K.4\nL1\nX165.Y15.T1\nX170.Y15.\n"
      "G71K.5\nL2\nX110.Y10.T0T5\nX110.Y30.G1F1.5\nX110.Y30.T0\nG70\nXY\n";
  EXPECT_EQ(body_of(body),
            "G71\nX165.Y15.G73L1\nG75\nX110.Y10.G73L2\nG75\nL1\nG71K0.4\nX165.Y15.T1\nX170.Y15.\n"
            "L2\nG71K0.5\nX110.Y10.T5T0\nX110.Y30.G1F1.5\nX110.Y30.T0\nG70\nX0.Y0.\n");
}

TEST(SiebMeyerDepth, SurfacesAreAveragedAndStoredAgain) {
  const std::string body =
      "G71\nX1.Y1.G73\nG73L7\nX2.Y1.G73\nG74L1\nL1\nG71K0.2\nX3.Y1.T1\nX4.Y1.G76\nG72\nG70\n";
  EXPECT_EQ(body_of(body),
            "G71\nX1.Y1.G73\nG73L7\nX2.Y1.G73\nM49,SPAV,A\nG74L1\nL1\nG71K0.2\nX3.Y1.T1\n"
            "X4.Y1.G76\nG72\nG70\n");
}

/// "Negative value: residual web."
TEST(SiebMeyerDepth, AResidualWebIsSaidWithG71) {
  EXPECT_EQ(body_of("G71\nX1.Y1.G73L1\nG71K-2.\nX2.Y2.T1\nG70\n"),
            "G71\nX1.Y1.G73L1\nG71K-2.\nX2.Y2.T1\nG70\n");
}

TEST(SiebMeyerDepth, ProbingPutsTheToolAwayOrTakesTheDummy) {
  EXPECT_EQ(body_of("X5.Y1.T1\nG71K.2\nX1.Y1.G73L1T0\nX2.Y1.T1\nX3.Y1.G73L1TD\nX4.Y1.T1\nG70\n"),
            "X5.Y1.T1\nG71\nX1.Y1.T0G73L1\nG71K0.2\nX2.Y1.T1\nX3.Y1.TDG73L1\nX4.Y1.T1\nG70\n");
}

/// What the last job left in the spindle is put away too.
TEST(SiebMeyerDepth, ProbingPutsTheToolAwayBeforeTheProgramHasTakenOne) {
  const std::string body = "G71\nX1.Y1.T0G73L1\nX2.Y1.T0G73L2\nG70\nX5.Y5.T1\n";
  EXPECT_EQ(body_of(body), body);
}

/// "The G70 command deactivates the function for detecting, using and storing a reference surface."
TEST(SiebMeyerDepth, SurfacesAreStoredAndTakenUnderG71) {
  EXPECT_EQ(body_of("G71\nX1.Y1.G73L1\nX2.Y2.G73L2\nG71K.4\nL1\nX1.Y1.T1\nX2.Y2.G77\nL2\n"
                    "X3.Y3.\nG70\n"),
            "G71\nX1.Y1.G73L1\nX2.Y2.G73L2\nL1\nG71K0.4\nX1.Y1.T1\nG70\nX2.Y2.\nG71\nL2\n"
            "X3.Y3.\nG70\n");
  EXPECT_EQ(body_of("G71\nX1.Y1.G73\nX5.Y5.T1G77\nG73L7\nX6.Y5.G77\nG74L1\nX7.Y5.G77\nX8.Y5.G76\n"
                    "G70\n"),
            "G71\nX1.Y1.G73\nG70\nX5.Y5.T1\nG71\nG73L7\nG70\nX6.Y5.\nG71\nM49,SPAV,"
            "A\nG74L1\nG70\nX7.Y5.\n"
            "G71\nX8.Y5.G76\nG70\n");
}

/// "Only the surface value ahead the T0 block is considered for a complete routing contour."
TEST(SiebMeyerDepth, ASurfaceIsTakenAheadOfTheT0LineOfItsContour) {
  const std::string body =
      "G71\nX1.Y1.G73L1\nX2.Y2.G73L2\nL1\nG71K0.4\nX5.Y5.T1T0\nX6.Y5.G1\nX6.Y5.T0\nL2\nX6.Y5.T0\n"
      "X7.Y5.G1\nX7.Y5.T0\nG70\n";
  EXPECT_EQ(body_of(body), body);
}

/// "Program section without depth control" follows G70 in the manual's example, and G83 "remains
/// on".
TEST(SiebMeyerDepth, G83BehindG70IsSaidAgainAndAssumedByName) {
  const std::string body = "X5.Y5.T1G83K.3\nG71K.4\nX1.Y1.G73L1\nX1.Y1.\nX2.Y2.G77\nX3.Y3.\nG70\n";
  const std::string written =
      "X5.Y5.T1G83K0.3\nG71\nX1.Y1.G73L1\nG71K0.4\nX1.Y1.\nG70\nX2.Y2.G83\nG71K0.4\nX3.Y3.\n"
      "G70\n";
  const DepthRun run = run_to_sieb_meyer(program(body + "X4.Y4.\nX5.Y4.\n"));
  EXPECT_EQ(body_in(run.text), written + "X4.Y4.G83\nX5.Y4.\n");
  EXPECT_THAT(run.warnings, ElementsAre(HasSubstr("p.s5:9:1: warning[depth-control-assumed]")));
  const DepthRun said = run_to_sieb_meyer(program(body + "X4.Y4.G82\nX5.Y4.\n"));
  EXPECT_EQ(body_in(said.text), written + "X4.Y4.G82\nX5.Y4.\n");
  EXPECT_THAT(said.warnings, IsEmpty());
  const DepthRun routed = run_to_sieb_meyer(
      program("X1.Y1.T1G83\nG71\nX1.Y1.G73\nG70\nX2.Y2.T0\nX3.Y2.G1\nX3.Y2.T0\n"));
  EXPECT_EQ(body_in(routed.text),
            "X1.Y1.T1G83\nG71\nX1.Y1.G73\nG70\nX2.Y2.T0G83\nX3.Y2.G1\nX3.Y2.T0\n");
  EXPECT_THAT(routed.warnings, ElementsAre(HasSubstr("p.s5:7:1: warning[depth-control-assumed]")));
}

/// The manual: depth control "remains on until the execution is finished or until a G82 command is
/// called"; G71 turns it on.
TEST(SiebMeyerDepth, G82UnderG71CountsFromTheTableAndSaysSo) {
  const std::string body =
      "G71K.4\nX1.Y1.G73L1\nX2.Y1.T1\nX3.Y1.G82Z2.\nX4.Y1.\nX5.Y1.G83\n"
      "X6.Y1.G82\nX7.Y1.\nG71\nX8.Y1.\nG70\nX9.Y1.\n";
  const DepthRun run = run_to_sieb_meyer(program(body));
  ASSERT_EQ(run.strokes.size(), 8U);
  std::vector<DepthControl> controls;
  for (const Stroke& stroke : run.strokes) controls.push_back(stroke.cut.control);
  using enum DepthControl;
  EXPECT_THAT(controls,
              ElementsAre(Slm, Standard, Standard, Slm, Standard, Standard, Slm, Standard));
  EXPECT_EQ(run.strokes[1].cut.z, mm(2));
  EXPECT_EQ(run.strokes[3].cut.lower_limit, mm(2));
  EXPECT_THAT(run.warnings,
              ElementsAre(HasSubstr("p.s5:5:1: warning[depth-control-assumed]"),
                          HasSubstr("p.s5:8:1: warning[depth-control-assumed]")));
  EXPECT_EQ(body_of(body),
            "G71\nX1.Y1.G73L1\nG71K0.4\nX2.Y1.T1\nG70\nX3.Y1.Z2.\nX4.Y1.\nG71K0.4\nX5.Y1.\nG70\n"
            "X6.Y1.\nX7.Y1.\nG71K0.4\nX8.Y1.\nG70\nX9.Y1.\n");
}

/// The last of G82 and G71 holds in a line.
TEST(SiebMeyerDepth, OfG82AndG71InOneLineTheLastHolds) {
  const auto control_of = [](const std::string& line) {
    const DepthRun run =
        run_to_sieb_meyer(program("G71K.4\nX1.Y1.G73L1\n" + line + "\nX2.Y1.T1\nG70\n"));
    EXPECT_THAT(run.errors, IsEmpty());
    return run.strokes.at(0).cut.control;
  };
  EXPECT_EQ(control_of("G82G71"), DepthControl::Slm);
  EXPECT_EQ(control_of("G71G82"), DepthControl::Standard);
}

/// A map's height is no surface that the control has probed: the depth becomes a plane, and then
/// the operator's plane is gone.
TEST(SiebMeyerDepth, AnOperatorsPlaneBehindAStatedOneIsRefusedByName) {
  StringSink bytes;
  SiebMeyerWriter writer(bytes, {});
  writer.begin({.file = "p", .dialect = Dialect::SiebMeyer});
  Drill hole;
  hole.tool = 1;
  hole.cut.control = DepthControl::Depth;
  hole.cut.depth = mm(0.2);
  hole.cut.surface = mm(1.6);
  writer.put({1, {}, hole, {}, nullptr});
  hole.cut = {};
  hole.cut.control = DepthControl::Depth;
  writer.put({2, {}, hole, {}, nullptr});
  const Expected<void> done = writer.finish();
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().code, Code::TranslationRefused);
  EXPECT_EQ(done.error().place.line, 2);
  EXPECT_THAT(done.error().text(), HasSubstr("lower limit"));
}

// --- sections ----------------------------------------------------------------------------------

DepthRun kept(const std::string& body) {
  WalkOptions options;
  options.structure = Structure::Kept;
  return run_to_sieb_meyer(program(body), options);
}

/// The second copy begins with what the first one ended with.
TEST(SiebMeyerDepth, ACopyThatBeginsAtAnotherDepthIsNotKeptInAPattern) {
  const std::string alike = "X1.Y1.T1Z1.M31\nX2.Y1.Z2.\nXYM50\nX50.YM50M30\n";
  EXPECT_THAT(kept(alike).text, HasSubstr("M31"));
  for (const char* const late : {"Z2.", "K.2", "H9.", "G83"}) {
    const std::string body =
        "X9.Y9.T1Z1.\nX1.Y1.M31\nX2.Y1." + std::string(late) + "\nXYM50\nX50.YM50M30\n";
    const DepthRun run = kept(body);
    EXPECT_THAT(run.errors, IsEmpty());
    EXPECT_THAT(run.text, testing::Not(HasSubstr("M31"))) << late;
  }
}

TEST(SiebMeyerDepth, APatternLeavesTheControlAsItsCopiesBegin) {
  StringSink bytes;
  SiebMeyerWriter writer(bytes, {});
  writer.begin({.file = "p", .dialect = Dialect::Excellon});
  Drill open;
  open.tool = 1;
  Drill deep = open;
  deep.cut.control = DepthControl::Depth;
  deep.cut.depth = mm(0.2);
  const std::vector<Placement> copies(2);
  for (const auto& what : std::vector<decltype(Operation::what)>{
           PatternBegin{}, open, deep, PatternEnd{copies}, open}) {
    writer.put({1, {}, what, {}, nullptr});
  }
  ASSERT_TRUE(writer.finish());
  EXPECT_EQ(body_in(bytes.text()),
            "M31\nX0.Y0.\nX0.Y0.G83K0.2\nG82\nX0.Y0.M50\nX0.Y0.M50M30\nX0.Y0.G82\n");
}

// --- other languages ---------------------------------------------------------------------------

TEST(ForeignDepth, ExcellonNamesEveryDepthThatItCannotSay) {
  EXPECT_THAT(to_excellon("X1.Y1.T1G83\nX2.Y1.G82\n").losses,
              ElementsAre(AllOf(HasSubstr("p.s5:2: error[translation-refused]"),
                                HasSubstr("G83 without K#"))));
  EXPECT_THAT(to_excellon("G71\nX1.Y1.G73L1\nX2.Y2.T1\nG70\n").losses,
              ElementsAre(AllOf(HasSubstr("p.s5:4: error[translation-refused]"),
                                HasSubstr("G71 without K#"))));
  EXPECT_THAT(to_excellon("X1.Y1.T1T0G83\nX2.Y1.G1F1.2\nX2.Y1.T0\n").losses,
              ElementsAre(HasSubstr("p.s5:3: error[translation-refused]")));
  EXPECT_THAT(to_excellon("X1.Y1.T1\nX2.Y1.\n").losses, IsEmpty());
}

TEST(ForeignDepth, GcodeRefusesTheOperatorsDepth) {
  const DepthRun run = to_gcode("X1.Y1.T1G83\nX2.Y1.G82\n");
  EXPECT_THAT(run.failure,
              AllOf(HasSubstr("p.s5:2: error[translation-refused]"), HasSubstr("G83 without K#")));
  EXPECT_THAT(run.text, testing::Not(HasSubstr("X1 Y1")));
  EXPECT_THAT(to_gcode("G71\nX1.Y1.G73L1\nX2.Y2.T1\nG70\n").failure, HasSubstr("G71 without K#"));
}

/// The board lies at Z1.6.
TEST(ForeignDepth, GcodeKeepsToTheLimits) {
  EXPECT_THAT(to_gcode("X10.Y10.T1Z1.3G83K.4\n").failure,
              AllOf(HasSubstr("p.s5:2: error[translation-refused]"), HasSubstr("lower limit")));
  EXPECT_EQ(to_gcode("X10.Y10.T1Z1.2G83K.4\n").failure, "");
  EXPECT_THAT(to_gcode("X10.Y10.T1Z1.2G83K.4\n", std::nullopt).failure,
              HasSubstr("table_z_mm in [gcode]"));
  EXPECT_THAT(to_gcode("X10.Y10.T1H25.\n").failure,
              AllOf(HasSubstr("p.s5:2: error[translation-refused]"), HasSubstr("safe_z_mm")));
  EXPECT_EQ(to_gcode("X10.Y10.T1H20.\n").failure, "");
}

// --- property ----------------------------------------------------------------------------------

using test::any;
using test::one_in;

/// Draws programs of holes, contours, sections and surface detection, in which numbers of Z, K and
/// H come everywhere, or never.
class DepthJob {
 public:
  DepthJob() : has_z_(!one_in(3)), has_k_(!one_in(3)), has_h_(one_in(2)) {}

  std::string draw() {
    text_ = "%%5000\n";
    hole("T1");
    for (int n = any(1, 14); n > 0; --n) piece(true);
    if (is_slm_) switch_off();
    return text_ + kTools;
  }

 private:
  void line(const std::string& words) { text_ += words + '\n'; }
  static std::string number(int low, int high) {
    return fmt::format("{}.{:03}", any(low, high), any(0, 999));
  }
  /// A place that no other line has, in steps of 1 um.
  std::string place() { return fmt::format("X{}.{:03}Y{}.", ++x_, any(0, 999), any(0, 99)); }

  /// Depth words of one line; each kind once.
  std::string words(bool is_down) {
    std::string out;
    if (one_in(3)) out += one_in(2) ? "G82" : "G83";
    if (has_z_ && one_in(3)) out += "Z" + number(0, 1);
    if (has_k_ && one_in(3)) out += "K" + number(0, 2);
    if (has_h_ && !is_down && one_in(6)) out += "H" + number(10, 30);
    if (is_slm_ && one_in(5)) out += "G77";
    return out;
  }

  void hole(const std::string& tool = {}) { line(place() + tool + words(false)); }

  void contour() {
    line(place() + "T0" + words(false));
    std::string at;
    for (int n = any(1, 3); n > 0; --n) {
      at = place();
      line(at + "G1" + words(true));
    }
    line(at + "T0");
  }

  void piece(bool may_nest) {
    switch (any(0, 7)) {
      case 0:
        return contour();
      case 1:
        return is_slm_ ? switch_off() : switch_on();
      case 2:
        return is_slm_ ? surface() : hole();
      case 3:
        return may_nest && !is_slm_ ? section() : hole();
      case 4:
        return hole(one_in(2) ? "T1" : "T2");
      default:
        return hole();
    }
  }

  void switch_on() {
    is_slm_ = true;
    line(has_k_ && one_in(2) ? "G71K" + number(0, 2) : "G71");
    probe();
  }
  void switch_off() {
    is_slm_ = false;
    line("G70");
  }
  void probe() {
    n_stored_ = std::max(n_stored_, any(1, 3));
    for (int i = 1; i <= n_stored_; ++i) line(place() + "G73L" + std::to_string(i));
  }
  void surface() {
    switch (any(0, 4)) {
      case 0:
        return line("L" + std::to_string(any(1, n_stored_)));
      case 1:
        line(place() + "G73");
        line("G73L" + std::to_string(any(1, n_stored_)));
        return line("G74L" + std::to_string(any(1, n_stored_)));
      case 2:
        return line(place() + "G76");
      case 3:
        return line(has_k_ ? "G71K" + number(0, 2) : "G71");
      default:
        return probe();
    }
  }

  /// Copies carry the state on from one to the next.
  void section() {
    line("M31");
    hole();
    for (int n = any(0, 3); n > 0; --n) piece(false);
    if (is_slm_) switch_off();
    line("XYM50");
    line("X100.YM50M30");
  }

  std::string text_;
  bool has_z_;
  bool has_k_;
  bool has_h_;
  bool is_slm_ = false;
  int n_stored_ = 0;
  int x_ = 0;
};

bool near(const std::optional<Length>& a, const std::optional<Length>& b) {
  constexpr double kSame_mm = 2e-6;  // six decimals are written
  return a.has_value() == b.has_value() && (!a || std::abs((*a - *b).in_mm()) < kSame_mm);
}

bool is_same(const Stroke& a, const Stroke& b) {
  return (a.at_mm - b.at_mm).norm() < 1e-5 && a.cut.control == b.cut.control &&
         a.cut.counts_from() == b.cut.counts_from() && near(a.cut.z, b.cut.z) &&
         near(a.cut.depth, b.cut.depth) && near(a.cut.surface, b.cut.surface) &&
         near(a.cut.lower_limit, b.cut.lower_limit) && near(a.cut.upper_limit, b.cut.upper_limit);
}

void require_same(const std::vector<Stroke>& before, const std::vector<Stroke>& after) {
  RC_ASSERT(before.size() == after.size());
  for (std::size_t i = 0; i < before.size(); ++i) {
    if (!is_same(before[i], after[i])) {
      RC_LOG(fmt::format("stroke {} at ({}, {})", i, before[i].at_mm.x(), before[i].at_mm.y()));
    }
    RC_ASSERT(is_same(before[i], after[i]));
  }
}

RC_GTEST_PROP(SiebMeyerDepth, AWrittenProgramHasTheSameDepthStates, ()) {
  const std::string source = *rc::gen::exec([] { return DepthJob().draw(); });
  RC_LOG(source);
  const DepthRun before = run_to_sieb_meyer(source);
  if (!before.errors.empty()) RC_LOG(before.errors.front());
  RC_ASSERT(before.errors.empty());
  RC_LOG(before.failure);
  RC_ASSERT(before.failure.empty());
  RC_LOG(before.text);
  const DepthRun after = run_to_sieb_meyer(before.text);
  if (!after.errors.empty()) RC_LOG(after.errors.front());
  RC_ASSERT(after.errors.empty());
  require_same(before.strokes, after.strokes);
  const auto has = [&](auto is_such) { return std::ranges::any_of(before.strokes, is_such); };
  RC_CLASSIFY(has([](const Stroke& s) { return s.cut.control == DepthControl::Slm; }), "G71");
  RC_CLASSIFY(has([](const Stroke& s) { return s.cut.is_controlled() && !s.cut.depth; }), "no K");
  RC_CLASSIFY(has([](const Stroke& s) { return s.cut.lower_limit.has_value(); }), "lower limit");
  RC_CLASSIFY(!before.warnings.empty(), "G82 under G71");
}

}  // namespace
}  // namespace panelcal::written_depth
