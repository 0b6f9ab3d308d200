// SPDX-License-Identifier: Apache-2.0
#include "vision/locate/focus.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Samples below this share of the greatest sharpness are no part of the peak.
constexpr double kPeakShare = 0.5;
constexpr std::size_t kMinSamples = 5;
/// The curve has to bend upwards by this number of its sigmas.
constexpr double kMinSignificance = 5;

std::optional<FocusPeak> no_peak(std::string* reason, std::string text) {
  if (reason) *reason = std::move(text);
  return std::nullopt;
}

/// 1 / sharpness^2 = p0 + p1 t + p2 t^2, t in half widths of the fitted range about its middle.
struct Parabola {
  Eigen::Vector3d p;
  Eigen::Matrix3d cov;
};

Parabola fit_parabola(const std::vector<Eigen::Vector2d>& t_and_sharpness) {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  const auto row_of = [](double t) { return Eigen::Vector3d(1, t, t * t); };
  // d(1 / s^2) = -2 ds / s^3
  const auto weight_of = [](double s) { return 0.25 * std::pow(s, 6); };
  for (const Eigen::Vector2d& v : t_and_sharpness) {
    const Eigen::Vector3d row = row_of(v.x());
    information += weight_of(v.y()) * row * row.transpose();
    right += weight_of(v.y()) * row / (v.y() * v.y());
  }
  const Eigen::LDLT<Eigen::Matrix3d> solver(information);
  Parabola fit;
  fit.p = solver.solve(right);
  double chi_square = 0;
  for (const Eigen::Vector2d& v : t_and_sharpness) {
    const double residual = 1 / (v.y() * v.y()) - row_of(v.x()).dot(fit.p);
    chi_square += weight_of(v.y()) * residual * residual;
  }
  const double n_free = static_cast<double>(t_and_sharpness.size()) - 3;
  fit.cov = chi_square / n_free * solver.solve(Eigen::Matrix3d::Identity());
  return fit;
}

/// The variance of an error over its sigma where that was estimated by n_free degrees of freedom;
/// with two, which have none, what makes 1.96 sigma hold 95 %.
double student_variance(std::size_t n_free) {
  const auto nu = static_cast<double>(n_free);
  return nu > 2 ? nu / (nu - 2) : 4.8;
}

}  // namespace

double sharpness(const Image& image) {
  const int w = image.width();
  const int h = image.height();
  if (w < 4 || h < 4) return 0;
  double sum = 0;
  double level = 0;
  for (int y = 1; y < h - 2; ++y) {
    const auto above = image.row(y - 1);
    const auto row = image.row(y);
    const auto below = image.row(y + 1);
    double of_row = 0;
    for (int x = 1; x < w - 2; ++x) {
      const auto i = static_cast<std::size_t>(x);
      const float gx = row[i + 1] - row[i - 1];
      const float gx_below = below[i + 1] - below[i - 1];
      const float gy = below[i] - above[i];
      const float gy_right = below[i + 1] - above[i + 1];
      of_row += static_cast<double>(gx * gx_below + gy * gy_right);
      level += static_cast<double>(row[i]);
    }
    sum += of_row;
  }
  const double n = static_cast<double>(w - 3) * (h - 3);
  const double mean = level / n;
  return mean > 0 ? sum / (n * mean * mean) : 0;
}

std::optional<FocusPeak> fit_focus_peak(std::span<const FocusSample> samples, std::string* reason) {
  std::vector<FocusSample> sorted;
  for (const FocusSample& s : samples) {
    if (std::isfinite(s.sharpness) && std::isfinite(s.z.in_mm())) sorted.push_back(s);
  }
  std::ranges::sort(sorted, {}, [](const FocusSample& s) { return s.z.in_mm(); });
  if (sorted.size() < kMinSamples) {
    return no_peak(reason, fmt::format("{} heights are too few for a curve", sorted.size()));
  }
  const auto best = std::ranges::max_element(sorted, {}, &FocusSample::sharpness);
  if (!(best->sharpness > 0)) return no_peak(reason, "nothing is to be seen at any height");
  // The flanks end where the curve first falls below the share: a second mark may be sharp at
  // another height.
  auto first = best;
  auto last = best;
  const double least = kPeakShare * best->sharpness;
  while (first != sorted.begin() && std::prev(first)->sharpness >= least) --first;
  while (std::next(last) != sorted.end() && std::next(last)->sharpness >= least) ++last;
  const double low_mm = first->z.in_mm();
  const double high_mm = last->z.in_mm();
  const double middle_mm = 0.5 * (low_mm + high_mm);
  const double half_mm = 0.5 * (high_mm - low_mm);
  std::vector<Eigen::Vector2d> points;
  for (auto s = first; s != std::next(last); ++s) {
    points.emplace_back((s->z.in_mm() - middle_mm) / half_mm, s->sharpness / best->sharpness);
  }
  if (points.size() < kMinSamples || !(half_mm > 0)) {
    return no_peak(reason,
                   fmt::format("only {} of {} heights {} near the sharpest, too few for a curve",
                               points.size(),
                               sorted.size(),
                               points.size() == 1 ? "is" : "are"));
  }
  const Parabola fit = fit_parabola(points);
  const double bend = fit.p(2);
  if (!fit.p.allFinite() || !(bend > kMinSignificance * std::sqrt(fit.cov(2, 2)))) {
    return no_peak(reason, "no height is clearly sharper than the others");
  }
  const double t = -fit.p(1) / (2 * bend);
  if (std::abs(t) > 1) {
    return no_peak(
        reason,
        fmt::format("the pictures get sharper towards z = {:.4f} mm, the end of the range",
                    t > 0 ? high_mm : low_mm));
  }
  const Eigen::Vector3d gradient(0, -1 / (2 * bend), fit.p(1) / (2 * bend * bend));
  const double floor = fit.p(0) - bend * t * t;  // 1 / sharpness^2 at the peak
  FocusPeak peak;
  peak.z = mm(middle_mm + half_mm * t);
  const double variance = student_variance(points.size() - 3);
  peak.sigma = mm(half_mm * std::sqrt(variance * gradient.dot(fit.cov * gradient)));
  peak.half_depth = mm(half_mm * std::sqrt(std::max(0.0, floor / bend)));
  return peak;
}

}  // namespace panelcal
