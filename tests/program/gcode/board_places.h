// SPDX-License-Identifier: Apache-2.0
// Boards of the tests of moved G-code.
#pragma once

#include <cmath>

#include "program/gcode/mover.h"
#include <Eigen/Core>

namespace panelcal::test {

/// Stretched, turned and shifted; more sure near (0, 0).
class AffinePlaces final : public BoardPlaces {
 public:
  AffinePlaces(const Eigen::Matrix2d& linear, const Eigen::Vector2d& shift_mm)
      : linear_(linear), shift_mm_(shift_mm) {}

  Eigen::Vector2d actual_mm(const Eigen::Vector2d& nominal_mm) const override {
    return linear_ * nominal_mm + shift_mm_;
  }
  Expected<Length> sigma(const Eigen::Vector2d& nominal_mm) const override {
    return um(1 + nominal_mm.norm() / 10);
  }

 private:
  Eigen::Matrix2d linear_;
  Eigen::Vector2d shift_mm_;
};

/// A quarter turn about (0, 0) and 100 mm to the right: (x, y) is at (100 - y, x).
inline AffinePlaces turned() {
  return {(Eigen::Matrix2d() << 0, -1, 1, 0).finished(), {100, 0}};
}

/// 1 % longer along x.
inline AffinePlaces stretched() {
  return {(Eigen::Matrix2d() << 1.01, 0, 0, 1).finished(), {0, 0}};
}

/// Bent by 1 mm over 100 mm: y is higher by x^2 / 10,000 mm.
class BentPlaces final : public BoardPlaces {
 public:
  Eigen::Vector2d actual_mm(const Eigen::Vector2d& p_mm) const override {
    return {p_mm.x(), p_mm.y() + 1e-4 * p_mm.x() * p_mm.x()};
  }
  Expected<Length> sigma(const Eigen::Vector2d&) const override { return um(2); }
};

}  // namespace panelcal::test
