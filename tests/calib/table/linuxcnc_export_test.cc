// SPDX-License-Identifier: Apache-2.0
#include "calib/table/linuxcnc_export.h"

#include <cmath>
#include <cstdio>
#include <limits>
#include <sstream>

#include "calib/correction/table_basis.h"
#include <gmock/gmock.h>

#include "tests/support/matchers.h"

namespace panelcal {
namespace {

using test::FailsWith;
using test::IsNearMatrix;

/// LinuxCNC as its manual and source have it: matrixkins, then COMP_FILE of type 0, as it reads
/// them; the direction of the last move chooses the column.
class Linuxcnc {
 public:
  explicit Linuxcnc(const LinuxcncCorrection& correction) {
    std::istringstream hal(correction.hal);
    std::string setp, name;
    double value = 0;
    while (hal >> setp >> name >> value) {
      const std::size_t at = name.find("C_") + 2;
      matrix_(name[at] - 'x', name[at + 1] - 'x') = value;
      ++n_set;
    }
    for (std::size_t joint = 0; joint < 2; ++joint) {
      std::istringstream lines(correction.comp_file[joint]);
      std::string line;
      while (std::getline(lines, line)) {
        Entry entry{};
        if (std::sscanf(
                line.c_str(), "%lf %lf %lf", &entry.nominal, &entry.forward, &entry.reverse) != 3) {
          break;
        }
        entries_[joint].push_back(entry);
      }
    }
  }

  /// Commands of the joints, x and y, for a wanted place in machine units.
  Eigen::Vector2d motors(const Eigen::Vector2d& wanted, bool is_forward) const {
    const Eigen::Vector3d joints = matrix_ * Eigen::Vector3d(wanted.x(), wanted.y(), 0);
    return {joints.x() + trim(0, joints.x(), is_forward),
            joints.y() + trim(1, joints.y(), is_forward)};
  }

  int n_set = 0;

 private:
  struct Entry {
    double nominal, forward, reverse;
  };
  double trim(std::size_t joint, double at, bool is_forward) const {
    const auto& entries = entries_[joint];
    const auto of = [&](std::size_t i) {
      return entries[i].nominal - (is_forward ? entries[i].forward : entries[i].reverse);
    };
    if (at <= entries.front().nominal) return of(0);
    for (std::size_t i = 1; i < entries.size(); ++i) {
      if (at > entries[i].nominal) continue;
      const double t =
          (at - entries[i - 1].nominal) / (entries[i].nominal - entries[i - 1].nominal);
      return of(i - 1) + t * (of(i) - of(i - 1));
    }
    return of(entries.size() - 1);
  }

  Eigen::Matrix3d matrix_ = Eigen::Matrix3d::Zero();
  std::array<std::vector<Entry>, 2> entries_;
};

TableGrid grid() {
  TableGrid g;
  g.low_mm = {0, 20};
  g.high_mm = {300, 220};
  g.nx = 9;
  g.ny = 7;
  return g;
}

/// Linear errors and what bends each axis along itself, in shares of polynomial_modes(), mm.
TableMap map_of(double along_mm, double across_mm) {
  const internal::TableBasis basis(grid());
  const auto modes = internal::polynomial_modes();
  Eigen::VectorXd all = Eigen::VectorXd::Zero(basis.size());
  for (std::size_t k = 0; k < modes.size(); ++k) {
    const auto& m = modes[k];
    const int degree = m.x_degree + m.y_degree;
    const bool is_along = (m.coordinate == 0 ? m.y_degree : m.x_degree) == 0;
    double share = degree == 1 ? 0.01 * (1 + static_cast<double>(k)) : 0;
    if (degree > 1) share = is_along ? along_mm : across_mm;
    all += share * basis.modes.col(static_cast<Eigen::Index>(k));
  }
  std::vector<Eigen::Vector2d> coefficients_mm;
  for (Eigen::Index i = 0; i < grid().n_coefficients(); ++i) {
    coefficients_mm.push_back(all.segment<2>(2 * i));
  }
  return {grid(), coefficients_mm};
}

/// Largest distance between wanted and reached, but for the shift at the first place.
double worst_mm(const TableMap& map, const Linuxcnc& machine, double unit_mm) {
  double worst = 0;
  std::optional<Eigen::Vector2d> shift;
  for (double x = 5; x < 300; x += 13) {
    for (double y = 25; y < 220; y += 11) {
      const Eigen::Vector2d wanted(x, y);
      const Eigen::Vector2d motors = machine.motors(wanted / unit_mm, true) * unit_mm;
      const Eigen::Vector2d off = map(position_mm<frame::Machine>(motors)).in_mm() - wanted;
      if (!shift) shift = off;
      worst = std::max(worst, (off - *shift).norm());
    }
  }
  return worst;
}

TEST(LinuxcncExport, AMachineThatBendsAlongItsAxesIsStraightened) {
  const TableMap map = map_of(0.006, 0);
  const auto correction = linuxcnc_correction(map, {.points = 101, .backlash = {}});
  ASSERT_TRUE(correction);
  const Linuxcnc machine(*correction);
  EXPECT_EQ(machine.n_set, 9);
  // Between points a parabola is off by curvature step^2 / 8: below 0.05 um here.
  EXPECT_LE(worst_mm(map, machine, 1), 1e-4);
  EXPECT_GT(worst_mm(map,
                     Linuxcnc(*linuxcnc_correction(
                         TableMap(grid(),
                                  std::vector(static_cast<std::size_t>(grid().n_coefficients()),
                                              Eigen::Vector2d(0, 0))),
                         {})),
                     1),
            0.05);
  EXPECT_LE(correction->left_largest_mm, 1e-4);
}

TEST(LinuxcncExport, SaysWhatItCannotTell) {
  const TableMap map = map_of(0.006, 0.004);
  const auto correction = linuxcnc_correction(map, {.points = 101, .backlash = {}});
  ASSERT_TRUE(correction);
  // 14 modes of two to three degrees, of which 4 lie along their axis; each is 4 um in the mean.
  EXPECT_NEAR(correction->left_rms_mm, 0.004 * std::sqrt(10.0), 0.0005);
}

TEST(LinuxcncExport, SpeaksInchesAndBacklash) {
  const TableMap map = map_of(0.006, 0);
  const auto correction =
      linuxcnc_correction(map, {.points = 101, .in_inches = true, .backlash = {um(8), um(0)}});
  ASSERT_TRUE(correction);
  const Linuxcnc machine(*correction);
  EXPECT_LE(worst_mm(map, machine, kMmPerInch), 1e-4);
  const Eigen::Vector2d wanted(5, 5);
  const Eigen::Vector2d later = machine.motors(wanted, false) - machine.motors(wanted, true);
  EXPECT_THAT(later * kMmPerInch, IsNearMatrix(Eigen::Vector2d(-0.008, 0), 1e-6));
}

TEST(LinuxcncExport, RefusesWhatNoStageDoes) {
  const TableMap map = map_of(0.006, 0);
  EXPECT_THAT(linuxcnc_correction(map, {.points = 257, .backlash = {}}),
              FailsWith(Code::CalibrationData, "points is 257"));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(linuxcnc_correction(map, {.backlash = {mm(nan), mm(0)}}),
              FailsWith(Code::CalibrationData, "backlash"));
  EXPECT_THAT(linuxcnc_correction(map_of(30, 0), {}), FailsWith(Code::CalibrationData, "steep"));
}

}  // namespace
}  // namespace panelcal
