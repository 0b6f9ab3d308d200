// SPDX-License-Identifier: Apache-2.0
#include "vision/round/model/window.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "vision/fit/search_area.h"

namespace panelcal::internal {
namespace {

/// Lens distortion moves the box of a disc by less than this part of its radius.
constexpr double kBoxSlack = 0.05;
/// A flat zone with a larger part of its pixels clipped is not summed up.
constexpr double kClippedShare = 0.002;

Eigen::Vector2d image_center(const FitFrame& frame, const RimVector& start) {
  return frame.to_image(start.head<2>()).value_or(Eigen::Vector2d::Zero());
}

/// Part of a row of pixels within a distance of a centre: |A (u - u0)| <= distance.
struct Chord {
  double middle = 0;
  double half = -1;  ///< below 0: nowhere
};

Chord chord_of(const Eigen::Matrix2d& metric, double dy, double distance) {
  // a x^2 + 2 b x + c = distance^2, x relative to the centre.
  const double a = metric(0, 0);
  const double b = metric(0, 1) * dy;
  const double c = metric(1, 1) * dy * dy;
  const double discriminant = b * b - a * (c - distance * distance);
  if (distance <= 0 || discriminant < 0) return {};
  return {-b / a, std::sqrt(discriminant) / a};
}

}  // namespace

RimWindow::RimWindow(const Image& image,
                     const FitFrame& frame,
                     const RimVector& start,
                     double outside_px,
                     bool is_ring)
    : image_(&image),
      patch_(frame,
             image_center(frame, start),
             std::max(4.0, (1 + kBoxSlack) * (start[kRadius] + outside_px))),
      is_ring_(is_ring),
      outer_(start[kRadius] + outside_px),
      unit_px_(std::max(1.0, start[kRadius])) {
  const Eigen::Vector2d& u = patch_.center_px();
  const double half = outer_ * (1 + kBoxSlack) + 1;
  const Eigen::Vector2d reach = Eigen::Vector2d::Constant(half);
  const PixelBox box = pixels_between(u - reach, u + reach, image);
  x0_ = box.x0;
  y0_ = box.y0;
  width_ = box.width;
  height_ = box.height;
  middle_ = u - Eigen::Vector2d(x0_, y0_);
  reference_ = static_cast<float>(start[kLevel]);
  may_be_clipped_ = false;
  for (int y = 0; y < height_ && width_ > 0 && !may_be_clipped_; ++y) {
    may_be_clipped_ = !is_unclipped(row(y), width_);
  }
  ramp_ = Eigen::ArrayXf::LinSpaced(
      std::max(1, width_), 0.0F, static_cast<float>(std::max(1, width_) - 1));
}

namespace {

/// First pixel of a stretch of a row and the one past its last.
struct Stretch {
  int x0 = 0;
  int x1 = 0;

  bool contains(int x) const { return x >= x0 && x < x1; }
};

Stretch stretch_of(const Chord& chord, double center_x, int width) {
  if (chord.half < 0) return {};
  const double low = center_x + chord.middle - chord.half;
  const double high = center_x + chord.middle + chord.half;
  const auto clamped = [&](double v) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(width)));
  };
  return {clamped(std::ceil(low)), clamped(std::floor(high) + 1)};
}

}  // namespace

