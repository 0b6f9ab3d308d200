// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/tally.h"

#include <algorithm>
#include <cmath>

namespace panelcal {
namespace {

/// Square root of the larger eigenvalue of a symmetric 2 x 2 matrix.
double largest_sigma_mm(const Eigen::Matrix2d& cov_mm2) {
  const double mean = (cov_mm2(0, 0) + cov_mm2(1, 1)) / 2;
  const double half = (cov_mm2(0, 0) - cov_mm2(1, 1)) / 2;
  return std::sqrt(std::max(0.0, mean + std::hypot(half, cov_mm2(0, 1))));
}

}  // namespace

void Tally::begin(const ProgramInfo& info) {
  tools_ = info.tools;
}

void Tally::put(const Operation& operation) {
  if (const auto* drill = std::get_if<Drill>(&operation.what)) {
    put_hole(*drill);
  } else if (const auto* change = std::get_if<ToolChange>(&operation.what)) {
    if (change->tool.number > 0) tools_[change->tool.number] = change->tool;
  }
}

void Tally::put_hole(const Drill& drill) {
  ++holes_by_tool_[drill.tool];
  max_shift_ = std::max(max_shift_, mm((drill.corrected.in_mm() - drill.nominal.in_mm()).norm()));
  max_sigma_ = std::max(max_sigma_, mm(largest_sigma_mm(drill.cov_mm2)));
  if (n_holes_++ % stride_ != 0) return;
  if (sample_.size() == kSample) {
    for (std::size_t i = 0; 2 * i < kSample; ++i) sample_[i] = sample_[2 * i];
    sample_.resize(kSample / 2);
    stride_ *= 2;
    if ((n_holes_ - 1) % stride_ != 0) return;
  }
  sample_.push_back({drill.tool, drill.nominal, drill.corrected});
}

}  // namespace panelcal
