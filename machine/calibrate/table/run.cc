// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/table/run.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

#include "calib/base/fields/json.h"
#include "calib/base/fields/slots.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "calib/correction/spindle_camera.h"
#include "machine/calibrate/table/outliers.h"
#include "machine/config/json_files.h"
#include "program/model/recorded.h"
#include <fmt/format.h>

namespace panelcal {
namespace internal {
namespace {

/// A look at a dot of the plate as a line has it.
struct PlateLook {
  std::size_t pose = 0;
  Position<frame::Machine> axis;
  int column = 0;
  int row = 0;
  Position<frame::Optical> seen;
  std::array<double, 3> cov = {};
};

#include "machine/calibrate/table/look.def"

}  // namespace

JsonFile plate_looks_file() {
  return {"looks.jsonl",
          "One look at a dot of the plate a line, by whatever vision system: `--measurements` of "
          "`panelcal calibrate table`. See docs/formats/calibration.md.",
          {&kPlateLook}};
}

}  // namespace internal

namespace {

using internal::JsonLine;

constexpr Code kSightCode = Code::MeasurementFile;
/// Fewer degrees of freedom say nothing of the scatter.
constexpr double kFewestFreedoms = 8;
constexpr int kFewestHeld = 16;  ///< coordinates
constexpr int kTableRunRounds = 8;
/// Limits of refusal(): stated sigmas that are so far from the truth, or a map that is, belong to a
/// person; one in this number of looks left out is one too many.
constexpr double kMaxTableExcess = 25;
constexpr double kMaxTableHeldOut_um = 10;
constexpr std::size_t kMaxTableLeftOut = 4;

/// A mean of squares over what was predicted, and of how many.
struct Excess {
  double squared = 1;
  double n = 1;

  /// Chance exceeds this once in a hundred times: 2.3 sigmas of chi square over n.
  bool is_surprising() const { return squared > 1 + 2.3 * std::sqrt(2 / n); }
};

/// Puts looks together to views.
class TableLooks {
 public:
  TableLooks(const MachineConfig& config, const CalibrationPlate& plate)
      : config_(config), plate_(plate), is_covered_(plate.covered_dots()) {
    sights_.data.dots = plate.dots();
  }

  Expected<void> add(const JsonLine& line) {
    PANELCAL_TRY(const internal::PlateLook look,
                 internal::read_line(internal::kPlateLook, line, kSightCode));
    if (look.column >= plate_.columns || look.row >= plate_.rows) {
      return failure(line.problem(
          "dot",
          Code::CalibrationData,
          fmt::format("a dot of the plate's {} x {}, from [0,0]", plate_.columns, plate_.rows)));
    }
    const std::size_t i_dot = plate_.index(look.column, look.row);
    if (is_covered_[i_dot]) {
      return failure(line.problem(
          "dot", Code::CalibrationData, "a dot that is there: [tags] has a tag in its place"));
    }
    const std::array<double, 3>& cov = look.cov;
    PositionEstimate<frame::Optical> seen{look.seen, internal::recorded_covariance(cov)};
    const bool is_covariance = cov[0] > 0 && cov[2] > 0 && seen.cov.allFinite() &&
                               std::abs(cov[1] / std::sqrt(cov[0]) / std::sqrt(cov[2])) < 1;
    if (!is_covariance) {
      return failure(line.problem(
          "cov", Code::MeasurementInvalid, "[xx, xy, yy] with xx > 0, yy > 0 and xy^2 < xx yy"));
    }
    seen.cov += config_.walk.uncertainty.stage_mm2();
    sights_.data.seen.push_back({view_of(look.pose, look.axis.in_mm()), i_dot, seen});
    return {};
  }

  TableSights& sights() { return sights_; }

 private:
  std::size_t view_of(std::size_t pose, const Eigen::Vector2d& axis_mm) {
    const auto [at, is_new] =
        views_.try_emplace(std::tuple(pose, axis_mm.x(), axis_mm.y()), sights_.data.views.size());
    if (is_new) {
      const auto axis = position_mm<frame::Machine>(axis_mm);
      sights_.data.views.push_back({config_.spindle_camera.spindle_to_see(axis), pose});
    }
    return at->second;
  }

