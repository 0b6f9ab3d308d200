// SPDX-License-Identifier: Apache-2.0
#include "surface/map/voids.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

using Eigen::Vector2d;

constexpr double kMostMargin_mm = 1000;
/// Of all polygons together: whether sides cross takes long to know.
constexpr std::size_t kMaxVoidCorners = 10'000;
/// A void whose rectangle has more bins than this, or that touches that number, is looked at for
/// every place.
constexpr double kMaxVoidTrials = 4096;
constexpr std::size_t kMostBins = 256;
/// Bins by voids, of all together.
constexpr std::size_t kUsualBins = 32;

std::size_t n_corners(const Area& area) {
  if (const auto* polygon = std::get_if<Polygon>(&area)) return polygon->corners.size();
  if (const auto* outside = std::get_if<Outside>(&area)) return outside->panel.corners.size();
  return 0;
}

std::size_t n_points(const Area& area) {
  if (const auto* track = std::get_if<Track>(&area)) return track->points.size();
  return 1 + n_corners(area);
}

AreaBox widened(AreaBox box, Length margin) {
  box.low_mm.array() -= margin.in_mm();
  box.high_mm.array() += margin.in_mm();
  return box;
}

}  // namespace

std::string text_of(const Void& hole) {
  if (hole.from.file.empty()) return quoted(hole.name);
  return fmt::format("{} ({}:{})", quoted(hole.name), hole.from.file, hole.from.line);
}

Expected<Voids> Voids::make(std::vector<Void> all, Length margin) {
  if (!(margin >= mm(0) && margin.in_mm() <= kMostMargin_mm)) {
    return failure({Code::ConfigValue,
                    {},
                    fmt::format("margin_mm of voids is {}", margin.in_mm()),
                    "0 to 1000 mm"});
  }
  std::size_t n_polygon_corners = 0;
  for (const Void& one : all) {
    n_polygon_corners += n_corners(one.area);
    if (n_polygon_corners > kMaxVoidCorners) {
      return failure({Code::ConfigValue,
                      one.from,
                      fmt::format("voids of more than {} corners", kMaxVoidCorners),
                      "simpler polygons"});
    }
    PANELCAL_CHECK(check_area(one.area, one.name, one.from));
  }
  Voids out;
  out.all_ = std::move(all);
  out.margin_ = margin;
  AreaBox bounds{Vector2d::Zero(), Vector2d::Zero()};
  bool is_first = true;
  for (const Void& one : out.all_) {
    const AreaBox box = widened(box_of(one.area), margin);
    if (!box.low_mm.allFinite()) continue;
    bounds = is_first ? box
                      : AreaBox{bounds.low_mm.cwiseMin(box.low_mm),
                                bounds.high_mm.cwiseMax(box.high_mm)};
    is_first = false;
  }
  // As many bins as voids, about.
  const Vector2d size_mm = bounds.high_mm - bounds.low_mm;
  const auto n = static_cast<double>(out.all_.size());
  out.bin_mm_ = std::max(
      {std::sqrt(size_mm.prod() / std::max(1.0, n)), size_mm.maxCoeff() / std::max(1.0, n), 1e-3});
  out.low_mm_ = bounds.low_mm;
  out.n_columns_ = static_cast<std::ptrdiff_t>(size_mm.x() / out.bin_mm_) + 1;
  out.n_rows_ = static_cast<std::ptrdiff_t>(size_mm.y() / out.bin_mm_) + 1;
  out.bins_.resize(static_cast<std::size_t>(out.n_columns_ * out.n_rows_));
  std::size_t room = kMostBins + kUsualBins * out.all_.size();
  for (std::size_t k = 0; k < out.all_.size(); ++k) {
    const std::vector<std::size_t> bins = out.bins_of(k, widened(box_of(out.all_[k].area), margin));
    if (bins.empty() || bins.size() > std::min(room, kMostBins)) {
      out.large_.push_back(k);
      continue;
    }
    room -= bins.size();
    for (const std::size_t bin : bins) out.bins_[bin].push_back(k);
  }
  return out;
}

/// Those that a void or its margin touches; none if it would take long to know.
///
/// A place in a bin is at most half of its diagonal from its middle.
std::vector<std::size_t> Voids::bins_of(std::size_t i_void, const AreaBox& box) const {
  const Area& area = all_[i_void].area;
  const Vector2d low = (box.low_mm - low_mm_) / bin_mm_;
  const Vector2d high = (box.high_mm - low_mm_) / bin_mm_;
  const double n_tried = (high - low + Vector2d::Constant(2)).prod();
  if (!(n_tried * static_cast<double>(n_points(area)) <= 64 * kMaxVoidTrials) ||
      n_tried > kMaxVoidTrials) {
    return {};
  }
  const auto clamped = [](double bin, std::ptrdiff_t n_bins) {
    return std::min(static_cast<std::ptrdiff_t>(bin), n_bins - 1);
  };
  const Length reach = margin_ + mm(bin_mm_ / std::numbers::sqrt2 * (1 + 1e-9));
  std::vector<std::size_t> out;
  for (std::ptrdiff_t j = clamped(low.y(), n_rows_); j <= clamped(high.y(), n_rows_); ++j) {
    for (std::ptrdiff_t i = clamped(low.x(), n_columns_); i <= clamped(high.x(), n_columns_); ++i) {
      const Vector2d middle(static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5);
      if (!is_within(area, position_mm<frame::Nominal>(low_mm_ + bin_mm_ * middle), reach))
        continue;
      out.push_back(static_cast<std::size_t>(j * n_columns_ + i));
    }
  }
  return out;
}

std::ptrdiff_t Voids::bin_of(const Vector2d& p_mm) const {
  const Vector2d bin = (p_mm - low_mm_) / bin_mm_;
  const bool is_in_some = bin.minCoeff() >= 0 && bin.x() < static_cast<double>(n_columns_) &&
                          bin.y() < static_cast<double>(n_rows_);
  if (!is_in_some) return -1;
  return static_cast<std::ptrdiff_t>(bin.y()) * n_columns_ + static_cast<std::ptrdiff_t>(bin.x());
}

const Void* Voids::first_within(const Position<frame::Nominal>& place, Length margin) const {
  const auto first_of = [&](const std::vector<std::size_t>& indices) {
    const auto found = std::ranges::find_if(
        indices, [&](std::size_t k) { return is_within(all_[k].area, place, margin); });
    return found == indices.end() ? all_.size() : *found;
  };
  std::size_t first = first_of(large_);
  const std::ptrdiff_t bin = bin_of(place.in_mm());
  if (bin >= 0) first = std::min(first, first_of(bins_[static_cast<std::size_t>(bin)]));
  return first < all_.size() ? &all_[first] : nullptr;
}

const Void* Voids::at(const Position<frame::Nominal>& place) const {
  return first_within(place, mm(0));
}

const Void* Voids::touched_at(const Position<frame::Nominal>& place) const {
  return first_within(place, margin_);
}

}  // namespace panelcal
