// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace panelcal::internal {

/// A pixel's sensitivity along one axis behind a Gaussian lens, box * Gauss, and its integral.
///
/// Tabulated with cubic Hermite pieces from the exact values and slopes: good to 1e-8, and far
/// quicker than the error function.
class PixelResponse {
 public:
  /// In     blur_px: 0.2 to 1000, otherwise the nearer one of these
  explicit PixelResponse(double blur_px);

  double blur_px() const { return blur_px_; }
  /// Beyond this distance the weight is below 1e-9, and the integral 0 or 1.
  double reach_px() const { return reach_px_; }
  /// Values at first, first - 1, first - 2 and so on, all within reach_px(): those of a row of
  /// pixels as seen from one place.
  void weights(double first_px, std::span<double> out) const { evaluate(weight_, first_px, out); }
  void integrals(double first_px, std::span<double> out) const {
    evaluate(integral_, first_px, out);
  }

 private:
  struct Cubic {
    double c0, c1, c2, c3;
  };

  void evaluate(const std::vector<Cubic>& table, double first_px, std::span<double> out) const;

  double blur_px_;
  double reach_px_;
  double end_px_;     ///< of the tables, both ways
  int steps_per_px_;  ///< whole, so that all pixels of a row stand at the same part of a step
  std::vector<Cubic> weight_;
  std::vector<Cubic> integral_;
};

/// One node of a quadrature along a closed outline, in pixels.
struct OutlineNode {
  Eigen::Vector2d at_px;
  double dy_px = 0;  ///< the node's weight times the outline's tangent, y part
};

/// Share of each pixel that lies inside of an outline; outside of the box the share is 0.
struct ShareMap {
  int x0 = 0;
  int y0 = 0;
  int width = 0;
  int height = 0;
  std::vector<double> share;

  int x1() const { return x0 + width; }
  int y1() const { return y0 + height; }
  double at(int x, int y) const { return share[index(x, y)]; }
  double& at(int x, int y) { return share[index(x, y)]; }
  std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y - y0) * static_cast<std::size_t>(width) +
           static_cast<std::size_t>(x - x0);
  }
};

/// Integrates lens blur times pixel square over the area inside outlines (Green's theorem):
///
///   share(u) = sum_nodes G(x - u_x) g(y - u_y) dy,   g = box * Gauss, G = its integral
///
/// In     nodes: of closed outlines; dy > 0 where the inside is to the left (at smaller x), times
///        whatever the inside weighs; spaced as outline.h has them
/// Out    the sum, for the pixels of a picture of width x height that the nodes can reach
/// Cost   O(nodes * (1 + 12 blur)^2)
ShareMap integrate_inside(std::span<const OutlineNode> nodes,
                          const PixelResponse& response,
                          int width,
                          int height);

}  // namespace panelcal::internal
