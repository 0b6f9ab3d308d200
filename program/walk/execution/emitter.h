// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <string_view>
#include <utility>

#include "program/geometry/arcs.h"
#include "program/model/measurement.h"
#include "program/model/tool_links.h"
#include "program/walk/execution/depth_follower.h"
#include "program/walk/execution/risk_judge.h"
#include "program/walk/measuring/measuring.h"
#include "program/walk/options.h"
#include "program/walk/reporter.h"
#include "program/walk/trial_execution.h"

namespace panelcal {

/// Place of a walk in the program: what carries a programmed point to its place.
struct WalkPlace {
  Placement placement;
  InstancePath path;
  PatternFile pattern;  ///< of the lines that are walked; none: the program itself
  Position<frame::Machine> work_zero;
  bool is_scaled = false;  ///< M60 is in force
};

/// Turns what blocks ask for into operations: places and corrects points, counts everything, and
/// passes it to the sink if there is one. Points come in programmed coordinates, mm.
class Emitter {
 public:
  Emitter(const std::map<int, Tool>& header_tools,
          const WalkOptions& options,
          const WalkPlace& place,
          const CorrectionState& corrections,
          const Reporter& reporter,
          OperationSink* sink);

  bool is_executing() const { return sink_ != nullptr; }
  /// Tells a panel of holes, where nothing is executed; may be null, and outlives this.
  void drill_into(DrilledPanel* panel) { panel_ = panel; }
  /// Places of holes matter, and not their number alone.
  bool needs_places() const { return sink_ != nullptr || panel_ != nullptr; }
  /// Only counts from here on.
  void stop_executing() { sink_ = nullptr; }
  /// The same where a trial is over; it may be null.
  void stop_after(const TrialExecution* trial) {
    if (trial != nullptr && trial->is_over()) stop_executing();
  }
  /// More was asked for than the limits allow; that was reported.
  bool is_over_limit() const { return is_over_limit_; }
  std::int64_t n_operations() const { return n_operations_; }
  std::int64_t n_idle_lines() const { return n_idle_lines_; }
  /// Grows with what is done at places of the panel: tools and settings do not count.
  std::int64_t n_worked() const { return n_operations_ - n_words_; }
  /// The limit allows n more; else ends the walk before it begins them.
  bool has_room_for(std::int64_t n, int line) {
    return n <= options_.max_operations - n_operations_ || refuse_operations(line);
  }
  bool count_operations(std::int64_t n, int line) {
    if (!has_room_for(n, line)) return false;
    n_operations_ += n;
    return true;
  }
  /// Counts holes of which nothing but their number matters, as far as the limit allows, and gives
  /// how many. Precondition: !needs_places()
  std::int64_t count_unseen(std::int64_t n) {
    n = std::min(n, options_.max_operations - n_operations_);
    n_operations_ += n;
    return n;
  }
  /// Walks what is counted elsewhere.
  template <class Walk>
  void uncounted(Walk&& walk) {
    const auto n_operations = std::exchange(n_operations_, 0);
    const auto n_idle_lines = std::exchange(n_idle_lines_, 0);
    walk();
    n_operations_ = n_operations;
    n_idle_lines_ = n_idle_lines;
  }
  /// Counts copies that need not be walked: their number, operations and idle lines of each.
  void count_copies(std::int64_t n_copies,
                    std::int64_t n_operations,
                    std::int64_t n_idle,
                    int line);
  bool count_target(int line);
  /// Lines need not operate: without this a pattern of comments could be repeated for ever.
  bool count_idle_line(int line);

  void put(int line, decltype(Operation::what) what);
  void take(int line, const ToolChange& change);
  ToolLinks& links() { return links_; }

