// SPDX-License-Identifier: Apache-2.0
#include "vision/round/profile/rim_profile.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <numeric>
#include <vector>

#include "vision/fit/regression.h"
#include "vision/round/profile/rim_blur.h"
#include "vision/round/profile/rim_circle.h"
#include "vision/round/profile/rim_shape.h"
#include "vision/round/profile/rim_waves.h"
#include "vision/round/profile/sector_turns.h"
#include "vision/round/profile/shift_filter.h"
#include "vision/round/profile/step_profile.h"
#include "vision/round/profile/strip.h"

namespace panelcal::internal {
namespace {

constexpr int kMaxRimPasses = 7;
constexpr int kFreePasses = 3;
constexpr double kUnsettledMove_px = 1.2;  // two sets of sectors farther apart are no one rim
constexpr double kSettledShape_px = 0.1;   // rms
constexpr double kSettledMove_px = 0.03;   // a smaller move leaves its square
/// A ring whose level is off by more of the contrast is something else: a hole, a mask's opening.
constexpr double kOtherRing = 0.1;
constexpr Eigen::Index kFewestStepRings = 7;
/// A sector's contrast beside the rim's: less is a track or something that covers it.
constexpr double kLeastSectorContrast = 0.5;
constexpr double kMostSectorContrast = 2.5;
/// The wide filter sees the rim where the narrow one does, within what that one leaves open:
/// farther off, it took something beside the rim for a part of it.
constexpr double kWideMove_px = 0.15;
constexpr double kWideMoveSigmas = 2;
constexpr double kMostWideMove_px = 0.6;
constexpr double kSharpSector_px = 0.2;  // sectors are judged together until they are as sure
constexpr int kMostSmoothed = 7;
/// If the surroundings are not flat, rims are as likely as not a little rough.
constexpr double kRoughChance = 0.5;
constexpr double kShortestOwnWave_px = 24;
constexpr double kMostBlurred = 4;     // px: narrow enough
constexpr double kLostByWide = 0.05;   // of the rim
constexpr double kUnevenBands = 0.1;   // a lamp lights the bands of an edge unevenly, as a sigma
constexpr double kDisagreement = 0.4;  // of the way from one to the other: the truth is between
constexpr double kMostDisagreement = 0.3;  // of the edge's sigma
/// Lobes are a wave that is far above noise and has most of what deviates. A triangle is rough.
constexpr int kFewestLobes = 4;
constexpr int kMostLobes = 8;
constexpr double kLobesOverFloor = 12;
constexpr double kLoneLobes = 1.2;
constexpr double kPureLobes = 10;
constexpr double kSurelyPure = 50;
constexpr double kAtCrests = 0.6;
constexpr double kOfSquare = 0.25;
constexpr double kDisplacedArc = 0.1;  // of the rim

/// Rings from the rim outwards and inwards as long as they are like the ones next to it. A camera
/// that sharpens draws a bright ring and a dark one along the edge itself: as many as a step takes
/// stay in any case.
void trim(const StepProfile& step, Eigen::ArrayXd& medians, RimStrip& strip) {
  const double limit = kOtherRing * std::abs(step.contrast());
  const double near = 2 * step.sigma_px + 0.7;
  const auto level_at = [&](double x) {
    const auto j = std::lround(x - strip.first_px);
    return medians[std::clamp<Eigen::Index>(j, 0, medians.size() - 1)];
  };
  const double inside = level_at(step.at_px + near);
  const double outside = level_at(step.at_px - near);
  Eigen::Index first = 0;
  Eigen::Index end = medians.size();
  // Where another step is known, the rings reach no farther than that.
  const auto has_other = [&](bool is_inside) {
    return std::ranges::any_of(step.others, [&](const OtherStep& other) {
      return (other.at_px > step.at_px) == is_inside;
    });
  };
  for (Eigen::Index j = has_other(false) ? 0 : medians.size(); j-- > 0;) {
    if (strip.at_px(j) < step.at_px - near && std::abs(medians[j] - outside) > limit) {
      first = j + 1;
      break;
    }
  }
  for (Eigen::Index j = 0; j < medians.size() && !has_other(true); ++j) {
    if (strip.at_px(j) > step.at_px + near && std::abs(medians[j] - inside) > limit) {
      end = j;
      break;
    }
  }
  if (end - first < kFewestStepRings) {
    const auto middle = static_cast<Eigen::Index>(std::lround(step.at_px - strip.first_px));
    first = std::min(first, std::max<Eigen::Index>(0, middle - kFewestStepRings / 2));
    end = std::max(end, std::min(medians.size(), middle + kFewestStepRings / 2 + 1));
  }
  if (first == 0 && end == medians.size()) return;
  strip.first_px += static_cast<double>(first);
  strip.mean = strip.mean.middleRows(first, end - first).eval();
  strip.mass = strip.mass.segment(first, end - first).eval();
  medians = medians.segment(first, end - first).eval();
}

/// Each sector's contrast beside the whole rim's, of three neighbours together.
Eigen::ArrayXd sector_contrasts(const RimStrip& strip,
                                const StepProfile& step,
                                const Eigen::ArrayXXf& left) {
  constexpr double kNearRings = 4;
  const Eigen::Index n = strip.n_sectors();
  const double foot = 1.5 * step.sigma_px + 0.5;
  // Distances from the step, outwards and inwards; towards another step, those in the middle.
  double from[2] = {foot, foot};
  double to[2] = {foot + kNearRings, foot + kNearRings};
  for (const OtherStep& other : step.others) {
    const std::size_t side = other.at_px > step.at_px ? 1 : 0;
    const double half = 0.5 * std::abs(other.at_px - step.at_px);
    from[side] = std::min(foot, half - 0.5);
    to[side] = std::min(to[side], half + 0.5);
  }
  Eigen::ArrayXd inside = Eigen::ArrayXd::Zero(n);
  Eigen::ArrayXd outside = Eigen::ArrayXd::Zero(n);
  double n_inside = 0;
  double n_outside = 0;
  for (Eigen::Index j = 0; j < strip.n_rings(); ++j) {
    const double x = strip.at_px(j) - step.at_px;
    const std::size_t side = x > 0 ? 1 : 0;
    if (std::abs(x) < from[side] || std::abs(x) > to[side]) continue;
    (x > 0 ? inside : outside) += left.row(j).transpose().cast<double>();
    (x > 0 ? n_inside : n_outside) += 1;
  }
  if (n_inside == 0 || n_outside == 0) return Eigen::ArrayXd::Ones(n);
  const Eigen::ArrayXd ratio = 1 + (inside / n_inside - outside / n_outside) / step.contrast();
  Eigen::ArrayXd smooth(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    smooth[i] = (ratio[(i + n - 1) % n] + ratio[i] + ratio[(i + 1) % n]) / 3;
  }
  return smooth;
}

/// Variance of a pixel's noise, from sectors that share no pixel.
double pixel_variance(const RimStrip& strip, const Eigen::ArrayXXf& left) {
  const Eigen::Index n = left.cols();
  double sum = 0;
  for (Eigen::Index j = 0; j < left.rows(); ++j) {
    const auto a = left.row(j).head(n - 2);
    const auto b = left.row(j).tail(n - 2);
    // Two thirds of a cell's variance are left of a pixel's, over its mass, by sharing out.
    sum += 0.5 * 1.5 * strip.mass[j] * static_cast<double>((a - b).square().mean());
  }
  return std::max(1.0 / 12, sum / static_cast<double>(left.rows()));
}

/// The measurement in one place, and what it says of the next.
struct Pass {
  RimStrip strip;
  StepProfile step;
  ShiftFilter filter;
  RimCircle circle;
  Eigen::ArrayXXf left;      ///< the strip less each ring's median
  Eigen::ArrayXd contrasts;  ///< of sectors, beside the whole rim's
  Eigen::VectorXd deviations;
  std::vector<char> usable;  ///< sectors that show a step
  double move_px = 0;
  double band_shift_px = 0;  ///< of the mean edge's own bands, at most

