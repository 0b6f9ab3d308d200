// SPDX-License-Identifier: Apache-2.0
// Outputs of SIEB & MEYER programs in inch state their unit, whatever the control is set to.
#include <string>
#include <string_view>
#include <vector>

#include "program/sieb_meyer/text/cnc_commands.h"
#include "program/walk/walk.h"
#include "program/writers/excellon/writer.h"
#include "program/writers/sieb_meyer/writer.h"
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/sieb_meyer/manual_run.h"

namespace panelcal {
namespace {

using test::expect_places;
using test::hole_places;
using test::run_program;
using testing::AllOf;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

ReadOptions control(std::string_view setting) {
  ReadOptions reading;
  reading.last_format = *parse_format(setting);
  reading.inch_rates = RateUnit::InchesPerMinute;
  return reading;
}

struct Output {
  std::string text;
  std::vector<std::string> losses;
  bool is_refused = false;
};

/// Of a program on a control that is set to inch.
template <class Writer>
Output written(const std::string& text) {
  DiagnosticLog log;
  const Program program = load_program({"p", text}, log, control("inch,tz,2.4"));
  NominalSource targets;
  const Survey found = survey(program, {}, targets, log);
  EXPECT_FALSE(log.has_errors());
  StringSink bytes;
  Writer writer(bytes, ProgramWriterOptions{.allow_losses = true});
  execute(program, {}, found, writer, log);
  EXPECT_TRUE(writer.finish());
  Output output{bytes.text(), {}, writer.losses().has_errors()};
  for (const Diagnostic& loss : writer.losses().kept()) output.losses.push_back(loss.text());
  return output;
}

const std::string kTable = "$\nT1D.04F80.Z.002\n$\n";
const std::string kProgram = "%%5001\nX1.Y2.T1\nX30000Y-.5\n" + kTable;

TEST(SiebMeyerInchOutput, IsInMillimetresAndStatesIt) {
  const Output output = written<SiebMeyerWriter>(
      "%%5001\nM49,FP5001\nM49,MAPT.04\nM49,BOTT,R.002\nM49,BOTL5\nH.5Z.1\nX1.Y2.T1\n"
      "X2.Y2.G81I.2P50J.05W800\n" +
      kTable);
  EXPECT_THAT(output.losses, IsEmpty());
  EXPECT_THAT(output.text,
              AllOf(HasSubstr("%%5000\n"),
                    HasSubstr("\nM49,MAPT1.016\n"),
                    HasSubstr("\nM49,BOTT,R0.05\n"),
                    HasSubstr("\nM49,BOTL5\n"),
                    HasSubstr("\nH12.700\n"),
                    HasSubstr("\nX25.4Y50.8T1Z2.54\n"),
                    HasSubstr("\nG81I5.08P50J1.27W800\n"),
                    HasSubstr("\nT1D1.016F2.032Z0.051\n"),
                    Not(HasSubstr("FP"))));
}

/// It reads back alike on any control: the digits behind %% are the format.
TEST(SiebMeyerInchOutput, DoesNotDependOnTheControl) {
  const Output same = written<SiebMeyerWriter>(kProgram);
  const Output excellon = written<ExcellonWriter>(kProgram);
  EXPECT_FALSE(same.is_refused);
  EXPECT_THAT(excellon.text, HasSubstr("\nINCH,LZ\n"));
  for (const char* const setting : {"inch,lz,2.4", "metric,tz,3.3", "metric,lz,4.2"}) {
    for (const std::string& text : {same.text, excellon.text}) {
      expect_places(hole_places(run_program(text, {}, control(setting))),
                    {{25.4, 50.8}, {76.2, -12.7}},
                    1e-6);
    }
  }
}

/// A number of a command that the manual does not describe may be a length.
TEST(SiebMeyerInchOutput, RefusesNumbersThatItCannotBringToMillimetres) {
  for (const char* const command :
       {"M49,QUIK.5", "M49,CHEK,S1XYDX.2DY0N20", "M49,TPEK,I1J2", "M49,FORB,X1.Y2.D.5"}) {
    const Output output =
        written<SiebMeyerWriter>("%%5001\n" + std::string(command) + "\nX1.Y2.T1\n" + kTable);
    EXPECT_TRUE(output.is_refused) << command;
    EXPECT_THAT(output.losses, Contains(HasSubstr(command)));
  }
  const Output without = written<SiebMeyerWriter>("%%5001\nM49,CHEKT1T2\nX1.Y2.T1\n" + kTable);
  EXPECT_FALSE(without.is_refused) << testing::PrintToString(without.losses);
  EXPECT_THAT(without.text, HasSubstr("\nM49,CHEKT1T2\n"));
}

/// The manual gives these commands letters alone: whatever stands with them otherwise is passed on.
bool takes_letters(sieb_meyer::CncCode code) {
  return code == sieb_meyer::CncCode::ProgramAreas || code == sieb_meyer::CncCode::ClearAreas ||
         code == sieb_meyer::CncCode::ForbiddenAreas;
}

bool holds_digits(std::string_view text) {
  return text.find_first_of("0123456789") != std::string_view::npos;
}

/// Of all that is obeyed, and of every form that is accepted: what is passed on can be written, but
/// for numbers that the manual does not describe.
TEST(SiebMeyerInchOutput, HasEveryCommandThatIsObeyed) {
  int n_accepted = 0;
  for (const sieb_meyer::CncInfo& row : sieb_meyer::cnc_table()) {
    if (row.treatment != sieb_meyer::Treatment::Obeyed) continue;
    for (const char* const argument : {"", "1", ".03", ",R.03", "X1.Y1.", ",A"}) {
      const std::string command = "M49," + std::string(row.name) + argument;
      const std::string text = "%%5001\n" + command + "\nX1.Y2.T1\n" + kTable;
      if (run_program(text, {}, control("inch,tz,2.4")).has_errors) continue;
      ++n_accepted;
      const Output output = written<SiebMeyerWriter>(text);
      if (takes_letters(row.code) && holds_digits(argument)) {
        EXPECT_THAT(output.losses, ElementsAre(HasSubstr("which may state lengths"))) << command;
      } else {
        EXPECT_THAT(output.losses, IsEmpty()) << command;
      }
    }
  }
  EXPECT_GE(n_accepted, 30);
}

}  // namespace
}  // namespace panelcal
