// SPDX-License-Identifier: Apache-2.0
#include "program/writers/jsonl_writer.h"

#include <string_view>
#include <variant>

#include "calib/base/append_format.h"
#include "calib/base/json/json_string.h"
#include "program/writers/description.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Appends keys to an object, which is open before and after.
class Keys {
 public:
  explicit Keys(std::string& out) : out_(out) {}

  void number(Field field, int n) {
    key(field);
    const fmt::format_int digits(n);
    out_.append(digits.data(), digits.size());
  }
  void value(Field field, double v) {
    key(field);
    append_fixed(out_, v, kMmDecimals);
  }
  void length(Field field, Length v) { value(field, v.in_mm()); }
  void point(Field field, const Eigen::Vector2d& p) {
    key(field);
    out_ += '[';
    append_fixed(out_, p.x(), kMmDecimals);
    out_ += ',';
    append_fixed(out_, p.y(), kMmDecimals);
    out_ += ']';
  }
  void risk(Field field, double v) {
    key(field);
    append_risk(out_, v);
  }
  void flag(Field field) {
    key(field);
    out_ += "true";
  }
  void text(Field field, std::string_view v) {
    key(field);
    append_json_string(out_, v);
  }
  /// One of our own words, which need no escapes.
  void word(Field field, std::string_view v) {
    key(field);
    out_ += '"';
    out_ += v;
    out_ += '"';
  }

 private:
  void key(Field field) {
    out_ += ",\"";
    out_ += field.key;
    out_ += "\":";
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
  describe(operation, keys);
  if (judge_) {
    if (const auto judged = judge_->judge(operation)) {
      keys.risk("risk_shallow", judged->risk.too_shallow);
      keys.risk("risk_deep", judged->risk.too_deep);
    }
  }
  if (!operation.path.empty()) {
    internal::append_format(out, ",\"path\":[{}]", fmt::join(operation.path, ","));
  }
  out += "}\n";
  flush_if_large();
}

}  // namespace panelcal
