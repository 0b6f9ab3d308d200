// SPDX-License-Identifier: Apache-2.0
#include "calib/spindle/calibration_file.h"

#include <cmath>
#include <cstddef>
#include <filesystem>
#include <limits>
#include <string>

#include "calib/base/files/atomic_file.h"
#include "calib/base/statistics/random.h"
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

SpindleCameraOffset offset_of(double x_mm, double y_mm, double xx, double xy, double yy) {
  SpindleCameraOffset offset;
  offset.offset = displacement_mm<frame::Machine>(x_mm, y_mm);
  offset.cov_mm2 << xx, xy, xy, yy;
  return offset;
}

std::chrono::sys_seconds night(int day) {
  return std::chrono::sys_days(std::chrono::year(2026) / 11 / day) + std::chrono::hours(2);
}

/// Two spindles; the second was calibrated a day before, with an unknown sigma.
SpindleCalibration good() {
  SpindleCalibration c;
  c.offsets.set({1, 1}, offset_of(45.03125, -2.98, 1.5e-6, 2.5e-7, 2e-6));
  c.offsets.set({2, 1}, offset_of(-60, 0.1, 4e-6, 0, 4e-6));
  c.date = night(21);
  c.provenance = "coupon \"A\", 9 holes";
  SpindleQuality quality;
  quality.n_holes = 9;
  quality.n_looks = 36;
  quality.wander_um = {3.25, 3.25};
  quality.repeatability_um = {{1, 1.5}};
  quality.backlash_um = {-2.5, std::nullopt};
  c.records[{1, 1}] = {night(21), quality};
  c.records[{2, 1}] = {night(20), std::nullopt};
  return c;
}

/// The good file with one piece of text exchanged.
std::string text_with(const std::string& old_text, const std::string& new_text) {
  std::string text = spindle_calibration_text(good());
  const std::size_t at = text.find(old_text);
  EXPECT_NE(at, std::string::npos) << old_text;
  return text.replace(at, old_text.size(), new_text);
}

Expected<SpindleCalibration> parse(const std::string& text) {
  return parse_spindle_calibration(text, "s.cal.json");
}

std::filesystem::path scratch(const std::string& name) {
  return std::filesystem::path(testing::TempDir()) / ("spindle_calibration_file_test_" + name);
}

void expect_same(const SpindleCalibration& a, const SpindleCalibration& b) {
  EXPECT_EQ(a.date, b.date);
  EXPECT_EQ(a.provenance, b.provenance);
  ASSERT_EQ(a.offsets.all().size(), b.offsets.all().size());
  for (const auto& [at, offset] : a.offsets.all()) {
    const SpindleCameraOffset* const other = b.offsets.find(at);
    ASSERT_NE(other, nullptr);
    EXPECT_EQ(offset.offset.in_mm(), other->offset.in_mm());
    EXPECT_EQ(offset.cov_mm2, other->cov_mm2);
    EXPECT_EQ(a.date_of(at), b.date_of(at));
    EXPECT_EQ(a.records.at(at).quality, b.records.at(at).quality);
  }
}

TEST(SpindleCalibrationFile, LooksAsDocumented) {
  EXPECT_EQ(spindle_calibration_text(good()), R"({
  "kind": "spindle-camera",
  "version": 1,
  "date": "2026-11-21T02:00:00Z",
  "provenance": "coupon \"A\", 9 holes",
  "units": {"length": "mm"},
  "offsets": [
    {"spindle": 1, "station": 1, "date": "2026-11-21T02:00:00Z",
     "offset_mm": [45.03125, -2.98],
     "covariance_mm2": [[1.5e-06, 2.5e-07], [2.5e-07, 2e-06]],
     "quality": {"holes": 9, "looks": 36, "left_out": 0, "wander_um": [3.25, 3.25],
       "repeatability_um": [1, 1.5], "backlash_um": [-2.5, null]}},
    {"spindle": 2, "station": 1, "date": "2026-11-20T02:00:00Z",
     "offset_mm": [-60, 0.1],
     "covariance_mm2": [[4e-06, 0], [0, 4e-06]],
     "quality": null}
  ]
}
)");
}

