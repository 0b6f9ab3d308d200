// SPDX-License-Identifier: Apache-2.0
#include "program/walk/execution/emitter.h"

#include <limits>
#include <utility>

#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr std::string_view kShorter = "a shorter program, or a higher --max-operations";

Transform<frame::Nominal, frame::Nominal> scaling_map(const ReferenceScaling& scaling) {
  const Eigen::Vector2d factor(scaling.x, scaling.y);
  const Eigen::Vector2d about_mm = scaling.about.in_mm();
  return {factor.asDiagonal(), about_mm - factor.cwiseProduct(about_mm)};
}

}  // namespace

Emitter::Emitter(const std::map<int, Tool>& header_tools,
                 const WalkOptions& options,
                 const WalkPlace& place,
                 const CorrectionState& corrections,
                 const Reporter& reporter,
                 OperationSink* sink)
    : options_(options),
      place_(place),
      corrections_(corrections),
      reporter_(reporter),
      sink_(sink),
      risks_(options, corrections),
      depths_(options.board, reporter) {
  if (options.scaling) scaling_ = scaling_map(*options.scaling);
  tolerance_ = options.tolerances.position;
  origin_.placement = &place.placement;
  origin_.base_series = &corrections.base_series;
  origin_.nested_series = &corrections.nested_series;
  origin_.work_zero = &place.work_zero;
  for (const auto& [number, tool] : header_tools) {
    if (tool.max_hits) max_hits_[number] = *tool.max_hits;
  }
}

// --- counting ----------------------------------------------------------------------------------

/// Counts one more; ends the walk above the limit.
bool Emitter::count(std::int64_t& n,
                    std::int64_t limit,
                    std::string_view things,
                    std::string_view expected,
                    int line) {
  if (n < limit) {
    ++n;
    return true;
  }
  if (!std::exchange(is_over_limit_, true)) {
    reporter_.report(Code::TooManyOperations,
                     line,
                     0,
                     fmt::format("more than {} {}", limit, things),
                     std::string(expected));
  }
  return false;
}

/// Idle lines cost less time than operations: a small limit on operations does not count for them.
std::int64_t Emitter::idle_limit() const {
  constexpr std::int64_t kAllowed = 10'000;
  return std::max(options_.max_operations, kAllowed);
}

bool Emitter::refuse_operations(int line) {
  n_operations_ = options_.max_operations;
  return count(n_operations_, options_.max_operations, "operations", kShorter, line);
}

void Emitter::count_copies(std::int64_t n_copies,
                           std::int64_t n_operations,
                           std::int64_t n_idle,
                           int line) {
  const auto is_too_many = [&](std::int64_t n_each, std::int64_t n, std::int64_t limit) {
    return n_each > 0 && n_copies > (limit - n) / n_each;
  };
  if (is_too_many(n_operations, n_operations_, options_.max_operations)) {
    refuse_operations(line);
  } else if (is_too_many(n_idle, n_idle_lines_, idle_limit())) {
    n_idle_lines_ = idle_limit();
    count_idle_line(line);
  } else {
    n_operations_ += n_copies * n_operations;
    n_idle_lines_ += n_copies * n_idle;
  }
}

bool Emitter::count_target(int line) {
  return count(n_targets_, options_.max_measurements, "targets", "a program with fewer", line);
}

bool Emitter::count_idle_line(int line) {
  return count(n_idle_lines_, idle_limit(), "idle lines of step and repeat", kShorter, line);
}

namespace {

/// What belongs to a contour, and not to the machine.
bool is_of_contour(const decltype(Operation::what)& what) {
  return std::holds_alternative<Retract>(what) || std::holds_alternative<Compensation>(what) ||
         std::holds_alternative<Autocalibration>(what);
}

}  // namespace

void Emitter::put(int line, decltype(Operation::what) what) {
  if (!count_operations(1, line)) return;
  ++n_words_;
  const bool is_withheld = corrections_.is_withheld && is_of_contour(what);
  if (sink_ != nullptr && !is_withheld) send(line, std::move(what));
}

void Emitter::send(int line, decltype(Operation::what) what) {
  sink_->put({line, place_.path, std::move(what), place_.pattern.path, &origin_});
}

