// SPDX-License-Identifier: Apache-2.0
#include "program/judge/job_check.h"

#include <algorithm>
#include <array>
#include <string>

#include "program/geometry/arc_shape.h"
#include "program/model/tool_links.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr double kLeastPanel_mm = 1;
constexpr double kMostPanel_mm = 2000;
constexpr double kLeastTool_mm = 0.03;
constexpr double kMostTool_mm = 20;
/// Fewer holes say nothing about the size of a board.
constexpr std::int64_t kTelling = 10;

std::string tool_list(const std::set<int>& tools) {
  std::string out;
  for (const int tool : tools) out += fmt::format("{}T{}", out.empty() ? "" : ", ", tool);
  return out;
}

}  // namespace

void JobCheck::put(const Operation& operation) {
  if (const auto* drill = std::get_if<Drill>(&operation.what)) return see_hole(operation, *drill);
  put_rare(operation);
}

void JobCheck::put_rare(const Operation& operation) {
  if (const auto* change = std::get_if<ToolChange>(&operation.what)) {
    take(change->tool);
  } else if (const auto* rout = std::get_if<Rout>(&operation.what)) {
    used_.insert(rout->tool);
    if (rout->feed_is_default) without_table_feed_.insert(rout->tool);
    see(operation, *rout);
    see_bulges(operation, *rout);
    router_mm_ = rout->corrected.in_mm();
  } else if (const auto* move = std::get_if<RapidMove>(&operation.what)) {
    see(operation, *move);
    router_mm_ = move->corrected.in_mm();
  } else if (const auto* slot = std::get_if<Slot>(&operation.what)) {
    used_.insert(slot->tool);
    if (!tool_.infeed) without_infeed_.insert(slot->tool);
    see(operation, slot->start);
    see(operation, slot->end);
  } else if (const auto* steps = std::get_if<StepSlot>(&operation.what)) {
    used_.insert(steps->tool);
    if (steps->feed_is_default) without_table_feed_.insert(steps->tool);
    see(operation, steps->start);
    see(operation, steps->end);
  } else if (const auto* setting = std::get_if<Setting>(&operation.what)) {
    constexpr std::size_t kMostLinks = 1000;
    if (is_tool_link(setting->text) && links_.size() < kMostLinks) {
      links_.emplace(setting->text);
    }
  } else if (const auto* compensation = std::get_if<Compensation>(&operation.what)) {
    see_compensation(operation, *compensation);
  } else if (const auto* rate = std::get_if<ToolRate>(&operation.what)) {
    if (rate->infeed) tool_.infeed = rate->infeed;
  } else if (const auto* stop = std::get_if<Stop>(&operation.what)) {
    if (stop->actual) hold_against_travel(operation, *stop->actual);
  } else if (const auto* calibration = std::get_if<Autocalibration>(&operation.what)) {
    hold_against_travel(operation, calibration->actual);
  }
}

void JobCheck::see_compensation(const Operation& operation, const Compensation& compensation) {
  if (compensation.side == CompensationSide::Off || compensation.value) return;
  if (without_compensation_.empty()) {
    first_without_compensation_ = {std::string(operation.file), operation.line, 1};
  }
  without_compensation_.insert(tool_.number);
}

void JobCheck::take(const Tool& tool) {
  tool_ = tool;
  drilling_tool_ = 0;
}

inline void JobCheck::see(const Operation& operation, const PlacedPoint& point) {
  low_mm_ = low_mm_.cwiseMin(point.nominal.in_mm());
  high_mm_ = high_mm_.cwiseMax(point.nominal.in_mm());
  hold_against_travel(operation, point.actual);
}

void JobCheck::see_bulges(const Operation& operation, const Rout& rout) {
  if (rout.kind == RoutKind::Line || !travel_) return;
  const Eigen::Vector2d work_zero_mm = rout.actual.in_mm() - rout.corrected.in_mm();
  ArcShape(router_mm_, rout).for_each_bulge([&](const Eigen::Vector2d& bulge_mm) {
    hold_against_travel(operation, position_mm<frame::Machine>(bulge_mm + work_zero_mm));
  });
}

void JobCheck::hold_against(const Travel& travel,
                            const Operation& operation,
                            const Position<frame::Machine>& place) {
  const Eigen::Vector2d& at_mm = place.in_mm();
  // Written so that a NaN is outside.
  if ((at_mm.array() >= travel.low.in_mm().array()).all() &&
      (at_mm.array() <= travel.high.in_mm().array()).all()) {
    return;
  }
  if (n_outside_++ == 0) {
    outside_ = Outside{operation.line, std::string(operation.file), place};
  }
}

void JobCheck::drill_with(int tool) {
  drilling_tool_ = tool;
  used_.insert(tool);
  if (!tool_.infeed) without_infeed_.insert(tool);
}

