// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace panelcal::internal {

/// One node of a quadrature along a closed outline, in pixels.
struct OutlineNode {
  Eigen::Vector2d at_px;
  double dy_px = 0;  ///< the node's weight times the outline's tangent, y part
};

/// Which share of each pixel lies inside of an outline; outside of the box the share is 0.
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

/// Integrates lens blur times pixel square over the area inside an outline (Green's theorem):
///
///   share(u) = sum_nodes G(x - u_x) g(y - u_y) dy,   g = box * Gauss, G = its integral
///
/// In     nodes: closed, either way round, spaced below about 0.7 blur_px; blur_px > 0; the
///        picture's size in pixels, which the map does not leave
/// Cost   O(nodes * (1 + 12 blur)^2)
ShareMap share_inside(std::span<const OutlineNode> nodes, double blur_px, int width, int height);

}  // namespace panelcal::internal
