// SPDX-License-Identifier: Apache-2.0
#include "calib/table/linuxcnc_export.h"

#include <algorithm>
#include <cmath>

#include "calib/table/modes.h"
#include <Eigen/LU>
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr int kMostPoints = 256;
/// Means and the check are over this number of places along each axis.
constexpr int kSamples = 64;
/// Each brings a correction nearer by the slope of the error, a thousandth.
constexpr int kExportRounds = 3;

tl::unexpected<Diagnostic> export_refused(std::string what, std::string expected) {
  return failure({Code::CalibrationData, {}, std::move(what), std::move(expected)});
}

double sample(double low, double high, int i, int n) {
  return low + (high - low) * i / (n - 1.0);
}

/// The linear part of the error, by the means over the map's rectangle.
Eigen::Matrix2d linear_part(const TableMap& map) {
  const internal::TableBasis basis(map.grid());
  Eigen::VectorXd coefficients(basis.size());
  for (std::size_t i = 0; i < map.coefficients_mm().size(); ++i) {
    coefficients.segment<2>(2 * static_cast<Eigen::Index>(i)) = map.coefficients_mm()[i];
  }
  return internal::linear_functional(basis, coefficients);
}

/// Error of a joint along itself without the linear part, at the place that it is sent to on that
/// account: the mean over the other axis.
struct AxisTable {
  std::vector<double> nominal_mm;
  std::vector<double> error_mm;

  double trim_mm(double at_mm) const {
    const auto above = std::ranges::upper_bound(nominal_mm, at_mm);
    if (above == nominal_mm.begin()) return -error_mm.front();
    if (above == nominal_mm.end()) return -error_mm.back();
    const auto i = static_cast<std::size_t>(above - nominal_mm.begin());
    const double t = (at_mm - nominal_mm[i - 1]) / (nominal_mm[i] - nominal_mm[i - 1]);
    return -(error_mm[i - 1] + t * (error_mm[i] - error_mm[i - 1]));
  }
};

/// The mean of what the linear part leaves of the error along an axis.
double mean_error_mm(const TableMap& map, const Eigen::Matrix2d& linear, int axis, double at_mm) {
  const TableGrid& grid = map.grid();
  const Eigen::Vector2d middle_mm = (grid.low_mm + grid.high_mm) / 2;
  const int other = 1 - axis;
  double mean_mm = 0;
  for (int j = 0; j < kSamples; ++j) {
    Eigen::Vector2d c_mm;
    c_mm[axis] = at_mm;
    c_mm[other] =
        grid.low_mm[other] + (grid.high_mm[other] - grid.low_mm[other]) * (j + 0.5) / kSamples;
    const Eigen::Vector2d left_mm =
        map.error_mm(position_mm<frame::Machine>(c_mm)) - linear * (c_mm - middle_mm);
    mean_mm += left_mm[axis] / kSamples;
  }
  return mean_mm;
}

AxisTable axis_table(const TableMap& map, const Eigen::Matrix2d& linear, int axis, int points) {
  const TableGrid& grid = map.grid();
  AxisTable table;
  for (int i = 0; i < points; ++i) {
    const double nominal_mm = sample(grid.low_mm[axis], grid.high_mm[axis], i, points);
    double error_mm = 0;
    for (int round = 0; round < kExportRounds; ++round) {
      const double sent_to_mm = nominal_mm - error_mm;
      error_mm = mean_error_mm(map, linear, axis, sent_to_mm) / (1 + linear(axis, axis));
    }
    table.nominal_mm.push_back(nominal_mm);
    table.error_mm.push_back(error_mm);
  }
  return table;
}

std::string axis_table_text(const AxisTable& table, Length backlash, bool in_inches) {
  const double unit = in_inches ? 1 / kMmPerInch : 1;
  std::string text;
  for (std::size_t i = 0; i < table.nominal_mm.size(); ++i) {
    const double forward_mm = table.nominal_mm[i] + table.error_mm[i];
    text += fmt::format("{:.8f} {:.8f} {:.8f}\n",
                        unit * table.nominal_mm[i],
                        unit * forward_mm,
                        unit * (forward_mm + backlash.in_mm()));
  }
  return text;
}

