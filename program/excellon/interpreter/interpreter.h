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

#include "program/excellon/patterns/canned_cycles.h"
#include "program/excellon/patterns/step_repeat.h"
#include "program/excellon/text/header.h"
#include "program/excellon/text/header_words.h"
#include "program/excellon/text/lexer.h"
#include "program/excellon/text/tools.h"
#include "program/excellon/vision/vision.h"
#include "program/text/plain_coordinate.h"
#include "program/walk/execution/emitter.h"
#include "program/walk/options.h"
#include "program/walk/program.h"
#include "program/walk/reporter.h"
#include "program/walk/survey.h"
#include "program/walk/trial_execution.h"

namespace panelcal::excellon {

/// One walk over a program. With a sink it executes; without one it measures and checks. With a
/// trial, a source and a sink it does both until the trial is over.
///
/// Memory does not grow with the number of holes: every instance of a step and repeat section reads
/// the pattern's text again.
///
/// interpreter.cc decides which block comes when, sections.cc which copy;
/// blocks.cc has numbers, holes and targets, settings.cc tools, zeros and
/// units, events.cc stops and messages, rout.cc routing,
/// cycles.cc canned cycles and stored patterns.
class Interpreter {
 public:
  Interpreter(const Program& program,
              const WalkOptions& options,
              Survey& survey,
              MeasurementSource* source,
              OperationSink* sink,
              DiagnosticLog& log,
              TrialExecution* trial = nullptr);

  /// Ends a measuring walk at a byte of the program, behind which it asks for nothing: the place
  /// that asked_until() of the check has given.
  void end_at(std::size_t offset);

  void run();

  /// End of the last line that measured, fitted or took back a fit.
  std::size_t asked_until() const { return asked_until_; }

 private:
  /// The last user of an axis: the two passes of the machine see different coordinates, so an axis
  /// may not be taken over from the one kind to the other. Cleared: an M08 came since. Lost: a P#,
  /// G93, M99 or a stop with a place did, and the manual does not say where they leave the
  /// position.
  enum class AxisUser : std::uint8_t { None, Work, Target, Cleared, Lost };
  enum class Motion : std::uint8_t { Drill, Rapid, Line, Clockwise, Counterclockwise };

  /// The state that every instance of a pattern starts with again.
  struct Modal {
    Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();  ///< programmed
    std::array<AxisUser, 2> user = {AxisUser::None, AxisUser::None};
    bool incremental = false;
    bool has_hole = false;
    Motion motion = Motion::Drill;
    bool has_start = false;  ///< a coordinate came since G00
    CompensationSide side = CompensationSide::Off;
    /// No coordinate came since M25: an axis left out is another one in each copy, or that of
    /// before the pattern. The manual does not say which; G91 goes on from where the program stood.
    bool begins_pattern = false;
    double at_step_mm = 0;                                  ///< rounding of the last coordinate
    double arc_step_mm = 0;                                 ///< rounding of A, or of I and J
    bool has_routed = false;                                ///< since the side was chosen
    std::optional<double> radius_mm;                        ///< A#
    std::array<std::optional<double>, 2> center_offset_mm;  ///< I# and J#
    std::optional<Feed> feed;                               ///< of the table
    Displacement<frame::Programmed> text_offset;            ///< CAN_TEXT_OFF
  };

  /// The numbers of a block that moves.
  struct MotionWords {
    std::array<std::optional<double>, 2> xy_mm;
    std::optional<double> radius_mm;
    std::array<std::optional<double>, 2> ij_mm;
    std::optional<Feed> feed;
    std::optional<double> depth_mm;          ///< Z#
    std::optional<double> initial_depth_mm;  ///< U#
    double step_mm = 0;                      ///< the coarsest last digit of all
  };

  /// A cycle, text or stored pattern with all its numbers, so that it can be repeated.
  struct Cycle {
    Command command = Command::DualInLine;
    int line = 0;
    std::optional<HoleSequence> holes;
    std::string name;  ///< of a stored pattern
    Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();
    double diameter_mm = 0;                              ///< of a canned circle
    Eigen::Vector2d end_mm = Eigen::Vector2d::Zero();    ///< of a slot
    Eigen::Vector2d shift_mm = Eigen::Vector2d::Zero();  ///< of the last copy
  };

  /// A cycle whose coordinates follow in blocks of their own.
  struct Pending {
    Command command = Command::DualInLine;
    int line = 0;
    std::string text;      ///< of the block, for messages
    std::string argument;  ///< text or name
    double pitch_mm = 0;   ///< of G82
    double row_mm = 0;     ///< of G82
    std::optional<Eigen::Vector2d> first_mm;
  };

