// SPDX-License-Identifier: Apache-2.0
#include "surface/fit/outliers.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "calib/base/statistics/distributions.h"
#include "calib/base/statistics/median.h"
#include "surface/fit/even_part.h"
#include "surface/fit/wild_probe.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Of |t|, t standard normal.
constexpr double kNormalMedian = 0.6744897501960817;
/// No probes are set aside below this number: the rest would always fit.
constexpr std::size_t kLeastKept = 5;
/// Neighbours among which wild probes are looked for, if there are more than kMostProbes.
constexpr std::size_t kNeighbors = 150;
/// Bent surfaces that miss more than this share of what a plane does hardly predict anything.
constexpr double kHardlyBetter = 0.8;

using Indices = std::vector<std::size_t>;

class Sorting {
 public:
  /// In     n_all: the probes that any of which may be called an outlier
  Sorting(std::span<const ProbePoint> points, std::size_t n_all, const OutlierOptions& options)
      : points_(points),
        limit_(options.false_alarm / static_cast<double>(n_all)),
        most_noise_(options.most_noise),
        n_most_(
            std::min(static_cast<std::size_t>(options.most * static_cast<double>(points.size())),
                     points.size() > kLeastKept ? points.size() - kLeastKept : 0)) {
    for (std::size_t i = 0; i < points.size(); ++i) kept_.push_back(i);
  }

  Expected<void> search(SurfaceModel model);
  /// The same of few probes.
  Expected<void> search_few();
  bool are_few() const { return points_.size() <= kFewProbes; }
  Expected<void> set_suspects_aside(SurfaceModel model);
  Expected<SoundSurface> judge(SurfaceModel model);
  /// Fails if too much would be set aside.
  Expected<void> set_aside(std::size_t i_point);
  std::span<const std::size_t> aside() const { return aside_; }

 private:
  Expected<SurfaceFit> fit(SurfaceModel model) const { return fit_surface(kept_points(), model); }
  /// As if scatter were assumed: a wild probe then is part of it, rather than a bend that hides it.
  Expected<SurfaceFit> fit_scattered(SurfaceModel model) const {
    std::vector<ProbePoint> points = kept_points();
    for (ProbePoint& point : points) point.is_sigma_assumed = true;
    return fit_surface(points, model);
  }
  /// Of many probes the shape hardly depends on the few that come or go, and is not learned again.
  Expected<SurfaceFit> fit_again(const SurfaceFit& before) const {
    if (kept_.size() <= kMostProbes) return fit(before.model());
    return fit_surface(kept_points(), before.model(), before.shape());
  }
  std::vector<ProbePoint> kept_points() const {
    std::vector<ProbePoint> out;
    for (const std::size_t i : kept_) out.push_back(points_[i]);
    return out;
  }
  std::string doubt_of(const internal::WildProbe& wild) const;
  std::string doubt_of(const SurfaceOutlier& outlier) const;
  Expected<SoundSurface> doubted(SurfaceFit found, std::vector<SurfaceOutlier> outliers) const;
  Expected<void> check_noise(const SurfaceFit& fit) const;
  SurfaceOutlier judged(const SurfaceFit& fit, std::size_t i_point) const;

  std::span<const ProbePoint> points_;
  double limit_;
  double most_noise_;
  std::size_t n_most_;
  Indices kept_;
  Indices aside_;
  std::string doubt_;         ///< about the kept ones
  Length suspected_ = mm(0);  ///< by which one of them deviates that may be wild
};

double absolute_t(const LeftOutProbe& probe) {
  return probe.deviation ? std::abs(*probe.deviation / probe.sigma) : 0;
}

