// SPDX-License-Identifier: Apache-2.0
#include "panelcal/surface/voids.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

using Eigen::Vector2d;

constexpr double kMostMargin_mm = 1000;
/// A void in more bins than this is looked at for every place.
constexpr double kMostBins = 64;

}  // namespace

Expected<Voids> Voids::make(std::vector<Void> all, Length margin) {
  if (!(margin >= mm(0) && margin.in_mm() <= kMostMargin_mm)) {
    return failure({Code::ConfigValue,
                    {},
                    fmt::format("margin_mm of voids is {}", margin.in_mm()),
                    "0 to 1000 mm"});
  }
  for (const Void& one : all) PANELCAL_CHECK(check_area(one.area, one.name, one.from));
  Voids out;
  out.all_ = std::move(all);
  out.margin_ = margin;
  std::vector<AreaBox> boxes;
  AreaBox bounds{Vector2d::Zero(), Vector2d::Zero()};
  bool is_first = true;
  for (const Void& one : out.all_) {
    AreaBox box = box_of(one.area);
    box.low_mm.array() -= margin.in_mm();
    box.high_mm.array() += margin.in_mm();
    boxes.push_back(box);
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
  for (std::size_t k = 0; k < boxes.size(); ++k) {
    const Vector2d low = (boxes[k].low_mm - out.low_mm_) / out.bin_mm_;
    const Vector2d high = (boxes[k].high_mm - out.low_mm_) / out.bin_mm_;
    const Vector2d bins = high - low + Vector2d::Constant(1);
    if (!(bins.prod() <= kMostBins)) {
      out.large_.push_back(k);
      continue;
    }
    const auto last = [](double bin, std::ptrdiff_t n_bins) {
      return std::min(static_cast<std::ptrdiff_t>(bin), n_bins - 1);
    };
    for (std::ptrdiff_t j = last(low.y(), out.n_rows_); j <= last(high.y(), out.n_rows_); ++j) {
      for (std::ptrdiff_t i = last(low.x(), out.n_columns_); i <= last(high.x(), out.n_columns_);
           ++i) {
        out.bins_[static_cast<std::size_t>(j * out.n_columns_ + i)].push_back(k);
      }
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

const Void* Voids::at(const Position<frame::Nominal>& place) const {
  const auto first_of = [&](const std::vector<std::size_t>& indices) {
    const auto found = std::ranges::find_if(
        indices, [&](std::size_t k) { return is_within(all_[k].area, place, margin_); });
    return found == indices.end() ? all_.size() : *found;
  };
  std::size_t first = first_of(large_);
  const std::ptrdiff_t bin = bin_of(place.in_mm());
  if (bin >= 0) first = std::min(first, first_of(bins_[static_cast<std::size_t>(bin)]));
  return first < all_.size() ? &all_[first] : nullptr;
}

}  // namespace panelcal
