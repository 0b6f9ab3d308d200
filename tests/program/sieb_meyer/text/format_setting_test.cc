// SPDX-License-Identifier: Apache-2.0
// Whose word counts: that of the digits behind %%, of --format, or of the control's setting.
#include "program/sieb_meyer/text/format_setting.h"

#include <string>
#include <string_view>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal::sieb_meyer {
namespace {

using test::Reports;
using testing::ElementsAre;
using testing::IsEmpty;

PartialFormat stated(std::string_view text, std::string from) {
  PartialFormat format;
  if (text.empty()) return format;
  format = *parse_format(text);
  format.from = std::move(from);
  return format;
}

struct Choice {
  std::string summary;
  std::string evidence;
  SubprogramNumbers subprograms = SubprogramNumbers::OfProgram;
  std::vector<std::string> diagnostics;
};

/// In     option: of --format; setting: of [program]; both may be empty
Choice choose(std::string_view mark, std::string_view option, std::string_view setting = "") {
  const auto known = parse_format_mark(mark);
  EXPECT_TRUE(known) << mark;
  if (!known) return {};
  const ReadOptions reading{.forced_format = stated(option, "--format " + std::string(option)),
                            .last_format = stated(setting, "[program]")};
  DiagnosticLog log;
  const Reporter reporter("p.ss", log);
  const FormatChoice choice = choose_format(*known, mark, 2, 1, reading, reporter);
  Choice out{summary(choice.format), choice.evidence, choice.subprograms, {}};
  for (const Diagnostic& diagnostic : log.kept()) out.diagnostics.push_back(diagnostic.text());
  return out;
}

// --- what a mark states --------------------------------------------------------------------------

TEST(FormatMark, NamesOneOfThreeFormatsOrItsSpecialCases) {
  EXPECT_EQ(parse_format_mark("%%")->file, FileFormat::F1000);
  EXPECT_EQ(parse_format_mark("%%")->setting, "");
  EXPECT_EQ(parse_format_mark("%%1000")->file, FileFormat::F1000);
  EXPECT_EQ(parse_format_mark("%%3000")->file, FileFormat::F3000);
  EXPECT_EQ(parse_format_mark("%%5000")->setting, "5000");
  EXPECT_FALSE(parse_format_mark("%%5000")->is_special);
  EXPECT_TRUE(parse_format_mark("%%5001")->is_special);
  EXPECT_EQ(parse_format_mark("%%3010")->file, FileFormat::F3000);
  EXPECT_TRUE(parse_format_mark("%%1010")->is_special);
}

TEST(FormatMark, IsNothingElse) {
  for (const char* const text :
       {"", "%5000", "%%500", "%%50000", "%%5011", "%%4000", "%%0001", "%%A", "%% 5000"}) {
    EXPECT_FALSE(parse_format_mark(text)) << text;
  }
}

// --- the program's own ---------------------------------------------------------------------------

/// "When the program is loaded another format than the default format is used."
TEST(FormatChoice, TheDigitsOfTheMarkRuleOverTheControl) {
  for (const char* const setting : {"", "metric", "lz", "metric,lz,4.2", "2.4"}) {
    const Choice choice = choose("%%5000", "", setting);
    EXPECT_EQ(choice.summary, "format 5000, 0.001 mm without a decimal point") << setting;
    EXPECT_THAT(choice.diagnostics, IsEmpty()) << setting;
  }
}

TEST(FormatChoice, AMarkInMillimetresIsObeyedOnAControlInInchWithAWarning) {
  for (const char* const setting : {"inch", "inch,tz,2.4"}) {
    const Choice choice = choose("%%3000", "", setting);
    EXPECT_EQ(choice.summary, "format 3000, 0.001 mm without a decimal point");
    EXPECT_THAT(choice.diagnostics,
                ElementsAre(Reports("p.ss:2:1: warning[format-overridden]", "[program]")));
  }
  EXPECT_THAT(choose("%%3000", "metric", "inch").diagnostics, IsEmpty());
}

// --- --format ------------------------------------------------------------------------------------

TEST(FormatChoice, TheOptionRulesOverTheMarkWithAWarning) {
  const auto overridden = ElementsAre(Reports("p.ss:2:1: warning[format-overridden]", "--format"));
  Choice choice = choose("%%5000", "inch");
  EXPECT_EQ(choice.summary, "format 5000 in inch, 0.0001 inch without a decimal point");
  EXPECT_EQ(choice.evidence, "--format inch");
  EXPECT_THAT(choice.diagnostics, overridden);
  choice = choose("%%5000", "inch,lz,2.3");
  EXPECT_EQ(choice.summary,
            "format 5000 in inch, 2.3 digits from the left without a decimal point");
  EXPECT_THAT(choice.diagnostics, overridden);
  choice = choose("%%3000", "3.4");
  EXPECT_EQ(choice.summary, "format 3000, 0.0001 mm without a decimal point");
  EXPECT_THAT(choice.diagnostics, overridden);
}

TEST(FormatChoice, AnOptionThatStatesTheSameIsNoContradiction) {
  for (const char* const option : {"metric", "tz", "metric,tz,3.3", "4.3"}) {
    EXPECT_THAT(choose("%%5000", option).diagnostics, IsEmpty()) << option;
  }
}

TEST(FormatChoice, TheDigitsOfAnOptionInInchAreThoseOfAControlInInch) {
  const Choice choice = choose("%%5000", "inch", "inch,2.3");
  EXPECT_EQ(choice.summary, "format 5000 in inch, 0.001 inch without a decimal point");
  EXPECT_EQ(choice.evidence, "--format inch and [program]");
  EXPECT_EQ(choose("%%5000", "inch", "metric,4.2").summary,
            "format 5000 in inch, 0.0001 inch without a decimal point");
  // Digits without units are millimetres' (docs/formats/machine_toml.md).
  EXPECT_EQ(choose("%%5000", "inch", "2.3").summary,
            "format 5000 in inch, 0.0001 inch without a decimal point");
  EXPECT_THAT(choose("%%1000", "inch", "2.3").diagnostics,
              ElementsAre(Reports("p.ss:2:1: error[format-ambiguous]", "0.001 inch")));
}

/// %%5000 keeps trailing zeros, but in millimetres; the control leading ones, but for programs that
/// state no format.
TEST(FormatChoice, TheZerosOfAnOptionInInchAreOpenOnAControlWithLeadingOnes) {
  for (const char* const setting : {"inch,lz,2.4", "lz"}) {
    EXPECT_THAT(choose("%%5000", "inch", setting).diagnostics,
                ElementsAre(Reports("p.ss:2:1: error[format-ambiguous]", "[program]")))
        << setting;
  }
  for (const char* const option : {"inch,tz", "inch,lz,2.4"}) {
    EXPECT_THAT(choose("%%5000", option, "inch,lz,2.4").diagnostics,
                ElementsAre(Reports("p.ss:2:1: warning[format-overridden]", option)))
        << option;
  }
  EXPECT_THAT(choose("%%5000", "inch", "metric,lz,3.3").diagnostics,
              ElementsAre(Reports("p.ss:2:1: warning[format-overridden]", "--format inch")));
}

/// "leading or trailing zeros" (A.1), but no number of digits before the point.
TEST(FormatChoice, LeadingZerosNeedDigits) {
  const auto open = ElementsAre(Reports("p.ss:2:1: error[format-ambiguous]", "unknown number"));
  EXPECT_THAT(choose("%%5000", "lz").diagnostics, open);
  EXPECT_THAT(choose("%%3000", "inch,lz").diagnostics, open);
  EXPECT_EQ(choose("%%5000", "lz,3.3").summary,
            "format 5000, 3.3 digits from the left without a decimal point");
}

// --- subprograms ---------------------------------------------------------------------------------

/// They have no %%, and no sentence of the manual says whether that of the program holds for them.
TEST(FormatChoice, LeavesSubprogramsOpenWhereTheControlHasOtherNumbers) {
  const auto of = [](std::string_view mark, std::string_view option, std::string_view setting) {
    return choose(mark, option, setting).subprograms;
  };
  EXPECT_EQ(of("%%5000", "", "inch,tz,2.4"), SubprogramNumbers::Open);
  EXPECT_EQ(of("%%5000", "metric", "inch,lz,2.4"), SubprogramNumbers::OpenWithoutPoint);
  EXPECT_EQ(of("%%5000", "tz", "inch,lz,2.4"), SubprogramNumbers::Open);
  for (const char* const setting : {"metric,lz,3.3", "4.2", "lz"}) {
    EXPECT_EQ(of("%%5000", "", setting), SubprogramNumbers::OpenWithoutPoint) << setting;
  }
  for (const char* const setting : {"", "metric", "metric,tz,3.3", "tz,4.3"}) {
    EXPECT_EQ(of("%%5000", "", setting), SubprogramNumbers::OfProgram) << setting;
  }
  EXPECT_EQ(of("%%5000", "metric,tz,3.3", "inch,lz,2.4"), SubprogramNumbers::OfProgram);
  EXPECT_EQ(of("%%5000", "inch", "inch,tz,2.4"), SubprogramNumbers::OfProgram);
  EXPECT_EQ(of("%%5000", "inch", ""), SubprogramNumbers::OfProgram);
  EXPECT_EQ(of("%%5001", "", "inch,tz,2.4"), SubprogramNumbers::OfProgram);
  // The control's numbers are those of %%, whether the setting counts or not.
  EXPECT_EQ(of("%%", "", "metric,tz,3.3"), SubprogramNumbers::OfProgram);
  EXPECT_EQ(of("%%", "", "3.3"), SubprogramNumbers::OfProgram);
}

/// It has no decimal points, and its step in inch is not known.
TEST(FormatChoice, Format1000InInchNeedsDigits) {
  EXPECT_THAT(choose("%%1000", "inch").diagnostics,
              ElementsAre(Reports("p.ss:2:1: error[format-ambiguous]", "\"%%1000\"")));
  const Choice choice = choose("%%1000", "inch,2.3");
  EXPECT_EQ(choice.summary, "format 1000 in inch, 0.001 inch, no decimal points");
  EXPECT_THAT(choice.diagnostics,
              ElementsAre(Reports("p.ss:2:1: warning[format-overridden]", "\"%%1000\"")));
}

// --- the control's setting -----------------------------------------------------------------------

TEST(FormatChoice, AMarkWithoutDigitsLeavesTheNumbersToTheControl) {
  EXPECT_THAT(choose("%%", "").diagnostics, IsEmpty());
  EXPECT_EQ(choose("%%", "").summary, "format 1000, 0.01 mm, no decimal points");
  const Choice choice = choose("%%", "", "inch,tz,2.3");
  EXPECT_EQ(choice.summary, "format 1000 in inch, 0.001 inch, no decimal points");
  EXPECT_EQ(choice.evidence, "[program]");
  EXPECT_THAT(choice.diagnostics,
              ElementsAre(Reports("p.ss:2:1: warning[format-assumed]", "[program]")));
  EXPECT_THAT(choose("%%", "", "metric,tz,3.2").diagnostics, IsEmpty());
}

/// Digits that are stated for programs in the other language are no setting of this control: 3.3
/// would make 1 mm of the manual's X1000 = 10.0 mm (A.5).
TEST(FormatChoice, APartOfASettingDoesNotCountForAMarkWithoutDigits) {
  const auto warned = ElementsAre(Reports("p.ss:2:1: warning[format-assumed]", "[program]"));
  for (const char* const setting : {"3.3", "metric,3.3", "lz", "metric,lz", "lz,3.3", "tz,4.4"}) {
    const Choice choice = choose("%%", "", setting);
    EXPECT_EQ(choice.summary, "format 1000, 0.01 mm, no decimal points") << setting;
    EXPECT_EQ(choice.evidence, "") << setting;
    EXPECT_THAT(choice.diagnostics, warned) << setting;
  }
  for (const char* const setting : {"metric", "tz", "metric,tz", "4.2"}) {
    EXPECT_THAT(choose("%%", "", setting).diagnostics, IsEmpty()) << setting;
  }
  EXPECT_EQ(choose("%%", "3.3", "lz").summary, "format 1000, 0.001 mm, no decimal points");
}

/// A control that is set to inch has no program in millimetres but those that say so.
TEST(FormatChoice, AMarkWithoutDigitsIsOpenOnAControlInInchWithoutZerosOrDigits) {
  const auto open = ElementsAre(Reports("p.ss:2:1: error[format-ambiguous]", "[program]"));
  for (const char* const setting : {"inch", "inch,2.3", "inch,tz"}) {
    EXPECT_THAT(choose("%%", "", setting).diagnostics, open) << setting;
    EXPECT_EQ(choose("%%", "metric", setting).summary, "format 1000, 0.01 mm, no decimal points");
    EXPECT_THAT(choose("%%1000", "", setting).diagnostics,
                ElementsAre(Reports("p.ss:2:1: warning[format-overridden]", "[program]")));
  }
}

TEST(FormatChoice, TheOptionRulesOverTheControl) {
  const Choice choice = choose("%%", "metric,tz,3.3", "inch,lz,2.4");
  EXPECT_EQ(choice.summary, "format 1000, 0.001 mm, no decimal points");
  EXPECT_THAT(choice.diagnostics, IsEmpty());
}

/// "Other units are special cases and not considered in this manual (Formats xx01 to xx10)."
TEST(FormatChoice, SpecialFormatsNeedAUnitZerosAndDigits) {
  for (const char* const setting : {"", "inch", "inch,tz", "inch,2.4", "tz,2.4"}) {
    EXPECT_THAT(choose("%%5001", "", setting).diagnostics,
                ElementsAre(Reports("p.ss:2:1: error[command-format]", "\"%%5001\"")))
        << setting;
  }
  Choice choice = choose("%%5001", "", "inch,tz,2.4");
  EXPECT_EQ(choice.summary, "format 5000 in inch, 0.0001 inch without a decimal point");
  EXPECT_EQ(choice.evidence, "[program]");
  EXPECT_THAT(choice.diagnostics, IsEmpty());
  choice = choose("%%3002", "inch", "inch,tz,2.4");
  EXPECT_EQ(choice.summary, "format 3000 in inch, 0.0001 inch without a decimal point");
  EXPECT_EQ(choice.evidence, "--format inch and [program]");
  EXPECT_THAT(choose("%%3002", "inch", "tz,2.4").diagnostics,
              ElementsAre(Reports("p.ss:2:1: error[command-format]", "\"%%3002\"")))
      << "2.4 of millimetres";
  EXPECT_THAT(choose("%%1003", "metric,lz,3.2").diagnostics, IsEmpty());
}

}  // namespace
}  // namespace panelcal::sieb_meyer
