// SPDX-License-Identifier: Apache-2.0
#include "program/walk/probing.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace panelcal {
namespace {

ProbeRequest request() {
  ProbeRequest request;
  request.seq = 3;
  request.line = 7;
  request.command = "G73";
  request.nominal = position_mm<frame::Nominal>(165, 15);
  request.expected = position_mm<frame::Actual>(165.25, 14.875);
  request.path = {0, 1};
  request.tool = 5;
  request.reference = mm(1.6);
  return request;
}

TEST(ProbingJson, ARequestHasItsPlaceAndItsReference) {
  EXPECT_EQ(to_json(request()),
            R"({"probe":3,"line":7,"command":"G73","tool":5,"nominal":[165,15],)"
            R"("expected":[165.25,14.875],"path":[0,1],"reference":1.6})");
}

TEST(ProbingJson, MemoryDepthAndFileAppearWhereTheyAre) {
  ProbeRequest full = request();
  full.path.clear();
  full.file = "sub \"1\".prg";
  full.memory = 0;
  full.depth = mm(-0.25);
  EXPECT_TRUE(to_json(full).ends_with(
      R"("path":[],"file":"sub \"1\".prg","L":0,"depth":-0.25,"reference":1.6})"));
}

TEST(ProbingJson, AReadingHasALineForEveryZAxis) {
  const ProbeReading reading{.request = request(),
                             .status = ProbeStatus::Found,
                             .heights = {{mm(1.5), um(2)}, {mm(1.75), Length()}}};
  const std::string same = R"({"probe":3,"line":7,"command":"G73","tool":5,"nominal":[165,15],)"
                           R"("expected":[165.25,14.875],"path":[0,1],"reference":1.6,)";
  EXPECT_EQ(to_json(reading),
            same + R"("zaxis":0,"height":1.5,"sigma":0.002,"status":"found"})" + "\n" + same +
                R"("zaxis":1,"height":1.75,"sigma":0,"status":"found"})");
}

TEST(ProbingJson, AMissedSurfaceHasAReasonAndNoHeight) {
  const ProbeReading missed{
      .request = request(), .status = ProbeStatus::NotFound, .reason = "no contact above Z-1"};
  EXPECT_TRUE(to_json(missed).ends_with(
      R"("reference":1.6,"status":"not_found","reason":"no contact above Z-1"})"));
}

TEST(ProbingJson, NumbersRoundTripExactly) {
  ProbeReading reading{.request = request(), .status = ProbeStatus::Found};
  reading.request.reference = mm(0.1 + 0.2);
  reading.request.depth = mm(2.0 / 3);
  reading.heights = {{mm(1.0 / 3), mm(1.2345678901234567e-7)}};
  const auto read = nlohmann::json::parse(to_json(reading));
  EXPECT_EQ(read["reference"].get<double>(), 0.1 + 0.2);
  EXPECT_EQ(read["depth"].get<double>(), 2.0 / 3);
  EXPECT_EQ(read["height"].get<double>(), 1.0 / 3);
  EXPECT_EQ(read["sigma"].get<double>(), 1.2345678901234567e-7);
}

TEST(ProbeStatus, NamesReadBack) {
  for (const auto status : {ProbeStatus::Found, ProbeStatus::NotFound}) {
    EXPECT_EQ(probe_status_from_name(name(status)), status);
  }
  EXPECT_EQ(probe_status_from_name("ambiguous"), std::nullopt);
}

TEST(NominalProbeSource, FindsTheSurfaceWhereItIsExpected) {
  NominalProbeSource source(3);
  const auto reading = source.probe(request());
  ASSERT_TRUE(reading);
  EXPECT_EQ(reading->status, ProbeStatus::Found);
  EXPECT_EQ(to_json(reading->request), to_json(request()));
  ASSERT_EQ(reading->heights.size(), 3u);
  for (const HeightEstimate& height : reading->heights) {
    EXPECT_EQ(height.height, mm(1.6));
    EXPECT_EQ(height.sigma, Length());
  }
}

TEST(ProbeRequest, ExpectedInMachineAddsWorkZero) {
  ProbeRequest shifted = request();
  shifted.work_zero = position_mm<frame::Machine>(100, 200);
  EXPECT_EQ(shifted.expected_in_machine(), position_mm<frame::Machine>(265.25, 214.875));
}

TEST(ProbeRequest, IsDescribedByCommandNumberAndLine) {
  EXPECT_EQ(describe(request()), "G73 probe 3 (line 7)");
}

}  // namespace
}  // namespace panelcal
