// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>

#include "program/geometry/arcs.h"
#include <Eigen/Core>
#include <tl/expected.hpp>

namespace panelcal::sieb_meyer {

/// A line or an arc of any angle of a contour. Programmed coordinates, mm.
struct ContourPiece {
  Eigen::Vector2d start_mm = Eigen::Vector2d::Zero();
  Eigen::Vector2d end_mm = Eigen::Vector2d::Zero();
  /// Of an arc, equally far from both ends; an arc that ends where it starts is a full circle.
  std::optional<Eigen::Vector2d> center_mm;
  bool clockwise = false;
};

/// D: the arc that rounds the corner between two pieces of a contour.
///
/// It touches both pieces and keeps the direction of travel. Its start is where the first piece
/// must end now, its end where the second one must begin.
///
///   Its centre is at the distance r from the line and, beside an arc of radius R, at R - r from
///   that one's centre if both turn the same way, otherwise at R + r.
///
/// In     first ends where second starts, within 1e-6 mm; radius_mm: D, > 0
/// Fails  a radius not above zero; pieces that do not meet or have no length; two arcs (the manual
///        has no rounding between them); a tangent continuation, which has no corner; a second
///        piece that turns straight back; a radius that needs more than a piece has (the manual: D
///        must be smaller than the shorter adjacent line), or that fits nowhere
/// Source SIEB & MEYER manual, D: Round Edge
/// See    tests/program/sieb_meyer/figures/corner_rounding_test.cc
tl::expected<Arc, std::string> round_corner(const ContourPiece& first,
                                            const ContourPiece& second,
                                            double radius_mm);

}  // namespace panelcal::sieb_meyer