  const MachineConfig& config_;
  const CalibrationPlate& plate_;
  std::vector<bool> is_covered_;  ///< dots in whose place a tag is
  TableSights sights_;
  std::map<std::tuple<std::size_t, double, double>, std::size_t> views_;
};

/// Poses are numbered by the fit without gaps, in the order of their numbers here.
void close_gaps(TableData& data) {
  std::map<std::size_t, std::size_t> number;
  for (const PlateView& view : data.views) number[view.i_pose] = 0;
  std::size_t n = 0;
  for (auto& [pose, to] : number) to = n++;
  for (PlateView& view : data.views) view.i_pose = number[view.i_pose];
}

Diagnostic in_file(const std::string& file, Diagnostic diagnostic) {
  if (diagnostic.place.file.empty()) diagnostic.place.file = file;
  return diagnostic;
}

std::string file_of(const MachineConfig& config, const TableSights& sights) {
  return sights.inputs.empty() ? config.file.string() : sights.inputs.front().name;
}

/// Looks that a fit did not see are predicted from those that it did; how often their squared error
/// is what the prediction's covariance says. A smooth map bends through noise that is understated,
/// so that residuals do not show it.
Excess surprise(const TableData& data, const TableFitOptions& options) {
  double sum = 0;
  int n = 0;
  for (const auto& one : internal::predict(data, options, internal::kTableFolds - 1)) {
    sum += one.chi_square;
    n += 2;
  }
  return n >= kFewestHeld ? Excess{sum / n, static_cast<double>(n)} : Excess{};
}

/// By how much sigmas are too small, squared; 1 where chance would do as well.
double excess_squared(const TableFit& fit, const TableData& data, const TableFitOptions& options) {
  const Excess of_held = surprise(data, options);
  double out = of_held.is_surprising() ? of_held.squared : 1;
  if (fit.degrees_of_freedom < kFewestFreedoms) return out;
  const Excess of_fit{fit.chi_square / fit.degrees_of_freedom, fit.degrees_of_freedom};
  if (of_fit.is_surprising()) out = std::max(out, of_fit.squared);
  return out;
}

/// A geometry's number in the unit that people say it in.
struct Unit {
  double factor;
  std::string_view name;
};
Unit unit_of(int i) {
  if (i == TableGeometry::ScaleX || i == TableGeometry::ScaleY) return {1e6, "ppm"};
  if (i == TableGeometry::Squareness) return {1e6, "urad"};
  return {1e3, "um"};
}
/// The same as the ledger has it.
std::string_view ledger_unit(int i) {
  if (i == TableGeometry::ScaleX || i == TableGeometry::ScaleY) return "1";
  return i == TableGeometry::Squareness ? "rad" : "mm";
}

/// The run's calibration with date and provenance.
TableCalibration table_calibration(const TableRun& run, const RecordWords& words) {
  TableCalibration c = run.calibration;
  c.date = words.date;
  c.provenance = fmt::format(
      "{} looks at a plate in {} poses", run.sights.data.seen.size(), run.fit.poses.size());
  if (run.excess > 1.05) {
    c.provenance += fmt::format(", sigmas times {:.3g} by their scatter", run.excess);
  }
  c.provenance += by_whom(words);
  return c;
}

}  // namespace

Expected<TableSights> parse_plate_looks(std::string_view text,
                                        const std::string& file,
                                        const MachineConfig& config,
                                        const CalibrationPlate& plate) {
  TableLooks looks(config, plate);
  const std::string_view whole = text;
  for (int number = 1; !text.empty(); ++number) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.find_first_not_of(" \t\r") == std::string_view::npos) continue;
    if (line.ends_with('\r')) line.remove_suffix(1);
    PANELCAL_TRY(const JsonLine parsed, JsonLine::parse(line, {file, number, 0}));
    PANELCAL_CHECK(looks.add(parsed));
  }
  close_gaps(looks.sights().data);
  looks.sights().inputs.push_back(
      {std::filesystem::path(file).filename().string(), sha256(whole), whole.size()});
  return std::move(looks.sights());
}

Expected<TableSights> read_plate_looks(const std::filesystem::path& file,
                                       const MachineConfig& config,
                                       const CalibrationPlate& plate) {
  PANELCAL_TRY(const std::string text, read_file(file, kMaxPlateLookBytes));
  return parse_plate_looks(text, file.string(), config, plate);
}

