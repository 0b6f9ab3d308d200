// SPDX-License-Identifier: Apache-2.0
#include "calib/camera/calibration/calibration_file.h"

#include <limits>

#include "calib/base/files/atomic_file.h"
#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using testing::HasSubstr;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

CameraCalibration good() {
  CameraCalibration c;
  c.parameters = {.scale_mm_per_px = 0.0125,
                  .rotation_rad = -0.0031,
                  .axis_px = {319.25, 240.7},
                  .k1_per_px2 = -1.3e-8};
  c.covariance.diagonal() << 1e-14, 1e-10, 4e-4, 9e-4, 1e-20;
  c.covariance(0, 4) = c.covariance(4, 0) = -9e-18;
  c.picture_width_px = 640;
  c.picture_height_px = 480;
  c.date = std::chrono::sys_days(std::chrono::year(2026) / 11 / 21) + std::chrono::seconds(31058);
  c.provenance = "coupon 17, 25 holes, \"lamp 2\"";
  return c;
}

/// The good file with one piece of text exchanged.
std::string text_with(const std::string& old_text, const std::string& new_text) {
  std::string text = camera_calibration_text(good());
  const std::size_t at = text.find(old_text);
  EXPECT_NE(at, std::string::npos) << old_text;
  return text.replace(at, old_text.size(), new_text);
}

Expected<CameraCalibration> parse(const std::string& text) {
  return parse_camera_calibration(text, "c.cal.json");
}

std::filesystem::path scratch(const std::string& name) {
  return std::filesystem::path(testing::TempDir()) / ("calibration_file_test_" + name);
}

TEST(CalibrationFile, ReadsBackWhatItWroteExactly) {
  const std::filesystem::path path = scratch("round.cal.json");
  const CameraCalibration written = good();
  ASSERT_TRUE(write_camera_calibration(path, written));
  const Expected<CameraCalibration> read = read_camera_calibration(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read->parameters.scale_mm_per_px, written.parameters.scale_mm_per_px);
  EXPECT_EQ(read->parameters.rotation_rad, written.parameters.rotation_rad);
  EXPECT_EQ(read->parameters.axis_px, written.parameters.axis_px);
  EXPECT_EQ(read->parameters.k1_per_px2, written.parameters.k1_per_px2);
  EXPECT_EQ(read->covariance, written.covariance);
  EXPECT_EQ(read->picture_width_px, 640);
  EXPECT_EQ(read->picture_height_px, 480);
  EXPECT_EQ(read->date, written.date);
  EXPECT_EQ(read->provenance, written.provenance);
}

TEST(CalibrationFile, LooksAsDocumented) {
  EXPECT_EQ(camera_calibration_text(good()), R"({
  "kind": "camera",
  "version": 1,
  "date": "2026-11-21T08:37:38Z",
  "provenance": "coupon 17, 25 holes, \"lamp 2\"",
  "units": {"length": "mm", "angle": "rad", "picture": "px"},
  "picture_px": [640, 480],
  "parameters": {
    "scale_mm_per_px": 0.0125,
    "rotation_rad": -0.0031,
    "axis_px": [319.25, 240.7],
    "k1_per_px2": -1.3e-08
  },
  "covariance": [
    [1e-14, 0, 0, 0, -9e-18],
    [0, 1e-10, 0, 0, 0],
    [0, 0, 0.0004, 0, 0],
    [0, 0, 0, 0.0009, 0],
    [-9e-18, 0, 0, 0, 1e-20]
  ]
}
)");
}

TEST(CalibrationFile, KeepsProvenanceThatIsNotText) {
  CameraCalibration c = good();
  c.provenance = std::string("\xff\x01\0 tab\t", 8);
  const Expected<CameraCalibration> read = parse(camera_calibration_text(c));
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_THAT(read->provenance, HasSubstr(" tab\t"));
}

TEST(CalibrationFile, NamesTheNearestKnownKey) {
  EXPECT_THAT(parse(text_with("\"rotation_rad\"", "\"rotation_deg\"")),
              FailsWith(Code::CalibrationInvalid, "\"rotation_rad\""));
  EXPECT_THAT(parse(text_with("\"kind\"", "\"colour\"")),
              FailsWith(Code::CalibrationInvalid, "\"colour\""));
}

