// SPDX-License-Identifier: Apache-2.0
#include "calib/base/json/json_string.h"
#include "program/model/measurement.h"
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace panelcal {
namespace {

MeasurementRequest request() {
  MeasurementRequest request;
  request.seq = 3;
  request.line = 7;
  request.command = "G46";
  request.settings.tools = {1};
  request.nominal = position_mm<frame::Nominal>(1.5, -2);
  request.expected = position_mm<frame::Actual>(1.25, -2.125);
  request.path = {0, 1};
  return request;
}

TEST(MeasurementJson, ARequestIsAsTheContractSays) {
  EXPECT_EQ(to_json(request()),
            R"({"seq":3,"line":7,"command":"G46","tool":1,"nominal":[1.5,-2],)"
            R"("expected":[1.25,-2.125],"path":[0,1]})");
}

TEST(MeasurementJson, AnEmptyPathIsAnEmptyList) {
  MeasurementRequest outside = request();
  outside.path.clear();
  EXPECT_TRUE(to_json(outside).ends_with(R"("path":[]})"));
}

TEST(MeasurementJson, SettingsAppearWhereTheyDifferFromNothing) {
  MeasurementRequest with_settings = request();
  with_settings.settings = {.tools = {1, 2, 3, 4},
                            .delta = mm(1.27),
                            .inspections = 2,
                            .search = false,
                            .search_area = mm(2.5),
                            .lamp = 55,
                            .zoom = 7,
                            .algorithm = 0};
  EXPECT_TRUE(to_json(with_settings)
                  .ends_with(R"("path":[0,1],"tools":[1,2,3,4],"delta":1.27,"inspections":2,)"
                             R"("search":false,"search_area":2.5,"lamp":55,"zoom":7,)"
                             R"("algorithm":0})"));
}

TEST(MeasurementJson, ARequestToFocusSaysSoInPlaceOfASeq) {
  MeasurementRequest focus;
  focus.seq = -1;
  focus.line = 12;
  focus.command = "$uvis,focus";
  focus.nominal = position_mm<frame::Nominal>(10, 20.5);
  focus.expected = position_mm<frame::Actual>(10, 20.5);
  focus.settings.tools = {1};
  focus.settings.lamp = 55;
  EXPECT_EQ(to_json(focus),
            R"({"focus":true,"line":12,"command":"$uvis,focus","nominal":[10,20.5],)"
            R"("expected":[10,20.5],"path":[],"lamp":55})");
}

TEST(MeasurementJson, AFoundTargetHasPlaceAndCovariance) {
  Measurement found{.request = request(), .status = MeasurementStatus::Found};
  found.measured.position = position_mm<frame::Actual>(1.26, -2.1);
  found.measured.cov << 1e-6, 2e-7, 2e-7, 4e-6;
  found.score = 0.98;
  found.image = "a \"b\".png";
  EXPECT_TRUE(to_json(found).ends_with(
      R"("path":[0,1],"measured":[1.26,-2.1],"cov":[1e-06,2e-07,4e-06],"score":0.98,)"
      R"("image":"a \"b\".png","status":"found"})"));
}

TEST(MeasurementJson, ALostTargetHasAReasonAndNoPlace) {
  const Measurement lost{
      .request = request(), .status = MeasurementStatus::NotFound, .reason = "too dark"};
  EXPECT_TRUE(to_json(lost).ends_with(R"("path":[0,1],"status":"not_found","reason":"too dark"})"));
}

TEST(MeasurementJson, NumbersRoundTripExactly) {
  Measurement found{.request = request(), .status = MeasurementStatus::Found};
  found.measured.position = position_mm<frame::Actual>(0.1 + 0.2, 1.0 / 3);
  found.measured.cov = Eigen::Matrix2d::Identity() * 1.2345678901234567e-7;
  const auto read = nlohmann::json::parse(to_json(found));
  EXPECT_EQ(read["measured"][0].get<double>(), 0.1 + 0.2);
  EXPECT_EQ(read["measured"][1].get<double>(), 1.0 / 3);
  EXPECT_EQ(read["cov"][2].get<double>(), 1.2345678901234567e-7);
}

TEST(MeasurementStatus, NamesReadBack) {
  for (const auto status : {MeasurementStatus::Found,
                            MeasurementStatus::NotFound,
                            MeasurementStatus::Ambiguous,
                            MeasurementStatus::Rejected}) {
    EXPECT_EQ(measurement_status_from_name(name(status)), status);
  }
  EXPECT_EQ(measurement_status_from_name("lost"), std::nullopt);
}

TEST(NominalSource, FindsEveryTargetWhereItIsExpected) {
  NominalSource source;
  const auto measurement = source.measure(request());
  ASSERT_TRUE(measurement);
  EXPECT_EQ(measurement->status, MeasurementStatus::Found);
  EXPECT_EQ(measurement->measured.position, request().expected);
}

TEST(MeasurementRequest, ExpectedInMachineAddsWorkZero) {
  MeasurementRequest shifted = request();
  shifted.work_zero = position_mm<frame::Machine>(100, 200);
  EXPECT_EQ(shifted.expected_in_machine(), position_mm<frame::Machine>(101.25, 197.875));
}

std::string json_string(std::string_view text) {
  std::string out;
  append_json_string(out, text);
  return out;
}

TEST(JsonString, EscapesQuotesBackslashesAndControls) {
  EXPECT_EQ(json_string("a\"b\\c"), R"("a\"b\\c")");
  EXPECT_EQ(json_string("\n\t\x7f"), R"("\u000a\u0009\u007f")");
  EXPECT_EQ(json_string(std::string_view("\0", 1)), R"("\u0000")");
}

TEST(JsonString, KeepsUtf8AndTurnsOtherBytesIntoLatin1) {
  EXPECT_EQ(json_string("\xC3\xA4 \xE2\x82\xAC \xF0\x9F\x98\x80"),
            "\"\xC3\xA4 \xE2\x82\xAC \xF0\x9F\x98\x80\"");
  EXPECT_EQ(json_string("\xE4"), R"("\u00e4")");
  EXPECT_EQ(json_string("\xC3"), R"("\u00c3")");
  EXPECT_EQ(json_string("\xC0\x80"), R"("\u00c0\u0080")");                      // overlong
  EXPECT_EQ(json_string("\xED\xA0\x80"), R"("\u00ed\u00a0\u0080")");            // surrogate
  EXPECT_EQ(json_string("\xF4\x90\x80\x80"), R"("\u00f4\u0090\u0080\u0080")");  // too large
}

TEST(JsonString, AnyBytesGiveValidJson) {
  std::string bytes;
  for (int first = 0; first < 256; ++first) {
    for (const int second : {0x00, 0x22, 0x7F, 0x80, 0xBF, 0xC3, 0xFF}) {
      bytes += static_cast<char>(first);
      bytes += static_cast<char>(second);
    }
  }
  EXPECT_TRUE(nlohmann::json::accept(json_string(bytes)));
}

}  // namespace
}  // namespace panelcal
