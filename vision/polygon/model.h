// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace panelcal::internal {

enum class Cell : char {
  Background,
  Target,
  Unknown,  ///< may show anything: pixels that see it do not count
};

/// A drawing made of rectangles: a grid of lines and what is in each of its cells.
///
/// A square is one cell, a cross three by three, an AprilTag as many as it has bits and borders. A
/// diamond is a square whose pose is turned. Pattern units and axes are the drawing's own; its
/// reference point is (0, 0).
struct CellPattern {
  std::vector<double> x;    ///< lines, ascending, two at least
  std::vector<double> y;    ///< lines, ascending, two at least
  std::vector<Cell> cells;  ///< (x.size() - 1) * (y.size() - 1), one row of x after the other
  Cell outside = Cell::Background;
  /// Direction in which each line moves if the target is etched too large: -1, 0 or 1. Empty: the
  /// model has no such parameter. A cross's length and width are told apart by it; a square has no
  /// use for it, its scale says the same.
  std::vector<double> x_growth;
  std::vector<double> y_growth;

  int n_columns() const { return static_cast<int>(x.size()) - 1; }
  int n_rows() const { return static_cast<int>(y.size()) - 1; }
  bool has_growth() const { return !x_growth.empty(); }
  /// Cells beyond the grid are `outside`.
  Cell at(int column, int row) const {
    if (column < 0 || row < 0 || column >= n_columns() || row >= n_rows()) return outside;
    return cells[static_cast<std::size_t>(row * n_columns() + column)];
  }
};

/// Freedom of a pattern's pose in the fit frame; the number of the pose's parameters is its value.
enum class PoseKind { Similarity = 4, Affine = 6, Homography = 8 };

/// Parameters in this order: pose (see CellModel), sigma px, growth (if the pattern has it),
/// plane 3, contrast 3 (grey levels; at the model's origin, then its change over a unit length).
inline constexpr int kMaxCellParameters = 16;
using CellVector = Eigen::Matrix<double, kMaxCellParameters, 1>;
using CellMatrix = Eigen::Matrix<double, kMaxCellParameters, kMaxCellParameters>;
using Levels = Eigen::Matrix<double, 6, 1>;

/// Pose and brightness of a pattern.
struct CellState {
  Eigen::Matrix3d pattern_from_frame = Eigen::Matrix3d::Identity();  ///< homogeneous
  double sigma_px = 1;  ///< blur of the edges, the pixel's own width included
  double growth = 0;    ///< of the target over its drawing on every side, pattern units
  Levels levels = Levels::Zero();

  Eigen::Vector2d to_pattern(const Eigen::Vector2d& at) const {
    const Eigen::Matrix3d& h = pattern_from_frame;
    const double w = 1 / (h(2, 0) * at.x() + h(2, 1) * at.y() + h(2, 2));
    return {w * (h(0, 0) * at.x() + h(0, 1) * at.y() + h(0, 2)),
            w * (h(1, 0) * at.x() + h(1, 1) * at.y() + h(1, 2))};
  }
  Eigen::Vector2d to_frame(const Eigen::Vector2d& v) const;
  /// d pattern / d frame.
  Eigen::Matrix2d jacobian(const Eigen::Vector2d& at) const;
};

/// The state of a drawing turned by `angle_rad`, enlarged and put to `at`.
CellState placed(const Eigen::Vector2d& at, double angle_rad, double scale);

/// Size and direction of the pattern's x at its origin, in the fit frame.
struct CellPose {
  double scale = 1;
  double angle_rad = 0;
};
CellPose pose_of(const CellState& state);

/// A pixel that takes part in a fit.
struct CellPixel {
  Eigen::Vector2d at;        ///< in the fit frame
  Eigen::Matrix2d jacobian;  ///< d at / d pixel
  double value = 0;          ///< grey level
  double weight = 1;         ///< 1 / variance of its noise
  int x = 0;                 ///< in the picture
  int y = 0;
  bool is_flat = false;      ///< far from all lines: `share` is 0 or 1 and stays so
  bool is_excluded = false;  ///< neighbour, debris, Unknown
  float share = 0;           ///< of a flat pixel
};

