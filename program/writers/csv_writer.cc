// SPDX-License-Identifier: Apache-2.0
#include "panelcal/program/writers/csv_writer.h"

#include <cmath>
#include <string_view>

#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::string_view kHeader =
    "op,line,path,tool,nominal_x,nominal_y,actual_x,actual_y,sigma_x,sigma_y,diameter,feed,speed,"
    "text\n";

void append_int(std::string& out, int n) {
  const fmt::format_int digits(n);
  out.append(digits.data(), digits.size());
}

void append_point(std::string& out, const Eigen::Vector2d& p) {
  append_fixed(out, p.x(), kMmDecimals);
  out += ',';
  append_fixed(out, p.y(), kMmDecimals);
}

/// Quotes a field where it needs quotes (RFC 4180).
void append_text(std::string& out, std::string_view text) {
  if (text.find_first_of(",\"\r\n") == std::string_view::npos) {
    out += text;
    return;
  }
  out += '"';
  for (const char c : text) {
    if (c == '"') out += '"';
    out += c;
  }
  out += '"';
}

/// Appends the columns from `tool` on.
class Columns {
 public:
  explicit Columns(std::string& out) : out_(out) {}

  void operator()(const ToolChange& change) {
    append_int(out_, change.tool.number);
    out_ += ",,,,,,,";
    if (change.tool.diameter) append_fixed(out_, change.tool.diameter->in_mm(), kMmDecimals);
    out_ += ',';
    if (change.tool.infeed) append_fixed(out_, change.tool.infeed->in_mm_s(), kMmDecimals);
    out_ += ',';
    if (change.tool.speed) append_fixed(out_, change.tool.speed->in_rpm(), kMmDecimals);
    out_ += ',';
  }
  void operator()(const Drill& drill) {
    append_int(out_, drill.tool);
    out_ += ',';
    append_point(out_, drill.nominal.in_mm());
    out_ += ',';
    append_point(out_, drill.actual.in_mm());
    out_ += ',';
    append_point(out_, {std::sqrt(drill.cov_mm2(0, 0)), std::sqrt(drill.cov_mm2(1, 1))});
    out_ += ",,,,";
  }
  void operator()(const Stop& stop) {
    out_ += ",,,";
    if (stop.actual) {
      append_point(out_, stop.actual->in_mm());
    } else {
      out_ += ',';
    }
    out_ += ",,,,,,";
    out_ += stop.kind == StopKind::EndRewind ? "end_rewind" : "end";
  }
  void operator()(const Message& message) { text_only(message.text); }
  void operator()(const Setting& setting) { text_only(setting.text); }
  void operator()(const ZeroSet& zero) {
    out_ += ",,,";
    append_point(out_, zero.work_zero.in_mm());
    out_ += ",,,,,,";
  }

 private:
  void text_only(std::string_view text) {
    out_ += ",,,,,,,,,,";
    append_text(out_, text);
  }

  std::string& out_;
};

}  // namespace

void CsvWriter::begin(const ProgramInfo&) {
  text() += kHeader;
}

void CsvWriter::put(const Operation& operation) {
  std::string& out = text();
  out += operation_name(operation);
  out += ',';
  append_int(out, operation.line);
  out += ',';
  for (std::size_t i = 0; i < operation.path.size(); ++i) {
    if (i > 0) out += '.';
    append_int(out, operation.path[i]);
  }
  out += ',';
  std::visit(Columns(out), operation.what);
  out += '\n';
  flush_if_large();
}

}  // namespace panelcal
