// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <vector>

#include "program/writers/excellon/stored_operations.h"
#include "program/writers/program_writer.h"

namespace panelcal {

/// A plain Excellon program: absolute coordinates with decimal points in the unit and the axis
/// version of the source program, with the digits of output_digits.h. Coordinates are what the
/// machine is told, relative to work zero; a G93 of the source is kept, so that the controller adds
/// work zero exactly as before. Cycles must have been kept whole (WalkOptions::cycles): the passes
/// of a step slot have no form of their own. Where structure is kept, patterns become M25 to M08
/// and vision commands G34 to G48; where it is not, there are neither repeats nor vision. What a
/// SIEB & MEYER source has and Excellon has no form for is in losses().
///
/// A pattern of a SIEB & MEYER source is kept in memory until its copies are known.
///
/// Fails  number-too-long: a coordinate that does not fit those digits; not-supported: a tool block
/// whose data the header's would overrule; internal: a pass of a
///        step slot; translation-refused: working planes and depths, an offset from two targets
/// See    tests/program/writers/excellon/writer_test.cc
class ExcellonWriter final : public ProgramWriter {
 public:
  ExcellonWriter(ByteSink& bytes, ProgramWriterOptions options);

  void begin(const ProgramInfo& info) override;
  void put(const Operation& operation) override;

 private:
  void end() override;
  void put_tool(const Tool& tool,
                bool with_data,
                std::optional<int> compensation_index = std::nullopt);
  void append_rate(char letter, Feed rate, int n_digits);
  void append_speed(SpindleSpeed speed);
  char* write_length(char* at, double value) const;
  char* write_point(char* at, const Eigen::Vector2d& p_mm, std::string_view letters);
  static constexpr std::size_t kPointChars = 2 * (kFixedChars + 3);
  void append_length(char letter, Length length, int n_decimals);
  /// Of a tool or a depth, whose digits no header declares.
  void append_length(char letter, Length length) {
    append_length(letter, length, n_tool_decimals_);
  }
  /// A point or a difference of points in axis version 1.
  void append_point(const Eigen::Vector2d& p_mm, std::string_view letters = "XY");
  void append_place(const PlacedPoint& place) { append_point(place.commanded.in_mm()); }
  void close_header(std::string_view mark);
  void go_to_drill_mode();
  void put_table_feed(Feed feed, bool is_default);
  void put_now(const Operation& operation);

  void write(const ToolChange& change);
  void write(const ToolRate& rate);
  void write(const Autocalibration& calibration);
  void write(const Drill& drill);
  void write(const RapidMove& move);
  void write(const Rout& rout);
  void write(const Plunge& plunge);
  void write(const Retract& retract);
  void write(const Compensation& compensation);
  void write(const Slot& slot);
  void write(const StepSlot& slot);
  void write(const Stop& stop);
  void write(const Message& message);
  void write(const Dwell& dwell);
  void write(const Function& function);
  void write(const Setting& setting);
  void write(const ZeroSet& zero);
  void write(const OpticalOrder& order);
  void write(const SurfaceOrder& order);

  // foreign.cc
  void put_foreign_header();
  void put_foreign_message(std::string_view message);
  void put_foreign_setting(const Setting& setting);
  /// Depths have no form.
  void check_cut(const DepthOfCut& cut) {
    if (cut.is_controlled() || cut.z) refuse_cut(cut);
  }
  void refuse_cut(const DepthOfCut& cut);

  // stored_sets.cc
  /// The orders in a pattern to keep and use corrections; null: none.
  struct PatternSets {
    const StoredCorrection* keep = nullptr;
    const StoredCorrection* use = nullptr;  ///< each copy its own
    bool uses_others = false;               ///< one of another copy, or outside of patterns
  };
  /// M51, and the M52 behind it.
  struct Replay {
    int label = 0;
    int n_passed = 0;
    int n_points = 0;  ///< all have to be passed
  };
  bool hold(const Operation& operation);
  void put_held(const StoredCorrection* keep);
  void use_stored(const StoredCorrection& stored);
  void pass_points(const StoredCorrection& stored, int n_points, int n_all);
  void end_replay();
  bool is_replaying() const { return replay_ && replay_->n_passed < replay_->n_points; }
  void lose_looking();
  void note_base_series();
  PatternSets sets_of(std::size_t begin, std::size_t end) const;
  bool may_repeat_sets(const PatternSets& sets,
                       std::size_t begin,
                       std::size_t end,
                       std::size_t n_copies) const;
  bool works_before_use(std::size_t begin) const;
  bool measures_first(std::size_t begin, std::size_t end) const;
  bool is_superseded(std::size_t i, std::size_t end) const;
  bool leaves_base(std::size_t begin, std::size_t end) const;

  // structure.cc
  void store(const Operation& operation);
  void put_stored(std::size_t begin, std::size_t end, const WorkMap& map);
  void put_pattern(std::size_t begin, std::size_t end, const std::vector<WorkMap>& copies);
  void close_pattern(const std::vector<WorkMap>& copies);
  void write(const PatternBegin& begin);
  void write(const PatternEnd& end);
  void write(const VisionSeries& series);
  void write(const TargetHole& hole);
  void write(const CancelCorrection& cancel);
  void write(const StoredCorrection& stored);
  void write(const VisionTool& tool);
  void note_vision(std::string_view order);
  void say_vision_tool();

  bool in_header_ = true;
  std::set<int> limited_tools_;   ///< tools whose hit limit was written
  bool has_usual_digits_ = true;  ///< those that the written header states
  bool overrides_rates_ = false;  ///< G07: the body's rates rule from there on
  double written_unit_mm_ = 1;
  int n_decimals_ = 0;
  int n_tool_decimals_ = 0;
  double limit_ = 0;                    ///< coordinates are below it, in the written unit
  std::optional<ZeroSet> header_zero_;  ///< waits for the end of the header
  bool is_down_ = false;                ///< the router
  bool is_routing_ = false;             ///< the control is in rout mode (G00)
  Eigen::Vector2d at_mm_ = Eigen::Vector2d::Zero();  ///< place of the router
  std::optional<long> table_feed_;  ///< as last written; absent: to be written again
  bool has_table_feed_ = false;     ///< one was written, so that the control's own is gone
  bool has_end_ = false;            ///< the source's, if it has one

  StoredOperations stored_;  ///< of an open pattern
  int n_open_patterns_ = 0;
  StoredOperations held_;             ///< a base series, and what came behind it
  std::map<int, int> n_kept_copies_;  ///< that keep their corrections, by label
  int executed_copy_ = 0;             ///< of a pattern that is not repeated, from 1
  std::optional<Replay> replay_;      ///< outside of patterns
  bool has_base_ = false;             ///< a correction may be in force
  bool has_nested_ = false;           ///< one is in force, or was in this copy
  bool has_grid_ = false;             ///< that the other control measures
  bool has_vision_tool_ = false;
  std::optional<int> series_size_;  ///< as $uvis,alg said last
  int algorithm_ = 0;               ///< Excellon's own
};

}  // namespace panelcal
