// SPDX-License-Identifier: Apache-2.0
#include "calib/faults/known_pads.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <unordered_map>
#include <utility>

namespace panelcal {
namespace {

/// Program coordinates step by 0.1 um at best.
constexpr double kSamePlace_mm = 1e-3;
/// No panel is so large.
constexpr double kFarthest_mm = 1e9;

using Cell = std::pair<std::int64_t, std::int64_t>;

struct CellHash {
  std::size_t operator()(const Cell& cell) const {
    return static_cast<std::size_t>(cell.first) * 0x9E3779B97F4A7C15ULL +
           static_cast<std::size_t>(cell.second);
  }
};

/// Without pads that repeat another, however far apart they stand in the program.
void remove_repeated(std::vector<KnownPad>& pads) {
  std::unordered_multimap<Cell, Eigen::Vector2d, CellHash> kept;
  kept.reserve(pads.size());
  std::erase_if(pads, [&kept](const KnownPad& pad) {
    const auto x = static_cast<std::int64_t>(std::floor(pad.place_mm.x() / kSamePlace_mm));
    const auto y = static_cast<std::int64_t>(std::floor(pad.place_mm.y() / kSamePlace_mm));
    for (std::int64_t i = x - 1; i <= x + 1; ++i) {
      for (std::int64_t k = y - 1; k <= y + 1; ++k) {
        const auto [first, last] = kept.equal_range({i, k});
        const auto is_same = [&pad](const auto& other) {
          return (pad.place_mm - other.second).norm() <= kSamePlace_mm;
        };
        if (std::any_of(first, last, is_same)) return true;
      }
    }
    kept.insert({{x, y}, pad.place_mm});
    return false;
  });
}

}  // namespace

KnownPads::KnownPads(std::vector<KnownPad> pads) : pads_(std::move(pads)) {
  // Written so that what is no number goes as well.
  std::erase_if(pads_, [](const KnownPad& pad) {
    return !(pad.place_mm.cwiseAbs().maxCoeff() <= kFarthest_mm) || !pad.place_mm.allFinite();
  });
  if (pads_.empty()) return;
  remove_repeated(pads_);
  low_mm_ = high_mm_ = pads_.front().place_mm;
  for (const KnownPad& pad : pads_) {
    low_mm_ = low_mm_.cwiseMin(pad.place_mm);
    high_mm_ = high_mm_.cwiseMax(pad.place_mm);
  }
  // About one pad to a cell, also where all of them lie in one line.
  const Eigen::Vector2d size_mm = high_mm_ - low_mm_;
  const auto n = static_cast<double>(pads_.size());
  cell_mm_ = std::max({std::sqrt(size_mm.x() * size_mm.y() / n), size_mm.maxCoeff() / n, 1e-3});
  n_cells_ = (size_mm / cell_mm_).array().floor().cast<int>() + 1;
  const auto index = [this](const KnownPad& pad) {
    const Eigen::Vector2i cell = cell_of(pad.place_mm);
    return static_cast<std::size_t>(cell.y()) * static_cast<std::size_t>(n_cells_.x()) +
           static_cast<std::size_t>(cell.x());
  };
  std::ranges::stable_sort(pads_, {}, index);
  const auto n_all =
      static_cast<std::size_t>(n_cells_.x()) * static_cast<std::size_t>(n_cells_.y());
  first_of_cell_.assign(n_all + 1, 0);
  for (const KnownPad& pad : pads_) ++first_of_cell_[index(pad) + 1];
  for (std::size_t i = 1; i < first_of_cell_.size(); ++i) {
    first_of_cell_[i] += first_of_cell_[i - 1];
  }
}

Eigen::Vector2i KnownPads::cell_of(const Eigen::Vector2d& place_mm) const {
  const Eigen::Vector2d cell = ((place_mm - low_mm_) / cell_mm_).array().floor();
  const Eigen::Vector2d last = (n_cells_.array() - 1).cast<double>();
  return cell.cwiseMin(last).cwiseMax(Eigen::Vector2d::Zero()).cast<int>();
}

void KnownPads::inside(const Eigen::Vector2d& low_mm,
                       const Eigen::Vector2d& high_mm,
                       std::vector<std::size_t>& found) const {
  found.clear();
  if (pads_.empty() || !low_mm.allFinite() || !high_mm.allFinite()) return;
  if ((high_mm.array() < low_mm_.array()).any() || (low_mm.array() > high_mm_.array()).any())
    return;
  const Eigen::Vector2i first = cell_of(low_mm);
  const Eigen::Vector2i last = cell_of(high_mm);
  for (int row = first.y(); row <= last.y(); ++row) {
    const auto begin = static_cast<std::size_t>(row) * static_cast<std::size_t>(n_cells_.x());
    const std::size_t end = first_of_cell_[begin + static_cast<std::size_t>(last.x()) + 1];
    for (std::size_t i = first_of_cell_[begin + static_cast<std::size_t>(first.x())]; i < end;
         ++i) {
      const Eigen::Vector2d& p_mm = pads_[i].place_mm;
      if ((p_mm.array() >= low_mm.array()).all() && (p_mm.array() <= high_mm.array()).all()) {
        found.push_back(i);
      }
    }
  }
}

std::vector<std::size_t> KnownPads::within(const Eigen::Vector2d& place_mm,
                                           double radius_mm) const {
  std::vector<std::size_t> found;
  const Eigen::Vector2d reach_mm = Eigen::Vector2d::Constant(radius_mm);
  inside(place_mm - reach_mm, place_mm + reach_mm, found);
  const auto distance_mm = [&](std::size_t i) { return (pads_[i].place_mm - place_mm).norm(); };
  std::erase_if(found, [&](std::size_t i) { return distance_mm(i) > radius_mm; });
  std::ranges::stable_sort(found, {}, distance_mm);
  return found;
}

}  // namespace panelcal
