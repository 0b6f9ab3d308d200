// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "program/sieb_meyer/figures/corner_rounding.h"
#include "program/sieb_meyer/figures/drill_patterns.h"
#include "program/sieb_meyer/figures/rout_figures.h"
#include "program/sieb_meyer/measuring/optical.h"
#include "program/sieb_meyer/measuring/surface_commands.h"
#include "program/sieb_meyer/sections/sections.h"
#include "program/sieb_meyer/sections/subprograms.h"
#include "program/sieb_meyer/text/cnc_commands.h"
#include "program/sieb_meyer/text/file_layout.h"
#include "program/sieb_meyer/text/lexer.h"
#include "program/sieb_meyer/text/order.h"
#include "program/text/plain_coordinate.h"
#include "program/walk/dialect.h"
#include "program/walk/execution/emitter.h"
#include "program/walk/execution/hole_sequence.h"
#include "program/walk/options.h"
#include "program/walk/program.h"
#include "program/walk/reporter.h"
#include "program/walk/survey.h"
#include "program/walk/trial_execution.h"

namespace panelcal::sieb_meyer {

/// One walk over a program. With a sink it executes; without one it measures and checks. With a
/// trial, sources and a sink it does both until the trial is over.
///
/// Memory does not grow with the number of holes: every copy of a section reads its text again.
///
/// interpreter.cc decides which line comes when and what is done in it in which order,
/// sections.cc has sections and subprograms, drill.cc holes and patterns,
/// rout.cc contours, depth.cc planes, peck drilling and surfaces,
/// events.cc what the machine does by itself, cnc.cc the CNC commands of
/// M49.
class Interpreter {
 public:
  Interpreter(const Program& program,
              const WalkOptions& options,
              Survey& survey,
              const WalkEnds& ends);

  void run();

 private:
  enum class Contour : std::uint8_t {
    None,
    Positioned,  ///< a T0 line brought the cutter to where routing begins
    Routing,     ///< the cutter is down
    Figures,     ///< the last figure is finished, the cutter is up
  };

  /// Kind of the last line with a coordinate, from which a line takes an axis that it leaves out.
  enum class Reference : std::uint8_t {
    Coordinate,  ///< or the program's begin: X0Y0
    Section,     ///< the offsets of a section: only G91 has a reference there, program zero
    Call,        ///< M99: whether its own, the subprogram's or the one before it, is open
    Begin,       ///< none came since M31: that of before the section, or of the copy before
    Area,        ///< M56 to M58: a place where nothing is worked
  };

  /// The state that every copy of a section starts with again.
  struct Modal {
    Eigen::Vector2d at_mm = Eigen::Vector2d::Zero();  ///< programmed
    Reference reference = Reference::Coordinate;
    double at_step_mm = 0;  ///< rounding of the last coordinate
    bool incremental = false;
    std::optional<Command> motion;  ///< G1 to G3, G45 to G50; absent: coordinates drill
    CompensationSide side = CompensationSide::Off;
    std::optional<double> radius_mm;                        ///< R
    std::array<std::optional<double>, 2> center_offset_mm;  ///< I, J
    double arc_step_mm = 0;
    std::optional<Feed> feed;
  };

  /// Peck drilling (G81) and pulse drilling (G89), of which one at most is on.
  struct Peck {
    bool is_on = false;
    bool is_pulsing = false;
    double lowering_mm = 0;
    double first_stroke_mm = 0;
    double factor_permille = 1000;
    bool forces_target = false;  ///< PEKM,D: a last stroke goes down to the working plane
  };

  /// A piece of a contour that waits for the next one, since its end may be rounded.
  struct PendingPiece {
    ContourPiece piece;
    int line = 0;
    std::string text;
    std::optional<double> rounding_mm;  ///< D
    bool finishes = false;              ///< G11
    CompensationSide side = CompensationSide::Off;
    DepthOfCut from;  ///< differs from `to` on a ramp
    DepthOfCut to;
    bool follows_grid = false;
    std::optional<Feed> feed;
    std::vector<std::pair<FunctionKind, std::string_view>> events;  ///< before it
  };

  /// A pattern or slot that waits for its second point.
  struct PendingPattern {
    int v = 0;  ///< V1 to V4; 0: the slot of G85
    Eigen::Vector2d first_mm = Eigen::Vector2d::Zero();
    int line = 0;
    std::string text;
    bool may_stop = false;    ///< M20: at the first hole
    bool has_output = false;  ///< M21: at all of them
  };

  /// A square in which no hole is drilled (M58).
  struct ForbiddenArea {
    Position<frame::Nominal> center;
    double half_mm = 0;
  };

