// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/measurement_file_source.h"

#include <bit>
#include <cstdint>
#include <string>
#include <string_view>

#include "calib/base/files/digest.h"
#include "calib/base/statistics/random.h"
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/machine/virtual_machine.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::Reports;

constexpr std::string_view kFound =
    R"({"seq":0,"line":7,"command":"G46","tool":2,"nominal":[1.5,2],"expected":[1.6,2.1],"path":[0,1],)"
    R"("measured":[1.61,2.12],"cov":[1e-06,0,1e-06],"score":0.98,"image":"a.png","status":"found"})";

/// kFound with one piece replaced.
std::string with(std::string_view piece, std::string_view other) {
  std::string text(kFound);
  const auto at = text.find(piece);
  EXPECT_NE(at, std::string::npos) << piece;
  return text.replace(at, piece.size(), other);
}

std::string refusal(std::string_view text) {
  const auto recorded = parse_measurements(text, "m.jsonl");
  return recorded ? "accepted" : test::brief(recorded.error());
}

std::uint64_t bits(double v) {
  return std::bit_cast<std::uint64_t>(v);
}

/// A standard deviation that a place may have, mm, with all bits in use.
double any_sigma(Random& random) {
  return std::exp2(random.uniform(-29, 9));
}

/// A coordinate that a machine may have, mm.
double any_place(Random& random) {
  return random.uniform(-1, 1) * std::exp2(std::round(random.uniform(-200, 16)));
}

Measurement any_measurement(Random& random, std::int64_t seq) {
  Measurement m;
  m.request.seq = seq;
  m.request.line = 12;
  m.request.command = "G36";
  m.request.settings.tools = {3};
  m.request.nominal = position_mm<frame::Nominal>(any_place(random), -0.0);
  m.request.expected = position_mm<frame::Actual>(any_place(random), any_place(random));
  m.request.path = {0, 4};
  m.status = MeasurementStatus::Found;
  m.measured.position = position_mm<frame::Actual>(any_place(random), any_place(random));
  const double sx = any_sigma(random);
  const double sy = any_sigma(random);
  const double xy = random.uniform(-0.99, 0.99) * sx * sy;
  m.measured.cov << sx * sx, xy, xy, sy * sy;
  m.score = random.uniform();
  m.image = "pict\xc3\xbcre \"1\".png";
  return m;
}

TEST(MeasurementFile, RoundTripsToTheBit) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Measurement written = any_measurement(random, i);
    const auto read = parse_measurements(to_json(written) + "\n", "m.jsonl");
    ASSERT_TRUE(read) << read.error().text();
    ASSERT_EQ(read->measurements.size(), 1u);
    const Measurement& m = read->measurements[0].answer;
    EXPECT_EQ(to_json(m), to_json(written));
    for (int k = 0; k < 2; ++k) {
      EXPECT_EQ(bits(m.request.nominal.in_mm()[k]), bits(written.request.nominal.in_mm()[k]));
      EXPECT_EQ(bits(m.measured.position.in_mm()[k]), bits(written.measured.position.in_mm()[k]));
    }
    for (int k = 0; k < 4; ++k) {
      EXPECT_EQ(bits(m.measured.cov(k)), bits(written.measured.cov(k)));
    }
  }
}

TEST(MeasurementFile, RoundTripsEveryOptionalKey) {
  Measurement written;
  written.request.command = "G38";
  written.request.settings.tools = {1, 2, 3, 4};
  written.request.settings.delta = mm(2.5);
  written.request.settings.inspections = 3;
  written.request.settings.search = false;
  written.request.settings.search_area = mm(0.25);
  written.request.settings.lamp = 30;
  written.request.settings.zoom = 7;
  written.request.settings.algorithm = 1;
  written.status = MeasurementStatus::Ambiguous;
  written.reason = "two discs\tof 1.0 mm";
  written.request.axes = ObservedAxes::Y;
  written.scatter = displacement_mm<frame::Actual>(0.001, 0.00025);
  written.decision = {Decider::Candidate, "Anna \"A.\"", "2026-11-27T08:00:00Z"};
  const auto read = parse_measurements(to_json(written), "m.jsonl");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(to_json(read->measurements[0].answer), to_json(written));
  EXPECT_EQ(read->measurements[0].answer.decision.by, Decider::Candidate);
  EXPECT_EQ(read->measurements[0].answer.decision.who, "Anna \"A.\"");
}

