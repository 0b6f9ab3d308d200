// SPDX-License-Identifier: Apache-2.0
#include "tests/program/random/job_events.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <type_traits>
#include <variant>

namespace panelcal::test {
namespace {

using Eigen::Vector2d;

bool near(const Vector2d& a, const Vector2d& b, double tolerance_mm) {
  return (a - b).norm() <= tolerance_mm;
}

bool near(const std::optional<Length>& a, const std::optional<Length>& b) {
  return a.has_value() == b.has_value() && (!a || std::abs((*a - *b).in_mm()) < kLastDigit_mm);
}

/// The middle of an arc of at most half a circle, on the side that its sense says.
Vector2d middle_of(const Vector2d& start_mm, const Rout& rout) {
  const Vector2d& end_mm = rout.corrected.in_mm();
  const double radius_mm = (end_mm - rout.corrected_center.in_mm()).norm();
  const Vector2d half = 0.5 * (end_mm - start_mm);
  const Vector2d left = Vector2d(-half.y(), half.x()).normalized();
  const double depth_mm = std::sqrt(std::max(0.0, radius_mm * radius_mm - half.squaredNorm()));
  const double rise_mm = half.squaredNorm() / (radius_mm + depth_mm);
  return start_mm + half + (rout.kind == RoutKind::Clockwise ? rise_mm : -rise_mm) * left;
}

/// Equality of two operations to what a written program keeps of them.
class Sameness {
 public:
  explicit Sameness(Tolerance tolerance = {}) : tolerance_(tolerance) {}

  bool operator()(const Event& a, const Event& b) {
    if (a.what.index() != b.what.index() || a.text != b.text) return false;
    const bool is_same = std::visit(
        [&](const auto& x) { return same(x, std::get<std::decay_t<decltype(x)>>(b.what)); },
        a.what);
    if (const auto* move = std::get_if<RapidMove>(&a.what)) at_mm_ = move->corrected.in_mm();
    if (const auto* rout = std::get_if<Rout>(&a.what)) at_mm_ = rout->corrected.in_mm();
    return is_same;
  }

 private:
  bool same_place(const PlacedPoint& a, const PlacedPoint& b) const {
    return near(a.corrected.in_mm(), b.corrected.in_mm(), tolerance_.place_mm);
  }
  bool same(const ToolChange& a, const ToolChange& b) const {
    return a.tool.number == b.tool.number && a.compensation_index == b.compensation_index &&
           near(a.tool.diameter, b.tool.diameter) && same_rate(a.tool.infeed, b.tool.infeed) &&
           same_rate(a.tool.retract, b.tool.retract) && a.tool.speed == b.tool.speed &&
           a.tool.max_hits == b.tool.max_hits && near(a.tool.depth_offset, b.tool.depth_offset);
  }
  bool same_rate(const std::optional<Feed>& a, const std::optional<Feed>& b) const {
    return a.has_value() == b.has_value() && (!a || same_feed(*a, false, *b));
  }
  bool same(const DepthOfCut& a, const DepthOfCut& b) const {
    return a.control == b.control && near(a.z, b.z) && near(a.depth, b.depth) &&
           near(a.surface, b.surface) && near(a.lower_limit, b.lower_limit) &&
           near(a.upper_limit, b.upper_limit);
  }
  bool same(const Drill& a, const Drill& b) const {
    return a.tool == b.tool && same_place(a, b) && same(a.cut, b.cut);
  }
  bool same(const RapidMove& a, const RapidMove& b) const { return same_place(a, b); }
  bool same_feed(Feed a, bool is_default, Feed b) const {
    return std::abs(a.in_mm_s() - b.in_mm_s()) <
           (is_default ? kWholeFeed_mm_s : tolerance_.rate_mm_s);
  }
  bool same(const Rout& a, const Rout& b) const {
    if (a.tool != b.tool || a.kind != b.kind || !same_place(a, b)) return false;
    if (!same(a.cut, b.cut)) return false;
    if (!same_feed(a.feed, a.feed_is_default, b.feed)) return false;
    if (a.kind == RoutKind::Line) return true;
    if (near(a.corrected_center.in_mm(), b.corrected_center.in_mm(), tolerance_.center_mm)) {
      return true;
    }
    // The centre of a nearly straight arc is far away and says little.
    const double chord_mm = (a.corrected.in_mm() - at_mm_).norm();
    const double radius_mm = (a.corrected.in_mm() - a.corrected_center.in_mm()).norm();
    return radius_mm > 10 * chord_mm &&
           near(middle_of(at_mm_, a), middle_of(at_mm_, b), kWritten_mm);
  }
  bool same(const Plunge& a, const Plunge& b) const {
    return a.tool == b.tool && a.kind == b.kind && near(a.depth_offset, b.depth_offset) &&
           same(a.cut, b.cut);
  }
  bool same(const Retract& a, const Retract& b) const { return a.with_clamping == b.with_clamping; }
  bool same(const Compensation& a, const Compensation& b) const {
    const bool is_off = a.side == CompensationSide::Off;
    return a.side == b.side && (is_off || near(a.value, b.value));
  }
  bool same(const Slot& a, const Slot& b) const {
    return a.tool == b.tool && same_place(a.start, b.start) && same_place(a.end, b.end) &&
           same(a.cut, b.cut);
  }
  bool same(const StepSlot& a, const StepSlot& b) const {
    return a.tool == b.tool && same_place(a.start, b.start) && same_place(a.end, b.end) &&
           near(std::optional(a.initial_depth), std::optional(b.initial_depth)) &&
           near(std::optional(a.increment), std::optional(b.increment)) &&
           same_feed(a.feed, a.feed_is_default, b.feed);
  }
  bool same(const Stop& a, const Stop& b) const {
    return a.kind == b.kind && a.actual.has_value() == b.actual.has_value() &&
           (!a.actual || near(a.actual->in_mm(), b.actual->in_mm(), kLastDigit_mm));
  }
  bool same(const Message& a, const Message& b) const { return a.is_long == b.is_long; }
  bool same(const Dwell& a, const Dwell& b) const {
    return std::abs((a.duration - b.duration).in_s()) < 1e-6;
  }
  bool same(const Function& a, const Function& b) const {
    return a.kind == b.kind && a.tool == b.tool && a.next_tool == b.next_tool;
  }
  bool same(const Setting& a, const Setting& b) const { return a.kind == b.kind; }
  bool same(const ToolRate& a, const ToolRate& b) const {
    return a.tool == b.tool && same_rate(a.infeed, b.infeed) && same_rate(a.retract, b.retract);
  }
  bool same(const Autocalibration& a, const Autocalibration& b) const {
    return near(a.nominal.in_mm(), b.nominal.in_mm(), kLastDigit_mm);
  }
  bool same(const ZeroSet& a, const ZeroSet& b) const {
    return near(a.work_zero.in_mm(), b.work_zero.in_mm(), kLastDigit_mm);
  }

