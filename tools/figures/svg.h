// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

#include "program/writers/svg/sheet.h"
#include <Eigen/Core>

namespace panelcal::report {

/// An upright rectangle in work coordinates, mm; empty until a point was added.
struct Extent {
  Eigen::Vector2d low_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d high_mm = Eigen::Vector2d::Zero();
  bool is_empty = true;

  void add(const Eigen::Vector2d& p_mm);  ///< points that are not finite are left out
  Eigen::Vector2d size_mm() const { return high_mm - low_mm; }
};

using svg::nice_below;

/// Maps work coordinates (mm, y up) to a picture (px, y down) with equal scales.
class View {
 public:
  /// `extent` with a margin fits into width x max_height, with room for axes around it.
  View(const Extent& extent, double width, double max_height);

  Eigen::Vector2d at(const Eigen::Vector2d& p_mm) const;
  /// A vector; y turns over.
  Eigen::Vector2d along(const Eigen::Vector2d& v_mm) const;
  double px_per_mm() const { return px_per_mm_; }
  double width() const { return width_; }
  double height() const { return height_; }
  const Extent& shown() const { return shown_; }  ///< all that the frame holds
  double plot_side() const;                       ///< the shorter side of the plotted area, px

  /// The opening tag; `label` is for those who cannot see it, already escaped.
  std::string open(std::string_view css_class, std::string_view label) const;
  /// Frame, grid and ticks in mm.
  std::string axes() const;
  /// A scale bar below the plot at its right end.
  std::string scale_bar() const;
  /// An arrow of `length` px with its meaning below the plot at its left end; escaped already.
  std::string reference_arrow(double length,
                              std::string_view css_class,
                              std::string_view text) const;

 private:
  std::string ticks(int axis) const;

  Extent shown_;
  double px_per_mm_ = 1;
  double width_ = 0;
  double height_ = 0;
};

/// Path data of an arrow that begins at `from` and has its tip at `from + v`, all px.
std::string arrow_path(const Eigen::Vector2d& from, const Eigen::Vector2d& v);

/// Factor by which arrows are drawn longer than true, so that the longest is at most `longest_px`.
struct ArrowScale {
  double magnification = 1;  ///< drawn length over true length on the picture; 1, 2, 5 times 10^k
  double reference_um = 1;   ///< a round length for the reference arrow
  double px_per_um = 1;
};
ArrowScale arrow_scale(double longest_mm, double longest_px, double px_per_mm);

}  // namespace panelcal::report
