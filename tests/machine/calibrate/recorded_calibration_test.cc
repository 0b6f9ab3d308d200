// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/recorded_calibration.h"

#include <string>
#include <string_view>

#include "calib/base/files/digest.h"
#include "machine/sources/measurement_file_source.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

constexpr std::string_view kRecorded =
    R"({"calibration":0,"line":7,"command":"G39","path":[],"first_hole":[101,202],"offset":[45,-3],)"
    R"("cov":[2e-06,0,2e-06],"text":"found"})";

std::string with(std::string_view piece, std::string_view other) {
  std::string text(kRecorded);
  const auto at = text.find(piece);
  EXPECT_NE(at, std::string::npos) << piece;
  return text.replace(at, piece.size(), other);
}

TEST(RecordedCalibration, ReadsBackWhatWasWritten) {
  const auto recorded = parse_measurements(kRecorded, "m.jsonl");
  ASSERT_TRUE(recorded) << recorded.error().text();
  ASSERT_EQ(recorded->calibrations.size(), 1U);
  EXPECT_EQ(to_json(recorded->calibrations[0].answer), kRecorded);
}

TEST(RecordedCalibration, RefusesWhatIsNone) {
  const auto refuses = [](const std::string& text, Code code, const std::string& part) {
    EXPECT_THAT(parse_measurements(text, "m.jsonl"), FailsWith(code, part)) << text;
  };
  refuses(with("\"offset\":[45,-3],", ""), Code::MeasurementFile, "m.jsonl:1:");
  refuses(with("2e-06,0", "-2e-06,0"), Code::MeasurementInvalid, "m.jsonl:1:");
  refuses(with("2e-06,0", "2e-06,3e-06"), Code::MeasurementInvalid, "xy^2 <= xx yy");
  refuses(with("[45,", "[1e300,"), Code::MeasurementFile, "-1000000 to 1000000");
  refuses(with("\"calibration\":0", "\"calibration\":-1"), Code::MeasurementFile, "m.jsonl:1:");
  refuses(with("\"text\"", "\"txet\""), Code::MeasurementFile, "text");
  refuses(
      std::string(kRecorded) + "\n" + std::string(kRecorded), Code::MeasurementFile, "m.jsonl:2:");
}

TEST(RecordedCalibration, ReplaysAStoredPatternFromAnotherFolder) {
  CalibrationAnswer written = parse_measurements(kRecorded, "m.jsonl")->calibrations[0].answer;
  written.order.file = "job/PINS";
  written.order.file_sha256 = sha256("G39\n");
  const auto recorded = parse_measurements(to_json(written), "m.jsonl");
  ASSERT_TRUE(recorded) << recorded.error().text();
  CalibrationOrder order = written.order;
  order.file = "PINS";
  EXPECT_TRUE(MeasurementFileSource(*recorded).calibrate(order));
  order.file_sha256 = sha256("G39\n\n");
  EXPECT_THAT(MeasurementFileSource(*recorded).calibrate(order),
              FailsWith(Code::MeasurementMismatch, "file \"PINS\", sha256 "));
}

TEST(RecordedCalibration, HasToBeTheProgramsOwn) {
  CalibrationOrder order;
  order.line = 7;
  order.command = "G39";
  order.first_hole = position_mm<frame::Machine>(101, 202);
  const auto answer_of = [&](const std::string& text) {
    MeasurementFileSource source(parse_measurements(text, "m.jsonl").value());
    return source.calibrate(order);
  };
  ASSERT_TRUE(answer_of(std::string(kRecorded)));
  EXPECT_TRUE(*answer_of(std::string(kRecorded)));
  EXPECT_THAT(answer_of(with("\"line\":7", "\"line\":8")),
              FailsWith(Code::MeasurementMismatch, "line 8"));
  EXPECT_THAT(answer_of(with("[101,202]", "[101,203]")),
              FailsWith(Code::MeasurementMismatch, "[101, 203]"));
  EXPECT_THAT(answer_of(with("\"first_hole\":[101,202],", "")),
              FailsWith(Code::MeasurementMismatch));
  // Of another number: this one was passed on only.
  EXPECT_FALSE(*answer_of(with("\"calibration\":0", "\"calibration\":1")));
  MeasurementFileSource unused(parse_measurements(kRecorded, "m.jsonl").value());
  EXPECT_THAT(unused.check_all_used(), FailsWith(Code::MeasurementMismatch, "calibration 0"));
}

}  // namespace
}  // namespace panelcal
