// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace panelcal::svg {

/// Appends a length in mm with three decimals.
void append_mm(std::string& out, double value_mm);
/// Appends `x y`.
void append_mm(std::string& out, const Eigen::Vector2d& p_mm);

struct Color {
  int red = 0;
  int green = 0;
  int blue = 0;

  std::string hex() const;
  Color darker() const { return {red * 6 / 10, green * 6 / 10, blue * 6 / 10}; }
};

/// Eight colours that colour-blind people tell apart as well, on white; then ever new hues.
Color tool_color(std::size_t i_tool);

/// The largest of 1, 2, 5 times a power of ten that is not above `x`; 1 for what is no length.
double nice_below(double x);

struct LegendRow {
  std::string swatch;  ///< SVG about (0, 0), y down, 1 = the size of the text
  std::string text;
  std::string detail;  ///< a second line, smaller; may be empty
};

/// The sheet of the drawing: title, ruled ground, legend, provenance. Coordinates of the picture
/// are mm with y down; the drawing in between is mirrored, so that it has y up.
class Sheet {
 public:
  /// Leaves room for everything from `low_mm` to `high_mm` and for `n_legend_rows`.
  Sheet(const Eigen::Vector2d& low_mm,
        const Eigen::Vector2d& high_mm,
        std::size_t n_legend_rows,
        std::string title,
        std::vector<std::string> provenance);

  double text_mm() const { return text_mm_; }              ///< size of the text
  double thin_mm() const { return 0.05 * text_mm_; }       ///< width of thin lines
  double side_mm() const { return size_mm().maxCoeff(); }  ///< the longer side of the ground

  /// Everything up to the opened group of the drawing.
  std::string open() const;
  /// Everything from the end of that group on; `labels` lies above it, y down.
  std::string close(std::string_view labels, std::span<const LegendRow> legend) const;

 private:
  Eigen::Vector2d size_mm() const { return high_mm_ - low_mm_; }
  double left_mm() const { return low_mm_.x() - 3.5 * text_mm_; }
  double top_mm() const { return -high_mm_.y() - (title_.empty() ? 0.5 : 2.5) * text_mm_; }
  double width_mm() const;
  double height_mm() const;
  std::size_t rows_in_column() const;
  std::string style() const;
  std::string rules() const;

  Eigen::Vector2d low_mm_;
  Eigen::Vector2d high_mm_;
  double text_mm_ = 1;
  std::size_t n_legend_rows_ = 0;
  std::string title_;
  std::vector<std::string> provenance_;
  std::vector<std::string> provenance_lines_;  ///< broken to fit
};

}  // namespace panelcal::svg
