// SPDX-License-Identifier: Apache-2.0
#include "program/writers/jsonl_writer.h"

#include <string_view>
#include <variant>

#include "calib/base/append_format.h"
#include "calib/base/json/json_string.h"
#include "program/model/setting_lengths.h"
#include "program/writers/words.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Appends the keys of one operation; the object is open before and after.
class Keys {
 public:
  explicit Keys(std::string& out) : out_(out) {}

  void operator()(const ToolChange& change) {
    number("tool", change.tool.number);
    if (change.tool.diameter) length("diameter", *change.tool.diameter);
    if (change.tool.infeed) value("feed", change.tool.infeed->in_mm_s());
    if (change.tool.retract) value("retract", change.tool.retract->in_mm_s());
    if (change.tool.speed) value("speed", change.tool.speed->in_rpm());
    if (change.tool.max_hits) number("max_hits", *change.tool.max_hits);
    if (change.tool.depth_offset) length("depth_offset", *change.tool.depth_offset);
    if (change.compensation_index) number("compensation_index", *change.compensation_index);
  }
  void operator()(const Drill& drill) {
    number("tool", drill.tool);
    place(drill);
    risk("risk", drill);
    depth(drill.cut);
  }
  void operator()(const RapidMove& move) { place(move); }
  void operator()(const Rout& rout) {
    number("tool", rout.tool);
    word("kind", name(rout.kind));
    point("nominal", rout.nominal.in_mm());
    point("actual", rout.actual.in_mm());
    if (rout.kind != RoutKind::Line) point("center", rout.center.in_mm());
    value("feed", rout.feed.in_mm_s());
    point("sigma", sigma_mm(rout));
    risk("risk", rout);
    depth(rout.cut);
  }
  void operator()(const Plunge& plunge) {
    number("tool", plunge.tool);
    word("kind", panelcal::word(plunge.kind));
    if (plunge.depth_offset) length("depth_offset", *plunge.depth_offset);
    depth(plunge.cut);
  }
  void operator()(const Retract& retract) { word("kind", panelcal::word(retract)); }
  void operator()(const Compensation& compensation) {
    word("side", panelcal::word(compensation.side));
    if (compensation.value) length("value", *compensation.value);
  }
  void operator()(const Slot& slot) {
    number("tool", slot.tool);
    ends(slot.start, slot.end);
    depth(slot.cut);
  }
  void operator()(const StepSlot& slot) {
    number("tool", slot.tool);
    ends(slot.start, slot.end);
    length("initial_depth", slot.initial_depth);
    length("increment", slot.increment);
    value("feed", slot.feed.in_mm_s());
  }
  void operator()(const ToolRate& rate) {
    number("tool", rate.tool);
    if (rate.infeed) value("feed", rate.infeed->in_mm_s());
    if (rate.retract) value("retract", rate.retract->in_mm_s());
  }
  void operator()(const Autocalibration& calibration) {
    point("nominal", calibration.nominal.in_mm());
    point("actual", calibration.actual.in_mm());
  }
  void operator()(const Stop& stop) {
    word("kind", name(stop.kind));
    if (stop.actual) point("actual", stop.actual->in_mm());
  }
  void operator()(const Message& message) {
    text("text", message.text);
    if (message.is_long) out_ += ",\"long\":true";
  }
  void operator()(const Dwell& dwell) { value("time", dwell.duration.in_s()); }
  void operator()(const Function& function) {
    word("kind", name(function.kind));
    if (!function.text.empty()) text("text", function.text);
    if (function.kind != FunctionKind::ToolExpired) return;
    number("tool", function.tool);
    if (function.next_tool) number("next_tool", *function.next_tool);
  }
  void operator()(const Setting& setting) {
    text("text", setting.text);
    // All other lengths are mm.
    if (setting.unit == LengthUnit::Inch && may_have_length(setting.text)) word("unit", "inch");
  }
  void operator()(const ZeroSet& zero) {
    point("zero_set", zero.zero_set.in_mm());
    point("work_zero", zero.work_zero.in_mm());
  }
  void operator()(const PatternBegin&) {}
  void operator()(const PatternEnd& end) {
    key("copies");
    number(static_cast<int>(end.copies.size()));
  }
  void operator()(const VisionSeries& series) {
    word("level", panelcal::word(series.level));
    key("targets");
    number(static_cast<int>(series.targets.size()));
  }
  void operator()(const TargetHole& hole) {
    number("tool", hole.tool);
    word("level", panelcal::word(hole.level));
    point("nominal", hole.nominal.in_mm());
    depth(hole.cut);
  }
  void operator()(const CancelCorrection& cancel) { word("level", panelcal::word(cancel.level)); }
  void operator()(const StoredCorrection& stored) { number("label", stored.label); }
  void operator()(const VisionTool& tool) { number("tool", tool.number); }
  void operator()(const OpticalOrder&) {}
  void operator()(const SurfaceOrder&) {}

