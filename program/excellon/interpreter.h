// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <string_view>

#include "panelcal/program/excellon/lexer.h"
#include "panelcal/program/excellon/reporter.h"
#include "panelcal/program/excellon/step_repeat.h"
#include "panelcal/program/excellon/tools.h"
#include "panelcal/program/excellon/vision.h"
#include "panelcal/program/walk.h"

namespace panelcal::excellon {

/// One walk over a program. With a sink it executes; without one it measures and checks.
///
/// Memory does not grow with the number of holes: every instance of a step and repeat section reads
/// the pattern's text again.
class Interpreter {
 public:
  Interpreter(const Program& program,
              const WalkOptions& options,
              Survey& survey,
              MeasurementSource* source,
              OperationSink* sink,
              DiagnosticLog& log);

  void run();

 private:
  /// Who used an axis last: the two passes of the machine see different coordinates, so an axis
  /// may not be taken over from the one kind to the other. Cleared: an M08 came since.
  enum class AxisUser : std::uint8_t { None, Hole, Target, Cleared };

  /// What every instance of a pattern starts with again.
  struct Modal {
    Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();  ///< programmed
    std::array<AxisUser, 2> user = {AxisUser::None, AxisUser::None};
    bool incremental = false;
    bool has_hole = false;
  };

  void pass_on_header();
  void run_line(const SourceLine& line);
  void run_words(const SourceLine& line);
  void run_command(const Block& block, const Word& word, Command command);
  void run_without_operands(const Block& block, Command command);

  void run_section(int line);
  void end_section(const RepeatSection& section);
  void run_level(const RepeatSection& section,
                 std::size_t level,
                 const Transform<frame::Nominal, frame::Nominal>& outer);
  void run_pattern(const RepeatSection& section,
                   const Transform<frame::Nominal, frame::Nominal>& place);

  void drill_coordinate(const Block& block);
  void repeat_hole(const Block& block);
  void measure(const Block& block, Command command);
  void drill_modal(int line);
  void drill(int line,
             const Position<frame::Nominal>& nominal,
             const PositionEstimate<frame::Actual>& corrected);
  bool has_tool(int line);
  Position<frame::Nominal> nominal_here() const;
  void select_tool(const Block& block);
  Tool ruled_by_header(const Block& block, const Tool& tool);
  void set_zero(const Block& block);
  void set_unit(const Block& block, LengthUnit unit);
  void stored_label(const Block& block, Command command);
  void end_program(const Block& block, std::span<const Word> words, StopKind kind);
  void check_rest();

  bool is_alone(const Block& block, std::size_t n_words = 1);
  bool read_coordinates(const Block& block,
                        std::span<const Word> words,
                        std::array<std::optional<double>, 2>& xy_mm);
  bool move_to(const Block& block,
               const std::array<std::optional<double>, 2>& xy_mm,
               AxisUser user);
  void put(int line, decltype(Operation::what) what);
  bool count(std::int64_t& n, std::int64_t limit, std::string_view things, int line);
  bool count_operation(int line);
  bool count_target(int line);
  void count_idle_line(int line);
  void report(Code code, const Block& block, const Word& word, std::string expected);

  const Program& program_;
  const WalkOptions& options_;
  OperationSink* sink_;
  Reporter reporter_;
  VisionSession vision_;

  LineCursor cursor_;
  NumberFormat format_;
  Modal modal_;
  Modal pattern_start_;
  std::optional<int> tool_;
  std::set<int> undefined_tools_;
  Position<frame::Machine> work_zero_;
  Placement placement_;
  InstancePath path_;
  bool in_pattern_ = false;
  bool has_motion_ = false;
  bool warned_format_ = false;
  bool reported_no_tool_ = false;
  bool ended_ = false;    ///< nothing more is executed
  bool has_end_ = false;  ///< because the program said so
  std::int64_t n_operations_ = 0;
  std::int64_t n_targets_ = 0;
  std::int64_t n_idle_lines_ = 0;
};

}  // namespace panelcal::excellon
