// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>

#include "program/writers/program_writer.h"

namespace panelcal {

/// A SIEB & MEYER program in format 5000: absolute coordinates in mm with decimal points, in the
/// axis version of the source program, lines of at most 64 characters, tool data in the $ table.
/// Coordinates are what the machine is told, relative to work zero. With structure kept, patterns
/// become sections between M31 and M30, and vision commands G30 to G36.
///
/// A CNC command holds beyond the end of the program that gave it. So every program states its axes
/// (FV), and that the control neither scales nor turns (NOSA, NORA), since the coordinates have
/// what the source asked for. Program zero is the operator's unless the source sets it (FA, NOFA).
///
/// Numbers have three decimals and at most six digits, unless a finer resolution is asked for. They
/// are in mm for a source in inch too, lengths in its CNC commands included.
///
/// Contours begin and end with a T0 line, which is also what lowers and raises the cutter; a stop
/// for inspection is a message. What has no form is in losses().
///
/// Depths leave the control in the state that each stroke had in the source: G82, G83 or G71 with
/// its probes, Z, K and H as far as the program states them. A depth below a surface of a map is
/// a plane.
///
/// Fails  number-too-long: a place of 1 m or more that needs all its decimals; translation-refused:
///        a depth or limit left to the operator behind one that was stated, a pass of a step slot
///        (WalkOptions::step_slots has to be Kept, which is refused as well), M14, tool data that
///        change in the program, tools above T99, CNC commands of a source in inch whose numbers
///        are not described
/// Source SIEB & MEYER CNC 8x.00 Command Set, A.3, A.7, 3, 5, 9
/// See    tests/program/writers/sieb_meyer/writer_test.cc
class SiebMeyerWriter final : public ProgramWriter {
 public:
  SiebMeyerWriter(ByteSink& bytes, ProgramWriterOptions options);

  void begin(const ProgramInfo& info) override;
  void put(const Operation& operation) override;

 private:
  /// A place in the last decimal that is written.
  using Steps = std::array<std::int64_t, 2>;
  /// Z or K.
  struct Plane {
    std::optional<std::string> told;  ///< as last said; absent: not said, or not known in this copy
    bool was_told = false;            ///< anywhere in the program: the operator's value is gone
    bool is_left_open = false;        ///< in an open pattern, something uses the operator's value

    void tell(std::string number) {
      told = std::move(number);
      was_told = true;
    }
  };
  /// The depth that the control works at, as it was told last.
  struct Depth {
    std::optional<bool> is_controlled = false;  ///< G83; absent: not known in this copy
    bool is_slm = false;                        ///< G71
    Plane z;
    Plane k;
  };
  enum class Nested : std::uint8_t { None, InForce, Cancelled, Ended };
  /// A line of the program or of a subprogram.
  struct SourceLine {
    int number = 0;  ///< 0: none
    std::string file;
  };
  /// Words of a line of the source for the places that it gives.
  struct PlaceWords {
    SourceLine line;          ///< none: there are no words
    bool may_stop = false;    ///< M20: at the next place
    bool has_output = false;  ///< M21: at every place
    bool skips_grid = false;  ///< G77: likewise
    bool is_said = false;
  };

  /// The pattern that is open, of which one copy is written for all.
  struct OpenPattern {
    int n_nested_targets = 0;          ///< they count together
    bool works_ahead = false;          ///< before it has an offset of its own
    bool has_offset = false;           ///< ends with the copy
    bool has_kept = false;             ///< corrections of its copies
    bool has_whole = false;            ///< measured them, in place of nested ones
    bool cancels_ahead = false;        ///< G47 before the series that its copies measure
    bool works_behind_cancel = false;  ///< between the two
    bool restores_board = false;       ///< instead of a copy's correction
  };

  void end() override;

  // lines.cc
  void state_control(int axis_version);
  Steps steps(const Eigen::Vector2d& at_mm) const;
  void append_number(double value);
  std::string plane_text(Length height) const;
  void append_point(const Eigen::Vector2d& at_mm, std::string_view letters) {
    append_point(at_mm, letters, digits().n_decimals);
  }
  void append_point(const Eigen::Vector2d& at_mm, std::string_view letters, int n_decimals);
  void open_line(const Eigen::Vector2d& at_mm);
  void tool_up_line(const Eigen::Vector2d& at_mm);
  void say_place_words();
  void settle_place_words();
  PlaceWords& place_words();
  bool has_place_words() const { return place_words_.line.number != 0; }
  /// The operation in hand comes from there.
  bool is_of(const SourceLine& line) const {
    return line.number == source_line() && line.file == source_file();
  }
  void finish_line();
  void line(std::string_view text);
  void say_tool();
  void say_feed(const Rout& rout);
  void message(std::string_view text);
  void note_tool(const Tool& tool);
  void write_tool_table();
  void write_magazines(const Tool& tool);

