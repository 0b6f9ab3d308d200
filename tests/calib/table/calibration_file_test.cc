// SPDX-License-Identifier: Apache-2.0
#include "calib/table/calibration_file.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "calib/base/statistics/random.h"
#include <gmock/gmock.h>

#include "tests/calib/table/simulated_table.h"
#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;

/// A map of 2 x 1 steps with knots of up to 30 um.
TableCalibration good() {
  TableGrid grid;
  grid.low_mm << 10, 20;
  grid.high_mm << 310, 220.5;
  grid.nx = 2;
  grid.ny = 1;
  Random random(5);
  std::vector<Eigen::Vector2d> knots_mm;
  for (int i = 0; i < grid.n_coefficients(); ++i) {
    const double x_mm = random.uniform(-0.03, 0.03);
    knots_mm.emplace_back(x_mm, random.uniform(-0.03, 0.03));
  }
  TableCalibration c;
  c.map = TableMap(grid, knots_mm);
  c.geometry.value.setLinSpaced(1e-5, 11e-5);
  c.geometry.cov.diagonal().setConstant(1e-12);
  c.undetermined = {"scale \"of both axes\""};
  c.sigma = um(0.7);
  c.rms = um(1.1);
  c.held_out_rms = um(1.2);
  c.date = std::chrono::sys_days(std::chrono::year(2026) / 11 / 21);
  c.provenance = "225 looks at a plate in 3 poses";
  return c;
}

Expected<TableCalibration> parse(const std::string& text) {
  return parse_table_calibration(text, "t.cal.json");
}

std::string text_with(const std::string& old_text, const std::string& new_text) {
  std::string text = table_calibration_text(good());
  const std::size_t at = text.find(old_text);
  EXPECT_NE(at, std::string::npos) << old_text << " in\n" << text;
  return at == std::string::npos ? text : text.replace(at, old_text.size(), new_text);
}

TEST(TableCalibrationFile, ReadsBackWhatItWroteExactly) {
  const auto path = std::filesystem::path(testing::TempDir()) / "table_calibration_file_test.json";
  const TableCalibration written = good();
  ASSERT_TRUE(write_table_calibration(path, written));
  const auto read = read_table_calibration(path);
  std::filesystem::remove(path);
  ASSERT_TRUE(read) << read.error().text();
  EXPECT_EQ(read->map.coefficients_mm(), written.map.coefficients_mm());
  EXPECT_EQ(read->map.grid().low_mm, written.map.grid().low_mm);
  EXPECT_EQ(read->map.grid().high_mm, written.map.grid().high_mm);
  EXPECT_EQ(read->map.grid().nx, 2);
  EXPECT_EQ(read->geometry.value, written.geometry.value);
  EXPECT_EQ(read->geometry.cov, written.geometry.cov);
  EXPECT_EQ(read->undetermined, written.undetermined);
  EXPECT_EQ(read->sigma, written.sigma);
  EXPECT_EQ(read->rms, written.rms);
  EXPECT_EQ(read->held_out_rms, written.held_out_rms);
  EXPECT_EQ(read->date, written.date);
  EXPECT_EQ(read->provenance, written.provenance);
}

TEST(TableCalibrationFile, HoldsAFit) {
  Random random(9);
  const auto plate = test::simulated_plate(7, 40, true, 0, random);
  TableData data;
  test::look(plate, {0, {150, 150}}, test::smooth_warp_mm, 0.001, random, data);
  const auto fit = fit_table(data, {});
  ASSERT_TRUE(fit) << fit.error().text();
  const auto read = parse(table_calibration_text(calibration_of(*fit)));
  ASSERT_TRUE(read) << read.error().text();
  const auto place = position_mm<frame::Machine>(101, 77);
  EXPECT_EQ(read->map.error_mm(place), fit->map.error_mm(place));
  // The mean variance over the rectangle lies between the least and the greatest that are looked
  // at.
  double least_mm2 = 1;
  double greatest_mm2 = 0;
  for (const double x_mm : {30.0, 90.0, 150.0, 210.0, 270.0}) {
    for (const double y_mm : {30.0, 150.0, 270.0}) {
      const double variance =
          0.5 * fit->covariance_at(position_mm<frame::Machine>(x_mm, y_mm)).trace();
      least_mm2 = std::min(least_mm2, variance);
      greatest_mm2 = std::max(greatest_mm2, variance);
    }
  }
  EXPECT_GT(std::pow(read->sigma.in_mm(), 2), least_mm2);
  EXPECT_LT(std::pow(read->sigma.in_mm(), 2), greatest_mm2);
}