Expected<void> Sorting::set_aside(std::size_t i_point) {
  aside_.push_back(i_point);
  std::erase(kept_, i_point);
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
    PANELCAL_TRY(const SurfaceFit found, fit_scattered(model));
    std::vector<double> t;
    for (const LeftOutProbe& probe : found.left_out()) t.push_back(absolute_t(probe));
    const auto worst = static_cast<std::size_t>(std::ranges::max_element(t) - t.begin());
    // Few probes may lie close together by chance: no probe scatters less than it says.
    const double scale = std::max(median(t) / kNormalMedian, 1 / found.noise_factor());
    if (2 * normal_exceedance(t[worst] / scale) >= limit_) return {};
    PANELCAL_CHECK(set_aside(kept_[worst]));
  }
}

Expected<void> Sorting::search_few() {
  while (true) {
    const internal::WildProbe wild = internal::wild_probe(kept_points());
    if (!wild.is_found) {
      doubt_ = doubt_of(wild);
      if (wild.is_doubtful && wild.i_worst) suspected_ = mm(std::abs(wild.deviation.in_mm()));
      return {};
    }
    PANELCAL_CHECK(set_aside(kept_[*wild.i_worst]));
  }
}

/// Sentence of `why`; empty without a doubt.
std::string Sorting::doubt_of(const internal::WildProbe& wild) const {
  if (!wild.is_doubtful) return "";
  if (!wild.i_worst) {
    return fmt::format("{} probes cannot tell a wild one among them", kept_.size());
  }
  return fmt::format(
      "{} probes cannot tell a wild one from a bend of the board: {} is {:.3f} mm {} the "
      "prediction of the others",
      kept_.size(),
      name_of(points_[kept_[*wild.i_worst]]),
      std::abs(wild.deviation.in_mm()),
      wild.deviation > mm(0) ? "above" : "below");
}

std::string Sorting::doubt_of(const SurfaceOutlier& outlier) const {
  return fmt::format(
      "{} probes cannot tell a wild one from a bend of the board: sigma about {}, left out, has "
      "the {:.3f} mm by which it is off",
      points_.size(),
      outlier.name,
      std::abs(outlier.deviation.in_mm()));
}

/// Few probes that were left out or are suspected may as well be right: sigma has that error.
Expected<SoundSurface> Sorting::doubted(SurfaceFit found,
                                        std::vector<SurfaceOutlier> outliers) const {
  if (suspected_ > mm(0)) {
    std::vector<ShapeShare> shapes(found.shapes().begin(), found.shapes().end());
    for (ShapeShare& share : shapes) share.shape.unresolved = suspected_;
    PANELCAL_TRY(found, fit_surface(kept_points(), found.model(), shapes));
  }
  std::string doubt;
  if (are_few()) {
    found = found.with(possible_bends(points_, kept_, outliers));
    for (const SurfaceOutlier& outlier : outliers) {
      const auto is_of_it = [&](const PossibleBend& bend) {
        return bend.place.in_mm() == points_[outlier.i_point].place.in_mm();
      };
      if (!std::ranges::any_of(found.possible_bends(), is_of_it)) continue;
      doubt += (doubt.empty() ? "" : "; ") + doubt_of(outlier);
    }
  }
  if (!doubt_.empty()) doubt += (doubt.empty() ? "" : "; ") + doubt_;
  if (found.model() != SurfaceModel::Plane && !found.has_seen_bending()) {
    doubt += fmt::format("{}{} probes at three places show no bending of the board: sigma has none",
                         doubt.empty() ? "" : "; ",
                         kept_.size());
  }
  return SoundSurface{std::move(found), kept_, std::move(outliers), std::move(doubt)};
}

/// A probe that took no part in the fit.
SurfaceOutlier Sorting::judged(const SurfaceFit& fit, std::size_t i_point) const {
  const ProbePoint& point = points_[i_point];
  const HeightEstimate predicted = fit.at(point.place);
  const double noise_mm = fit.noise_factor() * point.measured.sigma.in_mm();
  const Length deviation = point.measured.height - predicted.height;
  const Length sigma = mm(std::hypot(predicted.sigma.in_mm(), noise_mm));
  const double t = deviation / sigma;
  const double chance = variance_ratio_exceedance(t * t, 1, fit.degrees_of_freedom());
  return {i_point, name_of(point), deviation, sigma, chance};
}