void JobCheck::see_hole(const Operation& operation, const Drill& drill) {
  see(operation, drill);
  if (drill.tool != drilling_tool_) drill_with(drill.tool);
  // Holes of one block are a cycle's, which may overlap.
  if (operation.line != last_line_) {
    const double step_mm2 = (drill.nominal.in_mm() - last_mm_).squaredNorm();
    if (last_line_ != 0 && tool_.diameter && step_mm2 > 0) {
      const double radius_mm = tool_.diameter->in_mm() / 2;
      ++n_steps_;
      n_overlapping_ += step_mm2 < radius_mm * radius_mm ? 1 : 0;
    }
    last_line_ = operation.line;
  }
  last_mm_ = drill.nominal.in_mm();
}

void JobCheck::report(const Program& program, DiagnosticLog& log) const {
  const std::string& file = program.source.file;
  const bool is_excellon = program.dialect == Dialect::Excellon;
  std::set<int> used = used_;
  for (const std::string& link : links_) add_linked_tools(link, used);
  for (const auto& [number, tool] : program.tools()) {
    if (used.contains(number) || used_.empty()) continue;
    log.add({Code::ToolUnused,
             {file, program.tool_lines().at(number), 1},
             fmt::format("tool {}", number),
             ""});
  }
  if (!without_infeed_.empty()) {
    log.add({Code::FeedMissing,
             {file, 0, 0},
             "no infeed for " + tool_list(without_infeed_),
             is_excellon ? "F# in the tool's block, or the machine's Tool Data Page"
                         : "F of the tool in the table behind $"});
  }
  if (!without_table_feed_.empty()) {
    log.add({Code::FeedMissing,
             {file, 0, 0},
             "no table feed for " + tool_list(without_table_feed_) +
                 (is_excellon ? "; 100 in/min is used" : "; 2.54 m/min is used"),
             is_excellon ? "F# behind G00" : "F# in the first rout line"});
  }
  if (is_excellon && !without_compensation_.empty()) {
    Place place = first_without_compensation_;
    if (place.file.empty()) place.file = file;
    log.add({Code::CompensationMissing,
             std::move(place),
             "no value for " + tool_list(without_compensation_),
             "CP,INDEX,DIAMETER in the header, or the machine's Cutter Information Page"});
  }
  if (outside_) {
    const Eigen::Vector2d& at_mm = outside_->place.in_mm();
    const Eigen::Vector2d& low_mm = travel_->low.in_mm();
    const Eigen::Vector2d& high_mm = travel_->high.in_mm();
    log.add(
        {Code::TravelExceeded,
         {outside_->file.empty() ? file : outside_->file, outside_->line, 1},
         fmt::format("({:.3f}, {:.3f}) mm is outside the travel{}",
                     at_mm.x(),
                     at_mm.y(),
                     n_outside_ == 1 ? "" : fmt::format(", and so are {} more", n_outside_ - 1)),
         fmt::format("({:.3f}, {:.3f}) to ({:.3f}, {:.3f}) mm",
                     low_mm.x(),
                     low_mm.y(),
                     high_mm.x(),
                     high_mm.y())});
  }
  report_scale(program, log);
}

void JobCheck::report_scale(const Program& program, DiagnosticLog& log) const {
  const double size_mm = (high_mm_ - low_mm_).maxCoeff();
  if (n_steps_ < kTelling && !(size_mm > kMostPanel_mm)) return;
  const bool is_small = size_mm < kLeastPanel_mm;
  const bool is_large = size_mm > kMostPanel_mm;
  const bool overlaps = 2 * n_overlapping_ > n_steps_;
  const auto n_odd_tools = std::ranges::count_if(program.tools(), [](const auto& numbered) {
    const auto& diameter = numbered.second.diameter;
    return diameter && (diameter->in_mm() < kLeastTool_mm || diameter->in_mm() > kMostTool_mm);
  });
  const bool odd_tools = 2 * n_odd_tools > static_cast<std::ptrdiff_t>(program.tools().size());
  if (!is_small && !is_large && !overlaps && !odd_tools) return;

  std::string what = fmt::format(
      "the job spans {:.4g} x {:.4g} mm", high_mm_.x() - low_mm_.x(), high_mm_.y() - low_mm_.y());
  if (overlaps) what += ", and most holes overlap the one before";
  if (odd_tools) what += ", and most diameters are no drill's";
  if (!odd_tools) {
    constexpr std::array<double, 4> kUsual = {25.4, 10, 100, 1000};
    const auto fits = [&](double factor) {
      const double scaled_mm = size_mm * factor;
      return scaled_mm >= 10 * kLeastPanel_mm && scaled_mm <= kMostPanel_mm / 2;
    };
    for (const double factor : kUsual) {
      if ((is_small || overlaps) && fits(factor)) {
        what += fmt::format("; {:g} times larger it would be a panel", factor);
        break;
      }
      if (is_large && fits(1 / factor)) {
        what += fmt::format("; {:g} times smaller it would be a panel", factor);
        break;
      }
    }
  }
  log.add({Code::ScaleSuspicious,
           {program.source.file, 0, 0},
           std::move(what),
           "the right unit, zeros and digits; read as " + program.number_summary()});
}

}  // namespace panelcal