  // interpreter.cc
  void pass_on_header();
  void run_line(const SourceLine& line);
  void read_line(const SourceLine& line);
  bool run_plain_lines(std::size_t end);
  void run_slashed(const SourceLine& line);
  void run_words(const SourceLine& whole);
  void run_block(const Block& block);
  std::optional<std::size_t> second_block(const Block& block) const;
  void run_code(const Block& block);
  void run_command(const Block& block, Command command);
  void run_without_operands(const Block& block, Command command);
  void check_rest();
  std::string_view as_written(std::string_view part) const;
  bool has_ended() const { return ended_ || emitter_.is_over_limit(); }

  // sections.cc
  void run_section(int line);
  void warn_of_feed(const RepeatSection& section);
  void warn_of_open_count(const RepeatSection& section);
  void warn_of_swap(const RepeatSection& section);
  void end_section(const RepeatSection& section);
  bool run_kept(const RepeatSection& section, const Modal& start);
  void run_level(const RepeatSection& section,
                 const Modal& start,
                 std::size_t level,
                 const Placement& outer);
  void check_tools_of_copies(const RepeatSection& section, const Modal& start);
  void take_tool_of(const Copies& copies);
  /// A section of a stored pattern that a section's copy called: boards are the outer one's.
  bool is_inner_section() const { return in_stored_pattern_ && pattern_depth_ > 0; }
  void run_instance(const RepeatSection& section, const Modal& start, const Placement& placement);

  // blocks.cc
  void coordinate(const Block& block);
  void drill_modal(int line);
  void repeat_hole(const Block& block);
  void measure(const Block& block, Command command);
  void keep_target(const TargetPlace& target);
  void select_vision_tool(const Block& block);
  void cancel_correction(const Block& block, Command command);
  void stored_label(const Block& block, Command command);
  void autocalibration(const Block& block);
  bool has_working_tool() const { return tool_ && tool_->number > 0; }
  bool has_tool(int line);

  // settings.cc
  void select_tool(const Block& block);
  Tool known_tool(const Block& block, const ToolBlock& read);
  void rate(const Block& block);
  void set_zero(const Block& block);
  void set_unit(const Block& block, LengthUnit unit);
  void unit_word(Block& block, const HeaderCommand& command);
  void take_format(const Block& block, StatedFormat stated);
  void report_contradiction(const Block& block);
  void report_outside(Code code, const Block& block);
  OptionAgain compare_with_header(const Block& block, const HeaderCommand& command);
  bool is_late_unit(LengthUnit unit) const;
  void pass_on_setting(const Block& block);
  /// Passes on a setting as written, in the unit in force.
  void pass_on(int line, std::string_view text, SettingKind kind = SettingKind::Body) {
    emitter_.put(line, Setting{text, kind, format().unit});
  }
  void pass_on_vision(int line, std::string_view text) {
    emitter_.put(line,
                 Setting{text, SettingKind::Vision, format().unit, vision_.is_unperformed(line)});
  }
  void check_comment(const SourceLine& line);
  void refuse_comment(const SourceLine& line, const PartialFormat& parts, bool is_left_open);
  bool agrees_with_comment(const Block& block);
  void header_word(const SourceLine& line);

  // events.cc
  void stop(const Block& block, std::span<const Word> words, StopKind kind);
  void end_program(const Block& block, std::span<const Word> words, StopKind kind);
  bool is_whole_end(const Block& block, std::span<const Word> words) const;
  void end_without_mark();
  std::string end_codes() const;
  void dwell(const Block& block);
  void message(const Block& block);
  void long_message(const SourceLine& line);
  void text_offset(const SourceLine& line);
  void function(const Block& block, FunctionKind kind);
  void switch_scaling(const Block& block, bool is_on);

  // rout.cc
  void start_motion(const Block& block, Motion motion);
  void move_or_rout(const Block& block, std::span<const Word> words);
  void rout_arc(const Block& block, const Eigen::Vector2d& from_mm, double step_mm);
  void plunge(const Block& block, PlungeKind kind);
  void retract(const Block& block, bool with_clamping);
  void set_table_feed(const Block& block, std::optional<Feed> feed);
  std::optional<Feed> table_feed();
  void switch_compensation(const Block& block, CompensationSide side);
  void routed_circle(const Block& block, Command command);
  void step_slot(const Block& block,
                 const Eigen::Vector2d& start_mm,
                 const Eigen::Vector2d& end_mm,
                 const MotionWords& words);
  std::optional<Length> compensation_value() const;
  std::optional<Length> tool_diameter() const;
  bool drill_mode(const Block& block);
  bool refuse_while_plunged(const Block& block);