// --- tools -------------------------------------------------------------------------------------

void Emitter::take(int line, const ToolChange& change) {
  hits_left_of_[fitted_tool_] = hits_left_;
  tool_ = fitted_tool_ = change.tool.number;
  origin_.tool_line = line;
  take_tolerance(line, change.tool);
  depths_.take(line, change.tool);
  if (change.tool.max_hits) {
    max_hits_[tool_] = *change.tool.max_hits;
  } else {
    max_hits_.erase(tool_);
  }
  hits_left_ = std::numeric_limits<std::int64_t>::max();
  if (const auto max = max_hits_.find(tool_); max != max_hits_.end()) {
    const auto left = hits_left_of_.find(tool_);
    hits_left_ =
        left == hits_left_of_.end() || left->second > max->second ? max->second : left->second;
  }
  put(line, change);
}

void Emitter::take_tolerance(int line, const Tool& tool) {
  tolerance_ = options_.tolerances.radius(tool.number, tool.diameter);
  if (!options_.tolerances.asks_positions() || tolerance_) return;
  std::string problem = options_.tolerances.problem(tool.number, tool.diameter);
  if (problem.empty()) return;
  reporter_.report(Code::ToleranceInvalid,
                   line,
                   0,
                   std::move(problem),
                   "position_um, or a pad and a drill that leave room for the ring");
}

/// Takes one tool after the other until the last one has enough hits left; gives how many of them
/// it is to be charged.
std::int64_t Emitter::use_up(int line, std::int64_t n) {
  while (hits_left_ < n && count(n_expired_, idle_limit(), "used up tools", kShorter, line)) {
    n -= hits_left_;
    expire(line);
    if (hits_left_ == 0) return 0;  // H0 allows nothing; once is enough to say it
  }
  return n;
}

/// The next linked tool takes over; without one the machine stops for a fresh tool.
/// Source CNC-7 manual, Set Maximum Hit Count; Link Tools
void Emitter::expire(int line) {
  Function expired{.kind = FunctionKind::ToolExpired,
                   .text = {},
                   .tool = fitted_tool_,
                   .next_tool = std::nullopt};
  hits_left_of_[fitted_tool_] = 0;
  // Round the links to one that is not used up; if all are, the operator has to refill.
  std::optional<int> next = links_.next(fitted_tool_);
  while (next && *next != fitted_tool_) {
    const auto left = hits_left_of_.find(*next);
    if (left == hits_left_of_.end() || left->second > 0) break;
    next = links_.next(*next);
  }
  if (next && *next != fitted_tool_) {
    expired.next_tool = next;
    fitted_tool_ = *next;
  }
  const auto max = max_hits_.find(fitted_tool_);
  hits_left_ = max == max_hits_.end() ? std::numeric_limits<std::int64_t>::max() : max->second;
  if (const auto left = hits_left_of_.find(fitted_tool_);
      expired.next_tool && left != hits_left_of_.end()) {
    hits_left_ = left->second;
  }
  if (sink_ != nullptr) send(line, expired);
}

// --- places ------------------------------------------------------------------------------------

void Emitter::note_origin(const Eigen::Vector2d& at_mm,
                          const Transform<frame::Nominal, frame::Nominal>* scaling) {
  origin_.programmed = position_mm<frame::Programmed>(at_mm);
  origin_.scaling = scaling;
}

/// A place that the map does not reach refuses the job; the first one alone is reported: all that
/// follow would say the same.
Displacement<frame::Machine> Emitter::commanded_on_table(
    int line, const Displacement<frame::Machine>& from_zero) {
  const Position<frame::Machine> place = place_.work_zero + from_zero;
  if (const auto command = options_.table->command_for(place)) return *command - place_.work_zero;
  if (!std::exchange(is_off_table_, true)) {
    const Diagnostic refusal = options_.table->refusal(place);
    reporter_.report_working(refusal.code, line, 0, refusal.what, refusal.expected);
  }
  return from_zero;
}

