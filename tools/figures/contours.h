// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace panelcal::contours {

/// Values at the nodes of a lattice.
struct Field {
  std::vector<double> x, y;    ///< of columns and rows, not falling; two or more each
  std::vector<double> values;  ///< row by row, finite

  double at(std::size_t i, std::size_t j) const { return values[j * x.size() + i]; }
};

struct Line {
  std::vector<Eigen::Vector2d> points;
  bool is_closed = false;

  double length() const;
};

/// Contours of a field at a level: lines that end at the lattice's border or nowhere.
///
/// By marching squares: straight from side to side of each cell, on the sides as linear
/// interpolation has it. Where the field goes up at two opposite corners of a cell, the mean of its
/// four nodes decides which of them hang together.
///
/// Source Lorensen and Cline 1987 (marching cubes, in two dimensions)
/// See    tests/tools/figures/contours_test.cc
std::vector<Line> level_lines(const Field& field, double level);

/// The area where a field is at least a level, by closed lines: what is within an odd number of
/// them.
std::vector<Line> level_area(const Field& field, double level);

/// Round levels, of a step that is 1, 2 or 5 times a power of ten: at least n of them above `low`
/// and below `high`, as few as such steps allow. None if there is nothing between.
std::vector<double> round_levels(double low, double high, int n);

/// Digits behind the point that tell such levels apart.
int decimals_of(const std::vector<double>& levels);

}  // namespace panelcal::contours