  // Copies and targets are gone when an event is looked at; how many there were is not.
  bool same(const PatternBegin&, const PatternBegin&) const { return true; }
  bool same(const PatternEnd& a, const PatternEnd& b) const {
    return a.copies.size() == b.copies.size();
  }
  bool same(const VisionSeries& a, const VisionSeries& b) const {
    return a.level == b.level && a.targets.size() == b.targets.size();
  }
  bool same(const TargetHole& a, const TargetHole& b) const {
    return a.level == b.level && a.tool == b.tool &&
           near(a.nominal.in_mm(), b.nominal.in_mm(), tolerance_.place_mm);
  }
  bool same(const CancelCorrection& a, const CancelCorrection& b) const {
    return a.level == b.level;
  }
  bool same(const StoredCorrection& a, const StoredCorrection& b) const {
    return a.kind == b.kind && a.label == b.label;
  }
  bool same(const VisionTool& a, const VisionTool& b) const { return a.number == b.number; }
  bool same(const OpticalOrder& a, const OpticalOrder& b) const {
    return a.target.has_value() == b.target.has_value();  // the text is gone
  }
  bool same(const SurfaceOrder& a, const SurfaceOrder& b) const {
    return a.kind == b.kind && a.memory == b.memory;
  }

  Tolerance tolerance_;
  Vector2d at_mm_ = Vector2d::Zero();  ///< earlier place of the router
};

}  // namespace

std::vector<Event> essence_of(const std::vector<Event>& events) {
  std::vector<Event> out;
  for (const Event& event : events) {
    const auto* setting = std::get_if<Setting>(&event.what);
    const auto* function = std::get_if<Function>(&event.what);
    const bool is_own =
        setting != nullptr && (setting->kind != SettingKind::Body || event.text == "G05");
    const bool is_scaling = function != nullptr && (function->kind == FunctionKind::ScalingOn ||
                                                    function->kind == FunctionKind::ScalingOff);
    if (!is_own && !is_scaling) out.push_back(event);
  }
  return out;
}

std::string difference(const std::vector<Event>& a,
                       const std::vector<Event>& b,
                       Tolerance tolerance) {
  Sameness is_same(tolerance);
  const auto word = [](const Event& event) {
    const Operation operation{event.line, {}, event.what, {}, nullptr};
    return std::string(operation_name(operation)) + " of line " + std::to_string(event.line) + " " +
           event.text;
  };
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) {
    if (!is_same(a[i], b[i])) return word(a[i]) + " against " + word(b[i]);
  }
  if (a.size() > b.size()) return word(a[b.size()]) + " missing";
  if (a.size() < b.size()) return word(b[a.size()]) + " too much";
  return "";
}

}  // namespace panelcal::test