  /// Offsets of patterns (CAMA).
  struct KeptOffsets {
    bool has_own = false;            ///< ends with the copy
    bool has_outer = false;          ///< that may have been in force before the copy began
    int n_targets = 0;               ///< of G36 in this copy: they count together, until G34
    bool has_outer_targets = false;  ///< count again behind the copy
  };
  /// A section that is passed on as such.
  struct KeptSection {
    int n_copies = 0;
    std::size_t n_waiting = 0;              ///< targets from ahead of it
    bool has_series = false;                ///< by G31, in each copy
    int n_targets = 0;                      ///< that each copy measures, by G32 and G36
    std::optional<StoredCorrection> saved;  ///< by each copy
    bool has_loaded = false;                ///< each copy has loaded its own
    bool has_late_series = false;           ///< G31 behind G36
    int base = 0;                           ///< KeptState::base as it began
    bool uses_base = false;                 ///< keeps or loads offsets on top of that from outside
    std::optional<int> unsaved_offset;  ///< line of a G36 behind G39,SAVE that none stands behind
  };
  /// The content of a storage location.
  struct KeptSet {
    StoredCorrection correction;
    /// KeptState::base that comes back with it, or that an offset alone stands on; absent: each
    /// copy has measured its own.
    std::optional<int> base;

    bool is_offset_alone() const { return correction.is_offset && correction.n_targets == 1; }
  };
  /// For translation: corrections as other languages know them.
  struct KeptState {
    std::vector<Position<frame::Nominal>> targets;  ///< that G31 will fit
    KeptOffsets offsets;
    bool may_load_offset = false;  ///< a set was saved under one
    int n_of_last = 0;             ///< targets of the last correction, if it was calculated
    bool is_fit_in_force = false;  ///< no other correction came behind the last G31 or REQCOMP
    std::optional<std::int64_t> turned_off_in;  ///< the block of the last G30
    std::optional<KeptSection> section;         ///< that is passed on
    int n_labels = 0;
    int n_bases = 0;              ///< base corrections that came into force
    int base = 0;                 ///< the one in force, by its number; 0: none
    std::map<int, KeptSet> sets;  ///< by storage location, with the copy that saved them
  };
  /// G39 as another language says it.
  struct KeptOrder {
    std::string_view remedy;  ///< the form that it needs instead, if it cannot; valid for ever
    std::optional<StoredCorrection> stored;
  };

  /// A subprogram that is being executed, or the program itself.
  struct Text {
    std::string_view bytes;
    std::string_view file;  ///< empty: the program itself
    const SectionTree* sections = nullptr;
  };

  struct Scaling {
    Eigen::Vector2d factor = Eigen::Vector2d::Ones();
    Eigen::Vector2d about_mm = Eigen::Vector2d::Zero();
    std::optional<bool> is_on;   ///< M93, M92; absent: neither was there yet, and SA scales
    bool was_assumed = false;    ///< a coordinate was scaled that neither M93 nor M92 decides on
    bool is_behind_m92 = false;  ///< SA came under M92, and no coordinate since
    /// A scaled coordinate of this copy came before its first M93 or M92; false: behind it; absent:
    /// neither came.
    std::optional<bool> takes_over;

    bool is_set() const { return factor != Eigen::Vector2d::Ones(); }
    bool scales() const { return is_on.value_or(true); }
  };

  // interpreter.cc
  void run_line(const SourceLine& line);
  void read_line(const SourceLine& line);
  bool run_plain_lines(std::size_t end);
  void run_block(const Block& block);
  void update_care();
  void run_order(const Block& block, const Order& order);
  void prepare(const Block& block, const Order& order);
  bool holds_only(const Block& block, const Order& order, std::uint32_t known);
  void move_or_measure(const Block& block, const Order& order);
  void call_or_write(const Block& block, const Order& order);
  bool has_reference() const;
  std::string_view reference_text() const;
  bool has_axes(const Block& block, const Order& order);
  bool move_to(const Order& order);
  void end_program();
  bool has_ended() const {
    return ended_ || emitter_.is_over_limit() || measuring_.must_stop() || surface_.must_stop();
  }

  // sections.cc
  void run_text(const Text& text,
                const std::vector<int>& sections,
                LinePlace begin,
                std::size_t end);
  void run_section(int i_section);
  void run_body(int i_section);
  void run_copies(int i_section);
  void run_copy(int i_section, const Modal& start);
  void after_section(const Section& section);
  const Layout* called_layout(std::string_view name, bool deletes_blocks);
  bool may_call(const Block& block, const std::string& name);
  const SectionTree& sections_of(const std::string& name,
                                 const SourceText& source,
                                 const SubprogramText& body);
  void call(const Block& block, const Order& order);
  void place(const Placement& placement);
  int step_number() const;