  double n_used() const {
    return std::max(1.0, circle.used() * static_cast<double>(strip.n_sectors()));
  }
  /// Response of a filter for each sector.
  Eigen::VectorXd by_sector(const ShiftFilter& measure) const {
    return (left.matrix().transpose().cast<double>() * measure.weights).array() /
           contrasts.max(kLeastSectorContrast).min(kMostSectorContrast);
  }
};

class RimMeasurement {
 public:
  RimMeasurement(RimWindow& window, const RimSearch& search)
      : window_(window), search_(search), p_(search.start) {}

  std::optional<RimProfile> run() {
    for (int i = 0; i < kMaxRimPasses; ++i) {
      if (!look(Width::Narrow) && (i > 0 || !look(Width::All))) return std::nullopt;
      move(i < kFreePasses ? 1 : 0.5);
      if (!is_near()) return std::nullopt;
      const bool is_straight = follow_shape();
      if (pass_.move_px < kSettledMove_px && is_straight) break;
    }
    look_wide();
    return finished();
  }

 private:
  /// Narrow: the step and a little of what is beside it, whatever lies farther off. All: as far as
  /// is searched, where the start is so far off that the step lies beyond. Wide: the same, with a
  /// filter that knows from the texture beside the rim what it does at the rim.
  enum class Width { Narrow, All, Wide };

