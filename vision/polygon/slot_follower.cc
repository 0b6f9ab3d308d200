// SPDX-License-Identifier: Apache-2.0
#include "vision/polygon/slot_follower.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace panelcal::internal {
namespace {

/// A slot is followed at most so far either way, in widths and in px.
constexpr double kFarWidths = 4;
constexpr double kFarPx = 160;
/// Mean levels beside and on the slot over a short stretch of it.
struct Profile {
  double below = 0;
  double on = 0;
  double above = 0;
};

/// A slot as lines of samples across it.
class Follower {
 public:
  Follower(const Image& image, const SlotSighting& sighting, const ExpectedSlot& expected)
      : image_(image), sighting_(sighting), expected_(expected) {}

  /// The place nearest to the origin where the slot is not cut by the picture's border.
  std::optional<double> anchor() const {
    for (double along = 0; along <= 3 * expected_.width; along += kStep) {
      if (stretch(along)) return along;
      if (stretch(-along)) return -along;
    }
    return std::nullopt;
  }

  /// End of the slot in one direction (1 or -1) from an anchor, pattern units; `is_cut` is set if
  /// it leaves the picture there.
  double follow(double anchor, int way, double limit, bool& is_cut) const {
    constexpr double kLeast = 0.4;  // of the contrast at the anchor
    const auto first = stretch(anchor);
    if (!first) return anchor;
    const double contrast = first->on - 0.5 * (first->below + first->above);
    const double most_missing = std::max(3 * kStep, 0.3 * expected_.width);
    double end = 0;
    double along = 0;
    for (; along <= limit; along += kStep) {
      const auto profile = stretch(anchor + way * along);
      if (!profile) {
        is_cut = along - end < 2 * kStep;
        return anchor + way * end;
      }
      const double sign = contrast > 0 ? 1 : -1;
      const double weaker =
          std::min(sign * (profile->on - profile->below), sign * (profile->on - profile->above));
      if (weaker > kLeast * std::abs(contrast)) end = along;
      if (along - end > most_missing) return anchor + way * end;
    }
    is_cut = true;  // it goes on
    return anchor + way * end;
  }

 private:
  static constexpr double kStep = 2;

  std::optional<double> level(double along, double across) const {
    const auto u = sighting_.fit_frame.to_image(sighting_.state.to_frame({along, across}));
    if (!u) return std::nullopt;
    const int x = static_cast<int>(std::lround(u->x()));
    const int y = static_cast<int>(std::lround(u->y()));
    if (x < 0 || y < 0 || x >= image_.width() || y >= image_.height()) return std::nullopt;
    return image_.at(x, y);
  }

  /// Empty if a part of it is outside of the picture.
  std::optional<Profile> stretch(double along) const {
    const double w = expected_.width / 2;
    const double foot = std::min(2 * sighting_.state.sigma_px, 0.8 * w);
    const double outer = w + std::max(foot, std::min(0.25 * expected_.width, 8.0));
    const double inner = std::max(0.0, w - foot);
    Profile sum;
    int n = 0;
    for (int i = -2; i <= 2; ++i) {
      for (int k = -1; k <= 1; ++k) {
        const auto below = level(along + i, -outer + k);
        const auto on = level(along + i, 0.5 * k * inner);
        const auto above = level(along + i, outer + k);
        if (!below || !on || !above) return std::nullopt;
        sum.below += *below;
        sum.on += *on;
        sum.above += *above;
        ++n;
      }
    }
    return Profile{sum.below / n, sum.on / n, sum.above / n};
  }

  const Image& image_;
  const SlotSighting& sighting_;
  const ExpectedSlot& expected_;
};

}  // namespace

SlotStretch seen_stretch(const Image& image,
                         const SlotSighting& sighting,
                         const ExpectedSlot& expected,
                         const Eigen::Vector2d& wanted_px) {
  const Follower follower(image, sighting, expected);
  const double whole = image.width() + image.height();
  SlotStretch stretch;
  const auto anchor = follower.anchor();
  if (!anchor) return stretch;
  stretch.to = follower.follow(*anchor, 1, whole, stretch.is_cut_to);
  stretch.from = follower.follow(*anchor, -1, whole, stretch.is_cut_from);
  // Ends may be round, and are blurred: the edges are straight only this far from them.
  const double end = 0.6 * expected.width;
  const double foot = 2 * sighting.state.sigma_px;
  if (!stretch.is_cut_to) stretch.to -= end + foot;
  if (!stretch.is_cut_from) stretch.from += end + foot;
  // Farther off it may bend.
  const double limit = std::max(kFarWidths * expected.width, kFarPx);
  const double near = std::clamp(
      place_on(sighting, wanted_px).x(), stretch.from, std::max(stretch.from, stretch.to));
  stretch.from = std::max(stretch.from, near - limit);
  stretch.to = std::min(stretch.to, near + limit);
  return stretch;
}

}  // namespace panelcal::internal