/// The first one alone is reported, as above.
void Emitter::refuse_uncorrected(int line) {
  if (options_.aligned == nullptr || std::exchange(has_refused_uncorrected_, true)) return;
  reporter_.report_working(Code::Usage,
                           line,
                           0,
                           "--align: the program drops the correction before this line",
                           "a program without G37, G30 and other commands for the camera");
}

PlacedPoint Emitter::place_of(int line,
                              const Position<frame::Nominal>& nominal,
                              const PositionEstimate<frame::Actual>& corrected) {
  const Displacement<frame::Machine> commanded = commanded_for(line, corrected.position);
  return {.nominal = nominal,
          .corrected = corrected.position,
          .commanded = commanded,
          .actual = place_.work_zero + commanded,
          .cov_mm2 = corrected.cov};
}

PlacedPoint Emitter::placed(int line, const Eigen::Vector2d& at_mm, Scaling scaling) {
  const bool is_scaled =
      scaling == Scaling::Applies && place_.is_scaled && options_.scaling.has_value();
  const auto nominal = place_.placement(position_mm<frame::Programmed>(at_mm));
  note_origin(at_mm, is_scaled ? &scaling_ : nullptr);
  if (!is_correcting()) refuse_uncorrected(line);
  const auto at = is_scaled ? scaling_(nominal) : nominal;
  PlacedPoint point = place_of(line, nominal, corrections_.stack.drilled(at));
  if (tolerance_ && is_correcting()) risks_.judge(at, *tolerance_, point);
  return point;
}

namespace {

/// Of the coordinates i and k of a mapped place: an element of J(p) cov J(p)^T, in the order of
/// TransformEstimate's own operations.
template <int kI, int kK>
[[gnu::always_inline]] inline double mapped_covariance(const Eigen::Matrix<double, 6, 6>& cov,
                                                       double x,
                                                       double y) {
  const double by_x = x * cov(2 * kI, 2 * kK) + y * cov(2 * kI, 2 * kK + 1) + cov(2 * kI, 4 + kK);
  const double by_y =
      x * cov(2 * kI + 1, 2 * kK) + y * cov(2 * kI + 1, 2 * kK + 1) + cov(2 * kI + 1, 4 + kK);
  const double shift = x * cov(4 + kI, 2 * kK) + y * cov(4 + kI, 2 * kK + 1) + cov(4 + kI, 4 + kK);
  return x * by_x + y * by_y + shift;
}

/// drilled_from_nominal() into the hole itself: a covariance that is copied just after it was
/// written takes longer than the correction.
inline void correct_hole(const TransformEstimate<frame::Actual, frame::Nominal>& map,
                         const Position<frame::Nominal>& nominal,
                         PlacedPoint& hole) {
  const double x = nominal.in_mm().x();
  const double y = nominal.in_mm().y();
  hole.corrected = map.map(nominal);
  hole.cov_mm2(0, 0) = mapped_covariance<0, 0>(map.cov, x, y);
  hole.cov_mm2(1, 1) = mapped_covariance<1, 1>(map.cov, x, y);
  hole.cov_mm2(0, 1) = hole.cov_mm2(1, 0) = mapped_covariance<0, 1>(map.cov, x, y);
}

}  // namespace

/// A hole of a panel that is bent, or where reference scaling is on.
void Emitter::correct_specially(bool is_scaled, PlacedPoint& hole) const {
  const auto place = is_scaled ? scaling_(hole.nominal) : hole.nominal;
  const CorrectionStack& stack = corrections_.stack;
  if (stack.smooth() != nullptr) {
    const PositionEstimate<frame::Actual> drilled = stack.drilled(place);
    hole.corrected = drilled.position;
    hole.cov_mm2 = drilled.cov;
  } else {
    correct_hole(stack.drilled_from_nominal(), place, hole);
  }
}

void Emitter::lead_over_table(int line, PlacedPoint& hole) {
  hole.commanded = commanded_on_table(line, hole.commanded);
}

void Emitter::judge_hole(bool is_scaled, PlacedPoint& hole) {
  risks_.judge(is_scaled ? scaling_(hole.nominal) : hole.nominal, *tolerance_, hole);
}