TEST(CalibrationFile, RefusesMissingKeys) {
  EXPECT_THAT(parse(text_with("    \"rotation_rad\": -0.0031,\n", "")),
              FailsWith(Code::CalibrationInvalid, "\"rotation_rad\""));
  EXPECT_THAT(parse("{}"), FailsWith(Code::CalibrationInvalid, "\"kind\""));
  EXPECT_THAT(parse("[]"), FailsWith(Code::CalibrationInvalid));
  EXPECT_THAT(parse("17"), FailsWith(Code::CalibrationInvalid));
}

TEST(CalibrationFile, RefusesKeysThatAppearTwice) {
  EXPECT_THAT(parse(text_with("\"rotation_rad\": -0.0031", "\"k1_per_px2\": 0")),
              FailsWith(Code::JsonSyntax, "\"k1_per_px2\""));
}

TEST(CalibrationFile, RefusesWrongTypesAndOtherKinds) {
  const auto refuse = [](const std::string& old_text, const std::string& new_text) {
    EXPECT_THAT(parse(text_with(old_text, new_text)), FailsWith(Code::CalibrationInvalid))
        << new_text;
  };
  refuse("\"camera\"", "\"table\"");
  refuse("\"version\": 1", "\"version\": 2");
  refuse("\"version\": 1", "\"version\": \"1\"");
  refuse("\"version\": 1", "\"version\": 1e300");
  refuse("\"mm\"", "\"inch\"");
  refuse("0.0125", "\"0.0125\"");
  refuse("0.0125", "true");
  refuse("0.0125", "null");
  refuse("[319.25, 240.7]", "[319.25]");
  refuse("[319.25, 240.7]", "[319.25, \"240.7\"]");
  refuse("[640, 480]", "[640, 480.5]");
  refuse("[640, 480]", "[640, 0]");
  refuse("[640, 480]", "[-640, 480]");
  refuse("[640, 480]", "[1e99, 480]");
  refuse("[0, 1e-10, 0, 0, 0]", "[0, 1e-10, 0, 0]");
  refuse("[0, 1e-10, 0, 0, 0]", "[0, 1e-10, 0, 0, {}]");
  refuse("    [0, 1e-10, 0, 0, 0],\n", "");
  refuse("{\"length\": \"mm\", \"angle\": \"rad\", \"picture\": \"px\"}", "\"mm\"");
  refuse("2026-11-21T08:37:38Z", "2026-11-31T08:37:38Z");
  refuse("2026-11-21T08:37:38Z", "yesterday");
  refuse("\"2026-11-21T08:37:38Z\"", "20261121");
}

TEST(CalibrationFile, RefusesScalesThatAreNone) {
  for (const char* scale : {"0", "-0.0125", "0.0"}) {
    EXPECT_THAT(parse(text_with("0.0125", scale)),
                FailsWith(Code::CalibrationInvalid, "scale_mm_per_px"));
  }
}

TEST(CalibrationFile, RefusesALensThatFoldsInsideThePicture) {
  // The farthest corner is 400.1 px away: 1 + 3 k1 r^2 = 0 at k1 = -2.08e-6.
  EXPECT_TRUE(parse(text_with("-1.3e-08", "-2.05e-6")));
  EXPECT_THAT(parse(text_with("-1.3e-08", "-2.1e-6")),
              FailsWith(Code::CalibrationInvalid, "k1_per_px2"));
}

TEST(CalibrationFile, RefusesWhatIsNoCovariance) {
  EXPECT_THAT(parse(text_with("[0, 1e-10, 0, 0, 0]", "[0, 1e-10, 1e-9, 0, 0]")),
              FailsWith(Code::CalibrationInvalid, "symmetric"));
  EXPECT_THAT(parse(text_with("[0, 1e-10, 0, 0, 0]", "[0, -1e-10, 0, 0, 0]")),
              FailsWith(Code::CalibrationInvalid, "positive semidefinite"));
  CameraCalibration c = good();
  c.covariance(0, 4) = c.covariance(4, 0) = 1.1e-17;
  EXPECT_THAT(parse(camera_calibration_text(c)),
              FailsWith(Code::CalibrationInvalid, "positive semidefinite"));
  c = good();
  c.covariance(2, 2) = 0;
  EXPECT_TRUE(parse(camera_calibration_text(c))) << "a parameter may be held fixed";
  c.covariance(2, 3) = c.covariance(3, 2) = 1e-6;
  EXPECT_FALSE(parse(camera_calibration_text(c)));
}

