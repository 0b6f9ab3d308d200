// SPDX-License-Identifier: Apache-2.0
// A reader that takes six digits and no more accepts every program that is written, and reads the
// places that the job asked for.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "program/writers/excellon/writer.h"
#include "program/writers/output_digits.h"
#include "program/writers/sieb_meyer/writer.h"
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/program/program_run.h"

namespace panelcal {
namespace {

using test::FunctionSource;
using test::Recorder;

constexpr int kPrograms = 150;

/// How a source writes its numbers.
struct Notation {
  std::string_view name;
  std::string_view head;  ///< up to the tools
  int n_whole = 3;
  int n_decimals = 3;
  bool has_points = false;
  double largest = 100;  ///< coordinate, in the source's unit
};
constexpr auto kNotations = std::to_array<Notation>({
    {"000.000", "M48\nMETRIC,TZ\n"},
    {"0000.00", "M48\nMETRIC,TZ,0000.00\n", 4, 2},
    {"000.00", "M48\nMETRIC,TZ,000.00\n", 3, 2},
    {"00.0000", "M48\nINCH,TZ\n", 2, 4, false, 9},
    {"points", "M48\nMETRIC,TZ\n", 3, 6, true},
    {"points in 0000.00", "M48\nMETRIC,TZ,0000.00\n", 3, 6, true},
});

std::string number(const Notation& notation, double value) {
  if (notation.has_points) return fmt::format("{:.{}f}", value, notation.n_decimals);
  return std::to_string(std::llround(value * std::pow(10.0, notation.n_decimals)));
}

/// Three targets, holes and a contour with a half circle.
std::string random_program(const Notation& notation, std::mt19937& random) {
  std::uniform_real_distribution<double> place(1, notation.largest);
  const auto xy = [&](double x, double y) {
    return 'X' + number(notation, x) + 'Y' + number(notation, y);
  };
  const double most = notation.largest;
  std::string text(notation.head);
  text += "T1C1.0F100\nCP,1,1.0\n%\nG34,1\nT1\n";
  text += "G36" + xy(1, 1) + "\nG36" + xy(most, 1) + "\nG36" + xy(1, most) + '\n';
  for (int i = 0; i < 20; ++i) text += xy(place(random), place(random)) + '\n';
  const double x = place(random);
  const double y = place(random);
  text += "G00" + xy(x, y) + "\nM15\nG01" + xy(x + 1, y) + "\nG02" + xy(x + 2, y) + 'A' +
          number(notation, 0.5) + "\nM17\nG05\nM30\n";
  return text;
}

/// The digits of a number, behind a letter; empty if there is none.
std::string_view number_at(std::string_view text, std::size_t at) {
  const auto end = text.find_first_not_of("+-.0123456789", at);
  return text.substr(at, end == std::string_view::npos ? end : end - at);
}

/// The problem of a number for a control of these digits; empty if it has none.
std::string fault(std::string_view number, int n_whole, int n_decimals) {
  if (number.find('.') == std::string_view::npos) return fmt::format("{} without a point", number);
  const auto begin = number.find_first_not_of("-0");
  const std::string_view shown = number.substr(begin);  // leading zeros take no place
  const auto point = static_cast<int>(shown.find('.'));
  std::string_view decimals = shown.substr(static_cast<std::size_t>(point) + 1);
  while (decimals.ends_with('0')) decimals.remove_suffix(1);
  const auto n_behind = static_cast<int>(decimals.size());
  const bool fits = point <= n_whole && n_behind <= n_decimals && point + n_behind <= 6;
  return fits ? "" : fmt::format("{} in {} and {} digits", number, n_whole, n_decimals);
}

struct StrictReading {
  std::vector<std::string> faults;
  std::vector<Eigen::Vector2d> holes;  ///< coordinates alone in their line, in the written unit
};

double value_behind(std::string_view line, char letter) {
  const auto at = line.find(letter);
  return std::strtod(std::string(number_at(line, at + 1)).c_str(), nullptr);
}

/// Change of the radius from one end of an arc to the other, in the written unit.
double mismatch(const Eigen::Vector2d& from, const Eigen::Vector2d& to, std::string_view line) {
  const Eigen::Vector2d spoke(value_behind(line, 'I'), value_behind(line, 'J'));
  return std::abs(spoke.norm() - (to - (from - spoke)).norm());
}

/// Reads the lines of a body, as a control of these digits does.
StrictReading read_strictly(std::string_view text, int n_whole, int n_decimals) {
  StrictReading reading;
  // Of the centre's own rounding: half a diagonal at each end.
  const double most = std::sqrt(2.0) * std::pow(10.0, -n_decimals) + 1e-9;
  Eigen::Vector2d at = Eigen::Vector2d::Zero();
  while (!text.empty()) {
    const auto end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.starts_with(';') || line.starts_with('M')) continue;
    for (std::size_t i = 0; i < line.size(); ++i) {
      if (std::string_view("XYIJ").find(line[i]) == std::string_view::npos) continue;
      const std::string problem = fault(number_at(line, i + 1), n_whole, n_decimals);
      if (!problem.empty()) reading.faults.push_back(fmt::format("{}: {}", line, problem));
    }
    if (line.find('X') == std::string_view::npos) continue;
    const Eigen::Vector2d to(value_behind(line, 'X'), value_behind(line, 'Y'));
    const bool is_arc = line.find('I') != std::string_view::npos;
    if (is_arc && mismatch(at, to, line) > most) {
      reading.faults.push_back(fmt::format("{}: the radius changes", line));
    }
    at = to;
    const bool is_hole = line.starts_with('X') && !is_arc &&
                         line.find('G') == std::string_view::npos &&
                         line.find("T0") == std::string_view::npos;
    if (is_hole) reading.holes.push_back(to);
  }
  return reading;
}

struct WrittenJob {
  std::string text;
  ProgramInfo info;
  std::vector<Eigen::Vector2d> commanded_mm;  ///< of the holes
  std::string problem;
};

WrittenJob written_job(const std::string& source, Dialect to, std::mt19937& random) {
  std::uniform_real_distribution<double> shift(-0.5, 0.5);
  const Eigen::Vector2d offset_mm(0.6 + shift(random), 0.6 + shift(random));
  const double angle = 0.01 * shift(random);
  const double scale = 1 + 0.001 * shift(random);
  FunctionSource panel([&](const MeasurementRequest& request) -> Eigen::Vector2d {
    const Eigen::Vector2d p = request.nominal.in_mm();
    return offset_mm + scale * Eigen::Vector2d(p.x() - angle * p.y(), angle * p.x() + p.y());
  });
  WalkOptions options;
  DiagnosticLog log;
  const Program program = load_program({"p", source}, log);
  const Survey found = survey(program, options, panel, log);
  WrittenJob job;
  job.info = program_info(program, options);
  StringSink bytes;
  std::unique_ptr<ProgramWriter> writer;
  if (to == Dialect::Excellon) {
    writer = std::make_unique<ExcellonWriter>(bytes, ProgramWriterOptions{.allow_losses = true});
  } else {
    writer = std::make_unique<SiebMeyerWriter>(bytes, ProgramWriterOptions{.allow_losses = true});
  }
  Recorder recorder;
  if (!log.has_errors()) {
    execute(program, options, found, *writer, log);
    execute(program, options, found, recorder, log);
    if (const Expected<void> done = writer->finish(); !done) job.problem = done.error().text();
  }
  if (log.has_errors()) job.problem = log.kept().front().text();
  for (const test::Hole& hole : recorder.holes()) {
    job.commanded_mm.push_back(hole.drill.commanded.in_mm());
  }
  job.text = bytes.text();
  return job;
}

void expect_readable(const Notation& notation, Dialect to) {
  std::mt19937 random(static_cast<std::uint32_t>(notation.n_decimals * 7 + notation.n_whole));
  for (int i = 0; i < kPrograms; ++i) {
    const std::string source = random_program(notation, random);
    const WrittenJob job = written_job(source, to, random);
    SCOPED_TRACE(fmt::format("{} program {}\n{}\n{}", notation.name, i, source, job.text));
    ASSERT_EQ(job.problem, "");
    const OutputDigits digits = output_digits(to, job.info);
    const bool is_excellon = to == Dialect::Excellon;
    const auto body = job.text.find(is_excellon ? "\nG05\n" : "%%5000\n");
    ASSERT_NE(body, std::string::npos);
    const StrictReading reading =
        read_strictly(std::string_view(job.text).substr(body), digits.n_whole, digits.n_decimals);
    ASSERT_THAT(reading.faults, testing::IsEmpty());
    ASSERT_EQ(reading.holes.size(), job.commanded_mm.size());
    const double unit_mm = digits.unit == LengthUnit::Inch ? 25.4 : 1;
    const double most_mm = 0.5 * digits.step().in_mm() + 1e-9;
    for (std::size_t k = 0; k < reading.holes.size(); ++k) {
      const Eigen::Vector2d off_mm = unit_mm * reading.holes[k] - job.commanded_mm[k];
      ASSERT_LE(off_mm.cwiseAbs().maxCoeff(), most_mm) << "hole " << k;
    }
  }
}

class StrictDigits : public testing::TestWithParam<Notation> {};

TEST_P(StrictDigits, ASixDigitReaderAcceptsExcellonOutput) {
  expect_readable(GetParam(), Dialect::Excellon);
}

TEST_P(StrictDigits, ASixDigitReaderAcceptsSiebMeyerOutput) {
  expect_readable(GetParam(), Dialect::SiebMeyer);
}

INSTANTIATE_TEST_SUITE_P(Notations, StrictDigits, testing::ValuesIn(kNotations));

// --- what does not fit ---------------------------------------------------------------------------

std::string failure_of(const std::string& source, Dialect to) {
  std::mt19937 random(1);
  return written_job(source, to, random).problem;
}

/// A coordinate that fits the source's digits may leave those of the output behind a correction.
TEST(StrictDigitsRefusal, APlaceThatDoesNotFitIsAnErrorOfItsLine) {
  const std::string head = "M48\nMETRIC,TZ\nT1C1.0F100\n%\nT1\nX1.0Y1.0\n";
  EXPECT_THAT(failure_of(head + "X1000.5Y2.0\nM30\n", Dialect::Excellon),
              testing::HasSubstr("p:7: error[number-too-long]"));
  EXPECT_EQ(failure_of(head + "X999.999Y2.0\nM30\n", Dialect::Excellon), "");
  EXPECT_THAT(failure_of(head + "X999.9996Y2.0\nM30\n", Dialect::Excellon),
              testing::HasSubstr("p:7: error[number-too-long]"));
  EXPECT_EQ(failure_of(head + "X1000.5Y2.0\nM30\n", Dialect::SiebMeyer), "");
  EXPECT_THAT(failure_of(head + "X1000.125Y2.0\nM30\n", Dialect::SiebMeyer),
              testing::HasSubstr("p:7: error[number-too-long]"));
}

// --- settings
// --------------------------------------------------------------------------------------

std::string text_of(const std::string& source, Dialect to) {
  std::mt19937 random(1);
  const WrittenJob job = written_job(source, to, random);
  EXPECT_EQ(job.problem, "");
  return job.text;
}

/// The first number of CP is an index, that of PCKPARAM a tool.
TEST(StrictDigitsOfSettings, LengthsOfAHeaderHaveTheDigitsOfItsCoordinates) {
  EXPECT_THAT(
      text_of(
          "M48\nMETRIC,TZ\nCP,1,2.1234567\nDN,1.23456789\nUP,10.5\nPCKPARAM,1.2,2.00049\nT1C1.0\n"
          "%\nT1\nX1.0Y1.0\nM30\n",
          Dialect::Excellon),
      testing::AllOf(testing::HasSubstr("\nCP,1,2.123\n"),
                     testing::HasSubstr("\nDN,1.235\n"),
                     testing::HasSubstr("\nUP,10.5\n"),
                     testing::HasSubstr("\nPCKPARAM,1.2,2.000\n")));
  EXPECT_THAT(
      text_of("M48\nINCH,LZ\nCP,1,.081234567\nT1C.04\n%\nT1\nX1.0Y1.0\nM30\n", Dialect::Excellon),
      testing::HasSubstr("\nCP,1,0.0812\n"));
}

/// A tolerance becomes no larger.
TEST(StrictDigitsOfSettings, LengthsOfCncCommandsHaveTheDigitsOfCoordinates) {
  EXPECT_THAT(
      text_of(
          "%%5000\nM49,NIB.0123456\nM49,BOTR1.2345678\nM49,MAPT.5678999\nX1.Y1.T1\n$\nT1D1.\n$\n",
          Dialect::SiebMeyer),
      testing::AllOf(testing::HasSubstr("\nM49,NIB0.012\n"),
                     testing::HasSubstr("\nM49,BOTR1.235\n"),
                     testing::HasSubstr("\nM49,MAPT0.567\n")));
}

}  // namespace
}  // namespace panelcal
