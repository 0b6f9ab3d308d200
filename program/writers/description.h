// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <string_view>
#include <variant>

#include "program/model/operation.h"
#include "program/model/setting_lengths.h"
#include "program/writers/words.h"

namespace panelcal {

/// Columns of operations in CSV. A point has two, which follow each other.
inline constexpr std::string_view kOperationColumns =
    "op,line,path,tool,nominal_x,nominal_y,actual_x,actual_y,sigma_x,sigma_y,diameter,feed,speed,"
    "text,kind,center_x,center_y,retract,max_hits,depth_offset,compensation_index,side,value,"
    "nominal_end_x,nominal_end_y,actual_end_x,actual_end_y,sigma_end_x,sigma_end_y,initial_depth,"
    "increment,time,next_tool,long,zero_set_x,zero_set_y,work_zero_x,work_zero_y,file,z,"
    "depth,surface,risk,risk_end,surface_sigma,surface_source,risk_shallow,risk_deep,"
    "reference,control,lower_limit,upper_limit,unit";
inline constexpr auto kNumberOfOperationColumns =
    static_cast<std::size_t>(std::ranges::count(kOperationColumns, ',')) + 1;

/// A datum of an operation: its key in JSON, and the column that it stands in, of the same name
/// unless told otherwise. One that has no column does not compile.
struct Field {
  std::string_view key;
  std::size_t column = 0;

  consteval Field(const char* name)  // NOLINT(google-explicit-constructor): keys are literals
      : Field(name, name) {}
  consteval Field(const char* name, std::string_view of_column) : key(name) {
    std::string_view rest = kOperationColumns;
    while (true) {
      const std::string_view here = rest.substr(0, rest.find(','));
      const bool is_point = here.ends_with("_x") && here.substr(0, here.size() - 2) == of_column;
      if (here == of_column || is_point) return;
      rest.remove_prefix(here.size() + 1);  // past the last column: no constant
      ++column;
    }
  }
};

/// Tells `out` the data of an operation but its name, line, file and path, in the order of JSON
/// Lines: docs/formats/operations.md. Lengths are mm, rates mm/s and rpm, times s.
///
/// In     out: has number(), value(), length(), point(), risk(), word() (of our own words) and
///        text(), each with the field and what it is
template <class Out>
class Description {
 public:
  explicit Description(Out& out) : out_(out) {}

