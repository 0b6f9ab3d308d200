// SPDX-License-Identifier: Apache-2.0
#include "program/writers/csv_writer.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string_view>

#include "program/model/setting_lengths.h"
#include "program/writers/words.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// In the order of kHeader. The two columns of a point follow each other.
enum Column : std::size_t {
  kOp,
  kLine,
  kPath,
  kTool,
  kNominal,
  kActual = kNominal + 2,
  kSigma = kActual + 2,
  kDiameter = kSigma + 2,
  kFeed,
  kSpeed,
  kText,
  kKind,
  kCenter,
  kRetract = kCenter + 2,
  kMaxHits,
  kDepthOffset,
  kCompensationIndex,
  kSide,
  kValue,
  kNominalEnd,
  kActualEnd = kNominalEnd + 2,
  kSigmaEnd = kActualEnd + 2,
  kInitialDepth = kSigmaEnd + 2,
  kIncrement,
  kTime,
  kNextTool,
  kLong,
  kZeroSet,
  kWorkZero = kZeroSet + 2,
  kFile = kWorkZero + 2,
  kZ,
  kDepth,
  kSurface,
  kRisk,
  kRiskEnd,
  kSurfaceSigma,
  kSurfaceSource,
  kRiskShallow,
  kRiskDeep,
  kReference,
  kControl,
  kLowerLimit,
  kUpperLimit,
  kUnit,
  kColumns,  ///< number of columns
};

constexpr std::string_view kHeader =
    "op,line,path,tool,nominal_x,nominal_y,actual_x,actual_y,sigma_x,sigma_y,diameter,feed,speed,"
    "text,kind,center_x,center_y,retract,max_hits,depth_offset,compensation_index,side,value,"
    "nominal_end_x,nominal_end_y,actual_end_x,actual_end_y,sigma_end_x,sigma_end_y,initial_depth,"
    "increment,time,next_tool,long,zero_set_x,zero_set_y,work_zero_x,work_zero_y,file,z,"
    "depth,surface,risk,risk_end,surface_sigma,surface_source,risk_shallow,risk_deep,"
    "reference,control,lower_limit,upper_limit,unit\n";
static_assert(std::ranges::count(kHeader, ',') == kColumns - 1);

/// Writes one row from left to right; columns that are passed over stay empty.
class Row {
 public:
  explicit Row(std::string& out) : out_(out) {}

  /// Text to which the field is appended. Precondition: no column left of the last one.
  std::string& at(Column column) {
    out_.append(column - at_, ',');
    at_ = column;
    return out_;
  }
  void number(Column column, int n) {
    const fmt::format_int digits(n);
    at(column).append(digits.data(), digits.size());
  }
  void value(Column column, double v) { append_fixed(at(column), v, kMmDecimals); }
  void length(Column column, Length v) { value(column, v.in_mm()); }
  void point(Column column, const Eigen::Vector2d& p) {
    value(column, p.x());
    value(static_cast<Column>(column + 1), p.y());
  }
  void word(Column column, std::string_view v) { at(column) += v; }
  void risk(Column column, std::optional<double> v) {
    if (v) append_risk(at(column), *v);
  }
  /// Quotes a field where it needs quotes. An apostrophe before what a spreadsheet would take for
  /// a formula makes it a text there.
  void text(Column column, std::string_view v) {
    constexpr std::string_view kBeginFormulas = "=+-@\t\r";
    std::string& out = at(column);
    const bool is_formula = !v.empty() && kBeginFormulas.find(v.front()) != v.npos;
    if (!is_formula && v.find_first_of(",\"\r\n") == v.npos) {
      out += v;
      return;
    }
    out += '"';
    if (is_formula) out += '\'';
    for (const char c : v) {
      if (c == '"') out += '"';
      out += c;
    }
    out += '"';
  }

 private:
  std::string& out_;
  std::size_t at_ = kOp;
};

/// Fills all columns but the first three and `file`.
class Fields {
 public:
  explicit Fields(Row& row) : row_(row) {}

