// SPDX-License-Identifier: Apache-2.0
#include "panelcal/surface/surface_outliers.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "panelcal/calib/drift/distributions.h"

namespace panelcal {
namespace {

/// Of |t|, t standard normal.
constexpr double kNormalMedian = 0.6744897501960817;
/// No probes are set aside below so many: what is left would fit whatever it is.
constexpr std::size_t kLeastKept = 5;

using Indices = std::vector<std::size_t>;

class Sorting {
 public:
  Sorting(std::span<const ProbePoint> points, const OutlierOptions& options)
      : points_(points),
        limit_(options.false_alarm / static_cast<double>(points.size())),
        most_noise_(options.most_noise),
        n_most_(
            std::min(static_cast<std::size_t>(options.most * static_cast<double>(points.size())),
                     points.size() > kLeastKept ? points.size() - kLeastKept : 0)) {
    for (std::size_t i = 0; i < points.size(); ++i) kept_.push_back(i);
  }

  Expected<void> search(SurfaceModel model);
  Expected<SoundSurface> judge(SurfaceModel model);

 private:
  Expected<SurfaceFit> fit(SurfaceModel model) const {
    std::vector<ProbePoint> points;
    for (const std::size_t i : kept_) points.push_back(points_[i]);
    return fit_surface(points, model);
  }
  /// Fails if too much would be set aside.
  Expected<void> set_aside(std::size_t i_kept);
  SurfaceOutlier judged(const SurfaceFit& fit, std::size_t i_point) const;

  std::span<const ProbePoint> points_;
  double limit_;
  double most_noise_;
  std::size_t n_most_;
  Indices kept_;
  Indices aside_;
};

double absolute_t(const LeftOutProbe& probe) {
  return probe.deviation ? std::abs(*probe.deviation / probe.sigma) : 0;
}

Expected<void> Sorting::set_aside(std::size_t i_kept) {
  const std::size_t i_point = kept_[i_kept];
  aside_.push_back(i_point);
  kept_.erase(kept_.begin() + static_cast<std::ptrdiff_t>(i_kept));
  if (aside_.size() <= n_most_) return {};
  return failure({Code::SurfaceOutOfTolerance,
                  points_[i_point].from,
                  fmt::format("{} of {} probes do not fit the others, {} among them",
                              aside_.size(),
                              points_.size(),
                              quoted(name_of(points_[i_point]))),
                  fmt::format("at most {}", n_most_)});
}

Expected<void> Sorting::search(SurfaceModel model) {
  while (true) {
    PANELCAL_TRY(const SurfaceFit found, fit(model));
    std::vector<double> t;
    for (const LeftOutProbe& probe : found.left_out()) t.push_back(absolute_t(probe));
    const auto worst = static_cast<std::size_t>(std::ranges::max_element(t) - t.begin());
    std::vector<double> sorted = t;
    const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
    std::ranges::nth_element(sorted, middle);
    // Few probes may lie close together by chance: no probe scatters less than it says.
    const double scale = std::max(*middle / kNormalMedian, 1 / found.noise_factor());
    if (2 * normal_exceedance(t[worst] / scale) >= limit_) return {};
    PANELCAL_CHECK(set_aside(worst));
  }
}

/// A probe that took no part in the fit.
SurfaceOutlier Sorting::judged(const SurfaceFit& fit, std::size_t i_point) const {
  const ProbePoint& point = points_[i_point];
  const HeightEstimate foretold = fit.at(point.place);
  const double noise_mm = fit.noise_factor() * point.measured.sigma.in_mm();
  const Length deviation = point.measured.height - foretold.height;
  const Length sigma = mm(std::hypot(foretold.sigma.in_mm(), noise_mm));
  const double t = deviation / sigma;
  const double chance = variance_ratio_exceedance(t * t, 1, fit.degrees_of_freedom());
  return {i_point, name_of(point), deviation, sigma, chance};
}

Expected<SoundSurface> Sorting::judge(SurfaceModel model) {
  PANELCAL_TRY(SurfaceFit found, fit(model));
  while (true) {
    const auto worst =
        std::ranges::min_element(found.left_out(), {}, [](const auto& p) { return p.chance; });
    if (worst->chance >= limit_) break;
    PANELCAL_CHECK(set_aside(static_cast<std::size_t>(worst - found.left_out().begin())));
    PANELCAL_TRY(found, fit(model));
  }
  std::vector<SurfaceOutlier> outliers;
  std::ranges::sort(aside_);
  for (const std::size_t i_point : aside_) {
    SurfaceOutlier outlier = judged(found, i_point);
    if (outlier.chance < limit_) {
      outliers.push_back(std::move(outlier));
    } else {
      kept_.push_back(i_point);
    }
  }
  if (outliers.size() < aside_.size()) {
    std::ranges::sort(kept_);
    PANELCAL_TRY(found, fit(model));
  }
  if (!(found.noise_factor() <= most_noise_)) {
    return failure(
        {Code::SurfaceOutOfTolerance,
         points_[kept_.front()].from,
         fmt::format("the probes scatter {:.1f} times what they say", found.noise_factor()),
         fmt::format("at most {:.1f} times", most_noise_)});
  }
  return SoundSurface{std::move(found), std::move(kept_), std::move(outliers)};
}

}  // namespace

std::string name_of(const ProbePoint& point) {
  if (!point.name.empty()) return point.name;
  const Eigen::Vector2d p_mm = point.place.in_mm();
  return fmt::format("probe at ({:.3f}, {:.3f})", p_mm.x(), p_mm.y());
}

std::string SurfaceOutlier::text() const {
  return fmt::format("{} is {:.3f} mm {} what the others foretell, {:.0f} sigma",
                     name,
                     std::abs(deviation.in_mm()),
                     deviation > mm(0) ? "above" : "below",
                     std::abs(deviation / sigma));
}

Expected<void> OutlierOptions::validate() const {
  const auto check =
      [](const char* field, double value, bool is_good, const char* expected) -> Expected<void> {
    if (is_good) return {};
    return failure({Code::ConfigValue, {}, fmt::format("{} is {}", field, value), expected});
  };
  PANELCAL_CHECK(
      check("false_alarm", false_alarm, false_alarm > 0 && false_alarm < 1, "above 0, below 1"));
  PANELCAL_CHECK(check("most outliers", most, most >= 0 && most <= 0.5, "0 to 0.5 of the probes"));
  return check("most_noise", most_noise, most_noise > 0, "above 0");
}

Expected<SoundSurface> fit_without_outliers(std::span<const ProbePoint> points,
                                            SurfaceModel model,
                                            const OutlierOptions& options) {
  PANELCAL_CHECK(options.validate());
  Sorting sorting(points, options);
  const bool is_plane = model == SurfaceModel::Plane;
  PANELCAL_CHECK(sorting.search(is_plane ? SurfaceModel::Plane : SurfaceModel::ThinPlate));
  if (!is_of_grid(model)) return sorting.judge(model);
  PANELCAL_TRY(SoundSurface out, sorting.judge(SurfaceModel::ThinPlate));
  if (!out.outliers.empty()) {
    return failure({Code::GridInvalid,
                    points[out.outliers.front().i_point].from,
                    out.outliers.front().text(),
                    fmt::format("a good probe at each node for a {} surface", name_of(model))});
  }
  PANELCAL_TRY(out.fit, fit_surface(points, model));
  return out;
}

}  // namespace panelcal