  // drill.cc
  void drill(int line, const Eigen::Vector2d& at_mm);
  bool is_forbidden(int line, const Eigen::Vector2d& at_mm);
  void drill_all(int line, const HoleSequence& holes);
  void begin_pattern(const Block& block, const Order& order);
  void end_pattern(const Block& block, const Order& order);
  void nibble_circle(const Block& block, const Order& order);
  void drill_text(const Block& block, bool upwards);
  std::optional<double> tool_diameter_mm(const Block& block);
  bool has_tool(int line);
  bool may_work(int line);

  // rout.cc
  void position(const Block& block, const Order& order);
  void end_contour(int line);
  bool may_rout(const Block& block);
  void rout(const Block& block, const Order& order);
  bool make_arc(const Block& block, bool clockwise, ContourPiece& piece);
  bool make_radius_arc(const Block& block, bool clockwise, ContourPiece& piece);
  bool make_center_arc(const Block& block, bool clockwise, ContourPiece& piece);
  bool make_quadrant(const Block& block, bool clockwise, ContourPiece& piece);
  void flush_piece(PendingPiece* next);
  void send_piece(const PendingPiece& pending);
  void send_part(int line,
                 const ContourPiece& piece,
                 std::optional<Feed> feed,
                 const DepthOfCut& from);
  std::vector<double> cuts_of(const PendingPiece& pending);
  void figure(const Block& block, const Order& order);
  tl::expected<FigurePath, std::string> figure_path(Command motion,
                                                    const Order& order,
                                                    double diameter_mm) const;
  std::optional<Length> tool_diameter() const;

  // depth.cc
  void set_depths(const Block& block, const Order& order);
  void set_peck(const Block& block, const Order& order);
  void pass_peck_ends(int line, const Order& order, const Peck& before);
  void check_peck(int line);
  static std::string parameter_text(const Order& order);
  void suspend_surface(const Block& block, const Order& order);
  void judge_control(int line);
  bool uses_surface() const;
  bool is_depth_controlled() const;
  void update_cut();
  bool is_below_limit() const;
  bool uses_grid() const;
  DepthOfCut grid_cut(int line, const Eigen::Vector2d& at_mm, const DepthOfCut& cut);
  DepthOfCut cut_at(int line, const Eigen::Vector2d& at_mm) {
    return uses_grid() ? grid_cut(line, at_mm, base_cut_) : base_cut_;
  }
  bool may_take_surface_order(const Block& block, const Order& order, bool probes);
  void surface_order(const Block& block, const Order& order);
  void pass_average(const Block& block, const Order& order);
  void take_surface(const Block& block, const Order& order);
  ProbeRequest probe_request(const Block& block, const Order& order);

  // events.cc
  void take_tool(const Block& block, const Order& order);
  void events_before(const Block& block, const Order& order);
  void events_after(const Block& block, const Order& order);
  void function(int line, FunctionKind kind, std::string_view text, bool is_at_place = false);
  void stop_at_place(int line);
  void texts(const Block& block, const Order& order);
  void message(const Block& block);
  void area(const Block& block, const Order& order);
  void check_area(const Block& block, const Order& order);

  // cnc.cc
  void cnc_command(const Block& block);
  void obey(const Block& block, const CncCommand& command);
  bool obey_placement(const Block& block, const CncCommand& command);
  bool obey_surface(const Block& block, const CncCommand& command);
  void refuse_cnc(const Block& block, std::string expected);
  bool states_own_format(const CncCommand& command) const;
  /// A number of a CNC command, in the unit of the program.
  double in_mm(double number) const { return number * format_.one_unit().in_mm(); }
  void set_program_zero(const Block& block, std::string_view argument, bool is_set);
  void refresh_placement();
  void set_axis_version(const Block& block, std::string_view argument);
  void switch_scaling(const Block& block, bool is_on);
  void end_scaled_copy(int line, const Scaling& before);
  void note_scaling(int line);
  bool is_decided(int line);

  // optical.cc
  void optical_order(const Block& block, const Order& order);
  void camera_text(const Block& block, Command command);
  TargetPlace target_place(const Block& block, Command command);
  bool may_drill_target(int line);

  // kept.cc
  void run_kept(int i_section);
  bool is_kept(const Section& section) const;
  bool has_offsets_inside(const Section& section) const;
  bool organizes(const Section& section) const;
  bool is_repeated() const;
  void pass_order(int line, OpticalOrder order);
  bool has_executed_copy() const;
  void end_kept_section(const Section& section);
  KeptOffsets begin_kept_copy();
  void end_kept_copy(int line, const KeptOffsets& outer);
  void keep_optical_order(const Block& block, Command command);
  void keep_target(const Block& block, Command command, const TargetPlace& target);
  void keep_pattern_target(const Block& block, const Position<frame::Nominal>& nominal);
  void keep_series(int line, std::string_view text);
  void keep_end(const Block& block, Command command);
  void keep_set(const Block& block);
  KeptOrder save_of_copies(const std::optional<int>& location);
  KeptOrder save_at(const std::optional<int>& location);
  KeptOrder load_kept(const std::optional<int>& location);
  KeptOrder load_of_copies();
  KeptOrder load_from(const std::optional<int>& location);
  bool take_base_of(const KeptSet& set);
  void clear_sets(const std::optional<int>& location);
  void keep_surface_order(const Block& block, const Order& order, bool has_place);
  void skip_kept_grid(const Block& block, const Order& order);
  void refuse_kept(const Block& block);