  /// The filter that is surer of the center counts.
  void look_wide() {
    const Pass narrow = pass_;
    const auto use = use_;
    const bool is_seen = look(Width::Wide);
    if (is_seen && pass_.circle.arc >= search_.least_used) {
      // Two filters that see one rim in different places see something else beside it.
      const double by_noise = 2 * (narrow.filter.variance * narrow.circle.unit_cov.trace() +
                                   pass_.filter.variance * pass_.circle.unit_cov.trace());
      disagreement_px2_ = std::clamp(pass_.circle.shift_px.squaredNorm() - by_noise,
                                     0.0,
                                     std::pow(kMostDisagreement * narrow.step.sigma_px, 2));
    }
    if (is_seen && is_better(pass_, narrow)) {
      p_.head<2>() += pass_.strip.unit * pass_.circle.shift_px;
      pass_.move_px = pass_.circle.shift_px.norm();
      return;
    }
    pass_ = narrow;
    use_ = use;
  }

  /// True if the wide filter is surer and not at odds with the narrow one.
  bool is_better(const Pass& wide, const Pass& narrow) const {
    if (wide.circle.seen < narrow.circle.seen - kLostByWide) return false;
    const double variance = stated_variance(narrow);
    const double most2 = kWideMove_px * kWideMove_px + kWideMoveSigmas * kWideMoveSigmas * variance;
    return wide.circle.shift_px.squaredNorm() <
               std::min(most2, kMostWideMove_px * kMostWideMove_px) &&
           stated_variance(wide) < variance;
  }

  double stated_variance(const Pass& pass) const {
    const Eigen::VectorXd left = residuals_about_circle(pass.deviations, pass.circle.use);
    return waves_of(pass, own_waves(left, pass.circle.use)).first * pass.circle.unit_cov.trace();
  }

  /// Of two periods and more, down to a length.
  std::vector<double> own_waves(const Eigen::VectorXd& left, const std::vector<char>& use) const {
    const double around_px = 2 * std::numbers::pi * p_[kRadius] / pass_.strip.unit;
    const int last = std::clamp(static_cast<int>(around_px / kShortestOwnWave_px), 7, 24);
    return wave_powers(left, use, 2, last);
  }

  static RimWaves waves_of(const Pass& pass, const std::vector<double>& powers) {
    return extrapolate_waves(powers, pass.filter.variance, kRoughChance);
  }

