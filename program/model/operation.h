// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "calib/base/frames.h"
#include "calib/base/units.h"
#include "program/model/depth.h"
#include "program/model/placement.h"
#include "program/text/number_format.h"
#include <Eigen/Core>

namespace panelcal {

/// The program's data on a drill or router bit; absent where it states none.
struct Tool {
  int number = 0;
  std::optional<Length> diameter;
  std::optional<Feed> infeed;
  std::optional<Feed> retract;
  std::optional<SpindleSpeed> speed;
  std::optional<int> max_hits;
  std::optional<Length> depth_offset;
  std::optional<Time> dwell = std::nullopt;  ///< stays down so long
  std::vector<int> magazines = {};           ///< that it is taken from, in order
  /// Letters of a SIEB & MEYER tool table that the program sets to zero, so that what the control
  /// had there is gone. A letter that is not stated leaves it.
  std::string zeroed = {};

  friend bool operator==(const Tool&, const Tool&) = default;
};

/// Calls visit(datum, other's datum) for each number that a program may state of a tool.
template <class AnyTool, class Visit>
void for_each_datum(AnyTool& tool, const Tool& other, Visit visit) {
  visit(tool.diameter, other.diameter);
  visit(tool.infeed, other.infeed);
  visit(tool.retract, other.retract);
  visit(tool.speed, other.speed);
  visit(tool.max_hits, other.max_hits);
  visit(tool.depth_offset, other.depth_offset);
  visit(tool.dwell, other.dwell);
}
/// Data that the tool lacks, as the other one has them.
void fill_missing(Tool& tool, const Tool& other);
/// The two state a datum differently.
bool contradict(const Tool& tool, const Tool& other);

/// A point of the tool's way in the frames that outputs need.
struct PlacedPoint {
  Position<frame::Nominal> nominal;   ///< after placement, before any correction
  Position<frame::Actual> corrected;  ///< relative to work zero
  /// From work zero, what a program for the machine says: `corrected`, but for the error of a
  /// calibrated table.
  Displacement<frame::Machine> commanded;
  Position<frame::Machine> actual;  ///< sent to the machine: work zero + commanded
  Eigen::Matrix2d cov_mm2 =
      Eigen::Matrix2d::Zero();  ///< of what is drilled; zero without a correction
  /// That the hole breaks its tolerance, as outputs state it (program/walk/execution/risk_judge.h);
  /// absent without a tolerance or without a correction, and where it is not known.
  std::optional<double> risk;
  /// The same by `cov_mm2` alone, which [tolerance] is held against: present if there is a
  /// tolerance and a correction.
  std::optional<double> judged_risk;
  /// The largest shift of this place by an error of one target that would pass unnoticed, or a
  /// bound of it that another place exceeds.
  Length unseen;
};

/// No risk below this is stated where a target's error that the others do not show may break the
/// tolerance.
inline constexpr double kMinStatedRisk = 1e-3;

/// Takes a tool; number 0 puts the tool away.
struct ToolChange {
  Tool tool;
  std::optional<int> compensation_index;
};

/// Changes the rates of the tool that is in use.
struct ToolRate {
  int tool = 0;
  std::optional<Feed> infeed;
  std::optional<Feed> retract;
};

/// Asks the machine for its own camera calibration at a place that no correction moves (G39).
struct Autocalibration {
  Position<frame::Nominal> nominal;
  Displacement<frame::Machine> commanded;  ///< as of a PlacedPoint
  Position<frame::Machine> actual;
};

/// Drills one hole.
struct Drill : PlacedPoint {
  int tool = 0;
  DepthOfCut cut;
};

/// Moves with the tool up.
struct RapidMove : PlacedPoint {};

enum class PlungeKind : std::uint8_t {
  Plain,       ///< M15
  Contouring,  ///< M14: the depth follows the material
};

/// Lowers the router where it stands.
struct Plunge {
  int tool = 0;
  PlungeKind kind = PlungeKind::Plain;
  std::optional<Length> depth_offset;  ///< of one pass of a step slot; absent: the tool's own
  DepthOfCut cut;
};

/// Raises the router.
struct Retract {
  bool with_clamping = false;  ///< M16; otherwise M17
};

enum class RoutKind : std::uint8_t { Line, Clockwise, Counterclockwise };

/// Routs from where the tool stands to a place. Arcs are at most half a circle; `kind` is the sense
/// of the corrected arc, so mirrors have flipped it already.
struct Rout : PlacedPoint {
  int tool = 0;
  RoutKind kind = RoutKind::Line;
  Position<frame::Actual> corrected_center;       ///< of an arc
  Displacement<frame::Machine> commanded_center;  ///< the same as `commanded` is
  Position<frame::Machine> center;  ///< and as the machine is told: work zero + commanded_center
  Feed feed;
  bool feed_is_default = false;  ///< the program sets none
  DepthOfCut cut;                ///< at the end; the tool goes there evenly
};

enum class CompensationSide : std::uint8_t { Off, Left, Right };

/// Switches cutter compensation, which the controller applies: coordinates are the contour's.
/// Mirrors have exchanged left and right already.
struct Compensation {
  CompensationSide side = CompensationSide::Off;
  std::optional<Length> value;  ///< the diameter that the controller compensates for
};

/// A drilled slot (G85) left whole: see WalkOptions::slots.
struct Slot {
  int tool = 0;
  PlacedPoint start;
  PlacedPoint end;
  DepthOfCut cut;
};

/// A slot routed in deepening passes (G87) left whole.
struct StepSlot {
  int tool = 0;
  PlacedPoint start;
  PlacedPoint end;
  Length initial_depth;  ///< of the first pass above the final depth
  Length increment;      ///< from pass to pass, negative
  Feed feed;
  bool feed_is_default = true;
};

enum class StopKind : std::uint8_t {
  EndNoRewind,
  EndRewind,
  EndAccepted,  ///< the program has no end, and --accept-unterminated accepts that
  Inspection,
  Optional,
  HeaderEnd,
};

/// For a comment in written programs that end where the source has no end.
inline constexpr std::string_view kEndAcceptedComment =
    "the source has no M30: accepted by --accept-unterminated";

/// Stops, at a place that the program gives relative to absolute zero if it gives one (CNC-7
/// manual, Stop Commands).
struct Stop {
  StopKind kind = StopKind::EndRewind;
  std::optional<Displacement<frame::Machine>> from_absolute_zero;
  std::optional<Position<frame::Machine>> actual;
  /// At the place that comes next, before it is worked at (M20 of SIEB & MEYER in its line).
  bool is_at_place = false;
};

/// Shows a text to the operator and waits. Lines of a long one (M45) are separated by '\n'.
struct Message {
  std::string_view text;
  bool is_long = false;
};

/// Waits.
struct Dwell {
  Time duration;
};

enum class FunctionKind : std::uint8_t {
  ToolTipCheck,
  PeckOn,
  PeckOff,
  SpindleGroup,
  BinaryMap,
  ScalingOn,
  ScalingOff,
  ToolExpired,
  PulseOn,          ///< G89: peck drilling without retracting
  PulseOff,         ///< G88
  BreakageCheckOn,  ///< M95
  BreakageCheckOff,
  MachineFunction,  ///< M21 to M27, M34 to M45, M52 to M55, M49,M#: what the maker made of it
  MachineZero,      ///< M28
  ParkPosition,     ///< M29
  CheckArea,        ///< M56, M57
  ForbiddenArea,    ///< M58
  HoleOmitted,      ///< a hole inside a forbidden area
  FinishRouting,    ///< G11
  RetractProbe,     ///< G75
  TextForDevice,    ///< M76
};

/// An event of the machine that moves nothing by itself.
struct Function {
  FunctionKind kind = FunctionKind::ToolTipCheck;
  std::string_view text;         ///< the block as written; empty if the control does it by itself
  int tool = 0;                  ///< ToolExpired: whose hit count is used up
  std::optional<int> next_tool;  ///< ToolExpired: the linked tool that goes on; absent: stops
  /// Holds while the places of its line are worked at, and no longer (M21 of SIEB & MEYER).
  bool is_at_place = false;
};

enum class SettingKind : std::uint8_t { Header, Body, Vision };

enum class SurfaceOrderKind : std::uint8_t {
  Detect,       ///< G73 at a place: probes, and takes that for the reference
  StoreLast,    ///< G73 without a place: stores what was probed last
  StoreGrid,    ///< the same where G78 or G79 probed it
  Average,      ///< G74
  Take,         ///< L#: takes the reference from the memory
  ClearMemory,  ///< G72
  Record,       ///< G76: probes and records only
  // Only where structure is kept; else strokes have what these lead to:
  Switch,         ///< G71, G70: to the control that `cut` has
  GridReference,  ///< G78
  GridPoint,      ///< G79
  Skip,           ///< G77: the grid does not move the planes of the places of this line
};

/// An order of surface detection that a SIEB & MEYER control executes by itself. Strokes have the
/// heights that panelcal has probed for it, so that no other output needs it.
/// Source SIEB & MEYER CNC 8x.00 Command Set, 10.1 SLM
struct SurfaceOrder {
  SurfaceOrderKind kind = SurfaceOrderKind::Detect;
  std::optional<int> memory;         ///< L#
  std::optional<PlacedPoint> place;  ///< of Detect, Record, GridReference and GridPoint
  DepthOfCut cut;                    ///< in force; of Switch, GridReference and GridPoint
  std::string_view average;          ///< of Average: the letter of SPAV that is in force
};

/// Something the machine has to know or do that moves nothing, passed on as written.
struct Setting {
  std::string_view text;
  SettingKind kind = SettingKind::Body;
  LengthUnit unit = LengthUnit::Millimeter;  ///< of lengths in the text
  /// An order to calibrate or to focus that has had no effect on what is executed.
  bool is_unperformed = false;
};

/// Sets work zero (G93); later machine coordinates already contain it.
struct ZeroSet {
  Displacement<frame::Machine> zero_set;
  Position<frame::Machine> work_zero;
  bool is_reset = false;  ///< to the machine's own (NOFA)
};

/// Everything up to PatternEnd is one pattern, written once: only where structure is kept (see
/// WalkOptions::structure).
struct PatternBegin {};

/// The pattern's copies in the order of execution; the first may be the place where it stands. They
/// carry places of the pattern as it was passed, in work coordinates, to those of the copy.
struct PatternEnd {
  std::span<const Placement> copies;
};

/// The correction that a series of targets gives.
enum class CorrectionLevel : std::uint8_t { Base, Nested };

/// Targets that are measured and fitted together; only where structure is kept.
struct VisionSeries {
  CorrectionLevel level = CorrectionLevel::Base;
  std::span<const Position<frame::Nominal>> targets;
  bool fits_otherwise = false;  ///< than with the model that the manuals state for its targets
};

/// A target that is measured and drilled at; only where structure is kept.
struct TargetHole {
  CorrectionLevel level = CorrectionLevel::Base;
  Position<frame::Nominal> nominal;
  int tool = 0;
  DepthOfCut cut;
};

/// Drops a correction, and with Base the nested one too; only where structure is kept.
struct CancelCorrection {
  CorrectionLevel level = CorrectionLevel::Base;
};

enum class StoredCorrectionKind : std::uint8_t {
  RecordNext,  ///< M50,#: the next pattern keeps the corrections of its copies
  RewindNext,  ///< M51,#: the next pattern, or what comes next, uses what was kept
  NestNext,    ///< the next pattern measures a nested series of several targets in each copy
  Keep,        ///< in a pattern each copy, else the program, keeps what was measured last
  Use,         ///< puts in force what a copy has kept
};

/// Corrections that the copies of one pattern keep for those of later ones; only where structure is
/// kept. The first three are said by Excellon alone.
struct StoredCorrection {
  StoredCorrectionKind kind = StoredCorrectionKind::Keep;
  int label = 0;
  CorrectionLevel level = CorrectionLevel::Base;  ///< of Keep and Use
  int n_targets = 0;                              ///< likewise: of all series of the copy
  /// Likewise: the nested correction is an offset, on top of the copy's own base correction if that
  /// has targets as well.
  bool is_offset = false;
  /// Of Use: the copy that has kept it, from 1; 0: each copy of a pattern uses its own.
  int copy = 0;
  int n_passed = 0;  ///< of Use in Excellon: targets that the pointer passes on its way there
};

/// Chooses how the camera looks; only where structure is kept.
struct VisionTool {
  int number = 0;
};

/// An order of optical measurement as a SIEB & MEYER program has it, for writers of that language;
/// only where structure is kept. Others take VisionSeries, CancelCorrection and StoredCorrection,
/// which come with the orders that they can say.
/// Source SIEB & MEYER CNC 8x.00 Command Set, 9 Optical Measurement
struct OpticalOrder {
  std::string_view text;  ///< G31, G39,SAVE2; without coordinates; empty: the end of a section
  std::optional<Position<frame::Nominal>> target;  ///< of G32, G33, and G36 under CAMA
  /// The form that the program needs in another language, if that cannot say this one; valid for
  /// ever.
  std::string_view remedy;
  /// The reason, if it is not the order itself; valid for ever.
  std::string_view problem;
  /// The section's copies are executed one by one, and the order changes a correction that ends
  /// with the copy. Outside of sections nothing would end it.
  bool ends_with_copy = false;
};

/// Origin of a place, for those who ask; valid only during the call that passes it.
struct Origin {
  Position<frame::Programmed> programmed;
  const Placement* placement = nullptr;
  /// Reference scaling; null while it does not apply.
  const Transform<frame::Nominal, frame::Nominal>* scaling = nullptr;
  const std::optional<std::size_t>* base_series = nullptr;  ///< index into Survey::series
  const std::optional<std::size_t>* nested_series = nullptr;
  const Position<frame::Machine>* work_zero = nullptr;
  int tool_line = 0;  ///< of the block that took the tool
  /// Of a hole that is drilled where its own target was seen, which no correction moves: index into
  /// Survey::measurements.
  std::optional<std::size_t> i_measurement;
};

/// One thing the machine is told. Views are valid only during the call that passes it.
struct Operation {
  int line = 0;
  std::span<const int> path;
  std::variant<ToolChange,
               Drill,
               Stop,
               Message,
               Setting,
               ZeroSet,
               RapidMove,
               Rout,
               Plunge,
               Retract,
               Compensation,
               Slot,
               StepSlot,
               Dwell,
               Function,
               ToolRate,
               Autocalibration,
               PatternBegin,
               PatternEnd,
               VisionSeries,
               TargetHole,
               CancelCorrection,
               StoredCorrection,
               VisionTool,
               OpticalOrder,
               SurfaceOrder>
      what;
  std::string_view file;           ///< of a stored pattern (M99); empty: the program itself
  const Origin* origin = nullptr;  ///< of Drill, Rout, RapidMove, Slot and StepSlot
};

/// tool, drill, rout, position and so on: the `op` of output files.
std::string_view operation_name(const Operation& operation);
/// end_rewind, inspection and so on: the `kind` of output files.
std::string_view name(StopKind kind);
std::string_view name(FunctionKind kind);
std::string_view name(RoutKind kind);

/// The language of a part program.
enum class Dialect : std::uint8_t {
  Excellon,   ///< CNC-7
  SiebMeyer,  ///< formats 1000, 3000 and 5000
};

std::string_view name(Dialect dialect);

/// The input of a writer before the first operation.
struct ProgramInfo {
  std::string file;
  /// The language that the texts of settings and functions are written in.
  Dialect dialect = Dialect::Excellon;
  NumberFormat format;  ///< the program's own: rates are whole in its unit, settings in its zeros
  std::map<int, Tool> tools;
  bool is_scaled = false;   ///< reference scaling is in the coordinates already
  bool body_rules = false;  ///< OM48: the body's tool data win over the header's
  int axis_version = 1;     ///< VER: the axes that a program in the same format is written in
  /// The digits of `format` are those of the program or of the operator, not of something beside.
  bool declares_digits = true;
  /// Its coordinates have decimal points, whatever digits `format` declares.
  bool has_decimal_coordinates = false;
};

/// Takes operations one at a time; writers are sinks.
class OperationSink {
 public:
  virtual ~OperationSink() = default;
  virtual void begin(const ProgramInfo&) {}
  /// A sink that cannot go on remembers why and says so in finish().
  virtual void put(const Operation& operation) = 0;
};

}  // namespace panelcal