TEST(TableCalibrationFile, RefusesWhatIsNoTable) {
  const auto refuse =
      [](const std::string& old_text, const std::string& new_text, const std::string& part) {
        EXPECT_THAT(parse(text_with(old_text, new_text)), FailsWith(Code::CalibrationInvalid, part))
            << new_text;
      };
  refuse("\"table\"", "\"camera\"", "kind");
  refuse("\"version\": 1", "\"version\": 2", "version");
  refuse("\"low_mm\": [10, 20]", "\"low_mm\": [310, 20]", "grid");
  refuse("\"low_mm\": [10, 20]", "\"low_mm\": [-1e6, 20]", "grid");
  refuse("\"steps\": [2, 1]", "\"steps\": [0, 1]", "steps");
  refuse("\"steps\": [2, 1]", "\"steps\": [257, 1]", "steps");
  refuse("\"steps\": [2, 1]", "\"steps\": [1.5, 1]", "steps");
  refuse("\"steps\": [2, 1]", "\"steps\": [2, 2]", "coefficients_mm");
  refuse("\"sigma_mm\": 0.0007", "\"sigma_mm\": -1", "sigma_mm");
  refuse("\"scale_x\"", "\"scale_z\"", "scale_z");
  refuse("[\"scale \\\"of both axes\\\"\"]", "[3]", "undetermined");
  refuse("[\"scale \\\"of both axes\\\"\"]", "\"scale\"", "undetermined");
  refuse("2026-11-21T00:00:00Z", "yesterday", "date");
}

TEST(TableCalibrationFile, RefusesAMapThatNoTableHas) {
  TableCalibration c = good();
  std::vector<Eigen::Vector2d> knots_mm = c.map.coefficients_mm();
  knots_mm[7].x() = 101;
  c.map = TableMap(c.map.grid(), knots_mm);
  EXPECT_THAT(parse(table_calibration_text(c)), FailsWith(Code::CalibrationInvalid, "coefficient"));
  // A millimetre of travel, and knots that throw it about by ten.
  TableGrid grid;
  grid.nx = grid.ny = 1;
  std::vector<Eigen::Vector2d> wild_mm(16, Eigen::Vector2d::Zero());
  wild_mm[5].x() = 20;
  c.map = TableMap(grid, wild_mm);
  EXPECT_THAT(parse(table_calibration_text(c)), FailsWith(Code::CalibrationInvalid, "one to one"));
}

TEST(TableCalibrationFile, IsNotWrittenUnlessItCouldBeRead) {
  const auto path = std::filesystem::path(testing::TempDir()) / "table_refused.cal.json";
  TableCalibration c = good();
  c.rms = mm(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THAT(write_table_calibration(path, c), FailsWith(Code::CalibrationInvalid, "rms"));
  c = good();
  c.geometry.cov(0, 1) = 1e-6;
  EXPECT_THAT(write_table_calibration(path, c), FailsWith(Code::CalibrationInvalid, "symmetric"));
  EXPECT_FALSE(std::filesystem::exists(path));
}

TEST(TableCalibrationFile, AnswersAnyBytes) {
  // 2000 damaged files: never an exception or a crash.
  Random random(83);
  const std::string text = table_calibration_text(good());
  int n_read = 0;
  for (int trial = 0; trial < 2000; ++trial) {
    std::string damaged = text;
    const auto at =
        static_cast<std::size_t>(random.uniform() * static_cast<double>(damaged.size()));
    if (trial % 3 == 0) damaged[at] = static_cast<char>(static_cast<int>(random.uniform(0, 256)));
    if (trial % 3 == 1) damaged.erase(at, 1 + static_cast<std::size_t>(random.uniform(0, 20)));
    if (trial % 3 == 2) damaged.insert(at, 1, damaged[damaged.size() - 1 - at]);
    if (parse(damaged)) ++n_read;
  }
  EXPECT_GT(n_read, 10);
  EXPECT_LT(n_read, 1500);
}

}  // namespace
}  // namespace panelcal