TEST(CalibrationFile, NamesLineAndColumnOfSyntaxErrors) {
  EXPECT_THAT(parse("{\n  \"kind\": camera\n}"),
              FailsWith(Code::JsonSyntax, "c.cal.json:2:11: error[json-syntax]"));
  EXPECT_THAT(parse("{\n\"kind\": \"camera\",\n}"), FailsWith(Code::JsonSyntax, "c.cal.json:3:1:"));
  EXPECT_THAT(parse(""), FailsWith(Code::JsonSyntax, "c.cal.json:1:1:"));
  EXPECT_THAT(parse("{\"a\": 1"), FailsWith(Code::JsonSyntax, "c.cal.json:1:8:"));
  EXPECT_THAT(parse(text_with("0.0125", "NaN")), FailsWith(Code::JsonSyntax, "c.cal.json:9:24:"));
  EXPECT_THAT(parse(text_with("0.0125", "1e999")), FailsWith(Code::JsonSyntax, "1e999"));
  EXPECT_THAT(parse(camera_calibration_text(good()) + "{}"), FailsWith(Code::JsonSyntax, ":22:1:"));
}

TEST(CalibrationFile, SurvivesNestingBombs) {
  const std::string bomb(400000, '[');
  EXPECT_THAT(parse(bomb), FailsWith(Code::JsonSyntax, "c.cal.json:1:17: "));
  std::string objects;
  for (int i = 0; i < 100000; ++i) objects += "{\"a\":";
  EXPECT_THAT(parse(objects), FailsWith(Code::JsonSyntax));
  EXPECT_THAT(parse("\"" + bomb + "\""), FailsWith(Code::CalibrationInvalid))
      << "brackets in a string do not nest";
}

TEST(CalibrationFile, AnswersAnyBytes) {
  // Damage of every kind at every place: never an exception, a crash, or a place out of the text.
  Random random(81);
  const std::string text = camera_calibration_text(good());
  int n_read = 0;
  for (int trial = 0; trial < 5000; ++trial) {
    std::string damaged = text;
    const int n_changes = 1 + trial % 4;
    for (int i = 0; i < n_changes; ++i) {
      const auto at =
          static_cast<std::size_t>(random.uniform() * static_cast<double>(damaged.size()));
      const char byte = static_cast<char>(static_cast<int>(random.uniform(0, 256)));
      if (trial % 3 == 0) damaged[at] = byte;
      if (trial % 3 == 1) damaged.erase(at, 1 + static_cast<std::size_t>(random.uniform(0, 20)));
      if (trial % 3 == 2) damaged.insert(at, 1, damaged[damaged.size() - 1 - at]);
    }
    const Expected<CameraCalibration> read = parse(damaged);
    if (read) {
      ++n_read;
    } else {
      EXPECT_LE(read.error().place.line, 30) << damaged;
    }
  }
  EXPECT_GT(n_read, 10);
  EXPECT_LT(n_read, 2500);
}

TEST(CalibrationFile, IsNotWrittenUnlessItCouldBeRead) {
  const std::filesystem::path path = scratch("refused.cal.json");
  const auto refuse = [&](const CameraCalibration& c) {
    EXPECT_THAT(write_camera_calibration(path, c), FailsWith(Code::CalibrationInvalid));
    EXPECT_FALSE(std::filesystem::exists(path));
  };
  for (const double bad : {kNan, kInf}) {
    CameraCalibration c = good();
    c.parameters.scale_mm_per_px = bad;
    refuse(c);
    c = good();
    c.parameters.rotation_rad = bad;
    refuse(c);
    c = good();
    c.parameters.axis_px.y() = bad;
    refuse(c);
    c = good();
    c.parameters.k1_per_px2 = bad;
    refuse(c);
    c = good();
    c.covariance(3, 3) = bad;
    refuse(c);
  }
  CameraCalibration c = good();
  c.picture_height_px = 0;
  refuse(c);
}

TEST(CalibrationFile, RefusesFilesThatAreMissingOrTooLarge) {
  EXPECT_THAT(read_camera_calibration(scratch("missing.cal.json")),
              FailsWith(Code::FileUnreadable, "missing.cal.json"));
  const std::filesystem::path path = scratch("large.cal.json");
  ASSERT_TRUE(write_file(path, std::string(kMaxCalibrationBytes + 1, ' ')));
  EXPECT_THAT(read_camera_calibration(path), FailsWith(Code::FileUnreadable, " bytes"));
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace panelcal
