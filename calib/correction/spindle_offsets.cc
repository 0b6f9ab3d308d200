// SPDX-License-Identifier: Apache-2.0
#include "calib/correction/spindle_offsets.h"

namespace panelcal {
namespace {

bool is_offset_covariance(const Eigen::Matrix2d& c) {
  return c.allFinite() && c(0, 1) == c(1, 0) && c(0, 0) >= 0 && c(1, 1) >= 0 &&
         c(0, 0) * c(1, 1) >= c(0, 1) * c(1, 0);
}

bool is_meant(const OffsetOrder& order, const SpindleAt& at) {
  switch (order.of) {
    case OffsetOrder::Of::Station:
      return at.station == order.number;
    case OffsetOrder::Of::Spindle:
      return at.spindle == order.number;
    case OffsetOrder::Of::SpindleToSpindle:
      return at.spindle != 1;
  }
  return false;
}

}  // namespace

bool SpindleOffsets::set(SpindleAt at, const SpindleCameraOffset& offset) {
  const bool is_there = at.spindle >= 1 && at.spindle <= kMostSpindles && at.station >= 1 &&
                        at.station <= kMostStations;
  if (!is_there || !offset.offset.in_mm().allFinite() || !is_offset_covariance(offset.cov_mm2)) {
    return false;
  }
  offsets_[at] = offset;
  return true;
}

const SpindleCameraOffset* SpindleOffsets::find(SpindleAt at) const {
  const auto found = offsets_.find(at);
  return found == offsets_.end() ? nullptr : &found->second;
}

std::optional<SpindleDistance> SpindleOffsets::between(int from, int to, int station) const {
  const SpindleCameraOffset* a = find({from, station});
  const SpindleCameraOffset* b = find({to, station});
  if (a == nullptr || b == nullptr) return std::nullopt;
  if (a == b) return SpindleDistance{};
  return SpindleDistance{a->offset - b->offset, a->cov_mm2 + b->cov_mm2};
}

int SpindleOffsets::correct(const OffsetOrder& order,
                            const Displacement<frame::Machine>& deviation,
                            const Eigen::Matrix2d& cov_mm2) {
  if (!deviation.in_mm().allFinite() || !is_offset_covariance(cov_mm2)) return 0;
  int n_moved = 0;
  for (auto& [at, offset] : offsets_) {
    if (!is_meant(order, at)) continue;
    offset = {offset.offset - deviation, cov_mm2};
    ++n_moved;
  }
  return n_moved;
}

}  // namespace panelcal
