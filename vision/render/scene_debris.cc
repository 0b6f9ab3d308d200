// SPDX-License-Identifier: Apache-2.0
#include "vision/render/scene_debris.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "vision/render/outline.h"
#include <Eigen/Core>

namespace panelcal {
namespace {

/// Outlines of crumbs.
constexpr double kRoughness = 0.25;  // rms over the radius
constexpr int kMaxDebrisOrder = 7;
/// Crumbs lie this far to either side of the outline, of their diameter.
constexpr double kScatter = 0.3;
constexpr double kSmallest = 0.5;
constexpr double kLargest = 1.5;
/// Rim places per crumb: how exactly the covered share is known.
constexpr double kPlacesPerCrumb = 64;
constexpr double kMostShare = 0.95;
constexpr int kMostCrumbs = 2000;
constexpr int kHalvings = 24;
/// Scratches pass this near the middle of the mark's rim places, of their farthest.
constexpr double kScratchReach = 1.2;

double possible_share(double share) {
  return std::clamp(share, 0.0, kMostShare);
}

/// The rim of a mark as many places, and which of them are covered.
class Rim {
 public:
  Rim(const std::vector<Feature>& mark, Length spacing) {
    for (const Feature& feature : mark) {
      const auto more = internal::outline_places(internal::outline_of(feature), spacing);
      places_.insert(places_.end(), more.begin(), more.end());
    }
    is_covered_.assign(places_.size(), false);
  }

  bool empty() const { return places_.empty(); }
  double covered() const { return static_cast<double>(n_covered_) / n(); }
  /// The share with one more crumb.
  double covered_with(const Feature& crumb) const {
    std::size_t more = 0;
    visit(crumb, [&](std::size_t i) { more += is_covered_[i] ? 0 : 1; });
    return static_cast<double>(n_covered_ + more) / n();
  }
  void cover(const Feature& crumb) {
    visit(crumb, [&](std::size_t i) {
      n_covered_ += is_covered_[i] ? 0 : 1;
      is_covered_[i] = true;
    });
  }
  const Eigen::Vector2d& free_place(Random& random) const {
    auto skip = static_cast<std::size_t>(random.uniform() *
                                         static_cast<double>(places_.size() - n_covered_));
    std::size_t i = 0;
    for (; is_covered_[i] || skip > 0; ++i) skip -= is_covered_[i] ? 0 : 1;
    return places_[i];
  }
  Eigen::Vector2d middle() const {
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& place : places_) sum += place;
    return sum / n();
  }
  double reach_mm(const Eigen::Vector2d& from) const {
    double reach = 0;
    for (const Eigen::Vector2d& place : places_) reach = std::max(reach, (place - from).norm());
    return reach;
  }

 private:
  double n() const { return static_cast<double>(places_.size()); }

  template <class Found>
  void visit(const Feature& crumb, Found found) const {
    const internal::RoughCircle outline(crumb.size.in_mm() / 2, crumb.roughness);
    for (std::size_t i = 0; i < places_.size(); ++i) {
      const Eigen::Vector2d d = places_[i] - crumb.center.in_mm();
      if (d.squaredNorm() > outline.reach_mm() * outline.reach_mm()) continue;
      if (d.norm() < outline.radius_mm(std::atan2(d.y(), d.x()))) found(i);
    }
  }

  std::vector<Eigen::Vector2d> places_;
  std::vector<bool> is_covered_;
  std::size_t n_covered_ = 0;
};

Feature sized(Feature crumb, Length size) {
  crumb.size = size;
  crumb.roughness.rms = kRoughness * 0.5 * size;
  return crumb;
}

Feature draw_crumb(const Rim& rim, const DebrisOptions& options, Random& random) {
  Feature crumb;
  const double scatter_mm = kScatter * options.size.in_mm();
  const Eigen::Vector2d& on_rim = rim.free_place(random);
  const double dx = scatter_mm * random.uniform(-1, 1);
  const double dy = scatter_mm * random.uniform(-1, 1);
  crumb.center = position_mm<frame::Optical>(on_rim.x() + dx, on_rim.y() + dy);
  crumb.level = random.uniform(options.darkest, options.brightest);
  crumb.roughness.highest_order = kMaxDebrisOrder;
  crumb.roughness.seed = static_cast<std::uint64_t>(random.uniform() * 0x1p53);
  return sized(crumb, random.uniform(kSmallest, kLargest) * options.size);
}

/// As large as it takes to cover `share`, which it does as it is.
Feature shrunk(const Rim& rim, const Feature& crumb, double share) {
  Length low;
  Length high = crumb.size;
  for (int i = 0; i < kHalvings; ++i) {
    const Length size = 0.5 * (low + high);
    (rim.covered_with(sized(crumb, size)) > share ? high : low) = size;
  }
  return sized(crumb, low);
}

void add_crumbs(Rim& rim, const DebrisOptions& options, Random& random, Debris& debris) {
  const double share = possible_share(options.rim_share);
  for (int i = 0; i < kMostCrumbs && rim.covered() < share; ++i) {
    Feature crumb = draw_crumb(rim, options, random);
    const bool is_last = rim.covered_with(crumb) > share;
    if (is_last) crumb = shrunk(rim, crumb, share);
    rim.cover(crumb);
    if (crumb.size > mm(0)) debris.features.push_back(crumb);
    if (is_last) break;
  }
  debris.rim_share = rim.covered();
}

void add_scratches(const Rim& rim, const DebrisOptions& options, Random& random, Debris& debris) {
  const Eigen::Vector2d middle = rim.middle();
  const double reach_mm = kScratchReach * rim.reach_mm(middle);
  for (int i = 0; i < options.scratches; ++i) {
    Feature scratch;
    scratch.shape = Feature::Shape::Rectangle;
    const double dx = reach_mm * random.uniform(-1, 1);
    const double dy = reach_mm * random.uniform(-1, 1);
    scratch.center = position_mm<frame::Optical>(middle.x() + dx, middle.y() + dy);
    scratch.angle = rad(random.uniform(0, std::numbers::pi));
    scratch.size = random.uniform(kSmallest, kLargest) * options.scratch_length;
    scratch.inner_size = options.scratch_width;
    scratch.level = random.uniform(options.darkest, options.brightest);
    debris.features.push_back(scratch);
  }
}

}  // namespace

Debris strew_debris(const std::vector<Feature>& mark,
                    const DebrisOptions& options,
                    Random& random) {
  Debris debris;
  if (!(options.size > mm(0))) return debris;
  Rim rim(mark, options.size / kPlacesPerCrumb);
  if (rim.empty()) return debris;
  add_crumbs(rim, options, random, debris);
  add_scratches(rim, options, random, debris);
  return debris;
}

}  // namespace panelcal
