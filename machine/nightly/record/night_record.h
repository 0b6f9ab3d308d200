// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/diagnostic.h"
#include "calib/base/units.h"
#include "calib/drift/monitor.h"
#include "calib/drift/night_gates.h"
#include "calib/drift/warm_up.h"
#include "calib/ledger/ledger.h"
#include "machine/calibrate/calibration.h"
#include "surface/map/file.h"
#include <Eigen/Core>

// Actions and results of a night: plain data, everything that a report shows. Maker: nightly.h.

namespace panelcal {

enum class NightState : std::uint8_t {
  Installed,   ///< tonight's result is in force
  KeptOld,     ///< tonight's was refused, the one in force may be used until the next night
  Held,        ///< neither may be used: do not drill
  Failed,      ///< a device or the computer failed: nothing was found, nothing was changed
  NotReached,  ///< not begun, because something before it failed
  WouldRun,    ///< dry run
};

/// "installed", "kept old", "hold", "failed", "not reached", "would run".
std::string_view name(NightState state);
std::optional<NightState> night_state(std::string_view word);

/// One axis of what a step calibrates: what is in force before it, and what tonight found.
struct NightAxis {
  std::string name;  ///< "x", "y"
  std::string unit;  ///< "mm" is shown in um
  std::optional<double> old_value;
  std::optional<double> new_value;  ///< absent if nothing was found
  std::optional<double> new_sigma;
  std::optional<double> expected;  ///< as the nights before predicted it, of tonight's value
  std::optional<double> expected_sigma;
};

/// One night in the plot of a step.
struct NightPlotPoint {
  std::chrono::sys_seconds time{};
  std::vector<double> value;  ///< in the order of NightStep::axes
  std::vector<double> sigma;
  bool is_refused = false;
  bool is_fresh_start = false;
  bool is_alarm = false;                  ///< a chart of drift said something that night
  std::vector<double> in_force;           ///< after that night; empty if nothing was
  std::optional<std::int64_t> ledger_id;  ///< its entry; tonight's is the step's
  std::string asked_by;                   ///< of that entry: a person, a timer
  bool is_by_hand = false;                ///< a person has installed it, and no night
};

/// A scatter, a contrast or another number that tells how well a night could measure.
struct NightQuality {
  std::string name;  ///< "holes about the fit", "looks at a hole", "contrast", "edge blur"
  std::string unit;
  double value = 0;
  std::optional<double> usual;  ///< of the nights before
  bool is_alarm = false;
  std::string text;  ///< "3.4 um, usually 3.1 um (42 nights)"
};

/// Warm-up of the machine: the places at which the mark was seen meanwhile.
struct NightWarmUp {
  /// Since the start; mean of some looks, machine mm; their scatter says the sigma.
  std::vector<WarmUpSample> looks;
  Length limit;               ///< less than this had still to come
  std::optional<WarmUp> fit;  ///< absent if the looks do not tell; values in mm
  bool is_warm = false;
  std::string text;  ///< "warm after 14 min: ...", or why that is not known
};

/// One calibration of a night.
struct NightStep {
  std::string kind;     ///< "camera", "spindle-camera", as the ledger names it
  std::string subject;  ///< "spindle 1 station 1"
  NightState state = NightState::Failed;
  /// An earlier run of this night has done it; what only a measuring run knows (holes, qualities,
  /// fit_report) is empty then.
  bool is_from_earlier_run = false;
  std::string summary;  ///< one line: what became of it and why
  std::vector<NightAxis> axes;
  std::optional<double> change;  ///< length of new minus old, in the axes' unit
  std::optional<double> change_sigma;
  std::optional<NightDecision> decision;  ///< gates with their numbers; absent if nothing was found
  std::vector<NightQuality> qualities;
  std::vector<std::string> alarms;        ///< of drift and of qualities, in words
  std::optional<DrillForecast> forecast;  ///< of what is in force after this step
  /// Limit of the error of the one in force, to be drilled with, in the axes' unit: of one or two
  /// axes the length of its error, else the largest.
  std::optional<double> tolerance;
  std::string forecast_text;  ///< "yes, until ...", or why there is no forecast
  std::string since_when;     ///< of the last alarm: what moved, since which night; or empty
  std::vector<NightPlotPoint> series;  ///< the last 60 nights, tonight included
  std::vector<NightHole> holes;
  std::optional<StoredMap> surface;       ///< the probed surface
  std::vector<std::string> fit_report;    ///< lines
  std::filesystem::path file;             ///< the calibration file
  std::optional<std::int64_t> ledger_id;  ///< of tonight's entry
  std::optional<std::int64_t> in_force_id;
  std::optional<Diagnostic> problem;  ///< of Failed, and of a result that could not be found
};

/// In one word what a person should know in the morning.
enum class NightOutcome : std::uint8_t {
  AllInstalled,  ///< exit 0
  Refused,       ///< exit 1: something was kept old or is held, or a check did not pass
  Failed,        ///< exit 3: a device or the computer failed
};

/// All of a night.
struct NightRecord {
  std::string machine;
  std::filesystem::path config_file;
  std::filesystem::path ledger_file;
  /// From noon to noon, of the day it begins on: "2026-11-21" for the night to the 22nd.
  std::string night;
  std::chrono::sys_seconds started{};
  std::chrono::sys_seconds finished{};
  std::string software;
  std::string asked_by;
  std::optional<double> temperature_c;
  bool is_dry_run = false;
  /// Earlier runs of this night did some of it; the sentence says which and what was lost.
  bool is_resumed = false;
  std::vector<std::string> notes;  ///< repaired files, a run that was cut off, lost rows, ...

  Time warmed_up;                      ///< duration
  std::optional<NightWarmUp> warm_up;  ///< with [nightly] warm_up_limit_um
  std::vector<SelfTestCheck> checks;
  std::vector<NightStep> steps;

  NightOutcome outcome = NightOutcome::Failed;
  bool may_drill = false;
  /// The earliest end of the steps' forecasts; absent if it may not, if that is not known, or if it
  /// is beyond what is predicted.
  std::optional<std::chrono::sys_seconds> drill_until;
  std::string verdict;               ///< in words, with what to do: the report's first line
  std::vector<std::string> changes;  ///< the values in force now against a week ago, a line each
  LedgerHead head;  ///< note it elsewhere: it proves later that nothing was cut off
};

/// 0, 1 or 3; bad configurations (2) do not come to a record.
int exit_code(const NightRecord& record);

}  // namespace panelcal