  void operator()(const ToolChange& change) {
    const Tool& tool = change.tool;
    out_.number("tool", tool.number);
    if (tool.diameter) out_.length("diameter", *tool.diameter);
    if (tool.infeed) out_.value("feed", tool.infeed->in_mm_s());
    if (tool.retract) out_.value("retract", tool.retract->in_mm_s());
    if (tool.speed) out_.value("speed", tool.speed->in_rpm());
    if (tool.max_hits) out_.number("max_hits", *tool.max_hits);
    if (tool.depth_offset) out_.length("depth_offset", *tool.depth_offset);
    if (change.compensation_index) out_.number("compensation_index", *change.compensation_index);
  }
  void operator()(const Drill& drill) {
    out_.number("tool", drill.tool);
    place(drill);
    if (drill.risk) out_.risk("risk", *drill.risk);
    depth(drill.cut);
  }
  void operator()(const RapidMove& move) { place(move); }
  void operator()(const Rout& rout) {
    out_.number("tool", rout.tool);
    out_.word("kind", name(rout.kind));
    out_.point("nominal", rout.nominal.in_mm());
    out_.point("actual", rout.actual.in_mm());
    if (rout.kind != RoutKind::Line) out_.point("center", rout.center.in_mm());
    out_.value("feed", rout.feed.in_mm_s());
    out_.point("sigma", sigma_mm(rout));
    if (rout.risk) out_.risk("risk", *rout.risk);
    depth(rout.cut);
  }
  void operator()(const Plunge& plunge) {
    out_.number("tool", plunge.tool);
    out_.word("kind", word(plunge.kind));
    if (plunge.depth_offset) out_.length("depth_offset", *plunge.depth_offset);
    depth(plunge.cut);
  }
  void operator()(const Retract& retract) { out_.word("kind", word(retract)); }
  void operator()(const Compensation& compensation) {
    out_.word("side", word(compensation.side));
    if (compensation.value) out_.length("value", *compensation.value);
  }
  void operator()(const Slot& slot) {
    ends(slot.tool, slot.start, slot.end);
    depth(slot.cut);
  }
  void operator()(const StepSlot& slot) {
    ends(slot.tool, slot.start, slot.end);
    out_.length("initial_depth", slot.initial_depth);
    out_.length("increment", slot.increment);
    out_.value("feed", slot.feed.in_mm_s());
  }
  void operator()(const ToolRate& rate) {
    out_.number("tool", rate.tool);
    if (rate.infeed) out_.value("feed", rate.infeed->in_mm_s());
    if (rate.retract) out_.value("retract", rate.retract->in_mm_s());
  }
  void operator()(const Autocalibration& calibration) {
    out_.point("nominal", calibration.nominal.in_mm());
    out_.point("actual", calibration.actual.in_mm());
  }
  void operator()(const Stop& stop) {
    out_.word("kind", name(stop.kind));
    if (stop.actual) out_.point("actual", stop.actual->in_mm());
  }
  void operator()(const Message& message) {
    out_.text("text", message.text);
    if (message.is_long) out_.flag("long");
  }
  void operator()(const Dwell& dwell) { out_.value("time", dwell.duration.in_s()); }
  void operator()(const Function& function) {
    out_.word("kind", name(function.kind));
    if (!function.text.empty()) out_.text("text", function.text);
    if (function.kind != FunctionKind::ToolExpired) return;
    out_.number("tool", function.tool);
    if (function.next_tool) out_.number("next_tool", *function.next_tool);
  }
  void operator()(const Setting& setting) {
    out_.text("text", setting.text);
    // All other lengths are mm.
    const bool is_in_inch = setting.unit == LengthUnit::Inch && may_have_length(setting.text);
    if (is_in_inch) out_.word("unit", "inch");
  }
  void operator()(const ZeroSet& zero) {
    out_.point("zero_set", zero.zero_set.in_mm());
    out_.point("work_zero", zero.work_zero.in_mm());
  }
  void operator()(const PatternBegin&) {}
  void operator()(const PatternEnd& end) {
    out_.number({"copies", "value"}, static_cast<int>(end.copies.size()));
  }
  void operator()(const VisionSeries& series) {
    out_.word({"level", "kind"}, word(series.level));
    out_.number({"targets", "value"}, static_cast<int>(series.targets.size()));
  }
  void operator()(const TargetHole& hole) {
    out_.number("tool", hole.tool);
    out_.word({"level", "kind"}, word(hole.level));
    out_.point("nominal", hole.nominal.in_mm());
    depth(hole.cut);
  }
  void operator()(const CancelCorrection& cancel) {
    out_.word({"level", "kind"}, word(cancel.level));
  }
  void operator()(const StoredCorrection& stored) { out_.number({"label", "value"}, stored.label); }
  void operator()(const VisionTool& tool) { out_.number("tool", tool.number); }
  void operator()(const OpticalOrder&) {}
  void operator()(const SurfaceOrder&) {}

 private:
  void place(const PlacedPoint& at) {
    out_.point("nominal", at.nominal.in_mm());
    out_.point("actual", at.actual.in_mm());
    out_.point("sigma", sigma_mm(at));
  }
  void ends(int tool, const PlacedPoint& start, const PlacedPoint& end) {
    out_.number("tool", tool);
    place(start);
    if (start.risk) out_.risk("risk", *start.risk);
    out_.point("nominal_end", end.nominal.in_mm());
    out_.point("actual_end", end.actual.in_mm());
    out_.point("sigma_end", sigma_mm(end));
    if (end.risk) out_.risk("risk_end", *end.risk);
  }
  void depth(const DepthOfCut& cut) {
    if (cut.z) out_.length("z", *cut.z);
    if (cut.depth) out_.length("depth", *cut.depth);
    if (cut.surface) out_.length("surface", *cut.surface);
    if (cut.predicted) {
      out_.length("surface_sigma", cut.predicted->sigma);
      out_.word("surface_source", name(cut.predicted->source));
    }
    const DepthReference reference = cut.counts_from();
    if (reference != DepthReference::Table) out_.word("reference", name(reference));
    if (cut.is_controlled()) out_.word("control", name(cut.control));
    if (cut.lower_limit) out_.length("lower_limit", *cut.lower_limit);
    if (cut.upper_limit) out_.length("upper_limit", *cut.upper_limit);
  }

  Out& out_;
};

/// As above; nothing of an order of surface detection, whose heights are in the strokes' depths.
template <class Out>
void describe(const Operation& operation, Out& out) {
  std::visit(Description<Out>(out), operation.what);
}

}  // namespace panelcal