Expected<void> Sorting::set_suspects_aside(SurfaceModel model) {
  PANELCAL_TRY(SurfaceFit found, fit_scattered(model));
  std::size_t n_aside_then = aside_.size();  // when the shape was learned
  while (true) {
    const auto worst =
        std::ranges::min_element(found.left_out(), {}, [](const auto& p) { return p.chance; });
    if (worst->chance >= limit_) {
      if (aside_.size() == n_aside_then || kept_.size() <= kMostProbes) return {};
      // Shape and noise were those of the wild probes, too.
      n_aside_then = aside_.size();
      PANELCAL_TRY(found, fit_scattered(model));
      continue;
    }
    PANELCAL_CHECK(set_aside(kept_[static_cast<std::size_t>(worst - found.left_out().begin())]));
    if (kept_.size() <= kMostProbes) {
      PANELCAL_TRY(found, fit_scattered(model));
    } else {
      PANELCAL_TRY(found, fit_again(found));
    }
  }
}

Expected<SoundSurface> Sorting::judge(SurfaceModel model) {
  // Few probes were judged one by one.
  if (!are_few() || model == SurfaceModel::Plane) PANELCAL_CHECK(set_suspects_aside(model));
  PANELCAL_TRY(SurfaceFit found, fit(model));
  std::vector<SurfaceOutlier> outliers;
  std::ranges::sort(aside_);
  // A light share of rough bending would let nearly any probe pass: the likeliest kind judges.
  PANELCAL_TRY(const SurfaceFit likeliest,
               found.shapes().size() == 1 || are_few()
                   ? Expected<SurfaceFit>(found)
                   : fit_surface(kept_points(), model, found.shape()));
  for (const std::size_t i_point : aside_) {
    SurfaceOutlier outlier = judged(likeliest, i_point);
    if (outlier.chance < limit_ || (are_few() && model != SurfaceModel::Plane)) {
      outliers.push_back(std::move(outlier));
    } else {
      kept_.push_back(i_point);
    }
  }
  if (outliers.size() < aside_.size()) {
    std::ranges::sort(kept_);
    PANELCAL_TRY(found, fit_again(found));
  }
  PANELCAL_CHECK(check_noise(found));
  return doubted(std::move(found), std::move(outliers));
}

Expected<void> Sorting::check_noise(const SurfaceFit& found) const {
  const Place& from = points_[kept_.front()].from;
  if (!(found.noise_factor() <= most_noise_)) {
    return failure({Code::SurfaceOutOfTolerance,
                    from,
                    fmt::format("the probes are off the surface by {:.1f} times their sigma",
                                found.noise_factor()),
                    fmt::format("at most {:.1f} times", most_noise_)});
  }
  // Few probes that do not fit have a wide sigma, and a doubt.
  if (found.model() == SurfaceModel::Plane || are_few()) return {};
  PANELCAL_TRY(const SurfaceFit plane, fit(SurfaceModel::Plane));
  if (!(plane.noise_factor() > most_noise_) || !plane.left_out_rms()) return {};
  const double most = kHardlyBetter * *plane.left_out_rms();
  double missed = found.left_out_rms().value_or(0);
  if (!(missed > most)) return {};
  // A reading that another model predicts well is a surface, or one of the shapes of an average.
  for (const SurfaceModel model : {SurfaceModel::ThinPlate, SurfaceModel::GaussianProcess}) {
    PANELCAL_TRY(const SurfaceFit other, fit_scattered(model));
    missed = std::min(missed, other.left_out_rms().value_or(0));
    for (const ShapeShare& share : other.shapes()) {
      if (!(missed > most)) return {};
      PANELCAL_TRY(const SurfaceFit alone, fit_surface(kept_points(), model, share.shape));
      missed = std::min(missed, alone.left_out_rms().value_or(0));
    }
  }
  if (!(missed > most)) return {};
  return failure(
      {Code::SurfaceOutOfTolerance,
       from,
       fmt::format("probes left out are missed by {:.1f} sigma, hardly less than by a "
                   "plane, {:.1f}: many are outliers, or the surface is rougher than they "
                   "are dense",
                   missed,
                   *plane.left_out_rms()),
       fmt::format("at most {:g} times as much", kHardlyBetter)});
}