Measurement with_candidates(Random& random) {
  Measurement m = any_measurement(random, 0);
  for (int k = 0; k < 3; ++k) {
    MeasuredCandidate candidate;
    candidate.place = any_measurement(random, 0).measured;
    candidate.score = random.uniform();
    candidate.counts = k < 2;
    candidate.by_camera.setConstant(random.normal());
    m.candidates.push_back(candidate);
  }
  m.listed.emplace();
  for (Position<frame::Actual>& corner : m.listed->corners) {
    corner = position_mm<frame::Actual>(random.normal(), random.normal());
  }
  m.listed->radius = mm(1.5);
  return m;
}

TEST(MeasurementFile, RoundTripsCandidatesToTheBit) {
  Random random(2);
  for (int i = 0; i < 50; ++i) {
    const Measurement written = with_candidates(random);
    const auto read = parse_measurements(to_json(written), "m.jsonl");
    ASSERT_TRUE(read) << read.error().text();
    const Measurement& m = read->measurements[0].answer;
    EXPECT_EQ(to_json(m), to_json(written));
    ASSERT_EQ(m.candidates.size(), 3U);
    EXPECT_TRUE(m.has_choice());
    EXPECT_FALSE(m.candidates[2].counts);
    EXPECT_EQ(m.candidates[1].place.cov, written.candidates[1].place.cov);
  }
}

/// The lone candidate of a found target is the measured place, and is not said twice.
TEST(MeasurementFile, DoesNotListALoneCandidate) {
  Random random(3);
  Measurement written = with_candidates(random);
  written.candidates.resize(1);
  EXPECT_EQ(to_json(written).find("candidates"), std::string::npos);
  EXPECT_NE(to_json(written).find("\"listed_area\":["), std::string::npos);
}

TEST(MeasurementFile, RefusesCandidatesThatAreNone) {
  const auto list = [](std::string_view numbers) {
    return with(",\"status\"", ",\"candidates\":[" + std::string(numbers) + "],\"status\"");
  };
  EXPECT_EQ(refusal(list("1,2,1e-6,0,1e-6,0.9,1")), "accepted");
  for (const std::string_view bad : {"1,2,1e-6,0,1e-6,0.9",
                                     "1,2,1e-6,1,1e-6,0.9,1",
                                     "1,2,1e-6,0,1e-6,0.9,2",
                                     "1,2,0,0,0,1,1",
                                     "1e6,2,1e-6,0,1e-6,0.9,1"}) {
    EXPECT_NE(refusal(list(bad)), "accepted") << bad;
  }
}

TEST(MeasurementFile, SkipsBlankLinesAndCountsThem) {
  const auto read = parse_measurements("\n  \r\n" + std::string(kFound) + "\r\n\n", "m.jsonl");
  ASSERT_TRUE(read) << read.error().text();
  ASSERT_EQ(read->measurements.size(), 1u);
  EXPECT_EQ(read->measurements[0].line, 3);
}

TEST(MeasurementFile, RefusesWhatIsNotAMeasurement) {
  EXPECT_EQ(refusal("\n{\"seq\":0,}"), "m.jsonl:2:10: error[json-syntax]");
  EXPECT_EQ(refusal(with("\"score\"", "\"scoer\"")), "m.jsonl:1:141: error[measurement-file]");
  EXPECT_EQ(refusal(with("\"seq\":0,", "")), "m.jsonl:1:1: error[measurement-file]");
  EXPECT_EQ(refusal(with("\"expected\":[1.6,2.1],", "")), "m.jsonl:1:1: error[measurement-file]");
  EXPECT_EQ(refusal(with("\"seq\":0", "\"seq\":-1")), "m.jsonl:1:8: error[measurement-file]");
  EXPECT_EQ(refusal(with("\"seq\":0", "\"seq\":0.5")), "m.jsonl:1:8: error[measurement-file]");
  EXPECT_EQ(refusal(with("[1.5,2]", "[1.5]")), "m.jsonl:1:54: error[measurement-file]");
  EXPECT_EQ(refusal(with("[1.5,2]", "[1e999,2]")), "m.jsonl:1:54: error[measurement-file]");
  EXPECT_EQ(refusal(with("[0,1]", "[0,-1]")), "m.jsonl:1:90: error[measurement-file]");
  EXPECT_EQ(refusal(with("\"found\"", "\"lost\"")), "m.jsonl:1:179: error[measurement-file]");
  EXPECT_EQ(refusal(with("\"tool\":2", "\"tool\":2,\"tools\":[1,2]")),
            "m.jsonl:1:52: error[measurement-file]");
  EXPECT_EQ(refusal(std::string(kFound) + "\n" + std::string(kFound)),
            "m.jsonl:2:8: error[measurement-file]");
}

