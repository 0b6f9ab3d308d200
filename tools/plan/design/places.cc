// SPDX-License-Identifier: Apache-2.0
#include "tools/plan/design/places.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace panelcal::plan {
namespace {

Eigen::Vector2d direction(std::size_t k) {
  const double angle = 2 * std::numbers::pi * static_cast<double>(k) / CandidatePool::kDirections;
  return {std::cos(angle), std::sin(angle)};
}

}  // namespace

PlannedPlace PassingPlace::kept() const {
  return {
      nominal, line, std::string(file), tool, is_target, InstancePath(path.begin(), path.end())};
}

PlannedPlace target_place(const Measurement& measurement) {
  const MeasurementRequest& request = measurement.request;
  return {request.nominal,
          request.line,
          request.file,
          request.settings.tools.empty() ? 0 : request.settings.tools.front(),
          true,
          request.path};
}

PlaceSink::PlaceSink(const Survey& survey, Visit visit) : visit_(std::move(visit)) {
  std::vector<bool> is_in_series(survey.measurements.size(), false);
  for (const SeriesResult& series : survey.series) {
    for (const std::size_t i : series.measurements) is_in_series[i] = true;
  }
  for (std::size_t i = 0; i < survey.measurements.size(); ++i) {
    const MeasurementRequest& request = survey.measurements[i].request;
    if (!is_in_series[i]) own_target_lines_.emplace(request.file, request.line);
  }
}

void PlaceSink::pass(const Operation& operation, const PlacedPoint& point, int tool) {
  PassingPlace place{.nominal = point.nominal,
                     .line = operation.line,
                     .file = operation.file,
                     .tool = tool,
                     .path = operation.path,
                     .is_rout = std::holds_alternative<Rout>(operation.what)};
  if (operation.origin != nullptr) {
    if (operation.origin->base_series != nullptr)
      place.base_series = *operation.origin->base_series;
    if (operation.origin->nested_series != nullptr) {
      place.nested_series = *operation.origin->nested_series;
    }
  }
  place.has_own_target = !own_target_lines_.empty() &&
                         own_target_lines_.contains({std::string(operation.file), operation.line});
  visit_(place);
}

void PlaceSink::put(const Operation& operation) {
  if (const auto* drill = std::get_if<Drill>(&operation.what)) {
    pass(operation, *drill, drill->tool);
  } else if (const auto* rout = std::get_if<Rout>(&operation.what)) {
    if (begins_contour_) {
      PlacedPoint start;
      start.nominal = router_;
      pass(operation, start, rout->tool);
    }
    pass(operation, *rout, rout->tool);
    begins_contour_ = false;
    router_ = rout->nominal;
  } else if (const auto* move = std::get_if<RapidMove>(&operation.what)) {
    router_ = move->nominal;
    begins_contour_ = true;
  } else if (const auto* slot = std::get_if<Slot>(&operation.what)) {
    pass(operation, slot->start, slot->tool);
    pass(operation, slot->end, slot->tool);
  } else if (const auto* step_slot = std::get_if<StepSlot>(&operation.what)) {
    pass(operation, step_slot->start, step_slot->tool);
    pass(operation, step_slot->end, step_slot->tool);
  }
}

CandidatePool::CandidatePool(const Position<frame::Nominal>& low,
                             const Position<frame::Nominal>& high)
    : low_mm_(low.in_mm()),
      cell_mm_(((high - low).in_mm() / kCells).cwiseMax(1e-9)),
      cells_(static_cast<std::size_t>(kCells) * kCells) {
  for (auto& [reach_mm, place] : outermost_) {
    reach_mm = -std::numeric_limits<double>::infinity();
  }
}

std::optional<PlannedPlace>& CandidatePool::cell(const Position<frame::Nominal>& p) {
  const Eigen::Vector2d at = (p.in_mm() - low_mm_).cwiseQuotient(cell_mm_);
  const int x = std::clamp(static_cast<int>(at.x()), 0, kCells - 1);
  const int y = std::clamp(static_cast<int>(at.y()), 0, kCells - 1);
  return cells_[static_cast<std::size_t>(y * kCells + x)];
}

void CandidatePool::add(const PassingPlace& place) {
  ++n_;
  if (n_ <= kAll) all_.push_back(place.kept());
  std::optional<PlannedPlace>& kept = cell(place.nominal);
  if (!kept) kept = place.kept();
  static const auto kAround = [] {
    std::array<Eigen::Vector2d, kDirections> all;
    for (std::size_t k = 0; k < kDirections; ++k) all[k] = direction(k);
    return all;
  }();
  for (std::size_t k = 0; k < kDirections; ++k) {
    const double reach_mm = kAround[k].dot(place.nominal.in_mm());
    if (reach_mm > outermost_[k].first) outermost_[k] = {reach_mm, place.kept()};
  }
}

void CandidatePool::add(PlannedPlace target) {
  targets_.push_back(std::move(target));
}

std::vector<PlannedPlace> CandidatePool::candidates() const {
  std::vector<PlannedPlace> out = targets_;
  if (!is_thinned()) {
    out.insert(out.end(), all_.begin(), all_.end());
  } else {
    for (const auto& [reach_mm, place] : outermost_) out.push_back(place);
    for (const auto& kept : cells_) {
      if (kept) out.push_back(*kept);
    }
  }
  // Two holes nearer than a micrometre are one pad.
  std::set<std::pair<long long, long long>> seen;
  std::erase_if(out, [&](const PlannedPlace& place) {
    const Eigen::Vector2d at_um = place.nominal.in_mm() * 1e3;
    return !seen.emplace(std::llround(at_um.x()), std::llround(at_um.y())).second;
  });
  return out;
}

}  // namespace panelcal::plan