std::string hal_of(const Eigen::Matrix3d& matrix) {
  constexpr std::string_view kAxes = "xyz";
  std::string text;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      text += fmt::format("setp matrixkins.C_{}{} {:.12g}\n",
                          kAxes[static_cast<std::size_t>(row)],
                          kAxes[static_cast<std::size_t>(column)],
                          matrix(row, column));
    }
  }
  return text;
}

/// Computes the errors that the corrected machine keeps, place by place.
void check_axis_tables(const TableMap& map,
                       const std::array<AxisTable, 2>& tables,
                       LinuxcncCorrection& out) {
  const TableGrid& grid = map.grid();
  std::vector<Eigen::Vector2d> off;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (int i = 0; i < kSamples * kSamples; ++i) {
    // Middles of equal cells, so that no joint is sent beyond the map.
    const Eigen::Vector2d share((i % kSamples + 0.5) / kSamples, (i / kSamples + 0.5) / kSamples);
    const Eigen::Vector2d wanted_mm = grid.low_mm + share.cwiseProduct(grid.high_mm - grid.low_mm);
    Eigen::Vector2d joint_mm = out.matrix.topLeftCorner<2, 2>() * wanted_mm;
    joint_mm += Eigen::Vector2d(tables[0].trim_mm(joint_mm.x()), tables[1].trim_mm(joint_mm.y()));
    off.push_back(map(position_mm<frame::Machine>(joint_mm)).in_mm() - wanted_mm);
    mean += off.back() / (kSamples * kSamples);
  }
  double sum_mm2 = 0;
  for (const Eigen::Vector2d& o : off) {
    sum_mm2 += (o - mean).squaredNorm() / (kSamples * kSamples);
    out.left_largest_mm = std::max(out.left_largest_mm, (o - mean).norm());
  }
  out.left_rms_mm = std::sqrt(sum_mm2);
}

}  // namespace

Expected<LinuxcncCorrection> linuxcnc_correction(const TableMap& map,
                                                 const LinuxcncOptions& options) {
  if (options.points < 2 || options.points > kMostPoints) {
    return export_refused(fmt::format("points is {}", options.points),
                          fmt::format("2 to {}", kMostPoints));
  }
  for (const Length backlash : options.backlash) {
    if (!(backlash >= mm(0)) || !std::isfinite(backlash.in_mm())) {
      return export_refused("a backlash is negative or no number", "0 or more");
    }
  }
  const Eigen::Matrix2d linear = linear_part(map);
  std::array<AxisTable, 2> tables;
  for (int axis = 0; axis < 2; ++axis) {
    AxisTable& table = tables[static_cast<std::size_t>(axis)];
    table = axis_table(map, linear, axis, options.points);
    for (std::size_t i = 1; i < table.error_mm.size(); ++i) {
      const double step_mm = table.nominal_mm[i] - table.nominal_mm[i - 1];
      if (!(std::abs(table.error_mm[i] - table.error_mm[i - 1]) < 0.1 * step_mm)) {
        return export_refused("the table's error is as steep as its way",
                              "an error of a real stage");
      }
    }
  }
  if (!(linear.cwiseAbs().maxCoeff() < 0.1)) {
    return export_refused("the table's axes are a tenth off",
                          "scale and squareness of a real stage");
  }
  LinuxcncCorrection out;
  out.matrix.topLeftCorner<2, 2>() = (Eigen::Matrix2d::Identity() + linear).inverse();
  out.hal = hal_of(out.matrix);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    out.comp_file[axis] = axis_table_text(tables[axis], options.backlash[axis], options.in_inches);
  }
  check_axis_tables(map, tables, out);
  return out;
}

}  // namespace panelcal
