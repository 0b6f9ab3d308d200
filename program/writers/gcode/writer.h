// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "program/writers/gcode/setting.h"
#include "program/writers/program_writer.h"

namespace panelcal {

/// A G-code program: millimetres, absolute, feeds in mm/min, the first work zero (G54). For
/// LinuxCNC (RS274NGC), or another control (GcodeFlavour), whose program has moves instead of
/// cycles where it lacks these, and asks the operator for tools (M0) where it cannot change them.
///
/// X and Y are what the machine is told, from the work zero that the options name, x right and y up
/// whatever the program's axes; a G93 or FA of the program is in them. Z words are those of
/// GcodeSetting: a plane of the program counts from table_z, a depth below the measured surface
/// from there, one below a surface that is not measured from board_z; where the program says
/// nothing, holes go to drill_z and contours to rout_z, and a tool's depth offset comes to planes.
/// A missing value is refused.
///
/// The tool goes up alone before it goes anywhere else, and the exact path is asked for (G61): a
/// blended corner would draw a drill sideways through the board. Holes are cycles (G81, G83, G73),
/// or single moves where a tool's retract rate is known. Cycles have to be expanded
/// (WalkOptions::slots, step_slots), structure as well.
///
/// Precondition: what the flavour needs is there (check_output_format())
/// Fails  translation-refused: no depth, infeed, feed or speed; a surface that reaches up to where
/// the
///        tool moves rapidly; compensation by the control; M14; slots left whole. internal: a place
///        that is no number, an arc without one radius, structure
/// Source NIST RS274NGC version 3 (2000), 3.5, 3.6; LinuxCNC G-code reference; CNC-7 manual, Depth
///        Offset; SIEB & MEYER CNC 8x.00 Command Set, A.7
/// See    tests/program/writers/gcode/writer_test.cc
class GcodeWriter final : public ProgramWriter {
 public:
  GcodeWriter(ByteSink& bytes, ProgramWriterOptions options, GcodeSetting setting);

  void begin(const ProgramInfo& info) override;
  void put(const Operation& operation) override;

 private:
  /// A length in the last decimal that is written, a nanometre.
  using Steps = std::int64_t;
  using Place = std::array<Steps, 2>;
  enum class Height : std::uint8_t {
    Unknown,  ///< behind a change of tool
    Change,
    Safe,
    Down,
  };
  enum class Pecking : std::uint8_t { Off, Retracting, Pulsing };

  void end() override;

  // writer.cc
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
  void write(const Dwell& dwell);
  void write(const ZeroSet& zero);
  void take(const Tool& tool);
  void drill_cycle(const Place& at, Steps z, Feed infeed);
  void drill_moves(const Place& at, Steps z, Feed infeed);
  void peck_moves(const Place& at, Steps z, Feed infeed);
  void go_down(Steps z, Feed infeed);
  void go_up(Steps z);
  bool write_arc(const Rout& rout, const Place& to, Feed feed, std::string_view z_word);
  std::string_view cycle_code();

  // depths.cc
  std::optional<Steps> working_z(const DepthOfCut& cut,
                                 const std::optional<Length>& plane,
                                 const std::optional<Length>& offset,
                                 std::string_view plane_key);
  std::optional<Length> height_of(const DepthOfCut& cut,
                                  const std::optional<Length>& plane,
                                  std::string_view plane_key);
  bool surface_is_below(const DepthOfCut& cut);
  bool keeps_to_limits(const DepthOfCut& cut, Length z);
  Length rapid_limit() const { return setting_.approach_z.value_or(setting_.safe_z); }
  std::optional<Feed> infeed();
  std::optional<Feed> routing_feed(const Rout& rout);

  // events.cc
  void write(const Stop& stop);
  void write(const Message& message);
  void write(const Function& function);
  void write(const Setting& setting);
  void write(const PatternBegin&) { refuse_structure(); }
  void write(const PatternEnd&) { refuse_structure(); }
  void write(const VisionSeries&) { refuse_structure(); }
  void write(const TargetHole&) { refuse_structure(); }
  void write(const CancelCorrection&) { refuse_structure(); }
  void write(const StoredCorrection&) { refuse_structure(); }
  void write(const VisionTool&) { refuse_structure(); }
  void write(const OpticalOrder&) { refuse_structure(); }
  void write(const SurfaceOrder&) {}  // what was probed is in the depths
  void refuse_structure();
  std::string shown(std::string_view words) const;
  void comment(std::string_view words);
  void say_message(std::string_view words);
  void change_expired(const Function& expired);
  void pause(std::string_view code, const std::optional<Position<frame::Machine>>& place = {});
  void park(const std::optional<Position<frame::Machine>>& place);

  // words.cc
  Steps steps(double value_mm);
  Eigen::Vector2d from_zero_mm(const Position<frame::Machine>& actual) const;
  Place place_of(const Position<frame::Machine>& actual);
  static Eigen::Vector2d in_mm(const Place& at);
  std::string word(char letter, Steps value) const;
  std::string words(const Place& at) const;
  void say_move(std::string_view code, std::string_view rest, Feed feed);
  void say_rapid(std::string_view rest);
  void forget_feed();
  void leave_cycle();
  void rise();
  void go_to(const Place& at);
  bool start_spindle();
  void stop_spindle();

  GcodeSetting setting_;
  GcodeWording wording_;
  Tool tool_;
  GcodeWork work_;  ///< its values
  Height height_ = Height::Unknown;
  std::optional<Place> at_;      ///< the tool's place by the program
  std::optional<Place> told_;    ///< the tool's place by the control
  std::optional<Steps> told_z_;  ///< while it is down
  std::string feed_;             ///< F as written last
  std::string cycle_;            ///< words of the cycle that is in force; empty: none
  Pecking pecking_ = Pecking::Off;
  bool spindle_runs_ = false;
  bool has_ended_ = false;
};

}  // namespace panelcal
