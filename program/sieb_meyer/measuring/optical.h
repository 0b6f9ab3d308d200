// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "program/sieb_meyer/text/lexer.h"
#include "program/walk/control_settings.h"
#include "program/walk/measuring/measuring.h"

namespace panelcal::sieb_meyer {

/// A target as the program names it.
struct TargetPlace {
  Command command = Command::Measure;
  int line = 0;
  std::string file;  ///< of a subprogram; empty: the program itself
  std::string file_sha256;
  InstancePath path;
  Position<frame::Nominal> nominal;
  Placement placement;
  Position<frame::Machine> work_zero;
  std::vector<std::int64_t> copies;  ///< their number in each level of sections, outermost first
};

/// The optical measurement of one walk: points that wait for G31, the correction in force, and the
/// sets saved by G39.
///
/// Points gather until G31 fits them all; it uses them up. By scalar equations (a point gives two,
/// a slot of mode 5 one) fewer than 3 give an offset, fewer than 6 a rotation as well, from 6 on as
/// the machine's configuration says. Modes 2 and 3 measure a target layer by layer and take the
/// mean. optical_orders.cc has G39.
///
/// Source SIEB & MEYER CNC 8x.00 Command Set, 9 Optical Measurement; semantics page
/// See    tests/program/sieb_meyer/measuring/optical_manual_test.cc
class OpticalSession {
 public:
  OpticalSession(Measuring& measuring, const WalkOptions& options, const Reporter& reporter);

  void set_pattern_mode(bool is_on) { pattern_mode_ = is_on; }
  bool is_pattern_mode() const { return pattern_mode_; }
  void select_tool(int number) { tool_ = number; }

  void measure(const TargetPlace& target);  // G32, G33
  /// G36 under NOCAMA: where the hole is to be drilled; absent if the target was not found.
  std::optional<TargetHolePlace> measure_hole(const TargetPlace& target);
  void measure_pattern(const TargetPlace& target);  // G36 under CAMA
  void calculate(const TargetPlace& place);         // G31
  /// G30; `i_block` counts the blocks, since two in a row clear as well.
  void turn_off(std::int64_t i_block);
  void clear();  // G34
  /// G39; SPOP.. take what was measured last, calculated or not; REQCOMP (mode 3) calculates and
  /// activates like G31. `step` is the number of the pattern's copy, which SAVE, LOAD and CLEAR
  /// mean without one of their own. True: an order for the machine, to be passed on.
  bool organize(const Block& block, int step, const TargetPlace& place);
  /// True for such an order in this line that was not performed.
  bool is_unperformed(int line) const { return measuring_.is_unperformed(line); }
  /// True while a stroke would be the first under a correction that REQCOMP alone has turned on.
  bool is_assumed_on() const { return requested_ && requested_->is_assumed_on; }
  /// Warns of such a stroke in this line.
  void note_stroke(int line);
  /// A pattern's own offset ends with its copy; until then it holds for the copies inside as well.
  void begin_copy();
  void end_copy(int line);
  /// Reports targets that nothing was calculated from.
  void end_program(int line);

 private:
  static constexpr std::size_t kMostSets = 1000;
  static constexpr std::size_t kMostLayers = 100;  ///< no board has more

  /// The set that G39,SAVE keeps.
  struct SavedSet {
    std::optional<std::size_t> base;
    std::optional<std::size_t> nested;
    Placement placement;
    std::vector<std::int64_t> copies;
    bool has_number = false;  ///< the program named it
    int line = 0;
  };

  /// A G39,REQCOMP that no G31 stands behind yet. The manual leaves open whether the correction is
  /// on, and whether a later G31 counts the targets again.
  struct Request {
    int line = 0;
    std::string file;           ///< as the reporter names it
    std::size_t i_series = 0;   ///< the targets' fit
    bool is_assumed_on = true;  ///< no stroke and no other order for the correction came behind it
  };

  /// The points that G36 has measured in a copy, and the offset that was fitted to them.
  struct PatternState {
    std::vector<FitPoint> points;
    std::vector<std::size_t> measurements;
    bool has_lost = false;
    std::optional<std::size_t> nested;
    int n_turned_off = 0;  ///< times that a correction was turned off before the copy inside
  };

  std::optional<std::size_t> look(const TargetPlace& target,
                                  const Position<frame::Actual>& expected,
                                  ObservedAxes axes = ObservedAxes::Both,
                                  bool is_of_series = false);
  Position<frame::Actual> corrected(const Position<frame::Nominal>& nominal) const;
  ObservedAxes seen_axis(const TargetPlace& target, bool is_x);
  void add_point(const TargetPlace& target, ObservedAxes axes, std::size_t i_measurement);
  void close_layers();
  int n_equations() const;
  std::optional<SeriesAssignment> settle_points();
  SeriesResult new_series(CorrectionLevel level, const TargetPlace& place) const;
  bool has_open_layers(std::string_view order, int line);
  std::size_t fit_waiting(const TargetPlace& place);
  void put_in_force(int line);
  void forget_waiting();

  // optical_orders.cc
  void note_measured(std::vector<std::size_t> measurements);
  bool may_move_offset(const Block& block);
  bool is_made_of_last(std::size_t i_series) const;
  void forget_corrections_of_last();
  std::optional<OffsetCorrection> deviation_of_last(const Block& block, bool& is_lost);
  bool move_offset(const Block& block, const OffsetOrder& order, const TargetPlace& place);
  void request_correction(const Block& block, const TargetPlace& place);
  std::string request_text() const;
  void save(const Block& block, int slot, bool has_number, const TargetPlace& place);
  void load(const Block& block, int slot, const TargetPlace& place);

  Measuring& measuring_;
  const WalkOptions& options_;
  const Reporter& reporter_;
  int mode_;
  bool pattern_mode_;
  int tool_;

  std::vector<FitPoint> points_;
  std::vector<std::size_t> measurements_;  ///< that points_ are made of
  std::vector<FitPoint> layers_;           ///< of the target that G33 will finish
  std::vector<std::size_t> unsettled_;     ///< of points_: may be chosen among candidates
  int first_line_ = 0;
  double spread_mm_ = 0;
  std::optional<Request> requested_;
  std::vector<std::size_t> last_measurements_;  ///< that were calculated from, or moved an offset
  std::optional<OffsetCorrection> last_deviation_;  ///< theirs, once requested
  std::int64_t n_looks_ = 0;
  std::int64_t n_looks_at_order_ = 0;  ///< n_looks_ when last_deviation_ was first asked for
  PatternState pattern_;
  std::vector<PatternState> outer_patterns_;

  std::optional<std::size_t> base_;  ///< the last one calculated or loaded
  bool is_on_ = false;
  int n_turned_off_ = 0;
  std::optional<std::int64_t> turned_off_in_;  ///< the block of the last G30
  std::map<int, SavedSet> saved_;
};

}  // namespace panelcal::sieb_meyer
