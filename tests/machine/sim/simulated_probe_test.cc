// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/simulated_probe.h"

#include <limits>
#include <string>
#include <vector>

#include "machine/sources/probe_file_source.h"
#include <gtest/gtest.h>

#include "tests/support/matchers.h"
#include "tests/support/statistics.h"

namespace panelcal {
namespace {

using test::FailsWith;

/// Rounding of heights of some mm.
constexpr double kRounding_mm = 1e-13;

ProbeRequest request(std::int64_t seq, double x_mm, double y_mm) {
  ProbeRequest request;
  request.seq = seq;
  request.command = "G79";
  // The board lies a little off, so nominal and expected differ.
  request.nominal = position_mm<frame::Nominal>(x_mm - 0.5, y_mm + 0.25);
  request.expected = position_mm<frame::Actual>(x_mm, y_mm);
  return request;
}

SimulatedProbe made(const SimulatedProbeOptions& options) {
  auto probe = SimulatedProbe::create(options);
  EXPECT_TRUE(probe) << probe.error().text();
  return *std::move(probe);
}

SimulatedProbeOptions curved() {
  SimulatedProbeOptions options;
  options.height = mm(1.6);
  options.slope_x_ppm = 500;
  options.slope_y_ppm = -200;
  options.bow = mm(0.09);
  options.bow_center = position_mm<frame::Actual>(250, 200);
  options.bow_radius = mm(300);
  options.axis_offsets = {Length(), um(30)};
  options.noise_sigma = Length();
  return options;
}

double height_mm(SimulatedProbe& probe, const ProbeRequest& request, std::size_t axis = 0) {
  const auto reading = probe.probe(request);
  EXPECT_TRUE(reading);
  EXPECT_EQ(reading->status, ProbeStatus::Found);
  return reading->heights.at(axis).height.in_mm();
}

TEST(SimulatedProbe, SurfaceIsTiltedAndBowed) {
  SimulatedProbe probe = made(curved());
  // 1.6 + 0.0005 x - 0.0002 y, and 0.09 mm of bow 300 mm from (250, 200).
  EXPECT_NEAR(height_mm(probe, request(0, 250, 200)), 1.6 + 0.125 - 0.04, kRounding_mm);
  EXPECT_NEAR(height_mm(probe, request(1, 550, 200)), 1.6 + 0.275 - 0.04 + 0.09, kRounding_mm);
  EXPECT_NEAR(height_mm(probe, request(2, 250, 350)), 1.6 + 0.125 - 0.07 + 0.0225, kRounding_mm);
}

TEST(SimulatedProbe, EveryZAxisReadsItsOffset) {
  SimulatedProbe probe = made(curved());
  const auto reading = probe.probe(request(0, 250, 200));
  ASSERT_TRUE(reading);
  ASSERT_EQ(reading->heights.size(), 2u);
  EXPECT_NEAR((reading->heights[1].height - reading->heights[0].height).in_um(), 30, 1e-9);
  EXPECT_EQ(reading->heights[0].sigma, Length());
}

TEST(SimulatedProbe, NoiseHasTheSigmaItSays) {
  SimulatedProbeOptions options = curved();
  options.noise_sigma = um(3);
  SimulatedProbe probe = made(options);
  constexpr int kReadings = 2000;
  double sum = 0;
  double chi_square = 0;
  double product = 0;
  for (int seq = 0; seq < kReadings; ++seq) {
    const ProbeRequest asked = request(seq, 100, 0.1 * seq);
    const auto reading = probe.probe(asked);
    ASSERT_TRUE(reading);
    std::vector<double> errors;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      EXPECT_EQ(reading->heights[axis].sigma, um(3));
      const Length truth = probe.true_height(asked.expected, axis);
      errors.push_back((reading->heights[axis].height - truth) / um(3));
      sum += errors.back();
      chi_square += errors.back() * errors.back();
    }
    product += errors[0] * errors[1];
  }
  EXPECT_TRUE(test::mean_agrees(sum / (2 * kReadings), 0, 1, 2 * kReadings));
  EXPECT_TRUE(test::chi_square_agrees(chi_square, 2 * kReadings));
  EXPECT_TRUE(test::mean_agrees(product / kReadings, 0, 1, kReadings)) << "axes are independent";
}

TEST(SimulatedProbe, SeedNamesTheReadingsInWhateverOrder) {
  SimulatedProbeOptions options = curved();
  options.noise_sigma = um(3);
  SimulatedProbe probe = made(options);
  SimulatedProbe again = made(options);
  const double first = height_mm(probe, request(0, 10, 10));
  const double second = height_mm(probe, request(1, 10, 10));
  EXPECT_NE(first, second);
  EXPECT_EQ(height_mm(again, request(1, 10, 10)), second);
  EXPECT_EQ(height_mm(again, request(0, 10, 10)), first);
  options.seed = 2;
  SimulatedProbe other = made(options);
  EXPECT_NE(height_mm(other, request(0, 10, 10)), first);
}

TEST(SimulatedProbe, ItsReadingsReplayFromAFile) {
  SimulatedProbeOptions options = curved();
  options.noise_sigma = um(3);
  SimulatedProbe probe = made(options);
  std::string text;
  for (int seq = 0; seq < 5; ++seq) {
    text += to_json(*probe.probe(request(seq, 10.0 * seq, 7))) + "\n";
  }
  auto recorded = parse_probes(text, "p.jsonl");
  ASSERT_TRUE(recorded) << recorded.error().text();
  ProbeFileSource replay(*std::move(recorded));
  for (int seq = 0; seq < 5; ++seq) {
    const auto reading = replay.probe(request(seq, 10.0 * seq, 7));
    ASSERT_TRUE(reading) << reading.error().text();
    EXPECT_EQ(to_json(*reading), to_json(*probe.probe(request(seq, 10.0 * seq, 7))));
  }
  EXPECT_TRUE(replay.check_all_used());
}

TEST(SimulatedProbe, RefusesOptionsThatMakeNoSense) {
  const auto refusal = [](auto change) {
    SimulatedProbeOptions options;
    change(options);
    const auto probe = SimulatedProbe::create(options);
    return probe ? "accepted" : probe.error().text();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(refusal([](SimulatedProbeOptions&) {}), "accepted");
  EXPECT_NE(refusal([](auto& o) { o.bow_radius = Length(); })
                .find("bow_radius is 0 mm; expected "
                      "more than 0"),
            std::string::npos);
  EXPECT_NE(refusal([](auto& o) { o.noise_sigma = um(-1); })
                .find("noise_sigma is -1 um; expected "
                      "0 or more"),
            std::string::npos);
  EXPECT_NE(refusal([](auto& o) { o.axis_offsets.clear(); }).find("axis_offsets is empty"),
            std::string::npos);
  for (const auto& text : {refusal([&](auto& o) { o.height = mm(nan); }),
                           refusal([&](auto& o) { o.slope_y_ppm = nan; }),
                           refusal([&](auto& o) { o.axis_offsets[0] = mm(nan); }),
                           refusal([&](auto& o) { o.noise_sigma = mm(nan); })}) {
    EXPECT_NE(text, "accepted");
  }
  SimulatedProbeOptions bad;
  bad.bow_radius = mm(-1);
  EXPECT_THAT(SimulatedProbe::create(bad), FailsWith(Code::ConfigValue, "bow_radius"));
}

}  // namespace
}  // namespace panelcal