TEST(SpindleCalibrationFile, ReadsBackWhatItWroteExactly) {
  const std::filesystem::path path = scratch("round.cal.json");
  ASSERT_TRUE(write_spindle_calibration(path, good()));
  const auto read = read_spindle_calibration(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(read) << read.error().text();
  expect_same(good(), *read);
}

TEST(SpindleCalibrationFile, ReadsBackAnythingThatItWrites) {
  // Seeds 1 to 300: any spindles, any sizes, covariances up to rank one.
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    SCOPED_TRACE(seed);
    Random random(seed);
    SpindleCalibration c;
    c.date = night(21);
    c.provenance = fmt::format("seed {} \t\"\\", seed);
    const int n = 1 + static_cast<int>(random.uniform(0, 24));
    for (int i = 0; i < n; ++i) {
      const SpindleAt at{1 + static_cast<int>(random.uniform(0, 12)),
                         1 + static_cast<int>(random.uniform(0, 2))};
      const double sx_mm = std::pow(10, random.uniform(-9, 0));
      const double sy_mm = random.uniform() < 0.2 ? 0 : std::pow(10, random.uniform(-9, 0));
      const double correlation = random.uniform() < 0.2 ? 1 : random.uniform(-1, 1);
      c.offsets.set(at,
                    offset_of(random.uniform(-1e5, 1e5),
                              random.normal() * 1e-7,
                              sx_mm * sx_mm,
                              correlation * sx_mm * sy_mm,
                              sy_mm * sy_mm));
      SpindleQuality quality;
      quality.n_holes = static_cast<int>(random.uniform(0, 1000));
      quality.wander_um = {std::abs(random.normal()), 0};
      if (random.uniform() < 0.5) quality.backlash_um[1] = random.normal();
      c.records[at] = {night(1 + i % 20), quality};
    }
    const auto read = parse(spindle_calibration_text(c));
    ASSERT_TRUE(read) << read.error().text();
    expect_same(c, *read);
    EXPECT_EQ(spindle_calibration_text(*read), spindle_calibration_text(c));
  }
}

TEST(SpindleCalibrationFile, NamesTheNearestKnownKey) {
  EXPECT_THAT(parse(text_with("\"offset_mm\"", "\"offset_m\"")),
              FailsWith(Code::CalibrationInvalid, "\"offset_mm\""));
}

TEST(SpindleCalibrationFile, RefusesWhatIsMissing) {
  for (const char* line : {"  \"version\": 1,\n",
                           "  \"units\": {\"length\": \"mm\"},\n",
                           "     \"offset_mm\": [-60, 0.1],\n",
                           "\"left_out\": 0, ",
                           "\"station\": 1, "}) {
    EXPECT_THAT(parse(text_with(line, "")), FailsWith(Code::CalibrationInvalid)) << line;
  }
  EXPECT_THAT(parse("{}"), FailsWith(Code::CalibrationInvalid, "\"kind\""));
  EXPECT_THAT(parse("[]"), FailsWith(Code::CalibrationInvalid));
}

TEST(SpindleCalibrationFile, RefusesWrongTypesAndOtherKinds) {
  const auto refuse = [](const std::string& old_text, const std::string& new_text) {
    EXPECT_THAT(parse(text_with(old_text, new_text)), FailsWith(Code::CalibrationInvalid))
        << new_text;
  };
  refuse("\"spindle-camera\"", "\"camera\"");
  refuse("\"version\": 1", "\"version\": 2");
  refuse("\"mm\"", "\"inch\"");
  refuse("\"spindle\": 2", "\"spindle\": 13");
  refuse("\"spindle\": 2", "\"spindle\": 0");
  refuse("\"spindle\": 2", "\"spindle\": 1.5");
  refuse("\"station\": 1", "\"station\": 3");
  refuse("[45.03125, -2.98]", "[45.03125]");
  refuse("[45.03125, -2.98]", "[45.03125, null]");
  refuse("[45.03125, -2.98]", "\"45, -3\"");
  refuse("[[4e-06, 0], [0, 4e-06]]", "[4e-06, 0, 0, 4e-06]");
  refuse("[[4e-06, 0], [0, 4e-06]]", "[[4e-06, 0], [0]]");
  refuse("[-2.5, null]", "[-2.5]");
  refuse("[-2.5, null]", "[-2.5, \"\"]");
  refuse("[-2.5, null]", "null");
  refuse("\"quality\": null", "\"quality\": 3");
  refuse("\"holes\": 9", "\"holes\": -9");
  refuse("\"wander_um\": [3.25, 3.25]", "\"wander_um\": [3.25, -3.25]");
  refuse("2026-11-20T02:00:00Z", "yesterday");
}

TEST(SpindleCalibrationFile, RefusesNumbersThatCannotBe) {
  EXPECT_THAT(parse(text_with("[45.03125, -2.98]", "[45.03125, -2.98e6]")),
              FailsWith(Code::CalibrationInvalid, "\"offset_mm\" of offset 0"));
  for (const char* cov : {"[[4e-06, 5e-06], [5e-06, 4e-06]]",
                          "[[4e-06, 1e-06], [0, 4e-06]]",
                          "[[-4e-06, 0], [0, 4e-06]]",
                          "[[4e+09, 0], [0, 4e-06]]"}) {
    EXPECT_THAT(parse(text_with("[[4e-06, 0], [0, 4e-06]]", cov)),
                FailsWith(Code::CalibrationInvalid, "spindle 2 station 1"))
        << cov;
  }
}