  void report(Code code, const Block& block, std::string what, std::string expected);
  /// The cutter is down, or will be for a piece that waits for the next one.
  bool is_routing() const { return is_plunged_ || piece_.has_value(); }
  bool keeps_structure() const { return options_.structure == Structure::Kept; }

  const Program& program_;
  const FileLayout& layout_;
  const WalkOptions& options_;
  TrialExecution* trial_;
  ProgramFormat format_;
  PlainReader plain_;
  Reporter reporter_;
  Measuring measuring_;
  WalkPlace place_;
  Emitter emitter_;
  OpticalSession optical_;
  Settings settings_;
  SurfaceSession surface_;

  Text text_;
  LineCursor cursor_;
  SectionTree sections_;
  std::map<std::string, SectionTree, std::less<>> subprogram_sections_;  ///< of subprograms
  std::map<std::string, std::optional<Layout>, std::less<>> layouts_;    ///< absent: it works
  std::vector<std::string> calls_;  ///< that are being executed
  int depth_ = 0;                   ///< open levels
  /// Copies and the one being executed, of every level with offsets, outermost first.
  std::vector<std::pair<std::int64_t, std::int64_t>> steps_;

  Placement frame_;      ///< of the axis version
  Placement placement_;  ///< of the copy, without scale and rotation
  bool deletes_blocks_;
  std::int64_t n_refused_ = 0;  ///< Reporter::n_refused() ahead of the line in hand
  bool warned_slash_ = false;
  bool ended_ = false;

  Modal modal_;
  std::optional<Tool> tool_;
  bool leaves_surface_on_ = false;  ///< G71 without G70 behind it in this copy of a section
  bool needs_care_ = false;         ///< a scale, an area or a grid: a hole is more than its place
  Contour contour_ = Contour::None;
  std::optional<PendingPiece> piece_;
  std::optional<PendingPattern> pattern_;
  /// The next T counts though the tool is in the spindle: other copies may begin with another one.
  bool repeats_tool_ = false;
  bool reported_no_tool_ = false;
  bool is_plunged_ = false;
  /// Place of the machine, in the coordinates of the placement in force; absent while something
  /// else may have moved it. Counts only between a T0 line and the next hole.
  std::optional<Eigen::Vector2d> machine_at_mm_;
  DepthOfCut routed_cut_;  ///< of the last piece, without the grid
  bool routed_on_grid_ = false;
  bool has_coordinate_ = false;
  bool reported_surface_ = false;
  bool warned_unbracketed_ = false;  ///< G73 without G71
  bool reported_limit_ = false;
  std::vector<std::pair<FunctionKind, std::string_view>> waiting_events_;  ///< for the next piece
  std::int64_t n_blocks_ = 0;
  double step_mm_ = 0;  ///< rounding of the arc in hand
  KeptState kept_;
  bool has_kept_grid_ = false;  ///< G78, G79; structure kept

  // Depths
  std::optional<double> z_mm_;
  std::optional<double> k_mm_;
  std::optional<double> h_mm_;
  DepthOfCut base_cut_;                  ///< by planes and reference surface, without the grid
  DepthOfCut ramp_start_;                ///< the cut before this line
  bool depth_control_ = false;           ///< G83, without regard to G71
  bool is_surface_suspended_ = false;    ///< G82 under G71
  bool doubts_control_ = false;          ///< G83 holds from before G70
  bool skips_surface_ = false;           ///< G77, for one line
  bool takes_surface_late_ = false;      ///< L behind the last T0 line
  std::optional<Length> probing_depth_;  ///< BOTK, TOPK
  std::optional<int> probing_tool_;      ///< BOTL, TOPL
  Peck peck_;

  // CNC commands
  Nibbling nibbling_;
  bool clears_areas_ = false;  ///< ROUT,A
  std::optional<bool> obeys_areas_;
  bool warned_areas_ = false;
  std::optional<bool> areas_in_copies_;  ///< FORB,A or FORB,M and FORB,P; absent: not stated
  std::vector<ForbiddenArea> areas_;
  Scaling scaling_;
  double rotation_rad_ = 0;
};

}  // namespace panelcal::sieb_meyer