void RimWindow::make_spans(const RimVector& p, double reach_px) {
  spans_.clear();
  const Eigen::Matrix2d& a = patch_.center_jacobian();
  const Eigen::Matrix2d metric = a.transpose() * a;
  const double det = a(0, 0) * a(1, 1) - a(0, 1) * a(1, 0);
  Eigen::Matrix2d px_from_frame;
  px_from_frame << a(1, 1), -a(0, 1), -a(1, 0), a(0, 0);
  px_from_frame /= det;
  const double per_px = std::sqrt(std::abs(det));
  // Zones are told apart by the frame's linear part, so that what it bends is added to the reach.
  const double bend = patch_.bend(p[kRadius] / per_px);
  const double oval = std::hypot(p[kOval], p[kOvalDiagonal]) * p[kRadius];
  const double reach = reach_px * per_px + 2 * bend + oval;
  const Eigen::Vector2d center_frame(p[kCenterX], p[kCenterY]);
  const Eigen::Vector2d center = middle_ + px_from_frame * (center_frame - patch_.center_place());
  const Eigen::Vector2d hole = center + px_from_frame * Eigen::Vector2d(p[kHoleX], p[kHoleY]);

  for (int y = 0; y < height_; ++y) {
    const auto stretch = [&](const Eigen::Vector2d& at, double radius) {
      return stretch_of(chord_of(metric, y - at.y(), radius), at.x(), width_);
    };
    const Stretch window = stretch(middle_, outer_);
    if (window.x0 >= window.x1) continue;
    std::array<Stretch, 4> rims = {stretch(center, p[kRadius] + reach),
                                   stretch(center, p[kRadius] - reach)};
    std::size_t n_rims = 2;
    if (is_ring_) {
      rims[n_rims++] = stretch(hole, p[kInnerRadius] + reach);
      rims[n_rims++] = stretch(hole, p[kInnerRadius] - reach);
    }
    std::array<int, 10> ends = {window.x0, window.x1};
    std::size_t n_ends = 2;
    for (std::size_t i = 0; i < n_rims; ++i) {
      ends[n_ends++] = std::clamp(rims[i].x0, window.x0, window.x1);
      ends[n_ends++] = std::clamp(rims[i].x1, window.x0, window.x1);
    }
    std::sort(ends.begin(), ends.begin() + static_cast<std::ptrdiff_t>(n_ends));
    for (std::size_t i = 0; i + 1 < n_ends; ++i) {
      const int x = ends[i];
      if (x == ends[i + 1]) continue;
      RimSpan span{y, x, ends[i + 1], RimZone::Outside, false};
      const bool in_inner_band = is_ring_ && rims[2].contains(x) && !rims[3].contains(x);
      span.is_band = (rims[0].contains(x) && !rims[1].contains(x)) || in_inner_band;
      if (rims[1].contains(x)) span.zone = RimZone::Target;
      if (is_ring_ && rims[3].contains(x) && rims[1].contains(x)) span.zone = RimZone::Hole;
      spans_.push_back(span);
    }
  }
}

std::array<bool, kRimZones> RimWindow::clipped_zones() const {
  if (!may_be_clipped_) return {};
  std::array<double, kRimZones> n{};
  std::array<double, kRimZones> n_clipped{};
  const float full = static_cast<float>(full_scale());
  for (const RimSpan& span : spans_) {
    if (span.is_band) continue;
    const auto zone = static_cast<std::size_t>(span.zone);
    const Eigen::Map<const Eigen::ArrayXf> values(row(span.y) + span.x0, span.x1 - span.x0);
    n[zone] += static_cast<double>(values.size());
    if (is_unclipped(values.data(), values.size())) continue;
    n_clipped[zone] += static_cast<double>((values >= full || values <= 0).count());
  }
  std::array<bool, kRimZones> clipped{};
  for (std::size_t i = 0; i < kRimZones; ++i) clipped[i] = n_clipped[i] > kClippedShare * n[i];
  return clipped;
}

void RimWindow::add_flat(const RimSpan& span) {
  FlatMoments& moments = flat_[static_cast<std::size_t>(span.zone)];
  const Eigen::Index count = span.x1 - span.x0;
  const Eigen::Map<const Eigen::ArrayXf> values(row(span.y) + span.x0, count);
  const double n = static_cast<double>(count);
  const double sum_v = static_cast<double>((values - reference_).sum());
  const double sum_kv = static_cast<double>(((values - reference_) * ramp_.head(count)).sum());
  // x = u0 + k / unit for k = 0 .. n - 1.
  const Eigen::Vector2d first = plane_at(span.x0, span.y);
  const double step = 1 / unit_px_;
  const double sum_k = 0.5 * n * (n - 1);
  const double sum_kk = n * (n - 1) * (2 * n - 1) / 6;
  const double sum_x = n * first.x() + step * sum_k;
  const double sum_xx =
      n * first.x() * first.x() + 2 * step * first.x() * sum_k + step * step * sum_kk;
  const double y = first.y();
  moments.n += n;
  moments.bb += (Eigen::Matrix3d() << n,
                 sum_x,
                 n * y,  //
                 sum_x,
                 sum_xx,
                 sum_x * y,  //
                 n * y,
                 sum_x * y,
                 n * y * y)
                    .finished();
  moments.bv += Eigen::Vector3d(sum_v, first.x() * sum_v + step * sum_kv, y * sum_v);
}