/// Probes that are searched together: all of them, or neighbours.
struct Together {
  Indices indices;
  std::vector<ProbePoint> points;
};

std::vector<Together> searched_together(std::span<const ProbePoint> points) {
  std::vector<Together> out;
  const std::size_t most = points.size() > kMostProbes ? kNeighbors : points.size();
  for (Indices& indices : internal::neighborhoods(points, most)) {
    std::vector<ProbePoint> some;
    for (const std::size_t i : indices) some.push_back(points[i]);
    // Neighbours in one line make no surface that could predict any of them.
    if (some.size() == points.size() || fit_surface(some, SurfaceModel::Plane)) {
      out.push_back({std::move(indices), std::move(some)});
    }
  }
  return out;
}

/// Grid models judge nothing themselves: a thin plate does.
Expected<SoundSurface> fit_grid(std::span<const ProbePoint> points,
                                SurfaceModel model,
                                const OutlierOptions& options) {
  // First what is wrong with the grid.
  PANELCAL_TRY(SurfaceFit found, fit_surface(points, model));
  for (const Together& some : searched_together(points)) {
    Sorting sorting(some.points, points.size(), options);
    PANELCAL_CHECK(sorting.search(SurfaceModel::ThinPlate));
    PANELCAL_TRY(const SoundSurface sound, sorting.judge(SurfaceModel::ThinPlate));
    if (sound.outliers.empty()) continue;
    const SurfaceOutlier& first = sound.outliers.front();
    return failure({Code::GridInvalid,
                    some.points[first.i_point].from,
                    first.text(),
                    fmt::format("a good probe at each node for a {} surface", name_of(model))});
  }
  Indices all(points.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  return SoundSurface{std::move(found), std::move(all), {}, {}};
}

}  // namespace

std::string name_of(const ProbePoint& point) {
  if (!point.name.empty()) return point.name;
  const Eigen::Vector2d p_mm = point.place.in_mm();
  return fmt::format("probe at ({:.3f}, {:.3f})", p_mm.x(), p_mm.y());
}

std::string SurfaceOutlier::text() const {
  return fmt::format("{} is {:.3f} mm {} the prediction of the others, {:.0f} sigma",
                     name,
                     std::abs(deviation.in_mm()),
                     deviation > mm(0) ? "above" : "below",
                     std::abs(deviation / sigma));
}

std::vector<PossibleBend> possible_bends(std::span<const ProbePoint> points,
                                         std::span<const std::size_t> kept,
                                         std::span<const SurfaceOutlier> outliers) {
  std::vector<PossibleBend> out;
  if (points.size() > kFewProbes) return out;
  std::vector<ProbePoint> others;
  for (const std::size_t i : kept) others.push_back(points[i]);
  for (const SurfaceOutlier& outlier : outliers) {
    const auto bend = possible_bend(points[outlier.i_point], outlier.deviation, others);
    if (bend) out.push_back(*bend);
  }
  return out;
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
  PANELCAL_CHECK(check_probes(points, model));
  const bool is_plane = model == SurfaceModel::Plane;
  const SurfaceModel searching = is_plane ? SurfaceModel::Plane : SurfaceModel::ThinPlate;
  if (is_of_grid(model)) return fit_grid(points, model, options);
  Sorting all(points, points.size(), options);
  if (all.are_few() && !is_plane) {
    PANELCAL_CHECK(all.search_few());
    return all.judge(model);
  }
  for (const Together& some : searched_together(points)) {
    Sorting sorting(some.points, points.size(), options);
    PANELCAL_CHECK(sorting.search(searching));
    for (const std::size_t i : sorting.aside()) {
      PANELCAL_CHECK(all.set_aside(some.indices[i]));
    }
  }
  return all.judge(model);
}

}  // namespace panelcal
