// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>

#include <Eigen/Core>

#include "panelcal/vision/edge_profile.h"
#include "panelcal/vision/fit_window.h"
#include "panelcal/vision/target.h"

namespace panelcal::internal {

/// Parameter order; units are the fit frame's (about px) and grey levels.
enum RimParameter {
  kCenterX,
  kCenterY,
  kRadius,
  kSigma,  ///< of the edge, pixel width included
  kPlane,  ///< background at the plane's origin, then its slopes per plane unit
  kPlaneX,
  kPlaneY,
  kContrast,   ///< target minus background, then its slopes: light multiplies, so that a bright
  kContrastX,  ///< target has a steeper gradient than the background
  kContrastY,
  kInnerRadius,  ///< rings only, as is the next
  kHole,         ///< level in the hole minus background: the hole may show another material
  kMaxRimParameters
};

using RimVector = Eigen::Matrix<double, kMaxRimParameters, 1>;
using RimMatrix = Eigen::Matrix<double, kMaxRimParameters, kMaxRimParameters>;

/// The picture of a disc or ring as a function of its parameters.
///
///   I = plane + (contrast + slopes) (E(R) - E(R_inner)) + hole E(R_inner)
///
/// with E the edge profile and lengths measured in the fit frame, then brought to pixels by the
/// frame's local scale across the rim.
class RimModel {
 public:
  RimModel(Shape shape, const Eigen::Vector2d& plane_origin, double plane_unit)
      : shape_(shape), plane_origin_(plane_origin), plane_unit_(plane_unit) {}

  int n_parameters() const { return shape_ == Shape::Ring ? kMaxRimParameters : kInnerRadius; }
  bool is_ring() const { return shape_ == Shape::Ring; }

  /// Where on the target a pixel is.
  enum class Zone { Outside, Inside, Rim };

  struct Value {
    Zone zone = Zone::Rim;
    double level = 0;
    double share = 0;        ///< of the target (for a ring: its metal) in the pixel
    double distance_px = 0;  ///< inwards from the outer rim
    Eigen::Vector3d plane;   ///< (1, x, y) in plane units
  };

  /// The level, and for Zone::Rim its gradient (the other zones' follows from `plane` alone).
  Value evaluate(const WindowPixel& pixel, const RimVector& p, RimVector* gradient) const {
    Value value;
    value.plane << 1, (pixel.at - plane_origin_) / plane_unit_;
    const double background = value.plane.dot(p.segment<3>(kPlane));
    const double contrast = value.plane.dot(p.segment<3>(kContrast));

    const Eigen::Vector2d offset = pixel.at - p.head<2>();
    const double r = offset.norm();
    // Far from the rim the frame's units are pixels, near enough.
    const double reach = kFarFactor * (kEdgeReach * p[kSigma] + 1);
    value.distance_px = p[kRadius] - r;
    if (value.distance_px < -reach) {
      value.zone = Zone::Outside;
      value.level = background;
      return value;
    }
    if (!is_ring() && (value.distance_px > reach || r < kTinyRadius)) {
      value.zone = Zone::Inside;
      value.share = 1;
      value.level = background + contrast;
      return value;
    }
    const Eigen::Vector2d n = offset / std::max(r, kTinyRadius);
    const Eigen::Vector2d n_px = pixel.jacobian.transpose() * n;
    const double units_per_px = std::max(n_px.norm(), kTinyRadius);
    value.distance_px /= units_per_px;
    const double nx = n_px.x() / units_per_px;
    const double ny = n_px.y() / units_per_px;
    const EdgeValue outer = edge_profile(value.distance_px, p[kSigma], p[kRadius], nx, ny);
    EdgeValue inner;
    double hole = 0;
    if (is_ring()) {
      inner =
          edge_profile((p[kInnerRadius] - r) / units_per_px, p[kSigma], p[kInnerRadius], nx, ny);
      hole = p[kHole];
    }
    value.share = outer.share - inner.share;
    value.level = background + contrast * value.share + hole * inner.share;
    if (gradient) {
      const double inner_gain = hole - contrast;
      const double d_distance = contrast * outer.d_distance + inner_gain * inner.d_distance;
      RimVector& g = *gradient;
      g.head<2>() = d_distance / units_per_px * n;
      g[kRadius] = contrast * (outer.d_distance / units_per_px + outer.d_radius);
      g[kSigma] = contrast * outer.d_sigma + inner_gain * inner.d_sigma;
      g.segment<3>(kPlane) = value.plane;
      g.segment<3>(kContrast) = value.share * value.plane;
      g[kInnerRadius] = inner_gain * (inner.d_distance / units_per_px + inner.d_radius);
      g[kHole] = inner.share;
    }
    return value;
  }

 private:
  static constexpr double kTinyRadius = 1e-6;
  static constexpr double kFarFactor = 1.2;

  Shape shape_;
  Eigen::Vector2d plane_origin_;
  double plane_unit_;
};

}  // namespace panelcal::internal