TEST(MeasurementFile, RefusesPlacesBeyondAnyMachine) {
  EXPECT_EQ(refusal(with("[1.61,2.12]", "[1e308,-1e308]")),
            "m.jsonl:1:107: error[measurement-file]");
  EXPECT_EQ(refusal(with("[1.61,2.12]", "[1.61,-100001]")),
            "m.jsonl:1:107: error[measurement-file]");
  EXPECT_EQ(refusal(with("[1.61,2.12]", "[100000,-100000]")), "accepted");
}

TEST(MeasurementFile, MeasuredStandsThereIfAndOnlyIfFound) {
  EXPECT_EQ(refusal(with("\"measured\":[1.61,2.12],", "")), "m.jsonl:1:1: error[measurement-file]");
  EXPECT_EQ(refusal(with("\"cov\":[1e-06,0,1e-06],", "")), "m.jsonl:1:1: error[measurement-file]");
  EXPECT_EQ(refusal(with("\"found\"", "\"not_found\"")), "m.jsonl:1:107: error[measurement-file]");
  EXPECT_EQ(refusal(with(R"("measured":[1.61,2.12],"cov":[1e-06,0,1e-06],"score":0.98,)"
                         R"("image":"a.png","status":"found")",
                         R"("status":"rejected","reason":"too small")")),
            "accepted");
}

TEST(MeasurementFile, RefusesCovariancesThatAreNone) {
  EXPECT_EQ(refusal(with("[1e-06,0,1e-06]", "[0,0,1e-06]")),
            "m.jsonl:1:125: error[measurement-invalid]");
  EXPECT_EQ(refusal(with("[1e-06,0,1e-06]", "[1e-06,1e-06,1e-06]")),
            "m.jsonl:1:125: error[measurement-invalid]");
  EXPECT_EQ(refusal(with("[1e-06,0,1e-06]", "[1e-06,0,-1e-06]")),
            "m.jsonl:1:125: error[measurement-invalid]");
  EXPECT_EQ(refusal(with("[1e-06,0,1e-06]", "[1e-18,0,1e+06]")), "accepted");
}

TEST(MeasurementFile, RefusesSigmasThatNoMeasurementHas) {
  for (const std::string_view cov : {"[1.1e+06,0,1e-06]", "[1e-06,0,1e+09]", "[0.9e-18,0,1e-06]"}) {
    EXPECT_EQ(refusal(with("[1e-06,0,1e-06]", cov)), "m.jsonl:1:125: error[measurement-invalid]");
  }
}

TEST(MeasurementFile, RefusesNumbersOutOfTheirRanges) {
  const std::string_view score = R"("score":0.98)";
  EXPECT_THAT(refusal(with(score, R"("score":1.01)")),
              testing::EndsWith("error[measurement-file]"));
  EXPECT_THAT(refusal(with(score, R"("score":-0.01)")),
              testing::EndsWith("error[measurement-file]"));
  for (const std::string_view key : {"delta", "search_area", "lamp", "zoom"}) {
    const std::string much = fmt::format(R"("score":0.98,"{}":1e9)", key);
    EXPECT_THAT(refusal(with(score, much)), testing::EndsWith("error[measurement-file]")) << key;
  }
  EXPECT_THAT(refusal(with(score, R"("score":0.98,"scatter":[0.001,1e4])")),
              testing::EndsWith("error[measurement-file]"));
}

