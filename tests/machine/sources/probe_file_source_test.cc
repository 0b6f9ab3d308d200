// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/probe_file_source.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>

#include "calib/base/files/digest.h"
#include "calib/base/statistics/random.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::Reports;

constexpr std::string_view kFirst =
    R"({"probe":0,"line":4,"command":"G73","tool":5,"nominal":[165,15],"expected":[165.5,15],)"
    R"("path":[0,1],"L":1,"reference":1.6,"zaxis":0,"height":1.61,"sigma":0.002,"status":"found"})";
constexpr std::string_view kSecond =
    R"({"probe":0,"line":4,"command":"G73","tool":5,"nominal":[165,15],"expected":[165.5,15],)"
    R"("path":[0,1],"L":1,"reference":1.6,"zaxis":1,"height":1.72,"sigma":0.003,"status":"found"})";
constexpr std::string_view kMissed =
    R"({"probe":0,"line":4,"command":"G73","tool":5,"nominal":[165,15],"expected":[165.5,15],)"
    R"("path":[0,1],"L":1,"reference":1.6,"status":"not_found","reason":"no contact"})";

/// A line with one piece replaced.
std::string with(std::string_view piece, std::string_view other, std::string_view line = kFirst) {
  std::string text(line);
  const auto at = text.find(piece);
  EXPECT_NE(at, std::string::npos) << piece;
  return text.replace(at, piece.size(), other);
}

std::string lines(std::initializer_list<std::string_view> all) {
  std::string text;
  for (const std::string_view line : all) text += std::string(line) + "\n";
  return text;
}

std::string refusal(std::string_view text) {
  const auto recorded = parse_probes(text, "p.jsonl");
  return recorded ? "accepted" : test::brief(recorded.error());
}

TEST(ProbeFile, PutsTheLinesOfOneProbeTogether) {
  const std::string other = with("\"probe\":0", "\"probe\":1");
  const std::string other_second = with("\"probe\":0", "\"probe\":1", kSecond);
  // In any order, and with other lines between them.
  const auto read = parse_probes(lines({kSecond, "", other, kFirst, other_second}), "p.jsonl");
  ASSERT_TRUE(read) << read.error().text();
  ASSERT_EQ(read->probes.size(), 2u);
  EXPECT_EQ(read->probes[0].line, 1);
  EXPECT_EQ(read->probes[1].line, 3);
  for (const RecordedProbe& probe : read->probes) {
    ASSERT_EQ(probe.answer.heights.size(), 2u);
    EXPECT_EQ(probe.answer.heights[0].height, mm(1.61));
    EXPECT_EQ(probe.answer.heights[1].height, mm(1.72));
    EXPECT_EQ(probe.answer.heights[1].sigma, mm(0.003));
    EXPECT_EQ(probe.answer.request.memory, 1);
    EXPECT_EQ(probe.answer.request.depth, std::nullopt);
  }
}

std::uint64_t bits(Length v) {
  return std::bit_cast<std::uint64_t>(v.in_mm());
}

/// Numbers with all bits in use, far apart in size.
double any_number(Random& random) {
  return random.normal() * std::exp2(std::round(random.uniform(-200, 7)));
}

TEST(ProbeFile, RoundTripsToTheBit) {
  Random random(1);
  std::string text;
  std::vector<ProbeReading> written;
  for (int i = 0; i < 100; ++i) {
    ProbeReading reading{.status = ProbeStatus::Found};
    reading.request.seq = i;
    reading.request.line = 12;
    reading.request.command = "G79";
    reading.request.file = "sub\xc3\xbc \"1\"";
    reading.request.nominal = position_mm<frame::Nominal>(any_number(random), -0.0);
    reading.request.expected = position_mm<frame::Actual>(any_number(random), any_number(random));
    reading.request.depth = mm(any_number(random));
    reading.request.reference = mm(any_number(random));
    reading.reason = "slow\tprobe";
    for (int axis = 0; axis < 3; ++axis) {
      reading.heights.push_back({mm(any_number(random)), mm(std::abs(any_number(random)))});
    }
    text += to_json(reading) + "\n";
    written.push_back(std::move(reading));
  }
  const auto read = parse_probes(text, "p.jsonl");
  ASSERT_TRUE(read) << read.error().text();
  ASSERT_EQ(read->probes.size(), written.size());
  for (std::size_t i = 0; i < written.size(); ++i) {
    const ProbeReading& back = read->probes[i].answer;
    EXPECT_EQ(to_json(back), to_json(written[i]));
    ASSERT_EQ(back.heights.size(), 3u);
    EXPECT_EQ(bits(back.request.reference), bits(written[i].request.reference));
    EXPECT_EQ(bits(back.heights[2].height), bits(written[i].heights[2].height));
    EXPECT_EQ(bits(back.heights[2].sigma), bits(written[i].heights[2].sigma));
  }
}