  void operator()(const Drill& drill) {
    row_.number(kTool, drill.tool);
    place(drill);
    risk_ = drill.risk;
    cut_ = &drill.cut;
  }
  void operator()(const ToolChange& change) {
    const Tool& tool = change.tool;
    row_.number(kTool, tool.number);
    if (tool.diameter) row_.length(kDiameter, *tool.diameter);
    if (tool.infeed) row_.value(kFeed, tool.infeed->in_mm_s());
    if (tool.speed) row_.value(kSpeed, tool.speed->in_rpm());
    if (tool.retract) row_.value(kRetract, tool.retract->in_mm_s());
    if (tool.max_hits) row_.number(kMaxHits, *tool.max_hits);
    if (tool.depth_offset) row_.length(kDepthOffset, *tool.depth_offset);
    if (change.compensation_index) row_.number(kCompensationIndex, *change.compensation_index);
  }
  void operator()(const RapidMove& move) { place(move); }
  void operator()(const Rout& rout) {
    row_.number(kTool, rout.tool);
    place(rout);
    risk_ = rout.risk;
    row_.value(kFeed, rout.feed.in_mm_s());
    row_.word(kKind, name(rout.kind));
    if (rout.kind != RoutKind::Line) row_.point(kCenter, rout.center.in_mm());
    cut_ = &rout.cut;
  }
  void operator()(const Plunge& plunge) {
    row_.number(kTool, plunge.tool);
    row_.word(kKind, word(plunge.kind));
    if (plunge.depth_offset) row_.length(kDepthOffset, *plunge.depth_offset);
    cut_ = &plunge.cut;
  }
  void operator()(const Retract& retract) { row_.word(kKind, word(retract)); }
  void operator()(const Compensation& compensation) {
    row_.word(kSide, word(compensation.side));
    if (compensation.value) row_.length(kValue, *compensation.value);
  }
  void operator()(const Slot& slot) {
    start(slot.tool, slot.start);
    end(slot.end);
    cut_ = &slot.cut;
  }
  void operator()(const StepSlot& slot) {
    start(slot.tool, slot.start);
    row_.value(kFeed, slot.feed.in_mm_s());
    end(slot.end);
    row_.length(kInitialDepth, slot.initial_depth);
    row_.length(kIncrement, slot.increment);
  }
  void operator()(const ToolRate& rate) {
    row_.number(kTool, rate.tool);
    if (rate.infeed) row_.value(kFeed, rate.infeed->in_mm_s());
    if (rate.retract) row_.value(kRetract, rate.retract->in_mm_s());
  }
  void operator()(const Autocalibration& calibration) {
    row_.point(kNominal, calibration.nominal.in_mm());
    row_.point(kActual, calibration.actual.in_mm());
  }
  void operator()(const Stop& stop) {
    if (stop.actual) row_.point(kActual, stop.actual->in_mm());
    row_.word(kKind, name(stop.kind));
  }
  void operator()(const Message& message) {
    row_.text(kText, message.text);
    if (message.is_long) row_.word(kLong, "true");
  }
  void operator()(const Dwell& dwell) { row_.value(kTime, dwell.duration.in_s()); }
  void operator()(const Function& function) {
    const bool expired = function.kind == FunctionKind::ToolExpired;
    if (expired) row_.number(kTool, function.tool);
    row_.text(kText, function.text);
    row_.word(kKind, name(function.kind));
    if (expired && function.next_tool) row_.number(kNextTool, *function.next_tool);
  }
  void operator()(const Setting& setting) {
    row_.text(kText, setting.text);
    is_text_in_inch_ = setting.unit == LengthUnit::Inch && may_have_length(setting.text);
  }
  void operator()(const ZeroSet& zero) {
    row_.point(kZeroSet, zero.zero_set.in_mm());
    row_.point(kWorkZero, zero.work_zero.in_mm());
  }
  void operator()(const PatternBegin&) {}
  void operator()(const PatternEnd& end) {
    row_.number(kValue, static_cast<int>(end.copies.size()));
  }
  void operator()(const VisionSeries& series) {
    row_.word(kKind, word(series.level));
    row_.number(kValue, static_cast<int>(series.targets.size()));
  }
  void operator()(const TargetHole& hole) {
    row_.number(kTool, hole.tool);
    row_.point(kNominal, hole.nominal.in_mm());
    row_.word(kKind, word(hole.level));
    cut_ = &hole.cut;
  }
  void operator()(const CancelCorrection& cancel) { row_.word(kKind, word(cancel.level)); }
  void operator()(const StoredCorrection& stored) { row_.number(kValue, stored.label); }
  void operator()(const VisionTool& tool) { row_.number(kTool, tool.number); }
  void operator()(const OpticalOrder&) {}
  void operator()(const SurfaceOrder&) {}