  /// Sets the depth of holes, plunges and rout moves from here on.
  void set_cut(const DepthOfCut& cut) {
    cut_ = cut;
    has_hole_cut_ = false;
  }
  const DepthOfCut& cut() const { return cut_; }
  /// Holes from here on are pecked from a height above the table or the board (DepthFollower).
  void set_pecking(bool pecks) { depths_.set_pecking(pecks); }
  /// The cut of the tool in use at a place: as deep as [[depth]] states, from the map's height.
  DepthOfCut cut_at(int line, const Position<frame::Nominal>& place) {
    return depths_.at(line, place, cut_);
  }
  /// Every hole has a height of its own, so that no cycle can be passed on whole.
  bool follows_map() const { return depths_.follows_map(cut_); }

  void drill(int line, const Eigen::Vector2d& at_mm) {
    if (!count_operations(1, line) || !needs_places() || corrections_.is_withheld) return;
    if (sink_ != nullptr) {
      drill_now(line, at_mm);
    } else {
      drill_panel(at_mm);
    }
  }
  void drill_at_target(int line, const Eigen::Vector2d& at_mm, const TargetHolePlace& target);
  /// `n_hits` holes stand for a slot that is passed on whole.
  void slot(int line,
            const Eigen::Vector2d& start_mm,
            const Eigen::Vector2d& end_mm,
            std::int64_t n_hits);
  void step_slot(int line,
                 const Eigen::Vector2d& start_mm,
                 const Eigen::Vector2d& end_mm,
                 Length initial_depth,
                 Length increment,
                 std::optional<Feed> feed);
  void autocalibration(int line, const Eigen::Vector2d& at_mm);
  /// Passes on an order of surface detection. Of those with a place it is where the probe is sent,
  /// which corrections move.
  void surface_order(int line,
                     SurfaceOrderKind kind,
                     std::optional<int> memory,
                     const std::optional<Eigen::Vector2d>& at_mm,
                     const DepthOfCut& cut = {});
  void move(int line, const Eigen::Vector2d& to_mm);
  void rout(int line, const Eigen::Vector2d& to_mm, std::optional<Feed> feed);
  void rout(int line, const Arc& arc, std::optional<Feed> feed) { rout(line, arc, feed, cut_); }
  /// An arc that goes evenly from another depth to the one that is set.
  void rout(int line, const Arc& arc, std::optional<Feed> feed, const DepthOfCut& from);
  /// Changes the control's compensation while the tool is down.
  void compensate(int line, CompensationSide side, std::optional<Length> compensation_value);
  /// Switches the control's compensation before it lowers the tool, where it differs from what the
  /// control knows; a mirrored placement exchanges left and right.
  void plunge(int line,
              PlungeKind kind,
              CompensationSide side,
              std::optional<Length> compensation_value,
              std::optional<Length> depth_offset = std::nullopt);

 private:
  enum class Scaling : std::uint8_t { Applies, Never };