  void depth_risk(const DepthRisk& risk) {
    key("risk_shallow");
    append_risk(out_, risk.too_shallow);
    key("risk_deep");
    append_risk(out_, risk.too_deep);
  }

 private:
  void key(std::string_view name) {
    out_ += ",\"";
    out_ += name;
    out_ += "\":";
  }
  void number(std::string_view name, int n) {
    key(name);
    number(n);
  }
  void number(int n) {
    const fmt::format_int digits(n);
    out_.append(digits.data(), digits.size());
  }
  void value(std::string_view name, double v) {
    key(name);
    append_fixed(out_, v, kMmDecimals);
  }
  void length(std::string_view name, Length v) { value(name, v.in_mm()); }
  void point(std::string_view name, const Eigen::Vector2d& p) {
    key(name);
    out_ += '[';
    append_fixed(out_, p.x(), kMmDecimals);
    out_ += ',';
    append_fixed(out_, p.y(), kMmDecimals);
    out_ += ']';
  }
  void text(std::string_view name, std::string_view v) {
    key(name);
    append_json_string(out_, v);
  }
  /// One of our own words, which need no escapes.
  void word(std::string_view name, std::string_view v) {
    key(name);
    out_ += '"';
    out_ += v;
    out_ += '"';
  }
  void depth(const DepthOfCut& cut) {
    if (cut.z) length("z", *cut.z);
    if (cut.depth) length("depth", *cut.depth);
    if (cut.surface) length("surface", *cut.surface);
    if (cut.predicted) {
      length("surface_sigma", cut.predicted->sigma);
      word("surface_source", panelcal::name(cut.predicted->source));
    }
    if (cut.counts_from() != DepthReference::Table) {
      word("reference", panelcal::name(cut.counts_from()));
    }
    if (cut.is_controlled()) word("control", panelcal::name(cut.control));
    if (cut.lower_limit) length("lower_limit", *cut.lower_limit);
    if (cut.upper_limit) length("upper_limit", *cut.upper_limit);
  }
  void place(const PlacedPoint& at) {
    point("nominal", at.nominal.in_mm());
    point("actual", at.actual.in_mm());
    point("sigma", sigma_mm(at));
  }
  void risk(std::string_view name, const PlacedPoint& at) {
    if (!at.risk) return;
    key(name);
    append_risk(out_, *at.risk);
  }
  void ends(const PlacedPoint& start, const PlacedPoint& end) {
    place(start);
    risk("risk", start);
    point("nominal_end", end.nominal.in_mm());
    point("actual_end", end.actual.in_mm());
    point("sigma_end", sigma_mm(end));
    risk("risk_end", end);
  }

  std::string& out_;
};

}  // namespace

void JsonlWriter::put(const Operation& operation) {
  // What was probed is in the strokes' depths.
  if (std::holds_alternative<SurfaceOrder>(operation.what)) return;
  std::string& out = text();
  out += "{\"op\":\"";
  out += operation_name(operation);
  out += "\",\"line\":";
  const fmt::format_int line(operation.line);
  out.append(line.data(), line.size());
  if (!operation.file.empty()) {
    out += ",\"file\":";
    append_json_string(out, operation.file);
  }
  Keys keys(out);
  std::visit(keys, operation.what);
  if (judge_) {
    if (const auto judged = judge_->judge(operation)) keys.depth_risk(judged->risk);
  }
  if (!operation.path.empty()) {
    internal::append_format(out, ",\"path\":[{}]", fmt::join(operation.path, ","));
  }
  out += "}\n";
  flush_if_large();
}

}  // namespace panelcal