  /// Behind the file's column, which is the caller's.
  void depth_and_risk() {
    if (cut_ != nullptr) {
      if (cut_->z) row_.length(kZ, *cut_->z);
      if (cut_->depth) row_.length(kDepth, *cut_->depth);
      if (cut_->surface) row_.length(kSurface, *cut_->surface);
    }
    row_.risk(kRisk, risk_);
    row_.risk(kRiskEnd, risk_end_);
    if (cut_ == nullptr || !cut_->predicted) return;
    row_.length(kSurfaceSigma, cut_->predicted->sigma);
    row_.word(kSurfaceSource, name(cut_->predicted->source));
  }
  /// Behind the risks of the depth.
  void depth_state() {
    if (cut_ == nullptr) return;
    const DepthReference reference = cut_->counts_from();
    if (reference != DepthReference::Table) row_.word(kReference, name(reference));
    if (cut_->is_controlled()) row_.word(kControl, name(cut_->control));
    if (cut_->lower_limit) row_.length(kLowerLimit, *cut_->lower_limit);
    if (cut_->upper_limit) row_.length(kUpperLimit, *cut_->upper_limit);
  }
  /// Behind the depth. All other lengths are mm.
  void unit_of_text() {
    if (is_text_in_inch_) row_.word(kUnit, "inch");
  }

 private:
  void place(const PlacedPoint& at) {
    row_.point(kNominal, at.nominal.in_mm());
    row_.point(kActual, at.actual.in_mm());
    row_.point(kSigma, sigma_mm(at));
  }
  void start(int tool, const PlacedPoint& start) {
    row_.number(kTool, tool);
    place(start);
    risk_ = start.risk;
  }
  void end(const PlacedPoint& end) {
    row_.point(kNominalEnd, end.nominal.in_mm());
    row_.point(kActualEnd, end.actual.in_mm());
    row_.point(kSigmaEnd, sigma_mm(end));
    risk_end_ = end.risk;
  }

  Row& row_;
  const DepthOfCut* cut_ = nullptr;
  std::optional<double> risk_;
  std::optional<double> risk_end_;
  bool is_text_in_inch_ = false;
};

/// Fields behind sigma in the row of a hole without a risk.
constexpr auto kBehindSigma = [] {
  std::array<char, kColumns - kSigma - 1> end{};
  end.fill(',');
  end.back() = '\n';
  return end;
}();
/// The fields behind the risk.
constexpr std::size_t kHoleEnd = kColumns - kRisk;

char* write_integer(char* at, int n) {
  if (n < 0) *at++ = '-';
  return write_count(at,
                     n < 0 ? 0U - static_cast<std::uint32_t>(n) : static_cast<std::uint32_t>(n));
}

constexpr std::string_view kHoleName = "drill,";
constexpr std::size_t kMostPathLevels = 6;
constexpr std::size_t kHoleRowChars = kHoleName.size() + (kMostPathLevels + 2) * (kCountChars + 2) +
                                      3 * kCsvPointChars + kBehindSigma.size() + kRiskChars +
                                      kHoleEnd;

/// Nearly every row of a file is a hole's, so those are built at once instead of field by field.
/// Deep paths and stored patterns go the other way; null then.
const Drill* as_simple_hole(const Operation& operation) {
  const auto* drill = std::get_if<Drill>(&operation.what);
  const bool is_simple = drill != nullptr && operation.path.size() <= kMostPathLevels &&
                         operation.file.empty() && drill->cut.is_empty();
  return is_simple ? drill : nullptr;
}

char* write_path(char* at, std::span<const int> path) {
  for (const int index : path) {
    at = write_integer(at, index);
    *at++ = '.';
  }
  return path.empty() ? at : at - 1;
}

