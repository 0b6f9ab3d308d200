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
  std::optional<int> unsaved_offset;      ///< line of a G36 behind G39,SAVE that none stands behind
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
struct RunText {
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

/// One walk over a program: its state, which every line reads and changes. With a sink it executes;
/// without one it measures and checks. With a trial, sources and a sink it does both until the
/// trial is over.
///
/// Memory does not grow with the number of holes: every copy of a section reads its text again.
struct Walk {
  Walk(const Program& walked,
       const WalkOptions& walk_options,
       Survey& survey,
       const WalkEnds& ends);
  Walk(const Walk&) = delete;
  Walk& operator=(const Walk&) = delete;

  bool has_ended() const {
    return ended || emitter.is_over_limit() || measuring.must_stop() || surface.must_stop();
  }
  /// A number of a CNC command, in the unit of the program.
  double in_mm(double number) const { return number * format.one_unit().in_mm(); }
  /// The cutter is down, or will be for a piece that waits for the next one.
  bool is_routing() const { return is_plunged || piece.has_value(); }
  bool keeps_structure() const { return options.structure == Structure::Kept; }
  const Section& section(int i) const {
    return text.sections->sections[static_cast<std::size_t>(i)];
  }

  const Program& program;
  const FileLayout& layout;
  const WalkOptions& options;
  TrialExecution* trial;
  ProgramFormat format;
  PlainReader plain;
  Reporter reporter;
  Measuring measuring;
  WalkPlace place;
  Emitter emitter;
  OpticalSession optical;
  Settings settings;
  SurfaceSession surface;

  RunText text;
  LineCursor cursor;
  SectionTree sections;
  std::map<std::string, SectionTree, std::less<>> subprogram_sections;  ///< of subprograms
  std::map<std::string, std::optional<Layout>, std::less<>> layouts;    ///< absent: it works
  std::vector<std::string> calls;                                       ///< that are being executed
  int depth = 0;                                                        ///< open levels
  /// Copies and the one being executed, of every level with offsets, outermost first.
  std::vector<std::pair<std::int64_t, std::int64_t>> steps;

  Placement frame;      ///< of the axis version
  Placement placement;  ///< of the copy, without scale and rotation
  bool deletes_blocks;
  std::int64_t n_refused = 0;  ///< Reporter::n_refused() ahead of the line in hand
  bool warned_slash = false;
  bool ended = false;

  Modal modal;
  std::optional<Tool> tool;
  bool leaves_surface_on = false;  ///< G71 without G70 behind it in this copy of a section
  bool needs_care = false;         ///< a scale, an area or a grid: a hole is more than its place
  Contour contour = Contour::None;
  std::optional<PendingPiece> piece;
  std::optional<PendingPattern> pattern;
  /// The next T counts though the tool is in the spindle: other copies may begin with another one.
  bool repeats_tool = false;
  bool reported_no_tool = false;
  bool is_plunged = false;
  /// Place of the machine, in the coordinates of the placement in force; absent while something
  /// else may have moved it. Counts only between a T0 line and the next hole.
  std::optional<Eigen::Vector2d> machine_at_mm;
  DepthOfCut routed_cut;  ///< of the last piece, without the grid
  bool routed_on_grid = false;
  bool has_coordinate = false;
  bool reported_surface = false;
  bool warned_unbracketed = false;  ///< G73 without G71
  bool reported_limit = false;
  std::vector<std::pair<FunctionKind, std::string_view>> waiting_events;  ///< for the next piece
  std::int64_t n_blocks = 0;
  double step_mm = 0;  ///< rounding of the arc in hand
  KeptState kept;
  bool has_kept_grid = false;  ///< G78, G79; structure kept

  // Depths
  std::optional<double> z_mm;
  std::optional<double> k_mm;
  std::optional<double> h_mm;
  DepthOfCut base_cut;                  ///< by planes and reference surface, without the grid
  DepthOfCut ramp_start;                ///< the cut before this line
  bool depth_control = false;           ///< G83, without regard to G71
  bool is_surface_suspended = false;    ///< G82 under G71
  bool doubts_control = false;          ///< G83 holds from before G70
  bool skips_surface = false;           ///< G77, for one line
  bool takes_surface_late = false;      ///< L behind the last T0 line
  std::optional<Length> probing_depth;  ///< BOTK, TOPK
  std::optional<int> probing_tool;      ///< BOTL, TOPL
  Peck peck;

  // CNC commands
  Nibbling nibbling;
  bool clears_areas = false;  ///< ROUT,A
  std::optional<bool> obeys_areas;
  bool warned_areas = false;
  std::optional<bool> areas_in_copies;  ///< FORB,A or FORB,M and FORB,P; absent: not stated
  std::vector<ForbiddenArea> areas;
  Scaling scaling;
  double rotation_rad = 0;
};

}  // namespace panelcal::sieb_meyer