TEST(SpindleCalibrationFile, RefusesASpindleTwiceNoneAndOneOfTheFuture) {
  EXPECT_THAT(parse(text_with("\"spindle\": 2", "\"spindle\": 1")),
              FailsWith(Code::CalibrationInvalid, "spindle 1 station 1"));
  SpindleCalibration c = good();
  c.offsets = {};
  c.records.clear();
  EXPECT_THAT(parse(spindle_calibration_text(c)), FailsWith(Code::CalibrationInvalid));
  EXPECT_THAT(parse(text_with("2026-11-20T02:00:00Z", "2026-11-22T02:00:00Z")),
              FailsWith(Code::CalibrationInvalid, "date"));
}

TEST(SpindleCalibrationFile, NamesLineAndColumnOfSyntaxErrors) {
  EXPECT_THAT(parse("{\n  \"kind\": spindle\n}"),
              FailsWith(Code::JsonSyntax, "s.cal.json:2:11: error[json-syntax]"));
  EXPECT_THAT(parse(""), FailsWith(Code::JsonSyntax, "s.cal.json:1:1:"));
  EXPECT_THAT(parse(text_with("45.03125", "NaN")), FailsWith(Code::JsonSyntax));
  EXPECT_THAT(parse(text_with("45.03125", "1e999")), FailsWith(Code::JsonSyntax));
  EXPECT_THAT(parse(text_with("\"station\": 1", "\"spindle\": 1")), FailsWith(Code::JsonSyntax));
}

TEST(SpindleCalibrationFile, AnswersAnyBytes) {
  // Damage of every kind at every place: never an exception, a crash, or a place out of the text.
  Random random(83);
  const std::string text = spindle_calibration_text(good());
  int n_read = 0;
  for (int trial = 0; trial < 5000; ++trial) {
    std::string damaged = text;
    for (int i = 0; i <= trial % 4; ++i) {
      const auto at =
          static_cast<std::size_t>(random.uniform() * static_cast<double>(damaged.size()));
      const char byte = static_cast<char>(static_cast<int>(random.uniform(0, 256)));
      if (trial % 3 == 0) damaged[at] = byte;
      if (trial % 3 == 1) damaged.erase(at, 1 + static_cast<std::size_t>(random.uniform(0, 20)));
      if (trial % 3 == 2) damaged.insert(at, 1, damaged[damaged.size() - 1 - at]);
    }
    const auto read = parse(damaged);
    if (read) {
      ++n_read;
      EXPECT_TRUE(parse(spindle_calibration_text(*read)));
    } else {
      EXPECT_LE(read.error().place.line, 30) << damaged;
    }
  }
  EXPECT_GT(n_read, 10);
  EXPECT_LT(n_read, 2500);
}

TEST(SpindleCalibrationFile, IsNotWrittenUnlessItCouldBeRead) {
  const std::filesystem::path path = scratch("refused.cal.json");
  std::filesystem::remove(path);
  const auto refuse = [&](const SpindleCalibration& c) {
    EXPECT_THAT(write_spindle_calibration(path, c), FailsWith(Code::CalibrationInvalid));
    EXPECT_FALSE(std::filesystem::exists(path));
  };
  for (const double bad : {kNan, kInf, -kInf}) {
    SpindleCalibration c = good();
    c.records[{1, 1}].quality->wander_um[1] = bad;
    refuse(c);
    c = good();
    c.records[{1, 1}].quality->backlash_um[0] = bad;
    refuse(c);
  }
  SpindleCalibration c = good();
  c.offsets.set({1, 1}, offset_of(2e5, 0, 1, 0, 1));
  refuse(c);
  c = good();
  c.offsets.set({1, 1}, offset_of(0, 0, 2e6, 0, 1));
  refuse(c);
  c = good();
  c.records[{3, 1}] = {night(20), std::nullopt};
  refuse(c);
}

TEST(SpindleCalibrationFile, AnOffsetWithoutARecordIsOfTheFilesDate) {
  SpindleCalibration c = good();
  c.records.erase({2, 1});
  EXPECT_EQ(c.date_of({2, 1}), night(21));
  const auto read = parse(spindle_calibration_text(c));
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read->date_of({2, 1}), night(21));
}

}  // namespace
}  // namespace panelcal