  // cycles.cc
  void begin_cycle(const Block& block, Command command);
  void take_corner(const Block& block);
  void finish_cycle(const Block& block, const Pending& pending);
  void check_rows(const Pending& pending);
  void inline_cycle(const Block& block, std::size_t i_code, Command command);
  bool make_holes(const Block& block, const Word& word, Cycle& cycle);
  void run_cycle(const Block& block, const Cycle& cycle);
  void drill_holes(int line, const Cycle& cycle);
  void repeat_pattern(const Block& block);
  void engrave(const Block& block, const Pending& pending);
  void run_stored_pattern(const Block& block, const Cycle& cycle);
  void refuse_cut_off(const SourceText& pattern);
  bool refuse_pending(int line, std::string_view what);
  void refuse_cycle(const Block& block, const Word& word, const std::string& why);

  // helpers, blocks.cc
  /// Of the numbers that stand here.
  const NumberFormat& format() const { return stated_.format(); }
  bool is_alone(const Block& block, std::size_t n_words = 1);
  std::optional<Command> command(const Word& word) const { return command_of(word, set_); }
  bool read_words(const Block& block,
                  std::span<const Word> words,
                  std::string_view letters,
                  MotionWords& out);
  void warn_padded(const Block& block, const Word& word);
  bool read_word(const Block& block, const Word& word, MotionWords& out);
  bool move_to(const Block& block,
               const std::array<std::optional<double>, 2>& xy_mm,
               AxisUser user);
  double rounding_mm() const;
  void report(Code code, const Block& block, const Word& word, std::string expected);
  bool is_first_walk() const { return !emitter_.is_executing(); }
  /// Patterns and vision commands are passed on as such.
  bool keeps_structure() const {
    return options_.structure == Structure::Kept && emitter_.is_executing();
  }

  const Program& program_;
  const Header& header_;
  const std::string_view text_;  ///< of the program
  const WalkOptions& options_;
  TrialExecution* trial_;
  Reporter reporter_;
  VisionSession vision_;
  WalkPlace place_;
  Emitter emitter_;

  ProgramSet set_;
  bool deletes_blocks_;
  LineCursor cursor_;
  StatedFormat stated_;  ///< by the body as well, as far as it is read
  PlainReader plain_;    ///< in the format of `stated_`, see take_format()
  Modal modal_;
  const Placement axes_;  ///< axis version
  Placement frame_;       ///< of what is not inside a section: axis version, and a pattern's zero
  std::optional<Pending> pending_;
  std::optional<Cycle> last_cycle_;
  std::optional<Tool> tool_;
  std::optional<int> compensation_index_;
  /// The T# that changed the compensation index behind the G00 in force.
  std::optional<std::pair<Place, std::string>> late_index_;
  /// The last F# of rout mode in the pattern that is being executed, or in the program outside.
  std::optional<std::pair<Place, std::string>> feed_in_pattern_;
  bool takes_feed_from_before_ = false;  ///< a rout of that pattern, ahead of its first F#
  /// The last F# of a section whose pattern has routed at another feed before.
  std::optional<std::pair<Place, std::string>> late_feed_;
  std::map<int, bool> body_hits_off_;  ///< H without a number
  std::map<int, Tool> body_tools_;     ///< their data in the body, as far as it rules
  std::set<int> undefined_tools_;
  bool body_rules_;          ///< OM48
  bool has_dimension_;       ///< a number that the unit measures was read, in the header too
  bool body_rates_ = false;  ///< G07
  bool is_plunged_ = false;
  bool in_pattern_ = false;
  bool in_stored_pattern_ = false;
  std::size_t pattern_depth_ = 0;  ///< step and repeat levels around the stored pattern
  bool has_motion_ = false;
  /// The last comment that says whether coordinates are steps, until the next coordinate, and what
  /// it says.
  std::optional<std::pair<SourceLine, bool>> steps_comment_;
  bool warned_slash_ = false;
  bool warned_split_ = false;   ///< two blocks in a line
  bool warned_feed_ = false;    ///< of a pattern's copies
  bool warned_count_ = false;   ///< offsets counted anew without a bare M02
  bool warned_swap_ = false;    ///< M70 ahead of a mirror
  bool warned_padded_ = false;  ///< zeros beyond the format's digits
  bool reported_no_tool_ = false;
  int line_of_open_count_ = 0;  ///< see RepeatSection
  bool ended_ = false;          ///< nothing more is executed
  bool has_end_ = false;        ///< because the program said so
  bool ends_early_ = false;     ///< the end is that of end_at()
  std::int64_t n_refused_ = 0;  ///< Reporter::n_refused() ahead of the line in hand
  std::int64_t n_vision_steps_ = 0;
  std::size_t asked_until_ = 0;
};

}  // namespace panelcal::excellon