/// A cell pattern behind a Gaussian lens and square pixels; CellView evaluates it.
///
///   I = plane(X) + contrast(X) share(v),   v = pose(X),   plane, contrast affine in X
///   share(v) = sum_ij level_ij [P(x_i) - P(x_i+1)] [P(y_j) - P(y_j+1)]
///   P(x_i) = Phi(t) - q He3(t) phi(t),     t = (v.x - x_i) / (sigma |grad v.x|)
///
/// since a Gaussian is separable in any orthogonal axes. Axes that tilt makes oblique add the term
/// rho phi phi of the bivariate normal at corners. sigma and q are those of edge_profile.h.
///
/// The pose is a homography; its parameters are small changes of it, in pattern coordinates:
///   dv = sum_k delta_k b_k(v)
///   Similarity  b = (1,0) (0,1) (-y,x) (x,y)
///   Affine      b = (1,0) (0,1) (-y,x) (x,y) (x,-y) (y,x)
///   Homography  the same and (xx,xy) (xy,yy)
/// so gradients are the same for all kinds and a fit composes its steps.
///
/// See    tests/vision/polygon/model_test.cc
class CellModel {
 public:
  /// The planes' coordinates are (X - origin) / unit_length.
  /// Precondition: the pattern's lists have the sizes that they should have.
  CellModel(CellPattern pattern, PoseKind kind, const Eigen::Vector2d& origin, double unit_length);

  /// The state after a step of all parameters.
  CellState moved(const CellState& state, const CellVector& step) const;

  /// Derivative of a pattern point's seen place by a step of the parameters, d frame / d step.
  Eigen::Matrix<double, 2, kMaxCellParameters> place_gradient(const CellState& state,
                                                              const Eigen::Vector2d& v) const;

  const CellPattern& pattern() const { return pattern_; }
  PoseKind kind() const { return kind_; }
  int n_pose() const { return static_cast<int>(kind_); }
  int i_sigma() const { return n_pose(); }
  std::optional<int> i_growth() const {
    return pattern_.has_growth() ? std::optional(n_pose() + 1) : std::nullopt;
  }
  int i_levels() const { return n_pose() + 1 + (pattern_.has_growth() ? 1 : 0); }
  int n_parameters() const { return i_levels() + 6; }

  /// 1, x, y of the planes at a place of the frame.
  Eigen::Vector3d plane_terms(const Eigen::Vector2d& at) const {
    return {1, (at.x() - origin_.x()) / unit_length_, (at.y() - origin_.y()) / unit_length_};
  }

 private:
  CellPattern pattern_;
  PoseKind kind_;
  Eigen::Vector2d origin_;
  double unit_length_;
};

/// A model at one state, prepared for many pixels. It refers to both.
class CellView {
 public:
  CellView(const CellModel& model, const CellState& state);

  struct Value {
    double level = 0;  ///< of the model, grey levels
    double share = 0;
    bool is_flat = true;  ///< no line is near: the gradient is 0 but for the levels' part
    bool is_known = true;
  };
  /// gradient may be null; else its first n_parameters() numbers are set.
  Value evaluate(const CellPixel& pixel, CellVector* gradient);

  /// The share of a pixel that stays a plain 0 or 1 if lines move by up to `slack_px`; else empty.
  std::optional<double> flat_share(const CellPixel& pixel, double slack_px);

  /// More lines than this within reach of a pixel are no longer lines.
  static constexpr int kMaxNear = 8;
  /// A line as a pixel sees it.
  struct Line {
    double distance_px;
    double share;  ///< of the pixel beyond the line
    double d_distance;
    double d_sigma;
  };
  /// A family of parallel lines as a pixel sees it.
  struct Axis {
    Eigen::Vector2d gradient;  ///< of the pattern coordinate, pattern units per px
    double units_per_px;
    double px_per_unit;
    double fourth;  ///< sum of the fourth powers of the unit normal
    int first;      ///< lines before it are far below: their share is 1
    int n_near;     ///< lines from `first` within reach
    std::array<Line, kMaxNear> lines;
  };
  /// Derivatives of the share by what the parameters change.
  struct Slopes {
    Eigen::Vector2d along = Eigen::Vector2d::Zero();    ///< per pattern unit of v.x, v.y
    Eigen::Vector2d stretch = Eigen::Vector2d::Zero();  ///< per relative change of units_per_px
    double rho = 0;                                     ///< per unit of the axes' correlation
    double sigma = 0;                                   ///< per px
    double growth = 0;                                  ///< per pattern unit
  };

 private:
  void look_at(const CellPixel& pixel, double reach_px);
  /// Cell a, b of those about the near lines; 0, 0 is before the first of them.
  Cell cell(int a, int b) const;
  void add_cells(Value& value) const;
  void add_lines(Slopes& slopes) const;
  void add_corners(Value& value, Slopes& slopes) const;

  const CellModel& model_;
  const CellState& state_;
  std::vector<double> x_lines_;
  std::vector<double> y_lines_;
  bool is_affine_;
  // Values at the last pixel; axes stay the same while neither the frame nor the pose bends.
  Eigen::Matrix2d jacobian_ = Eigen::Matrix2d::Zero();
  Eigen::Vector2d v_;
  Axis x_;
  Axis y_;
};

}  // namespace panelcal::internal