Expected<TableRun> calibrate_table(const MachineConfig& config,
                                   TableSights sights,
                                   const TableFitOptions& options) {
  const std::string file = file_of(config, sights);
  TableRun run;
  run.sights = std::move(sights);
  run.left_out = internal::leave_out_outliers(options, run.sights.data);
  Expected<TableFit> fit = fit_table(run.sights.data, options);
  for (int round = 0; fit && round < kTableRunRounds; ++round) {
    const double excess2 = excess_squared(*fit, run.sights.data, options);
    if (!(excess2 > 1)) break;
    run.excess *= std::sqrt(excess2);
    for (TableObservation& look : run.sights.data.seen) look.seen.cov *= excess2;
    fit = fit_table(run.sights.data, options);
  }
  if (!fit) return failure(in_file(file, std::move(fit).error()));
  run.fit = *std::move(fit);
  run.calibration = calibration_of(run.fit);
  PANELCAL_CHECK(parse_table_calibration(table_calibration_text(run.calibration), file));
  return run;
}

std::string refusal(const TableRun& run) {
  const std::size_t n_left_out = run.left_out.size();
  const std::size_t n_all = run.sights.data.seen.size() + n_left_out;
  if (n_left_out * kMaxTableLeftOut > n_all) {
    return fmt::format("{} of {} looks do not fit the others, more than one in {}",
                       n_left_out,
                       n_all,
                       kMaxTableLeftOut);
  }
  if (run.fit.held_out_rms_mm && !(1e3 * *run.fit.held_out_rms_mm <= kMaxTableHeldOut_um)) {
    return fmt::format("looks that the fit did not see are {:.1f} um beside it, the limit is {} um",
                       1e3 * *run.fit.held_out_rms_mm,
                       kMaxTableHeldOut_um);
  }
  if (run.excess <= kMaxTableExcess) return {};
  return fmt::format(
      "looks scatter {:.1f} times more than they and [uncertainty] "
      "stage_repeatability_um state, the limit is {} times",
      run.excess,
      kMaxTableExcess);
}

std::string report(const TableRun& run) {
  std::string text = run.fit.summary() + "\n";
  const TableGeometry& geometry = run.fit.geometry;
  for (int i = 0; i < TableGeometry::kSize; ++i) {
    const Unit unit = unit_of(i);
    text += fmt::format("  {:<17} {:>9.2f} +- {:.2f} {}\n",
                        TableGeometry::name(static_cast<TableGeometry::Index>(i)),
                        geometry.value[i] * unit.factor,
                        std::sqrt(std::max(0.0, geometry.cov(i, i))) * unit.factor,
                        unit.name);
  }
  for (const std::string& name : run.fit.undetermined) {
    text += fmt::format("  these looks leave open: {}\n", name);
  }
  text += fmt::format("  sigma of the map {:.2f} um, {} looks in {} poses",
                      run.calibration.sigma.in_um(),
                      run.sights.data.seen.size(),
                      run.fit.poses.size());
  if (run.excess > 1.05) {
    text +=
        fmt::format("; they scatter {:.2f} times more than stated, which is counted", run.excess);
  }
  text += "\n";
  text += pictures_report(run.sights.left_out, run.sights.without_tag);
  for (const std::string& look : run.left_out) text += fmt::format("  without {}\n", look);
  return text;
}

LedgerKey table_key(const MachineConfig& config) {
  return {machine_name(config), LedgerKind::Table, "table"};
}

Expected<LedgerDraft> table_draft(const MachineConfig& config,
                                  const TableRun& run,
                                  const RecordWords& words) {
  PANELCAL_TRY(LedgerDraft draft, draft_of(config, table_key(config), words));
  LedgerRecord& record = draft.record;
  record.inputs.insert(record.inputs.end(), run.sights.inputs.begin(), run.sights.inputs.end());
  for (int i = 0; i < TableGeometry::kSize; ++i) {
    std::string name(TableGeometry::name(static_cast<TableGeometry::Index>(i)));
    std::ranges::replace(name, ' ', '_');
    record.parameters.push_back(
        {std::move(name), run.fit.geometry.value[i], std::string(ledger_unit(i))});
  }
  record.covariance = run.fit.geometry.cov;
  draft.result = table_calibration_text(table_calibration(run, words));
  return draft;
}

}  // namespace panelcal
