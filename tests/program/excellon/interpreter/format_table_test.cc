// SPDX-License-Identifier: Apache-2.0
// Which of two statements about a number format counts, for each part of it, each source and each
// place in the file: docs/conventions.md, "Number format".
#include <array>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "program/excellon/text/nc_param.h"
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/program/program_run.h"
#include "tests/support/matchers.h"

namespace panelcal::excellon {
namespace {

using testing::HasSubstr;
using Lines = std::vector<std::string>;

/// All that is stated outside of the program.
struct Outside {
  std::string operator_format;  ///< --format
  std::string beside;           ///< nc_param.txt
  std::string setting;          ///< [program]
};

struct Outcome {
  std::string x;      ///< of the last hole, in mm; "error" where the program is refused
  Lines diagnostics;  ///< about formats
};

Outcome run(const std::string& program, const Outside& outside) {
  ReadOptions reading;
  const auto parsed = [](const std::string& text, const char* from) {
    PartialFormat format = text.empty() ? PartialFormat() : *parse_format(text);
    format.from = from;
    return format;
  };
  reading.forced_format = parsed(outside.operator_format, "--format");
  reading.last_format = parsed(outside.setting, "[program]");
  if (!outside.beside.empty()) {
    reading.format_beside = *read_nc_param({"nc_param.txt", outside.beside});
  }
  DiagnosticLog log;
  const Program loaded = load_program({"p.exc", program}, log, reading);
  const Survey survey = check(loaded, {}, log).survey;
  Outcome out;
  test::Recorder executed;
  if (!log.has_errors()) execute(loaded, {}, survey, executed, log);
  out.x =
      log.has_errors() ? "error" : fmt::format("{:.6g}", executed.holes().back().nominal_mm().x());
  for (const std::string& line : test::briefs(log)) {
    const bool is_about_formats =
        line.find("error") != line.npos || line.find("format-") != line.npos;
    if (is_about_formats) out.diagnostics.push_back(line);
  }
  return out;
}

/// A source, by a letter: F --format; C a comment and H INCH or METRIC in the header; W INCH or
/// METRIC, M M71 or M72 and D a comment in the body; N nc_param.txt; S [program].
using Statements = std::map<char, std::string>;

/// The program and what lies beside it, in which these sources have these statements: those of the
/// body in this order.
Outcome run_statements(const Statements& of,
                       const std::string& order,
                       const std::string& header,
                       const std::string& place) {
  const auto said = [&](char source) {
    const auto found = of.find(source);
    return found == of.end() ? std::string() : found->second;
  };
  std::string body;
  for (const char source : order) {
    if (std::string_view("WMD").find(source) != std::string_view::npos) body += said(source);
  }
  const std::string program = said('C') + "M48\n" + (of.contains('H') ? said('H') : header) +
                              "R,H\n%\nT1\n" + body + place + "M30\n";
  return run(program, {said('F'), said('N'), said('S')});
}

/// Two sources and the one that counts; e: the program contradicts itself.
struct Pair {
  std::string sources;
  std::string winner;
};

/// Each pair twice: either source may have either value.
///
/// In     values: of the part, with the place of X5.0 or X5000 in it, by 0 and 1
void expect_winners(const std::vector<Pair>& pairs,
                    const std::array<Statements, 2>& values,
                    const std::array<std::string, 2>& places_mm,
                    const std::string& header,
                    const std::string& place) {
  for (const Pair& pair : pairs) {
    for (const std::size_t i : {0U, 1U}) {
      const char a = pair.sources[0];
      const char b = pair.sources[1];
      const Statements both = {{a, values.at(i).at(a)}, {b, values.at(1 - i).at(b)}};
      const Outcome out = run_statements(both, pair.sources, header, place);
      std::string expected = "error";
      if (pair.winner[0] == a) expected = places_mm.at(i);
      if (pair.winner[0] == b) expected = places_mm.at(1 - i);
      EXPECT_EQ(out.x, expected) << pair.sources << i << ' '
                                 << testing::PrintToString(out.diagnostics);
      if (expected != "error") continue;
      EXPECT_THAT(out.diagnostics, testing::Contains(HasSubstr("error[argument-invalid]")))
          << pair.sources << i;
    }
  }
}

TEST(FormatTable, Unit) {
  const auto values = [](bool is_inch) -> Statements {
    const std::string word = is_inch ? "INCH" : "METRIC";
    const std::string small = is_inch ? "inch" : "metric";
    return {{'F', small},
            {'C', "; FORMAT={-:-/ absolute / " + small + " / decimal}\n"},
            {'H', word + "\n"},
            {'W', word + "\n"},
            {'M', is_inch ? "M72\n" : "M71\n"},
            {'D', ";FORMAT={-:-/ " + small + "}\n"},
            {'N', std::string("OUTPUT-UNITS ") + (is_inch ? "ENGLISH\n" : "METRIC\n")},
            {'S', small}};
  };
  const std::vector<Pair> pairs = {
      {"FC", "F"}, {"FH", "F"}, {"FW", "F"}, {"FM", "F"}, {"FD", "F"}, {"FN", "F"}, {"FS", "F"},
      {"CH", "H"}, {"CW", "e"}, {"CM", "e"}, {"CD", "e"}, {"CN", "C"}, {"CS", "C"}, {"HW", "e"},
      {"HM", "M"}, {"HD", "e"}, {"HN", "H"}, {"HS", "H"}, {"WM", "M"}, {"MW", "e"}, {"WD", "e"},
      {"DW", "e"}, {"WN", "W"}, {"WS", "W"}, {"MD", "e"}, {"DM", "e"}, {"MN", "M"}, {"MS", "M"},
      {"DN", "e"}, {"DS", "e"}, {"NS", "N"}};
  const std::array values_of = {values(false), values(true)};
  expect_winners(pairs, values_of, {"5", "127"}, "", "X5.0Y5.0\n");
  // All digits, so that zeros do not matter: 000.000 or 00.0000, as the unit has it.
  expect_winners(pairs, values_of, {"50.8", "129.032"}, "", "X050800Y050800\n");
}

TEST(FormatTable, Zeros) {
  const auto values = [](bool is_leading) -> Statements {
    const std::string word = is_leading ? "METRIC,LZ\n" : "METRIC,TZ\n";
    const std::string comment = std::string(";FORMAT={-:-/ metric / suppress ") +
                                (is_leading ? "trailing}\n" : "leading}\n");
    return {{'F', is_leading ? "lz" : "tz"},
            {'C', comment},
            {'H', word},
            {'W', word},
            {'D', comment},
            {'N', is_leading ? "SUPPRESS-TRAIL-ZEROES YES\n" : "SUPPRESS-LEAD-ZEROES YES\n"},
            {'S', is_leading ? "lz" : "tz"}};
  };
  expect_winners({{"FC", "F"}, {"FH", "F"}, {"FW", "F"}, {"FD", "F"}, {"FN", "F"}, {"FS", "F"},
                  {"CH", "H"}, {"CW", "e"}, {"CD", "e"}, {"CN", "C"}, {"CS", "C"}, {"HW", "e"},
                  {"HD", "e"}, {"HN", "H"}, {"HS", "H"}, {"WD", "e"}, {"DW", "e"}, {"WN", "W"},
                  {"WS", "W"}, {"DN", "e"}, {"DS", "e"}, {"NS", "N"}},
                 {values(false), values(true)},
                 {"5", "500"},
                 "METRIC\n",
                 "X5000Y5000\n");
}

TEST(FormatTable, Digits) {
  const auto values = [](int before, int behind) -> Statements {
    const std::string mask = std::string(before, '0') + '.' + std::string(behind, '0');
    const std::string comment = fmt::format(";FILE_FORMAT={}:{}\n", before, behind);
    return {{'F', fmt::format("{}.{}", before, behind)},
            {'C', comment},
            {'H', "METRIC,TZ," + mask + "\n"},
            {'D', comment},
            {'N', fmt::format("INTEGER-PLACES {}\nDECIMAL-PLACES {}\n", before, behind)},
            {'S', fmt::format("{}.{}", before, behind)}};
  };
  expect_winners({{"FC", "F"},
                  {"FH", "F"},
                  {"FD", "F"},
                  {"FN", "F"},
                  {"FS", "F"},
                  {"CH", "H"},
                  {"CD", "e"},
                  {"CN", "C"},
                  {"CS", "C"},
                  {"HD", "H"},
                  {"HN", "H"},
                  {"HS", "H"},
                  {"DN", "e"},
                  {"DS", "e"},
                  {"NS", "N"}},
                 {values(4, 2), values(3, 4)},
                 {"50", "0.5"},
                 "METRIC,TZ\n",
                 "X5000Y5000\n");
}

// --- parts that hang together --------------------------------------------------------------------

constexpr const char* kPlaces = "T1\nX5000Y5000\nM30\n";

TEST(FormatTable, CodesThatTheOperatorOverrulesChangeNoDigits) {
  const std::string head = "M48\nMETRIC,TZ,0000.00\n%\nT1\n";
  for (const char* format : {"metric", "metric,tz", "metric,tz,4.2"}) {
    for (const char* body :
         {"M72\nX5000Y5000\n", "X5000Y5000\nM72\nX5000Y1000\n", "INCH\nX5000Y1\n"}) {
      const Outcome out = run(head + body + "M30\n", {.operator_format = format});
      EXPECT_EQ(out.x, "50") << format << body;
      EXPECT_THAT(out.diagnostics, testing::ElementsAre(HasSubstr("warning[format-overridden]")))
          << format << body;
    }
  }
  EXPECT_EQ(run(head + "M72\nX5000Y5000\nM30\n", {}).x, "12.7");  // inch 00.0000
  EXPECT_EQ(run(head + "X5000Y5000\nM72\nX5000Y1000\nM30\n", {}).diagnostics,
            Lines{"p.exc:6:1: error[command-misplaced]"});
}

TEST(FormatTable, DigitsOfAUnitAreThoseThatItWasStatedWithLast) {
  EXPECT_EQ(run("M48\nMETRIC,TZ,0000.00\n%\nT1\nM72\nM71\nX5000Y5000\nM30\n", {}).x, "50");
}

/// A comment is about all numbers of the file.
TEST(FormatTable, CodesDoNotChangeTheUnitOfAComment) {
  const std::string metric = "; FORMAT={3:3/ absolute / metric / suppress leading zeros}\n";
  const std::string plain = metric + "M48\nT1C0.8\n%\nM72\n" + kPlaces;
  EXPECT_EQ(run(plain, {}).diagnostics, Lines{"p.exc:5:1: error[argument-invalid]"});
  EXPECT_EQ(run(metric + "M48\nMETRIC,TZ\n%\nM72\n" + kPlaces, {}).diagnostics,
            Lines{"p.exc:5:1: error[argument-invalid]"});
  EXPECT_EQ(run(metric + "M72\n" + kPlaces, {}).diagnostics,
            Lines{"p.exc:2:1: error[argument-invalid]"});
  EXPECT_EQ(run(plain, {.operator_format = "metric"}).x, "5");
  EXPECT_EQ(run(plain, {.operator_format = "inch,tz,2.4"}).x, "12.7");
  EXPECT_EQ(run(metric + "M48\n%\nT1\nM71\nX5000Y5000\nM30\n", {}).x, "5");
}

/// Digits and zeros of a comment are those of the unit that it was written in, whether it says so
/// or not.
TEST(FormatTable, CodesDoNotChangeTheUnitBehindDigitsOrZerosOfAComment) {
  const std::string inch = std::string("INCH,TZ\n%\nT1\nM71\n") + "X7500Y7500\nM30\n";
  const Lines refused{"p.exc:6:1: error[argument-invalid]"};
  EXPECT_EQ(run("M48\n;FILE_FORMAT=2:5\n" + inch, {}).diagnostics, refused);
  EXPECT_EQ(run("M48\n; FORMAT={-:-/ suppress leading}\n" + inch, {}).diagnostics, refused);
  EXPECT_EQ(run(";FILE_FORMAT=4:2\nM48\nMETRIC,TZ\n%\nT1\nM72\nX7500Y7500\nM30\n", {}).diagnostics,
            refused);
  EXPECT_EQ(run("M48\nINCH,TZ\n%\nT1\n;FILE_FORMAT=2:4\nM71\nX7500Y7500\nM30\n", {}).diagnostics,
            refused);
  const Outcome ruled = run("M48\n;FILE_FORMAT=2:5\n" + inch, {.operator_format = "3.3"});
  EXPECT_EQ(ruled.x, "7.5");
  EXPECT_EQ(run("M48\n;FILE_FORMAT=2:5\nINCH,TZ\n%\nT1\nM72\nX7500Y7500\nM30\n", {}).x, "1.905");
}

/// Zeros and digits count for all of the program, as the unit does.
TEST(FormatTable, WordsOfAHeaderContradictEachOtherInNoPart) {
  const auto outcome = [](const std::string& lines, const std::string& operator_format = "") {
    return run("M48\n" + lines + "%\n" + kPlaces, {.operator_format = operator_format});
  };
  const Lines third{"p.exc:3:1: error[argument-invalid]"};
  for (const char* lines : {"METRIC,TZ,000.000\nMETRIC,TZ,0000.00\n",
                            "METRIC,LZ\nMETRIC,TZ\n",
                            "METRIC,TZ,0000.00\nMETRIC,000.000\n"}) {
    EXPECT_EQ(outcome(lines).diagnostics, third) << lines;
  }
  EXPECT_EQ(outcome("METRIC,LZ\nMETRIC\nMETRIC,TZ\n").diagnostics,
            Lines{"p.exc:4:1: error[argument-invalid]"});
  const std::string two_headers = "METRIC,LZ\n%\nM48\nMETRIC,TZ\n";
  EXPECT_EQ(outcome(two_headers).diagnostics, Lines{"p.exc:5:1: error[argument-invalid]"});
  EXPECT_EQ(outcome(two_headers, "tz").x, "5");
  EXPECT_EQ(outcome("METRIC,0000.00\nMETRIC,TZ,000.000\n", "3.3").x, "5");
  EXPECT_EQ(outcome("METRIC,0000.00\nMETRIC,TZ\nMETRIC,0000.00,TZ\n").x, "50");
}

TEST(FormatTable, DrillsOfTheHeaderAreInItsUnitAndHolesInThatOfTheBody) {
  const Outcome metric_holes =
      run("M48\nINCH\nT1C0.02\n%\nM71\nT1\nX7500Y5000\nX10000Y12000\nM30\n", {});
  EXPECT_EQ(metric_holes.x, "10");
  EXPECT_EQ(metric_holes.diagnostics, Lines{"p.exc:7:1: warning[format-assumed]"});
  const Outcome inch_holes =
      run("M48\nMETRIC\nT1C0.8\n%\nM72\nT1\nX7500Y5000\nX10000Y12000\nM30\n", {});
  EXPECT_EQ(inch_holes.x, "25.4");
}

TEST(FormatTable, DigitsOfTheLastSettingAreThoseOfItsUnit) {
  const std::string body_metric = std::string("M48\nINCH,TZ\n%\nM71\n") + kPlaces;
  const Outcome warned = run(body_metric, {.setting = "metric,4.2"});
  EXPECT_EQ(warned.x, "50");
  EXPECT_EQ(warned.diagnostics, Lines{"p.exc:6:1: warning[format-assumed]"});
  const std::string inch = std::string("M48\nINCH,TZ\n%\n") + kPlaces;
  const Outcome usual = run(inch, {.setting = "4.2"});
  EXPECT_EQ(usual.x, "12.7");
  EXPECT_EQ(usual.diagnostics, Lines{});
  EXPECT_EQ(run(inch, {.setting = "inch,2.3"}).x, "127");
}

/// Zeros of a file beside the program that is in another unit are those of other programs.
TEST(FormatTable, ZerosOfAFileBesideItAreThoseOfItsUnit) {
  const Outside other{.beside = "OUTPUT-UNITS ENGLISH\nSUPPRESS-LEAD-ZEROES YES\n"};
  EXPECT_EQ(run("M48\nMETRIC\n%\nT1\nX1234Y2345\nX1111Y1112\nM30\n", other).diagnostics,
            Lines{"p.exc:5:1: error[format-ambiguous]"});
  EXPECT_EQ(run("M48\nINCH\n%\nT1\nX1234Y2345\nX10000Y1112\nM30\n", other).x, "25.4");
}

TEST(FormatTable, TheOrderOfCommentsAndUnitsDoesNotMatter) {
  const std::string digits = ";FILE_FORMAT=3:4\n";
  const std::string inch = "; FORMAT={2:4/ inch / suppress trailing zeros}\n";
  const std::string metric = "METRIC,TZ\n";
  for (const std::string& lines : {digits + inch + metric,
                                   inch + digits + metric,
                                   metric + digits + inch,
                                   digits + metric + inch,
                                   inch + metric + digits}) {
    const Outcome out = run("M48\n" + lines + "%\n" + kPlaces, {});
    EXPECT_EQ(out.x, "0.5") << lines;
    EXPECT_EQ(out.diagnostics, Lines{}) << lines;
  }
}

TEST(FormatTable, CommentsOfAHeaderContradictEachOtherNowhere) {
  const auto errors = [](const std::string& lines, const Outside& outside = {}) {
    return run("M48\n" + lines + "%\n" + kPlaces, outside).diagnostics;
  };
  const Lines third{"p.exc:4:1: error[argument-invalid]"};
  EXPECT_EQ(errors("METRIC,TZ\n;FILE_FORMAT=4:4\n;FILE_FORMAT=3:3\n"), third);
  EXPECT_EQ(errors("METRIC\n; FORMAT={3:3/ metric/ suppress leading}\n"
                   "; FORMAT={3:3/ metric/ suppress trailing}\n"),
            third);
  EXPECT_EQ(errors("METRIC,TZ,000.000\n;FILE_FORMAT=4:4\n;FILE_FORMAT=3:3\n"), Lines{});
  EXPECT_EQ(errors("METRIC,TZ\n;FILE_FORMAT=4:4\n;FILE_FORMAT=4:4\n"), Lines{});
  const Outside operators{.operator_format = "4.4"};
  EXPECT_THAT(errors("METRIC,TZ\n;FILE_FORMAT=4:4\n;FILE_FORMAT=3:3\n", operators),
              testing::ElementsAre("p.exc:4:1: warning[format-overridden]"));
}

/// As gerbv's example ekf2 has it, here with another unit.
TEST(FormatTable, TheOperatorRulesOverASecondHeader) {
  const std::string program = "M48\nMETRIC,TZ\n%\nM72\nM48\n%\nT1\nX5000Y5000\nM30\n";
  EXPECT_THAT(run(program, {}).diagnostics,
              testing::Contains("p.exc:4:1: error[argument-invalid]"));
  EXPECT_EQ(run(program, {.operator_format = "metric"}).x, "5");
  const std::string again = "M48\nMETRIC,TZ\n%\nMETRIC,LZ\nT1\nX5000Y5000\nM30\n";
  EXPECT_EQ(run(again, {}).diagnostics, Lines{"p.exc:4:1: error[argument-invalid]"});
  const Outcome ruled = run(again, {.operator_format = "tz"});
  EXPECT_EQ(ruled.x, "5");
  EXPECT_EQ(ruled.diagnostics, Lines{"p.exc:4:1: warning[format-overridden]"});
}

TEST(FormatTable, NamesEachLineThatTheOperatorOverrules) {
  const Outcome out = run("M48\nINCH,TZ\n%\nT1\n;FILE_FORMAT=2:5\nX5000Y5000\nM30\n",
                          {.operator_format = "inch,tz,2.4"});
  EXPECT_EQ(out.x, "12.7");
  EXPECT_EQ(out.diagnostics, Lines{"p.exc:5:1: warning[format-overridden]"});
}

}  // namespace
}  // namespace panelcal::excellon
