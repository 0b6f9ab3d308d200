// SPDX-License-Identifier: Apache-2.0
#include "program/walk/measuring/pad_collector.h"

#include <variant>

namespace panelcal {
namespace {

/// Holes near targets, of a program that repeats its targets endlessly.
constexpr std::size_t kMostNear = 4 * PadCollector::kMost;

}  // namespace

PadCollector::PadCollector(const Survey& nominal) {
  for (const Measurement& measurement : nominal.measurements) {
    const MeasurementRequest& request = measurement.request;
    pads_.push_back({.place_mm = request.nominal.in_mm(), .line = request.line});
  }
  targets_ = KnownPads(pads_);
}

void PadCollector::put(const Operation& operation) {
  const auto* drill = std::get_if<Drill>(&operation.what);
  if (drill == nullptr || pads_.size() >= kMostNear) return;
  const Eigen::Vector2d place_mm = drill->nominal.in_mm();
  if (pads_.size() >= kMost && targets_.within(place_mm, kNear_mm).empty()) return;
  pads_.push_back({place_mm, operation.line, drill->tool});
}

}  // namespace panelcal