TEST(MeasurementFile, RefusesLongLines) {
  EXPECT_EQ(refusal(std::string(100'000, ' ') + "x"), "m.jsonl:1:1: error[measurement-file]");
}

MeasurementRequest request_of(std::string_view line) {
  return parse_measurements(line, "m.jsonl")->measurements[0].answer.request;
}

TEST(MeasurementFileSource, AnswersWithTheProgramsRequest) {
  MeasurementFileSource source(*parse_measurements(kFound, "m.jsonl"));
  MeasurementRequest request = request_of(kFound);
  request.work_zero = position_mm<frame::Machine>(100, 200);
  const auto measurement = source.measure(request);
  ASSERT_TRUE(measurement) << measurement.error().text();
  EXPECT_EQ(measurement->request.work_zero, request.work_zero);
  EXPECT_EQ(measurement->measured.position.in_mm(), Eigen::Vector2d(1.61, 2.12));
  EXPECT_EQ(measurement->score, 0.98);
  EXPECT_EQ(measurement->image, "a.png");
}

TEST(MeasurementFileSource, ForgivesThePrintingOfNominalsOnly) {
  MeasurementFileSource source(*parse_measurements(kFound, "m.jsonl"));
  MeasurementRequest request = request_of(kFound);
  request.nominal = position_mm<frame::Nominal>(1.5 + 0.9e-6, 2);
  EXPECT_TRUE(source.measure(request));
  request.nominal = position_mm<frame::Nominal>(1.5 + 1.1e-6, 2);
  EXPECT_FALSE(source.measure(request));
}

TEST(MeasurementFileSource, RefusesAnotherProgramsMeasurements) {
  const auto refusal_of = [](std::string_view recorded) {
    MeasurementFileSource source(*parse_measurements("\n" + std::string(recorded), "m.jsonl"));
    const auto measurement = source.measure(request_of(kFound));
    return measurement ? "accepted" : measurement.error().text();
  };
  EXPECT_EQ(refusal_of(kFound), "accepted");
  EXPECT_THAT(refusal_of(with("\"seq\":0", "\"seq\":1")),
              Reports("m.jsonl: error[measurement-missing]"));
  EXPECT_THAT(refusal_of(with("\"line\":7", "\"line\":8")),
              Reports("m.jsonl:2:1: error[measurement-mismatch]", "line 8", "line 7"));
  EXPECT_THAT(refusal_of(with("G46", "G36")),
              Reports("m.jsonl:2:1: error[measurement-mismatch]", "G36", "G46"));
  EXPECT_THAT(refusal_of(with("\"tool\":2", "\"tool\":1")),
              Reports("m.jsonl:2:1: error[measurement-mismatch]", "tool 1", "tool 2"));
  EXPECT_THAT(refusal_of(with("[0,1]", "[0,2]")),
              Reports("m.jsonl:2:1: error[measurement-mismatch]", "[0,2]", "[0,1]"));
  EXPECT_THAT(refusal_of(with("[1.5,2]", "[1.5,2.001]")),
              Reports("m.jsonl:2:1: error[measurement-mismatch]", "2.001", "1.5"));
}

/// The request of kFound in a stored pattern, as the program in this folder asks it.
MeasurementRequest in_pattern(const std::string& path, const std::string& content) {
  MeasurementRequest request = request_of(kFound);
  request.file = path;
  request.file_sha256 = sha256(content);
  return request;
}

TEST(MeasurementFileSource, ReplaysAStoredPatternFromAnotherFolder) {
  Measurement written = parse_measurements(kFound, "m.jsonl")->measurements[0].answer;
  written.request = in_pattern("job/PINS", "G46X1.5Y2.0\n");
  const std::string recorded = to_json(written);
  const auto answer = [](const std::string& text, const MeasurementRequest& request) {
    MeasurementFileSource source(*parse_measurements(text, "m.jsonl"));
    const auto measurement = source.measure(request);
    return measurement ? "accepted" : measurement.error().text();
  };
  EXPECT_EQ(answer(recorded, in_pattern("PINS", "G46X1.5Y2.0\n")), "accepted");
  EXPECT_EQ(answer(recorded, in_pattern("/else/PINS.exc", "G46X1.5Y2.0\n")), "accepted");
  EXPECT_THAT(answer(recorded, in_pattern("job/PINS", "G46X1.5Y2.1\n")),
              Reports("m.jsonl:1:1: error[measurement-mismatch]",
                      "file \"PINS\", sha256 " + sha256("G46X1.5Y2.0\n").substr(0, 12),
                      "file \"job/PINS\", sha256 " + sha256("G46X1.5Y2.1\n").substr(0, 12)));
  EXPECT_THAT(answer(recorded, request_of(kFound)),
              Reports("m.jsonl:1:1: error[measurement-mismatch]",
                      "file \"PINS\"",
                      "file (the program itself)"));
  // A recording from before, and those of other vision systems, has the name alone.
  const std::string named = with("\"line\":7", "\"line\":7,\"file\":\"job/PINS\"");
  EXPECT_EQ(answer(named, in_pattern("PINS", "G46X1.5Y2.0\n")), "accepted");
  EXPECT_THAT(answer(named, in_pattern("HOLES", "G46X1.5Y2.0\n")),
              Reports("m.jsonl:1:1: error[measurement-mismatch]", "job/PINS", "HOLES"));
}

TEST(MeasurementFile, RefusesADigestThatIsNone) {
  const auto refused = [](const std::string& digest) {
    return refusal(
        with("\"line\":7", "\"file\":\"PINS\",\"file_sha256\":" + digest + ",\"line\":7"));
  };
  EXPECT_EQ(refused("\"" + sha256("") + "\""), "accepted");
  for (const std::string& digest :
       {std::string("7"), "\"" + sha256("").substr(1) + "\"", "\"" + std::string(64, 'G') + "\""}) {
    EXPECT_EQ(refused(digest), "m.jsonl:1:38: error[measurement-file]") << digest;
  }
}

TEST(MeasurementFile, TakesADigestInEitherCase) {
  std::string digest = sha256("");
  std::ranges::transform(digest, digest.begin(), [](unsigned char c) { return std::toupper(c); });
  const auto read = parse_measurements(
      with("\"line\":7", "\"file\":\"PINS\",\"file_sha256\":\"" + digest + "\",\"line\":7"),
      "m.jsonl");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read->measurements[0].answer.request.file_sha256, sha256(""));
}

TEST(MeasurementFile, RefusesADigestWithoutItsFile) {
  EXPECT_EQ(refusal(with("\"line\":7", "\"file_sha256\":\"" + sha256("") + "\",\"line\":7")),
            "m.jsonl:1:24: error[measurement-file]");
  EXPECT_NE(refusal(with("\"line\":7",
                         "\"file\":\"\",\"file_sha256\":\"" + sha256("") + "\",\"line\":7")),
            "accepted");
}

TEST(MeasurementFile, RefusesANumberThatNoDoubleHoldsAsAText) {
  EXPECT_NE(refusal(with("\"line\":7", "\"line\":7,\"reason\":1e999")), "accepted");
}

TEST(MeasurementFileSource, NoticesMeasurementsThatNobodyAskedFor) {
  MeasurementFileSource source(*parse_measurements(kFound, "m.jsonl"));
  ASSERT_FALSE(source.check_all_used());
  EXPECT_EQ(test::brief(source.check_all_used().error()),
            "m.jsonl:1:1: error[measurement-mismatch]");
  ASSERT_TRUE(source.measure(request_of(kFound)));
  EXPECT_TRUE(source.check_all_used());
}

constexpr std::string_view kByCamera = R"("by_camera":[1,2,3,4,5,6,7,8,9,-0.1],"score")";

TEST(MeasurementFile, HowAPlaceMovesWithTheCameraReadsBackToTheBit) {
  Random random(8);
  for (int i = 0; i < 200; ++i) {
    Measurement m = any_measurement(random, i);
    m.by_camera = CameraJacobian::Zero();
    for (double& number : m.by_camera->reshaped()) number = random.normal() * 1e3;
    const auto recorded = parse_measurements(to_json(m), "m.jsonl");
    ASSERT_TRUE(recorded) << recorded.error().text();
    EXPECT_EQ(recorded->measurements[0].answer.by_camera, m.by_camera);
  }
  const auto recorded = parse_measurements(with(R"("score")", kByCamera), "m.jsonl");
  ASSERT_TRUE(recorded) << recorded.error().text();
  const auto& by_camera = recorded->measurements[0].answer.by_camera;
  ASSERT_TRUE(by_camera);
  EXPECT_EQ((*by_camera)(0, 4), 5);
  EXPECT_EQ((*by_camera)(1, 0), 6);
  EXPECT_FALSE(parse_measurements(kFound, "m.jsonl")->measurements[0].answer.by_camera);
}

TEST(MeasurementFile, RefusesACameraThatIsNone) {
  EXPECT_THAT(refusal(with(R"("score")", R"("by_camera":[1,2,3],"score")")),
              testing::HasSubstr("m.jsonl:1:"));
  EXPECT_THAT(refusal(with(R"("score")", R"("by_camera":[1,2,3,4,5,6,7,8,9,1e16],"score")")),
              testing::HasSubstr("m.jsonl:1:"));
  std::string lost = with(R"("score")", kByCamera);
  lost.replace(lost.find(R"("measured":[1.61,2.12],"cov":[1e-06,0,1e-06],)"), 45, "");
  lost.replace(lost.find("\"found\""), 7, "\"not_found\"");
  EXPECT_THAT(refusal(lost), testing::HasSubstr("m.jsonl:1:"));
}

}  // namespace
}  // namespace panelcal