void Emitter::cut_hole(int line, Drill& drill) {
  has_hole_cut_ = !depths_.is_needed();
  drill.cut = has_hole_cut_ ? cut_ : cut_at(line, drill.nominal);
}

/// The operation is built in place and kept: copying it would take longer than correcting a hole.
/// Functions of its own hold what few jobs need, so that nothing here has to wait in memory.
void Emitter::drill_now(int line, const Eigen::Vector2d& at_mm) {
  hit(line, 1);
  auto& drill = *std::get_if<Drill>(&hole_.what);
  drill.nominal = place_.placement(position_mm<frame::Programmed>(at_mm));
  hole_.line = line;
  hole_.path = place_.path;
  hole_.file = place_.pattern.path;
  const bool is_scaled = place_.is_scaled && options_.scaling.has_value();
  const bool is_corrected = is_correcting();
  if (is_scaled || corrections_.stack.smooth() != nullptr) {
    correct_specially(is_scaled, drill);
  } else if (is_corrected) {
    correct_hole(corrections_.stack.drilled_from_nominal(), drill.nominal, drill);
  } else {
    refuse_uncorrected(line);
    drill.corrected = position_mm<frame::Actual>(drill.nominal.in_mm());
    drill.cov_mm2.setZero();
  }
  drill.risk.reset();
  drill.judged_risk.reset();
  if (tolerance_ && is_corrected) judge_hole(is_scaled, drill);
  drill.commanded = displacement_mm<frame::Machine>(drill.corrected.in_mm());
  if (options_.table != nullptr) lead_over_table(line, drill);
  drill.actual = place_.work_zero + drill.commanded;
  note_origin(at_mm, is_scaled ? &scaling_ : nullptr);
  drill.tool = tool_;
  if (depths_.is_needed() || !has_hole_cut_) cut_hole(line, drill);
  sink_->put(hole_);
}

void Emitter::drill_panel(const Eigen::Vector2d& at_mm) const {
  const auto nominal = place_.placement(position_mm<frame::Programmed>(at_mm));
  panel_->drill({nominal, corrections_.stack.actual_of(nominal), place_.work_zero});
}

void Emitter::drill_at_target(int line,
                              const Eigen::Vector2d& at_mm,
                              const TargetHolePlace& target) {
  if (!count_operations(1, line) || !needs_places() || corrections_.is_withheld) return;
  const auto nominal = place_.placement(position_mm<frame::Programmed>(at_mm));
  if (sink_ == nullptr) return panel_->drill({nominal, target.place.position, place_.work_zero});
  hit(line, 1);
  note_origin(at_mm, nullptr);
  origin_.i_measurement = target.i_measurement;
  Drill drill{place_of(line, nominal, target.place), tool_, cut_at(line, nominal)};
  if (tolerance_) risks_.judge_at_target(*tolerance_, drill);
  send(line, drill);
  origin_.i_measurement.reset();
}

void Emitter::slot(int line,
                   const Eigen::Vector2d& start_mm,
                   const Eigen::Vector2d& end_mm,
                   std::int64_t n_hits) {
  if (!passes(line)) return;
  hit(line, n_hits);
  const PlacedPoint end = placed(line, end_mm, Scaling::Applies);
  const PlacedPoint start = placed(line, start_mm, Scaling::Applies);
  send(line, Slot{tool_, start, end, cut_at(line, start.nominal)});
}

void Emitter::surface_order(int line,
                            SurfaceOrderKind kind,
                            std::optional<int> memory,
                            const std::optional<Eigen::Vector2d>& at_mm,
                            const DepthOfCut& cut) {
  if (!passes(line)) return;
  SurfaceOrder order{.kind = kind, .memory = memory, .cut = cut};
  if (at_mm) order.place = placed(line, *at_mm, Scaling::Never);
  send(line, order);
}

void Emitter::autocalibration(int line, const Eigen::Vector2d& at_mm) {
  const auto nominal = place_.placement(position_mm<frame::Programmed>(at_mm));
  const auto commanded = commanded_for(line, position_mm<frame::Actual>(nominal.in_mm()));
  put(line, Autocalibration{nominal, commanded, place_.work_zero + commanded});
}

}  // namespace panelcal