char* write_point(char* end, const Eigen::Vector2d& p_mm) {
  *end = ',';
  end = write_fixed_as<kMmDecimals>(end + 1, p_mm.x());
  *end = ',';
  return write_fixed_as<kMmDecimals>(end + 1, p_mm.y());
}

/// Copies the text of a point; gives its end. The copy may begin where the text ends.
char* copy_point(const char* text, std::size_t n_chars, char* to) {
  constexpr std::size_t kPiece = 16;  // moved by two instructions
  static_assert(kCsvPointChars % kPiece == 0);
  std::size_t i = 0;
  do {
    std::memmove(to + i, text + i, kPiece);
    i += kPiece;
  } while (i < n_chars);
  return to + n_chars;
}

}  // namespace

/// Holes under a mere offset have one sigma, and those without a correction have none: its text is
/// kept from the second hole on.
char* CsvWriter::write_sigma(char* at, const Drill& drill) {
  const double x_mm2 = drill.cov_mm2(0, 0);
  const double y_mm2 = drill.cov_mm2(1, 1);
  if (x_mm2 != sigma_.x_mm2 || y_mm2 != sigma_.y_mm2) {
    sigma_.x_mm2 = x_mm2;
    sigma_.y_mm2 = y_mm2;
    sigma_.n_chars = 0;
    return write_point(at, sigma_mm(drill));
  }
  char* const text = sigma_.text.data();
  if (sigma_.n_chars == 0) {
    sigma_.n_chars = static_cast<std::size_t>(write_point(text, sigma_mm(drill)) - text);
  }
  return copy_point(text, sigma_.n_chars, at);
}

char* CsvWriter::write_hole(char* end, const Operation& operation, const Drill& drill) {
  end = std::ranges::copy(kHoleName, end).out;
  end = write_integer(end, operation.line);
  *end++ = ',';
  if (!operation.path.empty()) end = write_path(end, operation.path);
  *end++ = ',';
  end = write_integer(end, drill.tool);
  const Eigen::Vector2d& nominal_mm = drill.nominal.in_mm();
  const Eigen::Vector2d& actual_mm = drill.actual.in_mm();
  const char* const nominal_text = end;
  end = write_point(end, nominal_mm);
  // Without a correction both are the same, and converting them is most of the work.
  end = actual_mm == nominal_mm
            ? copy_point(nominal_text, static_cast<std::size_t>(end - nominal_text), end)
            : write_point(end, actual_mm);
  end = write_sigma(end, drill);
  char* const risk = end + kBehindSigma.size() - kHoleEnd;
  end = std::ranges::copy(kBehindSigma, end).out;
  if (!drill.risk) return end;
  return std::copy_n(kBehindSigma.end() - kHoleEnd, kHoleEnd, write_risk(risk, *drill.risk));
}

void CsvWriter::begin(const ProgramInfo& info) {
  if (judge_) judge_->begin(info);
  text() += kHeader;
}

void CsvWriter::put(const Operation& operation) {
  static_assert(kHoleRowChars <= kMostRow);
  const Drill* const drill = as_simple_hole(operation);
  if (drill == nullptr) {
    // What was probed is in the strokes' depths.
    if (!std::holds_alternative<SurfaceOrder>(operation.what)) put_by_fields(operation);
    return;
  }
  end_row(write_hole(begin_row(kHoleRowChars), operation, *drill));
}

void CsvWriter::put_by_fields(const Operation& operation) {
  std::string& out = text();
  Row row(out);
  row.word(kOp, operation_name(operation));
  row.number(kLine, operation.line);
  row.at(kPath);
  for (std::size_t i = 0; i < operation.path.size(); ++i) {
    if (i > 0) out += '.';
    const fmt::format_int digits(operation.path[i]);
    out.append(digits.data(), digits.size());
  }
  Fields fields(row);
  std::visit(fields, operation.what);
  row.text(kFile, operation.file);
  fields.depth_and_risk();
  if (judge_) {
    if (const auto judged = judge_->judge(operation)) {
      row.risk(kRiskShallow, judged->risk.too_shallow);
      row.risk(kRiskDeep, judged->risk.too_deep);
    }
  }
  fields.depth_state();
  fields.unit_of_text();
  row.at(static_cast<Column>(kColumns - 1));
  out += '\n';
  flush_if_large();
}

}  // namespace panelcal
