// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/writers/jsonl_writer.h"

#include <cmath>
#include <iterator>
#include <string_view>

#include <fmt/format.h>

#include "panelcal/program/json_text.h"

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
    point("nominal", drill.nominal.in_mm());
    point("actual", drill.actual.in_mm());
    point("sigma", {std::sqrt(drill.cov_mm2(0, 0)), std::sqrt(drill.cov_mm2(1, 1))});
  }
  void operator()(const Stop& stop) {
    key("kind");
    out_ += stop.kind == StopKind::EndRewind ? "\"end_rewind\"" : "\"end\"";
    if (stop.actual) point("actual", stop.actual->in_mm());
  }
  void operator()(const Message& message) { text("text", message.text); }
  void operator()(const Setting& setting) { text("text", setting.text); }
  void operator()(const ZeroSet& zero) {
    point("zero_set", zero.zero_set.in_mm());
    point("work_zero", zero.work_zero.in_mm());
  }

 private:
  void key(std::string_view name) {
    out_ += ",\"";
    out_ += name;
    out_ += "\":";
  }
  void number(std::string_view name, int n) {
    key(name);
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

  std::string& out_;
};

}  // namespace

void JsonlWriter::put(const Operation& operation) {
  std::string& out = text();
  out += "{\"op\":\"";
  out += operation_name(operation);
  out += "\",\"line\":";
  const fmt::format_int line(operation.line);
  out.append(line.data(), line.size());
  std::visit(Keys(out), operation.what);
  if (!operation.path.empty()) {
    fmt::format_to(std::back_inserter(out), ",\"path\":[{}]", fmt::join(operation.path, ","));
  }
  out += "}\n";
  flush_if_large();
}

}  // namespace panelcal