  bool look(Width width) {
    double outer = search_.outer_px;
    double inner = search_.inner_px;
    if (width == Width::Narrow) {
      const double narrow = 2.5 * std::min(p_[kSigma], kMostBlurred) + 4;
      outer = std::min(outer, narrow);
      inner = std::min(inner, narrow);
    }
    window_.collect_band(p_, std::max(outer, inner) + 1, 1);
    if (window_.band().size() < 40) return false;
    // The next pass uses what one pass finds of a sector, whatever the radius has become.
    pass_.strip = unroll(window_, p_, outer, inner, pass_.strip.n_sectors(), shape_);
    RimStrip& strip = pass_.strip;
    if (strip.seen < 0.5) return false;
    Eigen::ArrayXd medians = ring_medians(strip, use_);
    if (search_.ring_radius > 0) {
      const double expected_px = (p_[kRadius] - search_.ring_radius) / strip.unit;
      keep_nearest_edge(expected_px, search_.ring_px, search_.sign, medians, strip);
    }
    StepProfile start;
    start.sigma_px = p_[kSigma];
    for (const double other_px : strip.others_px) start.others.push_back({other_px, 0});
    if (!fit(medians, start)) return false;
    trim(pass_.step, medians, strip);
    const auto n_others = static_cast<Eigen::Index>(pass_.step.others.size());
    if (strip.n_rings() < kFewestStepRings + 2 * n_others) return false;
    if (!fit(medians, pass_.step)) return false;
    const Eigen::ArrayXXf& left = pass_.left = strip.mean.colwise() - medians.cast<float>();
    pass_.filter = width == Width::Wide
                       ? make_shift_filter(strip, left, pass_.step)
                       : make_plain_filter(strip, pass_.step, pixel_variance(strip, left));
    if (!(pass_.filter.variance > 0)) return false;
    pass_.band_shift_px = band_shift(strip, medians, pass_.step, pass_.filter);
    pass_.contrasts = sector_contrasts(strip, pass_.step, left);
    pass_.deviations = pass_.by_sector(pass_.filter);
    if (shape_.size() > 0) pass_.deviations += shape_;
    fit_circle(pass_.contrasts);
    use_ = pass_.circle.used() > 0.3 ? pass_.circle.use : std::vector<char>{};
    return true;
  }

  /// The next pass unrolls the band along the rim's own shape; true if it is that of this pass.
  bool follow_shape() {
    // Rims that are to be round gain nothing: it would only add noise.
    if (search_.own_shape == 0) return true;
    const Eigen::VectorXd left = residuals_about_circle(pass_.deviations, pass_.circle.use);
    Eigen::VectorXd shape = rim_shape(left, pass_.usable, pass_.filter.variance);
    const double change2 = shape_.size() > 0 ? (shape - shape_).squaredNorm() : shape.squaredNorm();
    shape_ = std::move(shape);
    return change2 < kSettledShape_px * kSettledShape_px * static_cast<double>(shape_.size());
  }

  void fit_circle(const Eigen::ArrayXd& contrasts) {
    pass_.usable.assign(static_cast<std::size_t>(contrasts.size()), 0);
    for (Eigen::Index i = 0; i < contrasts.size(); ++i) {
      pass_.usable[static_cast<std::size_t>(i)] =
          contrasts[i] > kLeastSectorContrast && contrasts[i] < kMostSectorContrast;
    }
    const double sigma = std::sqrt(pass_.filter.variance);
    const int n_together = static_cast<int>(std::ceil(
        std::min<double>(kMostSmoothed, sigma * sigma / (kSharpSector_px * kSharpSector_px))));
    pass_.circle = fit_rim_circle(pass_.deviations,
                                  pass_.usable,
                                  n_together | 1,
                                  search_.least_used,
                                  0.7 * sigma,
                                  search_.own_shape * p_[kRadius] / pass_.strip.unit);
  }

  bool fit(const Eigen::ArrayXd& medians, const StepProfile& start) {
    const auto step = fit_step(medians, pass_.strip.first_px, start);
    if (!step || !(step->contrast() * search_.sign > search_.least_contrast)) return false;
    pass_.step = *step;
    return true;
  }

