// SPDX-License-Identifier: Apache-2.0
#include "vision/polygon/model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "vision/fit/gauss_table.h"
#include <Eigen/LU>

namespace panelcal::internal {
namespace {

/// Beyond this many sigmas from a line a pixel sees nothing of it: the share's error is 3e-6.
constexpr double kLineReach = 4.5;
/// Pixels that see less than this of Unknown cells count.
constexpr double kUnknownShare = 2e-4;

using Axis = CellView::Axis;

double cell_level(Cell cell) {
  return cell == Cell::Target ? 1 : 0;
}

/// Change of level from one cell to the next; none from or to what is not known.
double edge_step(Cell from, Cell to) {
  return from == Cell::Unknown || to == Cell::Unknown ? 0 : cell_level(to) - cell_level(from);
}

void set_gradient(const Eigen::Vector2d& gradient, Axis& axis) {
  axis.gradient = gradient;
  axis.units_per_px = gradient.norm();
  axis.px_per_unit = 1 / axis.units_per_px;
  const double nx = gradient.x() * axis.px_per_unit;
  const double ny = gradient.y() * axis.px_per_unit;
  axis.fourth = nx * nx * nx * nx + ny * ny * ny * ny;
}

/// Finds the lines within reach.
void find_near(const std::vector<double>& lines, double v, double reach_px, Axis& axis) {
  axis.first = 0;
  axis.n_near = 0;
  for (const double line : lines) {
    const double d = (v - line) * axis.px_per_unit;
    if (d > reach_px) {
      ++axis.first;
    } else if (d >= -reach_px && axis.n_near < CellView::kMaxNear) {
      axis.lines[static_cast<std::size_t>(axis.n_near++)].distance_px = d;
    } else {
      break;
    }
  }
}

/// The profiles of edge_profile.h for a straight edge.
void find_profiles(double sigma_px, Axis& axis) {
  const double sigma2 = sigma_px * sigma_px;
  const double q = -axis.fourth / (120 * 24 * sigma2 * sigma2);
  for (std::size_t i = 0; i < static_cast<std::size_t>(axis.n_near); ++i) {
    CellView::Line& line = axis.lines[i];
    const double t = line.distance_px / sigma_px;
    const auto [cdf, phi] = gauss(t);
    const double t2 = t * t;
    const double he3 = t * (t2 - 3);
    const double d_t = phi * (1 + q * (t2 * (t2 - 6) + 3));
    line.share = cdf - q * he3 * phi;
    line.d_distance = d_t / sigma_px;
    line.d_sigma = (4 * q * he3 * phi - d_t * t) / sigma_px;
  }
}

/// Share of interval `a` between the near lines: a = 0 is before the first of them.
double interval(const Axis& axis, int a) {
  const double left = a == 0 ? 1 : axis.lines[static_cast<std::size_t>(a - 1)].share;
  const double right = a == axis.n_near ? 0 : axis.lines[static_cast<std::size_t>(a)].share;
  return left - right;
}

using Slopes = CellView::Slopes;

/// Skewness that the pixel's square adds at a corner besides the profiles of its two lines: the
/// mixed fourth cumulants, over the density of both lines.
double corner_skewness(const Axis& x, double dx_px, const Axis& y, double dy_px, double sigma2) {
  const Eigen::Array2d n = x.gradient.array() * x.px_per_unit;
  const Eigen::Array2d m = y.gradient.array() * y.px_per_unit;
  const Eigen::Array2d nm = n * m;
  const double nnnm = (nm * n.square()).sum();
  const double nnmm = nm.square().sum();
  const double nmmm = (nm * m.square()).sum();
  return -(4 * nnnm * (dx_px * dx_px / sigma2 - 1) + 6 * nnmm * dx_px * dy_px / sigma2 +
           4 * nmmm * (dy_px * dy_px / sigma2 - 1)) /
         (120 * 24 * sigma2 * sigma2);
}

/// Change of the share by one near line; `step` is the change of level across it.
void add_line(const CellView::Line& line, double step, Slopes& slopes, int axis) {
  slopes.along[axis] += step * line.d_distance;
  slopes.stretch[axis] -= step * line.d_distance * line.distance_px;
  slopes.sigma += step * line.d_sigma;
}

/// Two of the pose's generators are polynomials in v, and their slopes' products with these.
void set_pose_gradient(const Eigen::Vector2d& v,
                       const Slopes& slopes,
                       const Axis& x,
                       const Axis& y,
                       double contrast,
                       int n_pose,
                       CellVector& g) {
  const double xx = x.units_per_px * x.units_per_px;
  const double yy = y.units_per_px * y.units_per_px;
  const double xy = x.gradient.dot(y.gradient);
  const double norms = x.units_per_px * y.units_per_px;
  const double rho = xy / norms;
  // Derivatives of the share by the slopes db.x/dx, db.x/dy, db.y/dx, db.y/dy of a generator b.
  const double bx_x = slopes.stretch.x();
  const double bx_y = slopes.stretch.x() * xy / xx + slopes.rho * (yy / norms - rho * xy / xx);
  const double by_x = slopes.stretch.y() * xy / yy + slopes.rho * (xx / norms - rho * xy / yy);
  const double by_y = slopes.stretch.y();
  const double along_x = v.x() * slopes.along.x();
  const double along_y = v.y() * slopes.along.y();
  g[0] = contrast * slopes.along.x();
  g[1] = contrast * slopes.along.y();
  g[2] = contrast * (v.x() * slopes.along.y() - v.y() * slopes.along.x() - bx_y + by_x);
  g[3] = contrast * (along_x + along_y + bx_x + by_y);
  if (n_pose < 6) return;
  g[4] = contrast * (along_x - along_y + bx_x - by_y);
  g[5] = contrast * (v.y() * slopes.along.x() + v.x() * slopes.along.y() + bx_y + by_x);
  if (n_pose < 8) return;
  g[6] = contrast * (v.x() * (along_x + along_y + 2 * bx_x + by_y) + v.y() * by_x);
  g[7] = contrast * (v.y() * (along_x + along_y + bx_x + 2 * by_y) + v.x() * bx_y);
}

/// The generators of the pose's changes, by columns.
Eigen::Matrix<double, 2, 8> generators(const Eigen::Vector2d& v) {
  const double x = v.x();
  const double y = v.y();
  Eigen::Matrix<double, 2, 8> b;
  b << 1, 0, -y, x, x, y, x * x, x * y,  //
      0, 1, x, y, -y, x, x * y, y * y;
  return b;
}

std::vector<double> grown(const std::vector<double>& lines,
                          const std::vector<double>& way,
                          double growth) {
  std::vector<double> result = lines;
  for (std::size_t i = 0; i < way.size(); ++i) result[i] += growth * way[i];
  return result;
}

}  // namespace

Eigen::Vector2d CellState::to_frame(const Eigen::Vector2d& v) const {
  const Eigen::Vector3d h = pattern_from_frame.inverse() * Eigen::Vector3d(v.x(), v.y(), 1);
  return h.head<2>() / h.z();
}

Eigen::Matrix2d CellState::jacobian(const Eigen::Vector2d& at) const {
  const Eigen::Matrix3d& h = pattern_from_frame;
  const Eigen::Vector2d v = to_pattern(at);
  const double w = h(2, 0) * at.x() + h(2, 1) * at.y() + h(2, 2);
  Eigen::Matrix2d j;
  j << h(0, 0) - v.x() * h(2, 0), h(0, 1) - v.x() * h(2, 1),  //
      h(1, 0) - v.y() * h(2, 0), h(1, 1) - v.y() * h(2, 1);
  return j / w;
}

CellState placed(const Eigen::Vector2d& at, double angle_rad, double scale) {
  const double c = std::cos(angle_rad) / scale;
  const double s = std::sin(angle_rad) / scale;
  CellState state;
  state.pattern_from_frame << c, s, -c * at.x() - s * at.y(), -s, c, s * at.x() - c * at.y(), 0, 0,
      1;
  return state;
}

CellPose pose_of(const CellState& state) {
  const Eigen::Matrix2d frame_from_pattern = state.jacobian(state.to_frame({0, 0})).inverse();
  return {std::sqrt(std::abs(frame_from_pattern.determinant())),
          std::atan2(frame_from_pattern(1, 0), frame_from_pattern(0, 0))};
}

CellModel::CellModel(CellPattern pattern,
                     PoseKind kind,
                     const Eigen::Vector2d& origin,
                     double unit_length)
    : pattern_(std::move(pattern)), kind_(kind), origin_(origin), unit_length_(unit_length) {
}

CellView::CellView(const CellModel& model, const CellState& state)
    : model_(model),
      state_(state),
      x_lines_(grown(model.pattern().x, model.pattern().x_growth, state.growth)),
      y_lines_(grown(model.pattern().y, model.pattern().y_growth, state.growth)),
      is_affine_(state.pattern_from_frame(2, 0) == 0 && state.pattern_from_frame(2, 1) == 0) {
}

void CellView::look_at(const CellPixel& pixel, double reach_px) {
  v_ = state_.to_pattern(pixel.at);
  if (!is_affine_ || pixel.jacobian != jacobian_) {
    jacobian_ = pixel.jacobian;
    const Eigen::Matrix2d j = state_.jacobian(pixel.at) * pixel.jacobian;
    set_gradient(j.row(0), x_);
    set_gradient(j.row(1), y_);
  }
  find_near(x_lines_, v_.x(), reach_px, x_);
  find_near(y_lines_, v_.y(), reach_px, y_);
}

std::optional<double> CellView::flat_share(const CellPixel& pixel, double slack_px) {
  look_at(pixel, kLineReach * state_.sigma_px + slack_px);
  if (x_.n_near == kMaxNear || y_.n_near == kMaxNear) return std::nullopt;
  const Cell first = cell(0, 0);
  if (first == Cell::Unknown) return std::nullopt;
  for (int b = 0; b <= y_.n_near; ++b) {
    for (int a = 0; a <= x_.n_near; ++a) {
      if (cell(a, b) != first) return std::nullopt;
    }
  }
  return cell_level(first);
}

CellView::Value CellView::evaluate(const CellPixel& pixel, CellVector* gradient) {
  look_at(pixel, kLineReach * state_.sigma_px);
  Value value;
  Slopes slopes;
  if (x_.n_near + y_.n_near == 0) {
    const Cell at = cell(0, 0);
    value.share = cell_level(at);
    value.is_known = at != Cell::Unknown;
  } else {
    find_profiles(state_.sigma_px, x_);
    find_profiles(state_.sigma_px, y_);
    add_cells(value);
    if (gradient) add_lines(slopes);
    if (x_.n_near > 0 && y_.n_near > 0) add_corners(value, slopes);
    slopes.along.x() *= x_.px_per_unit;
    slopes.along.y() *= y_.px_per_unit;
  }
  const Eigen::Vector3d plane = model_.plane_terms(pixel.at);
  const double contrast = plane.dot(state_.levels.tail<3>());
  value.level = plane.dot(state_.levels.head<3>()) + contrast * value.share;
  if (!gradient) return value;
  CellVector& g = *gradient;
  if (value.is_flat) {
    std::fill_n(g.data(), model_.i_levels(), 0.0);
  } else {
    set_pose_gradient(v_, slopes, x_, y_, contrast, model_.n_pose(), g);
    g[model_.i_sigma()] = contrast * slopes.sigma;
    if (const auto i = model_.i_growth()) g[*i] = contrast * slopes.growth;
  }
  double* levels = g.data() + model_.i_levels();
  for (int i = 0; i < 3; ++i) {
    levels[i] = plane[i];
    levels[3 + i] = value.share * plane[i];
  }
  return value;
}

Cell CellView::cell(int a, int b) const {
  return model_.pattern().at(x_.first - 1 + a, y_.first - 1 + b);
}

void CellView::add_cells(Value& value) const {
  const Cell first = cell(0, 0);
  for (int b = 0; b <= y_.n_near; ++b) {
    const double part_y = interval(y_, b);
    for (int a = 0; a <= x_.n_near; ++a) {
      const Cell at = cell(a, b);
      const double part = interval(x_, a) * part_y;
      if (at == Cell::Unknown && std::abs(part) > kUnknownShare) value.is_known = false;
      if (at == Cell::Target) value.share += part;
      if (at != first) value.is_flat = false;
    }
  }
}

void CellView::add_lines(Slopes& slopes) const {
  const CellPattern& pattern = model_.pattern();
  for (int a = 0; a < x_.n_near; ++a) {
    double step = 0;
    for (int b = 0; b <= y_.n_near; ++b) {
      step += interval(y_, b) * edge_step(cell(a, b), cell(a + 1, b));
    }
    if (step == 0) continue;
    const Line& line = x_.lines[static_cast<std::size_t>(a)];
    add_line(line, step, slopes, 0);
    if (!pattern.has_growth()) continue;
    const double way = pattern.x_growth[static_cast<std::size_t>(x_.first + a)];
    slopes.growth -= way * step * line.d_distance * x_.px_per_unit;
  }
  for (int b = 0; b < y_.n_near; ++b) {
    double step = 0;
    for (int a = 0; a <= x_.n_near; ++a) {
      step += interval(x_, a) * edge_step(cell(a, b), cell(a, b + 1));
    }
    if (step == 0) continue;
    const Line& line = y_.lines[static_cast<std::size_t>(b)];
    add_line(line, step, slopes, 1);
    if (!pattern.has_growth()) continue;
    const double way = pattern.y_growth[static_cast<std::size_t>(y_.first + b)];
    slopes.growth -= way * step * line.d_distance * y_.px_per_unit;
  }
}

void CellView::add_corners(Value& value, Slopes& slopes) const {
  const CellPattern& pattern = model_.pattern();
  const double sigma2 = state_.sigma_px * state_.sigma_px;
  const double rho = x_.gradient.dot(y_.gradient) * x_.px_per_unit * y_.px_per_unit;
  for (int b = 0; b < y_.n_near; ++b) {
    for (int a = 0; a < x_.n_near; ++a) {
      const double corner =
          edge_step(cell(a, b + 1), cell(a + 1, b + 1)) - edge_step(cell(a, b), cell(a + 1, b));
      if (corner == 0) continue;
      const Line& x = x_.lines[static_cast<std::size_t>(a)];
      const Line& y = y_.lines[static_cast<std::size_t>(b)];
      const double density = corner * x.d_distance * y.d_distance * sigma2;
      const double oblique_x = rho * density * x.distance_px / sigma2;
      const double oblique_y = rho * density * y.distance_px / sigma2;
      value.share +=
          density * (rho + corner_skewness(x_, x.distance_px, y_, y.distance_px, sigma2));
      slopes.rho += density;
      slopes.along -= Eigen::Vector2d(oblique_x, oblique_y);
      slopes.stretch += Eigen::Vector2d(oblique_x * x.distance_px, oblique_y * y.distance_px);
      slopes.sigma += (oblique_x * x.distance_px + oblique_y * y.distance_px) / state_.sigma_px;
      if (!pattern.has_growth()) continue;
      const double way_x = pattern.x_growth[static_cast<std::size_t>(x_.first + a)];
      const double way_y = pattern.y_growth[static_cast<std::size_t>(y_.first + b)];
      slopes.growth += oblique_x * way_x * x_.px_per_unit + oblique_y * way_y * y_.px_per_unit;
    }
  }
}

CellState CellModel::moved(const CellState& state, const CellVector& step) const {
  const double c = std::exp(step[3]) * std::cos(step[2]);
  const double s = std::exp(step[3]) * std::sin(step[2]);
  Eigen::Matrix3d change;
  change << c, -s, step[0], s, c, step[1], 0, 0, 1;
  if (n_pose() >= 6) {
    Eigen::Matrix3d shear = Eigen::Matrix3d::Identity();
    shear.topLeftCorner<2, 2>() +=
        (Eigen::Matrix2d() << step[4], step[5], step[5], -step[4]).finished();
    change = change * shear;
  }
  if (n_pose() >= 8) change.bottomLeftCorner<1, 2>() << -step[6], -step[7];
  CellState next = state;
  next.pattern_from_frame = change * state.pattern_from_frame;
  // A homography's scale means nothing; this keeps it from drifting.
  if (n_pose() >= 8) next.pattern_from_frame /= next.pattern_from_frame(2, 2);
  next.sigma_px += step[i_sigma()];
  if (const auto i = i_growth()) next.growth += step[*i];
  next.levels += step.segment<6>(i_levels());
  return next;
}

Eigen::Matrix<double, 2, kMaxCellParameters> CellModel::place_gradient(
    const CellState& state, const Eigen::Vector2d& v) const {
  const Eigen::Matrix2d frame_from_pattern = state.jacobian(state.to_frame(v)).inverse();
  Eigen::Matrix<double, 2, kMaxCellParameters> gradient;
  gradient.setZero();
  gradient.leftCols(n_pose()) = -frame_from_pattern * generators(v).leftCols(n_pose());
  return gradient;
}

}  // namespace panelcal::internal
