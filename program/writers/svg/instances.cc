// SPDX-License-Identifier: Apache-2.0
#include "program/writers/svg/instances.h"

#include <algorithm>
#include <cmath>

#include "program/writers/svg/sheet.h"

namespace panelcal::svg {
namespace {

/// A placement to a micrometre; all zero if it is not stated which it is.
std::array<std::int64_t, 6> rounded(const Operation& operation) {
  if (operation.origin == nullptr || operation.origin->placement == nullptr) return {};
  const Placement& placement = *operation.origin->placement;
  const auto um = [](double value) {
    return static_cast<std::int64_t>(std::llround(std::clamp(value * 1e3, -9e15, 9e15)));
  };
  return {um(placement.linear()(0, 0)),
          um(placement.linear()(0, 1)),
          um(placement.linear()(1, 0)),
          um(placement.linear()(1, 1)),
          um(placement.translation().x()),
          um(placement.translation().y())};
}

}  // namespace

void Instances::add(const Operation& operation, const PlacedPoint& place, double radius_mm) {
  if (operation.path.empty()) return;
  const std::array<std::int64_t, 6> placement = rounded(operation);
  if (placement != last_key_.second || !std::ranges::equal(operation.path, last_key_.first)) {
    last_key_ = {{operation.path.begin(), operation.path.end()}, placement};
    const auto known = boxes_.find(last_key_);
    if (known != boxes_.end()) {
      last_ = &known->second;
    } else if (boxes_.size() < kMost) {
      last_ = &boxes_[last_key_];
    } else {
      last_ = nullptr;
      is_complete_ = false;
    }
  }
  if (last_ == nullptr) return;
  const Eigen::Vector2d& p_mm = place.corrected.in_mm();
  const Eigen::Vector2d radius(radius_mm, radius_mm);
  last_->box.add(position_mm<frame::Actual>(p_mm - radius));
  last_->box.add(position_mm<frame::Actual>(p_mm + radius));
  ++last_->n_places;
}

std::string Instances::frames() const {
  std::string path;
  for (const auto& [key, worked] : boxes_) {
    if (worked.n_places < 2 || worked.box.is_empty()) continue;
    const Eigen::Vector2d low_mm = worked.box.low().in_mm();
    const Eigen::Vector2d high_mm = worked.box.high().in_mm();
    path += 'M';
    append_mm(path, low_mm);
    path += 'H';
    append_mm(path, high_mm.x());
    path += 'V';
    append_mm(path, high_mm.y());
    path += 'H';
    append_mm(path, low_mm.x());
    path += 'z';
  }
  return path;
}

}  // namespace panelcal::svg
