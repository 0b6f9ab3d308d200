// SPDX-License-Identifier: Apache-2.0
#include "vision/render/render.h"

#include <algorithm>
#include <cstddef>

#include "vision/fit/coverage.h"
#include "vision/render/outline.h"
#include "vision/render/scene_picture.h"
#include "vision/render/scene_projection.h"
#include "vision/texture/weave.h"

namespace panelcal {
namespace {

using internal::Outline;
using internal::PixelResponse;
using internal::SceneProjection;
using internal::ShareMap;

/// Paints features over the levels of a picture.
class Painter {
 public:
  Painter(const Camera& camera, std::span<double> levels)
      : camera_(camera), projection_(camera), response_(camera.blur_px), levels_(levels) {}

  void paint(const Feature& feature) {
    const ShareMap share = share_of(internal::outline_of(feature));
    switch (feature.shape) {
      case Feature::Shape::Cells:
        return paint_cells(feature, share);
      case Feature::Shape::Picture:
        return paint_picture(feature, share);
      default:
        return blend(share, [&](int, int, double part) { return feature.level * part; });
    }
  }

  /// Paints a feature black, whatever its brightness.
  void cover(const Feature& feature) {
    blend(share_of(internal::outline_of(feature)), [](int, int, double) { return 0.0; });
  }

 private:
  ShareMap integral_of(const Outline& outline) const {
    const auto nodes = internal::outline_nodes(projection_, outline, response_.blur_px());
    return internal::integrate_inside(nodes, response_, camera_.width, camera_.height);
  }

  ShareMap share_of(const Outline& outline) const {
    ShareMap map = integral_of(outline);
    for (double& share : map.share) share = std::clamp(share, 0.0, 1.0);
    return map;
  }

  /// The level becomes what shines through plus what the feature adds: light(x, y, share).
  template <class Light>
  void blend(const ShareMap& map, Light light) {
    for (int y = map.y0; y < map.y1(); ++y) {
      double* row = levels_.data() + static_cast<std::ptrdiff_t>(y) * camera_.width;
      for (int x = map.x0; x < map.x1(); ++x) {
        const double share = map.at(x, y);
        row[x] += light(x, y, share) - row[x] * share;
      }
    }
  }

  /// Light of all cells at once: neighbours share edges, and painted one after the other each would
  /// let through some of what the other one covers.
  void paint_cells(const Feature& feature, const ShareMap& share) {
    if (!feature.cells) return;
    std::vector<double> values;
    for (const auto& level : feature.cells->levels) values.push_back(level.value_or(0));
    const ShareMap light = integral_of(internal::cell_edges(feature, values));
    const auto is_inside = [&](int x, int y) {
      return x >= light.x0 && x < light.x1() && y >= light.y0 && y < light.y1();
    };
    // Black cells at the grid's rim make the box of the light the smaller one.
    blend(share, [&](int x, int y, double) { return is_inside(x, y) ? light.at(x, y) : 0; });
  }

  void paint_picture(const Feature& feature, const ShareMap& share) {
    if (!feature.picture || feature.picture->image.empty() || !(feature.size > mm(0))) return;
    const internal::PictureSampler sampler(feature, projection_);
    blend(share, [&](int x, int y, double part) {
      return part > 0 ? part * sampler.level({x, y}) : 0;
    });
  }

  const Camera& camera_;
  SceneProjection projection_;
  PixelResponse response_;
  std::span<double> levels_;
};

/// Area of a picture on the panel, mm: the box of its border.
struct PanelBox {
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300);
  Eigen::Vector2d high = Eigen::Vector2d::Constant(-1e300);
};

template <class PanelOf>
PanelBox panel_box(const Camera& camera, PanelOf panel_of) {
  PanelBox box;
  const auto take = [&](int x, int y) {
    const Eigen::Vector2d at_mm = panel_of(x, y);
    box.low = box.low.cwiseMin(at_mm);
    box.high = box.high.cwiseMax(at_mm);
  };
  for (int x = 0; x < camera.width; ++x) {
    take(x, 0);
    take(x, camera.height - 1);
  }
  for (int y = 0; y < camera.height; ++y) {
    take(0, y);
    take(camera.width - 1, y);
  }
  return box;
}

void paint_background(const Scene& scene, const Camera& camera, std::span<double> levels) {
  std::fill(levels.begin(), levels.end(), scene.background);
  if (scene.weave.amplitude == 0 || levels.empty()) return;
  const SceneProjection projection(camera);
  const auto& panel = scene.weave.panel_from_optical;
  const auto panel_of = [&](int x, int y) -> Eigen::Vector2d {
    return panel.linear() * projection.board_of(Eigen::Vector2d(x, y)) + panel.translation();
  };
  const PanelBox box = panel_box(camera, panel_of);
  const internal::WeaveField weave(scene.weave, box.low, box.high);
  std::size_t i = 0;
  for (int y = 0; y < camera.height; ++y) {
    for (int x = 0; x < camera.width; ++x, ++i) {
      levels[i] += scene.weave.amplitude * weave.level(panel_of(x, y));
    }
  }
}

/// Light is 1 in the middle of the picture.
void shine(const Scene& scene, const Camera& camera, std::span<double> levels) {
  const double bright = scene.lamp * camera.full_scale;
  std::size_t i = 0;
  for (int y = 0; y < camera.height; ++y) {
    const double dy = (y - 0.5 * (camera.height - 1)) / camera.height;
    for (int x = 0; x < camera.width; ++x, ++i) {
      const double dx = (x - 0.5 * (camera.width - 1)) / camera.width;
      const double light = (1 + scene.light_gradient.x() * dx + scene.light_gradient.y() * dy) *
                           (1 - scene.vignetting * (2 * (dx * dx + dy * dy)));
      levels[i] *= light * bright;
    }
  }
}

std::size_t n_pixels(const Camera& camera) {
  return static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
}

}  // namespace

std::vector<double> render_levels(const Scene& scene, const Camera& camera) {
  std::vector<double> levels(n_pixels(camera));
  paint_background(scene, camera, levels);
  Painter painter(camera, levels);
  for (const Feature& feature : scene.features) painter.paint(feature);
  shine(scene, camera, levels);
  return levels;
}

std::vector<bool> touched_pixels(std::span<const Feature> features,
                                 const Camera& camera,
                                 double least_share) {
  std::vector<double> rest(n_pixels(camera), 1);
  Painter painter(camera, rest);
  for (const Feature& feature : features) painter.cover(feature);
  std::vector<bool> touched;
  touched.reserve(rest.size());
  for (const double v : rest) touched.push_back(v <= 1 - least_share);
  return touched;
}

Image render(const Scene& scene, const Camera& camera, Random& random) {
  return expose(render_levels(scene, camera), camera, random);
}

}  // namespace panelcal
