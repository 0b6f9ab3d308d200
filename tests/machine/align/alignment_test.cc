// SPDX-License-Identifier: Apache-2.0
#include "machine/align/alignment.h"

#include <string>

#include "calib/base/clock.h"
#include <gtest/gtest.h>

namespace panelcal {
namespace {

Alignment small_alignment() {
  Alignment alignment{.file = "a.json",
                      .made_by = "panelcal 0",
                      .machine = "m",
                      .panel = "7",
                      .time = *from_iso_8601("2026-11-28T02:00:00Z"),
                      .by = "Ada",
                      .source = "s",
                      .pads = "2 pads",
                      .inputs = {{"machine file", "machine.toml", std::string(64, 'a')}},
                      .names = {"FID1", ""}};
  for (int i = 0; i < 2; ++i) {
    Measurement pad;
    pad.request.seq = i;
    pad.request.command = "G36";
    pad.request.settings.tools = {1};
    pad.request.nominal = position_mm<frame::Nominal>(10.0 * i, 0.1);
    pad.status = MeasurementStatus::Found;
    pad.measured = {position_mm<frame::Actual>(10.0 * i + 1.0 / 3, 0.2),
                    Eigen::Matrix2d::Identity() * 1e-7};
    alignment.measurements.push_back(pad);
  }
  alignment.fit.emplace().model = "rigid";
  alignment.gates = {{"residual", 1.5, 100, "um", true}};
  alignment.checks = {{*from_iso_8601("2026-11-28T03:00:00Z"),
                       "Ben",
                       {1, 2},
                       {position_mm<frame::Actual>(0, 0), position_mm<frame::Actual>(1, 1)},
                       2.5,
                       18.5,
                       true}};
  return alignment;
}

TEST(AlignmentFile, ComesBackToTheBit) {
  const Alignment written = small_alignment();
  const std::string text = alignment_text(written);
  const auto read = parse_alignment(text, "a.json");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(alignment_text(*read), text);
  EXPECT_EQ(read->measurements[1].measured.position, written.measurements[1].measured.position);
  EXPECT_EQ(read->last_seen(), written.checks[0].time);
  EXPECT_EQ(read->inputs, written.inputs);
}

TEST(AlignmentFile, LacksWhatWasNotFound) {
  Alignment held = small_alignment();
  held.fit.reset();
  held.held = "target not found";
  held.checks.clear();
  const auto read = parse_alignment(alignment_text(held), "a.json");
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_FALSE(read->fit);
  EXPECT_EQ(read->held, held.held);
  EXPECT_EQ(read->last_seen(), held.time);
}

TEST(AlignmentFile, KeepsACheckThatLostAPad) {
  Alignment lost = small_alignment();
  lost.checks[0].is_accepted = false;
  for (std::size_t n = 2; n-- > 0;) {
    lost.checks[0].seen.resize(n);
    const auto read = parse_alignment(alignment_text(lost), "a.json");
    ASSERT_TRUE(read) << read.error().text();
    EXPECT_EQ(read->checks[0].seen.size(), n);
    EXPECT_FALSE(read->checks[0].has_seen_all());
  }
}

TEST(AlignmentFile, RefusesWhatContradictsItself) {
  const auto refused = [](const auto& change) {
    Alignment alignment = small_alignment();
    change(alignment);
    const auto read = parse_alignment(alignment_text(alignment), "a.json");
    return read ? std::string("none") : std::string(info(read.error().code).slug);
  };
  EXPECT_EQ(refused([](Alignment& a) { a.names.pop_back(); }), "calibration-invalid");
  EXPECT_EQ(refused([](Alignment& a) { a.measurements[1].request.seq = 5; }),
            "calibration-invalid");
  EXPECT_EQ(refused([](Alignment& a) { a.checks[0].seen.pop_back(); }), "calibration-invalid")
      << "accepted without";
  EXPECT_EQ(refused([](Alignment& a) { a.checks[0].pads = {1, 3}; }), "calibration-invalid");
  EXPECT_EQ(refused([](Alignment& a) { a.checks[0].time = a.time - std::chrono::seconds(1); }),
            "calibration-invalid");
  EXPECT_EQ(refused([](Alignment& a) { a.measurements[0].measured.cov(0, 1) = 1; }),
            "measurement-invalid");
  EXPECT_EQ(refused([](Alignment& a) {
              a.measurements.clear();
              a.names.clear();
            }),
            "calibration-invalid");
}

TEST(AlignmentFile, EndsForAnyCutOffText) {
  const std::string text = alignment_text(small_alignment());
  for (std::size_t n = 0; n + 2 < text.size(); ++n) {
    EXPECT_FALSE(parse_alignment(text.substr(0, n), "a.json")) << n;
  }
}

}  // namespace
}  // namespace panelcal
