// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/bench_program.h"

#include <cmath>
#include <cstdint>
#include <iterator>
#include <string_view>
#include <vector>

#include "calib/base/statistics/random.h"
#include <fmt/format.h>

namespace panelcal::bench {
namespace {

constexpr std::uint64_t kSeed = 20261121;
constexpr int kPatternHoles = 100;
constexpr int kMostCopies = 100;  // of one level, where the count of holes lets us
constexpr std::string_view kHead =
    "M48\nMETRIC,TZ\nT1C0.8\nT2C1.0\nT3C1.2\n%\n"
    "G34,1\nG36X010000Y010000\nG36X490000Y010000\nG36X010000Y590000\n";

constexpr std::string_view kSiebMeyerHead =
    "%%5000\nX10000Y10000G32\nX490000Y10000G32\nX10000Y590000G32\nG31\n";
constexpr std::string_view kSiebMeyerTools =
    "$\nT1D.8S60.F2.R20.\nT2D1.S60.F2.R20.\nT3D1.2S60.F2.R20.\n$\n";

void append_hole(std::string& text, Random& random) {
  const auto six_digits = [&random] { return static_cast<int>(random.uniform(0, 1e6)); };
  const int x = six_digits();
  fmt::format_to(std::back_inserter(text), "X{:06}Y{:06}\n", x, six_digits());
}

/// The largest level that divides the copies; all of them if only that does.
int level_of(int n_copies) {
  for (int n = kMostCopies; n > 1; --n) {
    if (n_copies % n == 0) return n;
  }
  return n_copies;
}

}  // namespace

std::string plain_program(int n_holes) {
  Random random(kSeed);
  std::string text(kHead);
  for (int i = 0; i < n_holes; ++i) {
    if (i % (n_holes / 3 + 1) == 0) text += fmt::format("T{}\n", 1 + i / (n_holes / 3 + 1));
    append_hole(text, random);
  }
  return text + "M30\n";
}

std::string repeat_program(int n_holes) {
  Random random(kSeed);
  std::string text = std::string(kHead) + "T1\nM25\n";
  for (int i = 0; i < kPatternHoles; ++i) append_hole(text, random);
  text += "M01\n";
  for (int n_copies = n_holes / kPatternHoles; n_copies > 1;) {
    const int n = level_of(n_copies);
    text += fmt::format("R{}M02X001000Y000500\nM01\n", n - 1);
    n_copies /= n;
  }
  return text + "M08\nM30\n";
}

std::string plain_sieb_meyer_program(int n_holes) {
  Random random(kSeed);
  std::string text(kSiebMeyerHead);
  for (int i = 0; i < n_holes; ++i) {
    append_hole(text, random);
    if (i % (n_holes / 3 + 1) != 0) continue;
    text.insert(text.size() - 1, fmt::format("T{}", 1 + i / (n_holes / 3 + 1)));
  }
  return text + std::string(kSiebMeyerTools);
}

std::string repeat_sieb_meyer_program(int n_holes) {
  Random random(kSeed);
  std::vector<int> levels;
  for (int n_copies = n_holes / kPatternHoles; n_copies > 1;) {
    levels.push_back(level_of(n_copies));
    n_copies /= levels.back();
  }
  std::string text(kSiebMeyerHead);
  for (int i = 0; i < kPatternHoles; ++i) {
    append_hole(text, random);
    if (i > 0) continue;
    text.pop_back();
    text += "T1";
    for (std::size_t level = 0; level < levels.size(); ++level) text += "M31";
    text += '\n';
  }
  for (const int n : levels) {
    text += fmt::format("X0Y0M50V2\nX{}Y{}M50W{}M30\n", 1000 * (n - 1), 500 * (n - 1), n);
  }
  return text + std::string(kSiebMeyerTools);
}

Expected<Measurement> TurnedPanel::measure(const MeasurementRequest& request) {
  constexpr double kTurn_rad = 1e-3;
  constexpr double kVariance_mm2 = 1e-6;
  Eigen::Matrix2d turn;
  turn << std::cos(kTurn_rad), -std::sin(kTurn_rad), std::sin(kTurn_rad), std::cos(kTurn_rad);
  const Eigen::Vector2d seen_mm = turn * request.nominal.in_mm() + Eigen::Vector2d(0.3, -0.2);
  Measurement measurement{.request = request, .status = MeasurementStatus::Found};
  measurement.measured = {position_mm<frame::Actual>(seen_mm),
                          kVariance_mm2 * Eigen::Matrix2d::Identity()};
  measurement.by_camera = CameraJacobian::Constant(0.01);
  return measurement;
}

WalkOptions rigid() {
  return {.series_size = 3, .model = PanelModel::Rigid};
}

WalkOptions with_uncertainty() {
  WalkOptions options = rigid();
  options.uncertainty.stage_repeatability = um(1.5);
  options.uncertainty.table_residual = um(2);
  options.uncertainty.drill_wander = um(2.5);
  options.uncertainty.spindle_camera_mm2 = 1e-6 * Eigen::Matrix2d::Identity();
  options.uncertainty.drift_mm2 = 2e-6 * Eigen::Matrix2d::Identity();
  options.uncertainty.camera.diagonal() << 4e-14, 4e-10, 1e-2, 1e-2, 1e-18;
  return options;
}

WalkOptions with_tolerance() {
  WalkOptions options = with_uncertainty();
  options.tolerances.position = um(20);
  return options;
}

}  // namespace panelcal::bench
