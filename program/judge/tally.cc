// SPDX-License-Identifier: Apache-2.0
#include "program/judge/tally.h"

#include <algorithm>
#include <set>

#include "program/geometry/arc_shape.h"

namespace panelcal {
void Tally::begin(const ProgramInfo& info) {
  tools_ = info.tools;
}

void Tally::put(const Operation& operation) {
  if (const auto* drill = std::get_if<Drill>(&operation.what)) {
    put_hole(*drill);
  } else if (const auto* rout = std::get_if<Rout>(&operation.what)) {
    put_rout(*rout);
  } else if (const auto* move = std::get_if<RapidMove>(&operation.what)) {
    router_ = *move;
  } else if (std::holds_alternative<Plunge>(operation.what)) {
    put_place(router_);
  } else if (const auto* slot = std::get_if<Slot>(&operation.what)) {
    put_slot(slot->tool, slot->start, slot->end);
  } else if (const auto* step_slot = std::get_if<StepSlot>(&operation.what)) {
    put_slot(step_slot->tool, step_slot->start, step_slot->end);
  } else if (const auto* change = std::get_if<ToolChange>(&operation.what)) {
    if (change->tool.number > 0) tools_[change->tool.number] = change->tool;
  }
}

std::vector<int> Tally::tools_used() const {
  std::set<int> used;
  for (const Counter* counter : {&holes_, &slots_, &routs_}) {
    for (const auto& [tool, n] : counter->by_tool) used.insert(tool);
  }
  return {used.begin(), used.end()};
}

void Tally::put_place(const PlacedPoint& place) {
  max_square_shift_mm2_ = std::max(max_square_shift_mm2_,
                                   (place.corrected.in_mm() - place.nominal.in_mm()).squaredNorm());
  max_sigma_.add(place.cov_mm2);
  nominal_box_.add(place.nominal);
  corrected_box_.add(place.corrected);
}

void Tally::put_hole(const Drill& drill) {
  const std::int64_t index = holes_.n;
  holes_.add(drill.tool);
  put_place(drill);
  if (is_sampled(index)) keep_sample(index, drill);
}

void Tally::keep_sample(std::int64_t index, const Drill& drill) {
  if (sample_.size() == kSample) {
    for (std::size_t i = 0; 2 * i < kSample; ++i) sample_[i] = sample_[2 * i];
    sample_.resize(kSample / 2);
    stride_ *= 2;
    if (!is_sampled(index)) return;
  }
  sample_.push_back({drill.tool, drill.nominal, drill.corrected});
}

void Tally::put_slot(int tool, const PlacedPoint& start, const PlacedPoint& end) {
  slots_.add(tool);
  put_place(start);
  put_place(end);
}

void Tally::put_rout(const Rout& rout) {
  routs_.add(rout.tool);
  put_place(rout);
  const Eigen::Vector2d start_mm = router_.corrected.in_mm();
  router_ = rout;
  if (rout.kind == RoutKind::Line) {
    routed_length_ = routed_length_ + mm((rout.corrected.in_mm() - start_mm).norm());
    return;
  }
  const ArcShape arc(start_mm, rout);
  routed_length_ = routed_length_ + mm(arc.length_mm());
  arc.for_each_bulge([this](const Eigen::Vector2d& bulge_mm) {
    corrected_box_.add(position_mm<frame::Actual>(bulge_mm));
  });
}

}  // namespace panelcal
