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
#include "program/excellon/text/lexer.h"
#include "program/excellon/text/tools.h"
#include "program/excellon/vision/vision.h"
#include "program/text/plain_coordinate.h"
#include "program/walk/dialect.h"
#include "program/walk/execution/emitter.h"
#include "program/walk/options.h"
#include "program/walk/program.h"
#include "program/walk/reporter.h"
#include "program/walk/survey.h"
#include "program/walk/trial_execution.h"

namespace panelcal::excellon {

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
struct CannedCycle {
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

/// One walk over a program: its state, which every command reads and changes. With a sink it
/// executes; without one it measures and checks. With a trial, a source and a sink it does both
/// until the trial is over.
///
/// Memory does not grow with the number of holes: every instance of a step and repeat section reads
/// the pattern's text again.
struct Walk {
  Walk(const Program& walked,
       const WalkOptions& walk_options,
       Survey& survey,
       const WalkEnds& ends);
  Walk(const Walk&) = delete;
  Walk& operator=(const Walk&) = delete;

  /// Ends a measuring walk at a byte of the program, behind which it asks for nothing: the place
  /// that asked_until of the check has given.
  void end_at(std::size_t offset);
  bool has_ended() const { return ended || emitter.is_over_limit(); }
  /// A section of a stored pattern that a section's copy called: boards are the outer one's.
  bool is_inner_section() const { return in_stored_pattern && pattern_depth > 0; }
  bool has_working_tool() const { return tool && tool->number > 0; }
  /// Of the numbers that stand here.
  const NumberFormat& format() const { return stated.format(); }
  std::optional<Command> command(const Word& word) const { return command_of(word, set); }
  bool is_first_walk() const { return !emitter.is_executing(); }
  /// Patterns and vision commands are passed on as such.
  bool keeps_structure() const {
    return options.structure == Structure::Kept && emitter.is_executing();
  }
  bool is_in_copies() const { return in_pattern || in_stored_pattern; }
  /// Passes on a setting as written, in the unit in force.
  void pass_on(int line, std::string_view words, SettingKind kind = SettingKind::Body) {
    emitter.put(line, Setting{words, kind, format().unit});
  }
  void pass_on_vision(int line, std::string_view words) {
    emitter.put(line,
                Setting{words, SettingKind::Vision, format().unit, vision.is_unperformed(line)});
  }

  const Program& program;
  const Header& header;
  const std::string_view text;  ///< of the program
  const WalkOptions& options;
  TrialExecution* trial;
  Reporter reporter;
  VisionSession vision;
  WalkPlace place;
  Emitter emitter;

  ProgramSet set;
  bool deletes_blocks;
  LineCursor cursor;
  StatedFormat stated;  ///< by the body as well, as far as it is read
  PlainReader plain;    ///< in the format of `stated`, see take_format()
  Modal modal;
  const Placement axes;  ///< axis version
  Placement frame;       ///< of what is not inside a section: axis version, and a pattern's zero
  std::optional<Pending> pending;
  std::optional<CannedCycle> last_cycle;
  std::optional<Tool> tool;
  std::optional<int> compensation_index;
  /// The T# that changed the compensation index behind the G00 in force.
  std::optional<std::pair<Place, std::string>> late_index;
  /// The last F# of rout mode in the pattern that is being executed, or in the program outside.
  std::optional<std::pair<Place, std::string>> feed_in_pattern;
  bool takes_feed_from_before = false;  ///< a rout of that pattern, ahead of its first F#
  /// The last F# of a section whose pattern has routed at another feed before.
  std::optional<std::pair<Place, std::string>> late_feed;
  std::map<int, bool> body_hits_off;  ///< H without a number
  std::map<int, Tool> body_tools;     ///< their data in the body, as far as it rules
  std::set<int> undefined_tools;
  bool body_rules;          ///< OM48
  bool has_dimension;       ///< a number that the unit measures was read, in the header too
  bool body_rates = false;  ///< G07
  bool is_plunged = false;
  bool in_pattern = false;
  bool in_stored_pattern = false;
  std::size_t pattern_depth = 0;  ///< step and repeat levels around the stored pattern
  bool has_motion = false;
  /// The last comment that says whether coordinates are steps, until the next coordinate, and what
  /// it says.
  std::optional<std::pair<SourceLine, bool>> steps_comment;
  bool warned_slash = false;
  bool warned_split = false;   ///< two blocks in a line
  bool warned_feed = false;    ///< of a pattern's copies
  bool warned_count = false;   ///< offsets counted anew without a bare M02
  bool warned_swap = false;    ///< M70 ahead of a mirror
  bool warned_padded = false;  ///< zeros beyond the format's digits
  bool reported_no_tool = false;
  int line_of_open_count = 0;        ///< see RepeatSection
  bool ended = false;                ///< nothing more is executed
  bool has_end = false;              ///< because the program said so
  bool ends_early = false;           ///< the end is that of end_at()
  std::int64_t n_worked_before = 0;  ///< Emitter::n_worked() where the copy began
  std::int64_t n_refused = 0;        ///< Reporter::n_refused() ahead of the line in hand
  std::int64_t n_vision_steps = 0;
  std::size_t asked_until = 0;
};

}  // namespace panelcal::excellon
