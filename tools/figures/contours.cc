// SPDX-License-Identifier: Apache-2.0
#include "tools/figures/contours.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <utility>

#include "program/writers/svg/sheet.h"

namespace panelcal::contours {
namespace {

/// A side of a cell, from a node to the right or upwards: twice the node's index, and 1 if upwards.
using Side = std::size_t;

class MarchingSquares {
 public:
  MarchingSquares(const Field& field, double level) : field_(field), level_(level) {
    for (std::size_t j = 0; j + 1 < field.y.size(); ++j) {
      for (std::size_t i = 0; i + 1 < field.x.size(); ++i) cross_cell(i, j);
    }
  }

  /// Every crossing has at most two neighbours: a chain, or a ring.
  std::vector<Line> lines() {
    std::vector<Line> out;
    for (const bool wants_ends : {true, false}) {
      for (const auto& [side, next] : next_) {
        if (wants_ends && next.size() != 1) continue;
        if (!done_[side]) out.push_back(line_from(side, !wants_ends));
      }
    }
    return out;
  }

 private:
  bool is_above(std::size_t i, std::size_t j) const { return field_.at(i, j) >= level_; }
  Side to_right(std::size_t i, std::size_t j) const { return 2 * (j * field_.x.size() + i); }
  Side upwards(std::size_t i, std::size_t j) const { return to_right(i, j) + 1; }

  void cross_cell(std::size_t i, std::size_t j) {
    const Side low = to_right(i, j), high = to_right(i, j + 1);
    const Side left = upwards(i, j), right = upwards(i + 1, j);
    std::vector<Side> crossed = {};  // counter-clockwise
    const bool corners[] = {
        is_above(i, j), is_above(i + 1, j), is_above(i + 1, j + 1), is_above(i, j + 1)};
    const Side sides[] = {low, right, high, left};
    for (std::size_t k = 0; k < 4; ++k) {
      if (corners[k] != corners[(k + 1) % 4]) crossed.push_back(sides[k]);
    }
    if (crossed.size() == 2) connect(crossed[0], crossed[1]);
    if (crossed.size() < 4) return;
    const double mean =
        (field_.at(i, j) + field_.at(i + 1, j) + field_.at(i + 1, j + 1) + field_.at(i, j + 1)) / 4;
    // The first corner is cut off if it is unlike the middle.
    if (corners[0] != (mean >= level_)) {
      connect(low, left);
      connect(right, high);
    } else {
      connect(low, right);
      connect(high, left);
    }
  }

  void connect(Side a, Side b) {
    next_[a].push_back(b);
    next_[b].push_back(a);
  }

  Eigen::Vector2d crossing(Side side) const {
    const std::size_t n = field_.x.size(), node = side / 2;
    const std::size_t i = node % n, j = node / n;
    const std::size_t k = side % 2 == 1 ? i : i + 1, l = side % 2 == 1 ? j + 1 : j;
    const double a = field_.at(i, j), b = field_.at(k, l);
    const double t = (level_ - a) / (b - a);
    return {field_.x[i] + t * (field_.x[k] - field_.x[i]),
            field_.y[j] + t * (field_.y[l] - field_.y[j])};
  }

  Line line_from(Side first, bool is_closed) {
    Line line{{}, is_closed};
    std::optional<Side> side = first;
    while (side) {
      done_[*side] = true;
      line.points.push_back(crossing(*side));
      std::optional<Side> next;
      for (const Side candidate : next_[*side]) {
        if (!done_[candidate]) next = candidate;
      }
      side = next;
    }
    return line;
  }

  const Field& field_;
  double level_;
  std::map<Side, std::vector<Side>> next_;
  std::map<Side, bool> done_;
};

/// With a border all round that lies on the field's own and is below every level.
Field surrounded(const Field& field, double below) {
  Field out;
  for (const auto& [from, to] : {std::pair(&field.x, &out.x), std::pair(&field.y, &out.y)}) {
    to->push_back(from->front());
    to->insert(to->end(), from->begin(), from->end());
    to->push_back(from->back());
  }
  out.values.assign(out.x.size() * out.y.size(), below);
  for (std::size_t j = 0; j < field.y.size(); ++j) {
    for (std::size_t i = 0; i < field.x.size(); ++i) {
      out.values[(j + 1) * out.x.size() + i + 1] = field.at(i, j);
    }
  }
  return out;
}

}  // namespace

double Line::length() const {
  double sum = 0;
  for (std::size_t i = 1; i < points.size(); ++i) sum += (points[i] - points[i - 1]).norm();
  return sum;
}

std::vector<Line> level_lines(const Field& field, double level) {
  return MarchingSquares(field, level).lines();
}

std::vector<Line> level_area(const Field& field, double level) {
  const Field closed = surrounded(field, level - 1);
  return MarchingSquares(closed, level).lines();
}

std::vector<double> round_levels(double low, double high, int n) {
  if (!(high > low) || !std::isfinite(high - low)) return {};
  const double step = svg::nice_below((high - low) / (n + 1));
  std::vector<double> out;
  const double first = std::floor(low / step) + 1;
  for (int i = 0; (first + i) * step < high; ++i) out.push_back((first + i) * step);
  return out;
}

int decimals_of(const std::vector<double>& levels) {
  if (levels.size() < 2) return 3;
  const double step = levels[1] - levels[0];
  return std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-6)), 0, 9);
}

}  // namespace panelcal::contours
