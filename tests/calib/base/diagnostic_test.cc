// SPDX-License-Identifier: Apache-2.0
#include "calib/base/diagnostic.h"

#include <array>
#include <set>

#include "calib/base/expected.h"
#include "calib/base/files/byte_sink.h"
#include <gmock/gmock.h>

namespace panelcal {
namespace {

Diagnostic problem(Place place) {
  return {Code::ConfigKeyUnknown, std::move(place), "\"shap\" in [[vision.tool]]", "\"shape\""};
}

TEST(Diagnostic, ReadsLikeACompilers) {
  const std::string text =
      "error[config-key-unknown]: key not known: \"shap\" in [[vision.tool]]; expected \"shape\"";
  EXPECT_EQ(problem({"m.toml", 12, 5}).text(), "m.toml:12:5: " + text);
  EXPECT_EQ(problem({"m.toml", 12, 0}).text(), "m.toml:12: " + text);
  EXPECT_EQ(problem({"m.toml", 0, 5}).text(), "m.toml: " + text);
  EXPECT_EQ(problem({}).text(), text);
}

TEST(Diagnostic, LeavesOutAnEmptyPart) {
  const Diagnostic without_remedy = {Code::HoleOmitted, {"x", 1, 1}, "nominal (1, 2) mm", ""};
  EXPECT_EQ(without_remedy.text(),
            "x:1:1: warning[hole-omitted]: hole in a forbidden area left out: nominal (1, 2) mm");
  const Diagnostic bare = {Code::EndMissing, {"x", 1, 0}, "", "M30 or M00"};
  EXPECT_EQ(bare.text(), "x:1: error[end-missing]: file without its end; expected M30 or M00");
  EXPECT_EQ(bare.message(), "file without its end");
}

TEST(Diagnostic, EndsWithAQuestionAsItStands) {
  const Diagnostic question = {
      Code::HeaderWordUnknown, {"x", 1, 1}, "\"INHC\"", "did you mean \"INCH\"?"};
  EXPECT_EQ(
      question.text(),
      "x:1:1: error[header-word-unknown]: header command not in the manual: \"INHC\"; did you "
      "mean \"INCH\"?");
}

TEST(DiagnosticCatalogue, IsInTheOrderOfItsCodesWithoutDuplicates) {
  std::set<std::string_view> slugs;
  const auto catalogue = diagnostic_catalogue();
  for (std::size_t i = 0; i < catalogue.size(); ++i) {
    const CodeInfo& row = catalogue[i];
    EXPECT_EQ(static_cast<std::size_t>(row.code), i);
    EXPECT_EQ(&info(row.code), &row);
    EXPECT_TRUE(slugs.insert(row.slug).second) << row.slug;
  }
}

TEST(DiagnosticCatalogue, IsWellWritten) {
  for (const CodeInfo& row : diagnostic_catalogue()) {
    EXPECT_THAT(row.slug, testing::Not(testing::IsEmpty()));
    EXPECT_EQ(row.slug.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-"),
              std::string_view::npos)
        << row.slug;
    EXPECT_THAT(row.summary, testing::Not(testing::IsEmpty())) << row.slug;
    EXPECT_THAT(row.summary, testing::Not(testing::EndsWith("."))) << row.slug;
    EXPECT_THAT(row.summary, testing::Not(testing::StartsWith("A "))) << row.slug;
    EXPECT_THAT(row.summary, testing::SizeIs(testing::Le(60U))) << row.slug;
    EXPECT_THAT(row.advice, testing::EndsWith(".")) << row.slug;
  }
}

TEST(DiagnosticLog, KeepsTheFirstAndCountsTheRest) {
  DiagnosticLog log;
  EXPECT_FALSE(log.has_errors());
  constexpr int kAdded = 1000;
  for (int i = 1; i <= kAdded; ++i) log.add(problem({"a", i, 0}));
  EXPECT_EQ(log.kept().size(), DiagnosticLog::kKept);
  EXPECT_EQ(log.kept().front().place.line, 1);
  EXPECT_EQ(log.kept().back().place.line, static_cast<int>(DiagnosticLog::kKept));
  EXPECT_EQ(log.n_errors(), 1000U);
  EXPECT_EQ(log.n_warnings(), 0U);
  EXPECT_EQ(log.n_dropped(), 800U);
  EXPECT_TRUE(log.has_errors());
}

TEST(DiagnosticLog, WarningsAreNoErrors) {
  for (const CodeInfo& row : diagnostic_catalogue()) {
    DiagnosticLog log;
    log.add({row.code, {}, "", ""});
    EXPECT_EQ(log.has_errors(), row.severity == Severity::Error) << row.slug;
    EXPECT_EQ(log.n_warnings(), row.severity == Severity::Warning ? 1U : 0U) << row.slug;
  }
}

TEST(NearestWord, FindsWhatWasMeant) {
  constexpr std::array<std::string_view, 4> kKnown = {"rotate", "radius", "model", "x"};
  EXPECT_EQ(nearest_word("rotat", kKnown), "rotate");
  EXPECT_EQ(nearest_word("raduis", kKnown), "radius");
  EXPECT_EQ(nearest_word("Model", kKnown), "model");
  EXPECT_EQ(nearest_word("rotate", kKnown), "rotate");
  EXPECT_EQ(nearest_word("y", kKnown), "x");
}

TEST(NearestWord, TakesTwoSwappedLettersForOneMistake) {
  constexpr std::array<std::string_view, 2> kKnown = {"run", "survey"};
  EXPECT_EQ(nearest_word("rnu", kKnown), "run");
  EXPECT_EQ(nearest_word("nur", kKnown), "");
}

TEST(NearestWord, IsSilentWhenNothingIsNear) {
  constexpr std::array<std::string_view, 2> kKnown = {"rotate", "radius"};
  EXPECT_EQ(nearest_word("colour", kKnown), "");
  EXPECT_EQ(nearest_word("", kKnown), "");
  EXPECT_EQ(nearest_word("rotate", {}), "");
}

TEST(Quoted, ShowsOnlyPrintableAscii) {
  EXPECT_EQ(quoted("G36X1"), "\"G36X1\"");
  EXPECT_EQ(quoted(std::string_view("\0\t\x7f\xc3\xa4", 5)), R"("\x00\x09\x7f\xc3\xa4")");
  EXPECT_EQ(quoted(""), "\"\"");
}

TEST(Quoted, CutsLongText) {
  EXPECT_EQ(quoted("abcdef", 3), "\"abc...\"");
  EXPECT_EQ(quoted("abc", 3), "\"abc\"");
  EXPECT_EQ(quoted(std::string(1000000, 'x')).size(), 65U);
}

TEST(EscapedControls, KeepsNamesOfAnyLanguage) {
  EXPECT_EQ(escaped_controls("b\xc3\xb6hr \xe9\xbb\x9e.exc"), "b\xc3\xb6hr \xe9\xbb\x9e.exc");
  EXPECT_EQ(escaped_controls(""), "");
}

TEST(EscapedControls, ShowsWhatWouldSteerATerminal) {
  EXPECT_EQ(escaped_controls("\x1b[31mred"), R"(\x1b[31mred)");
  EXPECT_EQ(escaped_controls("a\rb\x7f\n"), R"(a\x0db\x7f\x0a)");
  EXPECT_EQ(escaped_controls("\xc2\x9b"
                             "31m\xc2"),
            "\\xc2\\x9b31m\xc2");
  EXPECT_EQ(escaped_controls("a\nb\t\x1b", "\n\t"), "a\nb\t\\x1b");
}

TEST(Diagnostic, ShowsNoControlBytesOfAFilesName) {
  const Diagnostic problem{Code::FileUnreadable, {"a\x1b]0;owned\x07.exc", 0, 0}, "", ""};
  EXPECT_EQ(problem.text(), R"(a\x1b]0;owned\x07.exc: error[file-unreadable]: file not readable)");
}

Expected<int> half_of(int n) {
  if (n % 2 != 0) return failure(problem({"n", n, 0}));
  return n / 2;
}

Expected<void> must_be_even(int n) {
  PANELCAL_TRY(const int half, half_of(n));
  static_cast<void>(half);
  return {};
}

Expected<int> quarter_of(int n) {
  PANELCAL_CHECK(must_be_even(n));
  PANELCAL_TRY(const int half, half_of(n));
  PANELCAL_TRY(const int quarter, half_of(half));
  return quarter;
}

TEST(Expected, PassesTheFirstFailureOn) {
  EXPECT_EQ(quarter_of(12).value(), 3);
  EXPECT_EQ(quarter_of(6).error().place.line, 3);
  EXPECT_EQ(quarter_of(5).error().place.line, 5);
}

TEST(StringSink, CollectsBytes) {
  StringSink sink;
  EXPECT_TRUE(sink.write("ab"));
  EXPECT_TRUE(sink.write(std::string_view("\0c", 2)));
  EXPECT_EQ(sink.text(), std::string("ab\0c", 4));
}

}  // namespace
}  // namespace panelcal