TEST(ProbeFile, ReadsWhatWasNotFound) {
  const auto read = parse_probes(kMissed, "p.jsonl");
  ASSERT_TRUE(read) << read.error().text();
  const ProbeReading& missed = read->probes[0].answer;
  EXPECT_EQ(missed.status, ProbeStatus::NotFound);
  EXPECT_TRUE(missed.heights.empty());
  EXPECT_EQ(missed.reason, "no contact");
  EXPECT_EQ(to_json(missed), kMissed);
}

TEST(ProbeFile, RefusesWhatIsNotAReading) {
  EXPECT_EQ(refusal("\n{\"probe\":0,}"), "p.jsonl:2:12: error[json-syntax]");
  EXPECT_EQ(refusal(with("\"height\"", "\"heigth\"")), "p.jsonl:1:132: error[measurement-file]");
  EXPECT_EQ(refusal(with("\"reference\":1.6,", "")), "p.jsonl:1:1: error[measurement-file]");
  EXPECT_EQ(refusal(with("\"zaxis\":0,", "")), "p.jsonl:1:1: error[measurement-file]");
  EXPECT_EQ(refusal(with("\"zaxis\":0", "\"zaxis\":64")), "p.jsonl:1:130: error[measurement-file]");
  EXPECT_EQ(refusal(with("\"L\":1", "\"L\":-1")), "p.jsonl:1:104: error[measurement-file]");
  EXPECT_EQ(refusal(with("\"found\"", "\"ambiguous\"")), "p.jsonl:1:169: error[measurement-file]");
  EXPECT_EQ(refusal(with("1.61", "1e999")), "p.jsonl:1:141: error[measurement-file]");
  EXPECT_EQ(refusal(with("0.002", "-0.002")), "p.jsonl:1:154: error[measurement-invalid]");
  EXPECT_EQ(refusal(with("\"status\"", "\"zaxis\":0,\"status\"", kMissed)),
            "p.jsonl:1:130: error[measurement-file]");
  EXPECT_EQ(refusal(std::string(100'000, ' ') + "x"), "p.jsonl:1:1: error[measurement-file]");
}

TEST(ProbeFile, RefusesLinesOfOneProbeThatDoNotBelongTogether) {
  EXPECT_EQ(refusal(lines({kFirst, kFirst})), "p.jsonl:2:130: error[measurement-file]");
  EXPECT_EQ(refusal(lines({kFirst, "", with("\"line\":4", "\"line\":5", kSecond)})),
            "p.jsonl:3:10: error[measurement-file]");
  EXPECT_EQ(refusal(lines({kFirst, with("\"status\"", "\"reason\":\"?\",\"status\"", kSecond)})),
            "p.jsonl:2:10: error[measurement-file]");
  const std::string once = "p.jsonl:2:10: error[measurement-file]";
  EXPECT_EQ(refusal(lines({kMissed, kMissed})), once);
  EXPECT_EQ(refusal(lines({kMissed, kFirst})), once);
  EXPECT_EQ(refusal(lines({kFirst, kMissed})), once);
}

TEST(ProbeFile, RefusesMissingZAxes) {
  EXPECT_EQ(refusal(lines({"", kSecond})), "p.jsonl:2:1: error[measurement-file]");
  EXPECT_EQ(refusal(lines({kFirst, kSecond, with("\"probe\":0", "\"probe\":9")})),
            "p.jsonl:3:1: error[measurement-file]");
  EXPECT_EQ(refusal(lines({kFirst, kSecond, with("\"probe\":0", "\"probe\":9", kMissed)})),
            "accepted");
}

TEST(ProbeFile, RefusesAFileThatIsNotThere) {
  EXPECT_THAT(read_probes("/nonexistent/p.jsonl"), FailsWith(Code::FileUnreadable, "p.jsonl"));
}

ProbeRequest request_of(std::string_view line) {
  return parse_probes(line, "p.jsonl")->probes[0].answer.request;
}

TEST(ProbeFileSource, AnswersWithTheProgramsRequest) {
  ProbeFileSource source(*parse_probes(lines({kFirst, kSecond}), "p.jsonl"));
  ProbeRequest request = request_of(kFirst);
  request.work_zero = position_mm<frame::Machine>(100, 200);
  const auto reading = source.probe(request);
  ASSERT_TRUE(reading) << reading.error().text();
  EXPECT_EQ(reading->request.work_zero, request.work_zero);
  ASSERT_EQ(reading->heights.size(), 2u);
  EXPECT_EQ(reading->heights[1].height, mm(1.72));
}

TEST(ProbeFileSource, ForgivesThePrintingOfNominalsOnly) {
  ProbeFileSource source(*parse_probes(kFirst, "p.jsonl"));
  ProbeRequest request = request_of(kFirst);
  request.nominal = position_mm<frame::Nominal>(165 + 0.9e-6, 15);
  EXPECT_TRUE(source.probe(request));
  request.nominal = position_mm<frame::Nominal>(165 + 1.1e-6, 15);
  EXPECT_FALSE(source.probe(request));
}

TEST(ProbeFileSource, RefusesAnotherProgramsReadings) {
  const auto refusal_of = [](std::string_view recorded) {
    ProbeFileSource source(*parse_probes("\n" + std::string(recorded), "p.jsonl"));
    const auto reading = source.probe(request_of(kFirst));
    return reading ? "accepted" : reading.error().text();
  };
  const std::string mismatch = "p.jsonl:2:1: error[measurement-mismatch]";
  EXPECT_EQ(refusal_of(kFirst), "accepted");
  EXPECT_THAT(refusal_of(with("\"probe\":0", "\"probe\":1")),
              Reports("p.jsonl: error[measurement-missing]"));
  EXPECT_THAT(refusal_of(with("\"line\":4", "\"line\":8")), Reports(mismatch, "line 8", "line 4"));
  EXPECT_THAT(refusal_of(with("G73", "G79")),
              Reports(mismatch, "command \"G79\"", "command \"G73\""));
  EXPECT_THAT(refusal_of(with("\"tool\":5", "\"tool\":1")), Reports(mismatch, "tool 1", "tool 5"));
  EXPECT_THAT(refusal_of(with("[0,1]", "[0,2]")), Reports(mismatch, "path [0,2]", "path [0,1]"));
  EXPECT_THAT(refusal_of(with("\"L\":1", "\"file\":\"a\",\"L\":1")),
              Reports(mismatch, "file \"a\"", "file (the program itself)"));
  EXPECT_THAT(refusal_of(with("[165,15]", "[165,15.001]")),
              Reports(mismatch, "nominal [165, 15.001]", "nominal [165, 15]"));
}

TEST(ProbeFileSource, ReplaysASubprogramFromAnotherFolder) {
  const std::string content = "@PROBES\nX1.Y1.G73\n";
  ProbeRequest request = request_of(kFirst);
  request.file = "job/PROBES.SS5";
  request.file_sha256 = sha256(content);
  const auto recorded = parse_probes(
      to_json(ProbeReading{request, ProbeStatus::Found, {{mm(1.61), um(2)}}, ""}), "p.jsonl");
  ASSERT_TRUE(recorded) << recorded.error().text();
  request.file = "PROBES.SS5";
  EXPECT_TRUE(ProbeFileSource(*recorded).probe(request));
  request.file_sha256 = sha256(content + "X2.Y1.G73\n");
  EXPECT_THAT(ProbeFileSource(*recorded).probe(request),
              FailsWith(Code::MeasurementMismatch, "file \"PROBES.SS5\", sha256 "));
}

TEST(ProbeFileSource, NoticesReadingsThatNobodyAskedFor) {
  ProbeFileSource source(*parse_probes(kFirst, "p.jsonl"));
  EXPECT_THAT(source.check_all_used(), FailsWith(Code::MeasurementMismatch, "p.jsonl:1:1: "));
  ASSERT_TRUE(source.probe(request_of(kFirst)));
  EXPECT_TRUE(source.check_all_used());
}

}  // namespace
}  // namespace panelcal