  /// In     share: of the way; whole steps may go to and fro between two sets of sectors
  void move(double share) {
    const double unit = pass_.strip.unit;
    const double grown = -pass_.step.at_px;
    p_.head<2>() += share * unit * pass_.circle.shift_px;
    p_[kRadius] += share * unit * grown;
    p_[kSigma] =
        std::sqrt(std::max(0.1, pass_.step.sigma_px * pass_.step.sigma_px - kCellVariance));
    pass_.move_px = std::max(pass_.circle.shift_px.norm(), std::abs(grown));
  }

  bool is_near() const {
    const double limit = std::max(2.0, search_.far * search_.start[kRadius]);
    return p_.allFinite() && (p_.head<2>() - search_.start.head<2>()).norm() < limit &&
           std::abs(p_[kRadius] - search_.start[kRadius]) < limit && p_[kRadius] > 1;
  }

  RimProfile finished() const {
    RimProfile profile;
    profile.parameters = p_;
    const double radius_px = p_[kRadius] / pass_.strip.unit;
    // A convex rim blurs inwards (edge_profile.h).
    profile.parameters[kRadius] += 0.5 * pass_.strip.unit * p_[kSigma] * p_[kSigma] / radius_px;
    profile.parameters[kLevel] = pass_.step.outside;
    profile.parameters[kContrast] = pass_.step.contrast();
    profile.parameters[kOval] = pass_.circle.oval_px.x() / radius_px;
    profile.parameters[kOvalDiagonal] = pass_.circle.oval_px.y() / radius_px;
    profile.used = pass_.circle.seen;
    profile.arc = pass_.circle.arc;
    profile.oval_sigma = oval_sigma(radius_px);
    profile.is_settled = pass_.move_px < kUnsettledMove_px;
    add_covariance(radius_px, profile);
    add_likeness(profile);
    return profile;
  }

  /// By noise, and of a rim that is not smooth: as much as the next waves have.
  double oval_sigma(double radius_px) const {
    const std::vector<char>& use = pass_.circle.use;
    const Eigen::VectorXd left = residuals_about_circle(pass_.deviations, use);
    const std::vector<double> powers = wave_powers(left, use, 3, 5);
    const double power = std::accumulate(powers.begin(), powers.end(), 0.0) / 3;
    return std::sqrt(2 * std::max(power, pass_.filter.variance) / pass_.n_used()) / radius_px;
  }

  void add_covariance(double radius_px, RimProfile& profile) const {
    // A long arc that lies elsewhere may be the right one.
    const bool is_displaced = pass_.circle.displaced > kDisplacedArc;
    const auto& use = is_displaced ? pass_.usable : pass_.circle.use;
    const Eigen::VectorXd left = residuals_about_circle(pass_.deviations, use);
    const auto n = static_cast<double>(left.size());
    const std::vector<double> powers = own_waves(left, use);
    double squares = 0;
    for (const double power : powers) squares += 2 / n * (power - pass_.filter.variance);
    const RimWaves waves = waves_of(pass_, powers);
    const double unit = pass_.strip.unit;
    profile.center_cov = unit * unit * waves.first * pass_.circle.unit_cov;
    profile.center_cov +=
        std::pow(kDisagreement * unit, 2) * disagreement_px2_ * Eigen::Matrix2d::Identity();
    // If it goes to and fro, the truth may be at either end.
    if (pass_.move_px > kSettledMove_px) {
      profile.center_cov += std::pow(unit * pass_.move_px, 2) * Eigen::Matrix2d::Identity();
    }
    profile.center_cov += unit * unit * std::pow(kDisagreement, 2) * pass_.circle.doubt_px *
                          pass_.circle.doubt_px.transpose();
    profile.center_cov += unit * unit * blur_cov();
    profile.center_cov +=
        std::pow(kUnevenBands * unit * pass_.band_shift_px, 2) * Eigen::Matrix2d::Identity();
    add_lobes(radius_px, profile);
    profile.roughness = std::sqrt(std::max(0.0, squares)) / radius_px;
  }

  Eigen::Matrix2d blur_cov() const {
    const double pixel = pixel_variance(pass_.strip, pass_.left);
    const Eigen::VectorXd blurs = pass_.by_sector(make_blur_filter(pass_.strip, pass_.step, pixel));
    return hidden_by_blur(blurs, pass_.circle.use, pass_.step.sigma_px);
  }

