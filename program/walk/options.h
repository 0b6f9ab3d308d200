// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/diagnostic.h"
#include "calib/base/machine_uncertainty.h"
#include "calib/correction/table_correction.h"
#include "calib/correction/tolerance.h"
#include "calib/faults/known_pads.h"
#include "calib/panel/fit.h"
#include "calib/panel/gates.h"
#include "program/model/board_depths.h"
#include "program/model/operation.h"
#include "program/text/number_format.h"
#include "program/walk/control_settings.h"
#include "program/walk/reading_terms.h"
#include <Eigen/Core>

namespace panelcal {

struct Survey;

/// nc_param.txt beside a program (Allegro PCB Editor).
struct FormatBeside {
  PartialFormat format;
  std::string file;                 ///< empty: there is none
  std::optional<Diagnostic> fault;  ///< it cannot be read, and states nothing
  /// COORDINATES INCREMENTAL: refuses an Excellon program that states neither that its coordinates
  /// are steps nor that they are not, unless --format is whole.
  std::optional<Diagnostic> steps;
};

/// The machine's settings of how a program is read.
struct ReadOptions {
  /// Tool data by diameter; every row has a diameter (CNC-7 manual, Tool Diameter).
  std::vector<Tool> diameter_page;
  /// Folders in which M99 looks for stored patterns and subprograms, in order.
  std::vector<std::filesystem::path> pattern_folders;
  std::optional<bool> block_delete;  ///< the operator's switch, where the header has no BLKD
  int axis_version = 1;              ///< used if the header has no VER
  /// --accept-unterminated: an Excellon program may stop behind any complete line.
  bool accepts_unterminated = false;
  /// --format: what the program says otherwise is not obeyed.
  PartialFormat forced_format;
  FormatBeside format_beside;  ///< for parts that the program does not state
  PartialFormat last_format;   ///< [program], the control's last setting: for the others
  /// [program] rates: of a SIEB & MEYER program in inch, whose manual has their unit in mm alone.
  std::optional<RateUnit> inch_rates;
  /// Sides of the machine's travel, in mm: no coordinates of a program spread farther.
  std::optional<Eigen::Vector2d> travel_mm;
  std::string operator_id;  ///< OPID: what an asterisk in a canned text stands for

  void take(const ReadingTerms& terms);
};

/// Scales drilled holes about a point, in work coordinates, while M60 is in force.
struct ReferenceScaling {
  double x = 1;
  double y = 1;
  Position<frame::Nominal> about;
  bool starts_enabled = false;  ///< SCLR,ON before the program starts
};

enum class Structure : std::uint8_t {
  Expanded,  ///< every copy is executed at its place, and targets are measured
  Kept,      ///< patterns and vision sequences are passed on as such: for translation
};

enum class Cycles : std::uint8_t {
  Expanded,  ///< every hole and pass is an operation of its own
  Kept,      ///< passed on whole; the control expands it
};

struct Survey;

/// The settings of the machine and the vision system of how a program is executed.
struct WalkOptions {
  int series_size = 3;  ///< [vision] rotate: G36 or G46 blocks that form one series
  int inspections = 1;  ///< [vision] inspections: until a $uvis,insp says another number
  std::optional<PanelModel> model;  ///< [vision] model; absent: what the manual says for the count
  bool chooses_model = false;       ///< [vision] model = "auto": what the targets themselves say
  bool bends_panel = false;         ///< [vision] model = "smooth": base series; nested as usual
  bool compares_models = false;     ///< a report shows the models that were not taken
  MachineUncertainty uncertainty;   ///< [uncertainty], [spindle], [camera]
  Tolerances tolerances;            ///< [tolerance]
  GateLimits base_limits;    ///< [gates]; by itself none, a MachineConfig has the default ones
  GateLimits nested_limits;  ///< [gates.nested]; the same
  /// Holes and targets of the program, asked for only when a series does not fit. Without it no pad
  /// can be named that was taken for another.
  std::function<const KnownPads*()> known_pads;
  /// A panel that was measured before: its one base series is in force from the program's first
  /// block on, and the survey of each walk begins with it. Null: none. No place that the program
  /// leaves uncorrected is executed then.
  std::shared_ptr<const Survey> aligned;
  /// Told after each series of the measuring walk; the last one is new. May be empty.
  std::function<void(const Survey&)> fitted;
  /// Work zero without any zero set (the machine's zero correction), and absolute zero.
  Position<frame::Machine> work_zero;
  Position<frame::Machine> absolute_zero;
  /// A repeat of repeats can ask for more holes than there are atoms; this is where we stop. So
  /// many lines of step and repeat that do not operate are the most as well.
  std::int64_t max_operations = kUsualMaxOperations;
  /// The same for targets; their measurements are kept in memory, about 1 kB each.
  std::int64_t max_measurements = 100'000;
  std::optional<ReferenceScaling> scaling;
  Cycles slots = Cycles::Expanded;       ///< G85
  Cycles step_slots = Cycles::Expanded;  ///< G87
  /// [table]: what the stage errs by, which commands take back. Null: nothing.
  std::shared_ptr<const TableCorrection> table;
  /// A corrected arc stays one arc while it is this close to the true ellipse;
  /// on a bent panel and on a calibrated table lines are held to it as well.
  Length arc_tolerance = um(1);
  Structure structure = Structure::Expanded;
  BoardDepths board;                ///< --surface, [surface], [[depth]]
  sieb_meyer::Settings sieb_meyer;  ///< of that language only
  /// [camera] focus_range_mm: the measurement source is asked to focus; otherwise `$uvis,focus` is
  /// only passed on, with a warning.
  bool has_focus = false;
  /// [coupon]: the measurement source is asked to calibrate (G39, `$uvis,calib`); otherwise the
  /// order is only passed on, with a warning.
  bool has_coupon = false;
  /// [camera]: G39,SPOP and its kin move the offset of later measurements; otherwise as above.
  bool moves_offset = false;
};

}  // namespace panelcal