  bool count(std::int64_t& n,
             std::int64_t limit,
             std::string_view things,
             std::string_view expected,
             int line);
  std::int64_t idle_limit() const;
  bool refuse_operations(int line);
  /// Nothing of a board that is left out passes.
  bool passes(int line) {
    return count_operations(1, line) && sink_ != nullptr && !corrections_.is_withheld;
  }
  void drill_now(int line, const Eigen::Vector2d& at_mm);
  [[gnu::noinline]] void drill_panel(const Eigen::Vector2d& at_mm) const;
  void hit(int line, std::int64_t n) {
    if (n > hits_left_) n = use_up(line, n);
    hits_left_ -= n;
  }
  std::int64_t use_up(int line, std::int64_t n);
  void expire(int line);
  CompensationSide placed_side(CompensationSide side) const;
  Eigen::Vector2d commanded_mm(int line, const Eigen::Vector2d& at_mm);
  void rout_way(int line, const Arc& path, std::optional<Feed> feed, const DepthOfCut& from);
  void rout_piece(int line,
                  const Arc& path,
                  std::optional<Feed> feed,
                  const DepthOfCut& from,
                  const DepthOfCut& to);
  void rout_bent(int line,
                 const Arc& path,
                 std::optional<Feed> feed,
                 const DepthOfCut& from,
                 const DepthOfCut& to);
  void rout_arc(int line,
                const Arc& arc,
                std::optional<Feed> feed,
                const DepthOfCut& from,
                const DepthOfCut& to);
  void stand_at(const Eigen::Vector2d& at_mm);
  DepthOfCut cut_where_it_stands(int line);
  void refuse_passes(int line);
  Rout rout_to(int line,
               const Eigen::Vector2d& at_mm,
               std::optional<Feed> feed,
               const DepthOfCut& cut);
  [[gnu::noinline]] void correct_specially(bool is_scaled, PlacedPoint& hole) const;
  [[gnu::noinline]] void lead_over_table(int line, PlacedPoint& hole);
  [[gnu::noinline]] void judge_hole(bool is_scaled, PlacedPoint& hole);
  [[gnu::noinline]] void cut_hole(int line, Drill& drill);
  PlacedPoint placed(int line, const Eigen::Vector2d& at_mm, Scaling scaling);
  PlacedPoint place_of(int line,
                       const Position<frame::Nominal>& nominal,
                       const PositionEstimate<frame::Actual>& corrected);
  /// The command that leads the machine there, from work zero.
  Displacement<frame::Machine> commanded_for(int line, const Position<frame::Actual>& place) {
    const auto from_zero = displacement_mm<frame::Machine>(place.in_mm());
    return options_.table == nullptr ? from_zero : commanded_on_table(line, from_zero);
  }
  void refuse_uncorrected(int line);
  Displacement<frame::Machine> commanded_on_table(int line,
                                                  const Displacement<frame::Machine>& from_zero);
  void take_center(const Eigen::Vector2d& commanded_center_mm, Rout& move) const;
  /// Straight ways of the machine are bent on the panel.
  bool is_bent() const { return corrections_.stack.is_bent() || options_.table != nullptr; }
  void take_tolerance(int line, const Tool& tool);
  bool is_correcting() const {
    return corrections_.stack.base() != nullptr || corrections_.stack.nested() != nullptr;
  }
  void note_origin(const Eigen::Vector2d& at_mm,
                   const Transform<frame::Nominal, frame::Nominal>* scaling);
  void send(int line, decltype(Operation::what) what);

  const WalkOptions& options_;
  const WalkPlace& place_;
  const CorrectionState& corrections_;
  const Reporter& reporter_;
  OperationSink* sink_;
  DrilledPanel* panel_ = nullptr;
  Transform<frame::Nominal, frame::Nominal> scaling_;

  int tool_ = 0;
  int fitted_tool_ = 0;  ///< in the spindle: a linked one after the programmed one was used up
  std::int64_t hits_left_ = std::numeric_limits<std::int64_t>::max();
  std::map<int, std::int64_t> hits_left_of_;
  std::map<int, int> max_hits_;
  ToolLinks links_;
  std::optional<Length> tolerance_;  ///< of the tool in use
  RiskJudge risks_;
  DepthOfCut cut_;  ///< as the program asks
  DepthFollower depths_;
  CompensationSide side_ = CompensationSide::Off;  ///< as the control was told last
  bool was_switched_off_ = false;                  ///< by the control itself, since then
  bool is_off_table_ = false;                      ///< and that was reported
  bool has_refused_uncorrected_ = false;
  /// Last place and depth of the tool; on a bent panel the way from there is no line.
  std::optional<Position<frame::Nominal>> stands_at_;
  DepthOfCut stands_at_cut_;
  Origin origin_;
  Operation hole_{.line = 0, .path = {}, .what = Drill(), .file = {}, .origin = &origin_};
  bool has_hole_cut_ = false;  ///< hole_ has cut_

  std::int64_t n_operations_ = 0;
  std::int64_t n_words_ = 0;  ///< of them, those of put()
  std::int64_t n_targets_ = 0;
  std::int64_t n_idle_lines_ = 0;
  std::int64_t n_expired_ = 0;  ///< tools: a slot that is kept whole uses up any number
  bool is_over_limit_ = false;
};

}  // namespace panelcal