  /// Of every sector that shows an edge: a polygon's corners are no debris. If those that show none
  /// lie at the crests of a pure wave, they are corners too, and about the fourth power of the
  /// share with an edge is left of the wave.
  void add_lobes(double radius_px, RimProfile& profile) const {
    const Eigen::VectorXd left = residuals_about_circle(pass_.deviations, pass_.usable);
    const auto n = static_cast<double>(left.size());
    const std::vector<double> powers = wave_powers(left, pass_.usable, 0, kMostLobes);
    const double all = std::accumulate(powers.begin() + kFewestLobes - 1, powers.end(), 0.0);
    const auto largest = std::max_element(powers.begin() + kFewestLobes, powers.end());
    if (*largest < kLobesOverFloor * pass_.filter.variance) return;
    auto n_lobes = static_cast<std::size_t>(largest - powers.begin());
    // A square's corners, where they are cut off, make as much of eight waves as of four.
    if (n_lobes == 8 && powers[4] > kOfSquare * powers[8]) n_lobes = 4;
    const double own = powers[n_lobes] + (n_lobes == 4 ? powers[8] : 0);
    if (own < kLoneLobes * (all - own)) return;
    profile.n_lobes = static_cast<int>(n_lobes);
    profile.lobes = 2 * std::sqrt(own / n) / radius_px;
    if (own < std::max(kPureLobes * (all - own), kSurelyPure * pass_.filter.variance)) return;
    if (crest_of_unseen(left, profile.n_lobes) < kAtCrests) return;
    const auto n_usable = static_cast<double>(std::ranges::count(pass_.usable, 1));
    profile.lobes /= std::pow(n_usable / n, 4);
  }

  /// Mean height on a wave of the sectors that show no edge: 1 at its crests.
  double crest_of_unseen(const Eigen::VectorXd& left, int n_periods) const {
    std::complex<double> wave = 0;
    std::complex<double> unseen = 0;
    double n_unseen = 0;
    for (Eigen::Index i = 0; i < left.size(); ++i) {
      const auto turn = std::polar(1.0, n_periods * pass_.strip.angle_rad(i));
      const bool is_usable = pass_.usable[static_cast<std::size_t>(i)] != 0;
      (is_usable ? wave : unseen) += is_usable ? left[i] * turn : turn;
      n_unseen += is_usable ? 0 : 1;
    }
    if (n_unseen == 0 || std::abs(wave) == 0) return 0;
    return (wave * std::conj(unseen)).real() / std::abs(wave) / n_unseen;
  }

  /// The correlation over the sectors that are used.
  void add_likeness(RimProfile& profile) const {
    const RimStrip& strip = pass_.strip;
    Regression sums;
    double white = 0;
    for (Eigen::Index j = 0; j < strip.n_rings(); ++j) {
      const double model = pass_.step.level(strip.at_px(j));
      for (Eigen::Index i = 0; i < strip.n_sectors(); ++i) {
        if (!pass_.circle.use[static_cast<std::size_t>(i)]) continue;
        const auto seen = static_cast<double>(strip.mean(j, i));
        const auto next = static_cast<double>(strip.mean(j, (i + 2) % strip.n_sectors()));
        sums.add(model, seen);
        white += 0.5 * (seen - next) * (seen - next);
      }
    }
    if (sums.n < 2) return;
    white /= sums.n;
    profile.noise = std::sqrt(white * strip.mass.mean());
    profile.correlation = sums.correlation(white);
  }

  static constexpr double kCellVariance = 1.0 / 6;  ///< of sharing pixels out linearly

  RimWindow& window_;
  const RimSearch& search_;
  RimVector p_;
  std::vector<char> use_;
  Pass pass_;
  Eigen::VectorXd shape_;  ///< that the strip follows; empty: a circle
  double disagreement_px2_ = 0;
};

}  // namespace

std::optional<RimProfile> measure_rim(RimWindow& window, const RimSearch& search) {
  return RimMeasurement(window, search).run();
}

}  // namespace panelcal::internal