void RimWindow::add_row(int y, int x0, int x1) {
  const auto n = static_cast<std::size_t>(x1 - x0);
  const std::size_t first = band_.grow(n);
  const auto at = static_cast<std::ptrdiff_t>(first);
  const Eigen::Vector2d plane = plane_at(x0, y);
  RimBand::set_ramp(band_.plane_x, first, n, plane.x(), 1 / unit_px_);
  RimBand::set_ramp(band_.plane_y, first, n, plane.y(), 0);
  const float* const values = row(y) + x0;
  std::copy_n(values, n, band_.value.begin() + at);
  std::iota(band_.x.begin() + at, band_.x.end(), static_cast<std::int16_t>(x0));
  std::fill_n(band_.y.begin() + at, n, static_cast<std::int16_t>(y));
  const FramePatch::Row frame = patch_.row(y0_ + y);
  if (patch_.is_plain()) {
    const Eigen::Vector2d place = frame.at(x0_ + x0).place;
    RimBand::set_ramp(band_.at_x, first, n, place.x(), 1);
    RimBand::set_ramp(band_.at_y, first, n, place.y(), 0);
  } else {
    for (std::size_t k = 0; k < n; ++k) {
      const auto here = frame.at(x0_ + x0 + static_cast<int>(k));
      const std::size_t i = first + k;
      band_.at_x[i] = static_cast<float>(here.place.x());
      band_.at_y[i] = static_cast<float>(here.place.y());
      band_.j00[i] = static_cast<float>(here.jacobian(0, 0));
      band_.j01[i] = static_cast<float>(here.jacobian(0, 1));
      band_.j10[i] = static_cast<float>(here.jacobian(1, 0));
      band_.j11[i] = static_cast<float>(here.jacobian(1, 1));
    }
  }
  if (!may_be_clipped_ || is_unclipped(values, static_cast<Eigen::Index>(n))) return;
  band_.has_clipped = true;
  const auto full = static_cast<float>(full_scale());
  for (std::size_t k = 0; k < n; ++k) {
    if (values[k] >= full) band_.clipped[first + k] = 1;
    if (values[k] <= 0) band_.clipped[first + k] = -1;
  }
}

bool RimWindow::is_unclipped(const float* values, Eigen::Index n) const {
  const Eigen::Map<const Eigen::ArrayXf> all(values, n);
  const auto half = static_cast<float>(0.5 * full_scale());
  return (all - half).abs().maxCoeff() < half;
}

void RimWindow::collect(const RimVector& p, double reach_px, int stride) {
  collect_band(p, reach_px, stride);
  flat_.fill({});
  for (const RimSpan& span : spans_) {
    if (!span.is_band) add_flat(span);
  }
}

void RimWindow::collect_band(const RimVector& p, double reach_px, int stride) {
  make_spans(p, reach_px);
  const std::array<bool, kRimZones> clipped = clipped_zones();
  for (RimSpan& span : spans_) {
    if (clipped[static_cast<std::size_t>(span.zone)]) span.is_band = true;
  }
  std::size_t n_band = 0;
  for (const RimSpan& span : spans_) {
    if (span.is_band && span.y % stride == 0) n_band += static_cast<std::size_t>(span.x1 - span.x0);
  }
  band_.clear(!patch_.is_plain());
  band_.reserve(n_band);
  for (const RimSpan& span : spans_) {
    if (span.is_band && span.y % stride == 0) add_row(span.y, span.x0, span.x1);
  }
}

}  // namespace panelcal::internal