  // depths.cc
  const DepthOfCut* told_cut(const DepthOfCut& cut);
  bool may_be_plane(const DepthOfCut& cut, Length z);
  void zero_offset();
  void note_offset_use(std::set<int>& tools, const std::set<int>& others);
  bool is_bracketed_by_slm() const { return n_open_patterns_ > 0 && begins_with_slm_; }
  bool needs_surface_line(const DepthOfCut& cut) const;
  void say_surface_line(const DepthOfCut& cut);
  void say_surface_line_of_contour(const DepthOfCut& cut);
  void say_depth(const DepthOfCut& cut, bool is_ramp);
  void say_control(bool is_controlled);
  void say_plane(char letter,
                 const std::optional<Length>& value,
                 Plane& plane,
                 std::string_view what);
  void begin_depths_of_copy();
  void end_depths_of_copy();
  void write(const SurfaceOrder& order);
  void probe(const SurfaceOrder& order, std::string_view command);
  void probe_grid(const SurfaceOrder& order, std::string_view command);

  // writer.cc
  void drill_line(const Eigen::Vector2d& at_mm, const DepthOfCut& cut, std::string_view command);
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
  void write(const ZeroSet& zero);

  // orders.cc
  void write(const Function& function);
  void note_pecking(FunctionKind kind);
  void write(const Setting& setting);
  void write_foreign(const Setting& setting);
  void write_in_mm(std::string_view setting, Length unit);
  bool was_nibbling_told(std::string_view setting);
  void note_average(std::string_view letter);
  void state_average(std::string_view letter);
  void write(const PatternBegin& begin);
  void write(const PatternEnd& end);
  void write(const VisionSeries& series);
  void write(const TargetHole& hole);
  void write(const CancelCorrection& cancel);
  void write(const StoredCorrection& stored);
  void write(const VisionTool& tool);
  void write(const OpticalOrder& order);
  void write_nested(const VisionSeries& series);
  bool may_be_whole(const VisionSeries& series) const;
  void write_whole(const VisionSeries& series);
  void measure_targets(const VisionSeries& series);
  void use_stored(const StoredCorrection& stored);
  void restore_board();
  void refuse_cancel_ahead();
  bool refuse_second_nested();
  void save_board();
  void clear_corrections();
  void refuse_uneven_copies(std::size_t n_copies);
  void switch_pattern_mode(bool is_on);
  void note_work();

  bool states_control_ = false;          ///< the lines that say how the control is to be
  std::array<std::string, 2> nibbling_;  ///< order and roughness as told last; empty: not known
  std::string average_;                  ///< the letter of SPAV as told last; empty: not known
  std::string line_;                     ///< not finished: words may follow
  bool is_tool_up_line_ = false;         ///< that line is a T0 line
  SourceLine line_source_;               ///< that it comes from
  PlaceWords place_words_;
  std::optional<int> pending_tool_;  ///< said in the next line with a coordinate
  int tool_ = 0;                     ///< the program's last
  std::map<int, Tool> tools_;
  std::set<int> used_tools_;

  Eigen::Vector2d at_mm_ = Eigen::Vector2d::Zero();  ///< place of the tool
  std::optional<Steps> up_at_;                       ///< the last coordinate line was T0 there
  bool is_down_ = false;
  bool has_routed_ = false;  ///< a line since the tool went down
  CompensationSide side_ = CompensationSide::Off;
  CompensationSide told_side_ = CompensationSide::Off;  ///< T0 switches it off
  std::optional<std::string> feed_;                     ///< as written last
  Depth depth_;
  DepthOfCut map_plane_;             ///< of the last stroke to a depth below a map's surface
  std::set<int> plane_tools_;        ///< that worked at planes of the program or the operator
  int plane_tool_ = -1;              ///< the last of them
  std::set<int> map_tools_;          ///< offset unknown, and set to zero
  bool has_left_standard_ = false;   ///< G83 was said
  bool is_switched_on_ = false;      ///< the source's own G71 holds; structure kept
  bool begins_with_slm_ = false;     ///< the open pattern: G71 held at its begin
  bool relies_on_standard_ = false;  ///< in an open pattern, without saying G82
  bool ends_contour_ = false;        ///< the last T0 line
  std::string_view probing_tool_;    ///< of the next line that probes: T0, TD
  bool pecks_ = false;               ///< G81 holds
  bool pulses_ = false;              ///< G89 holds
  std::string rout_words_;           ///< of the next rout line

  int n_open_patterns_ = 0;
  bool has_base_ = false;  ///< a correction may be in force
  // Of a source in Excellon, whose nested series become corrections of the copies by themselves:
  std::size_t n_board_targets_ = 0;  ///< of the last base correction
  bool keeps_copies_ = false;  ///< the next pattern, or the open one, has such series or keeps them
  std::size_t n_kept_copies_ = 0;  ///< of the pattern that kept them last
  bool uses_board_location_ = false;
  bool is_board_saved_ = false;        ///< the base correction
  bool is_saved_with_offset_ = false;  ///< with a nested one that was in force
  bool is_replaced_ = false;           ///< by that of a copy
  std::optional<int> kept_label_;      ///< of the corrections in the copies' locations
  Nested nested_ = Nested::None;
  bool has_outer_offset_ = false;   ///< measured outside of patterns, which only G34 ends
  bool has_loaded_offset_ = false;  ///< outside of patterns, in force until another takes over
  OpenPattern pattern_;
  std::optional<bool> pattern_mode_;  ///< CAMA, NOCAMA
};

}  // namespace panelcal
