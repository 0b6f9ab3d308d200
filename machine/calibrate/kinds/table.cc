// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/table/calibration_file.h"
#include "machine/calibrate/kinds/kinds.h"
#include "machine/calibrate/kinds/parts.h"
#include "machine/calibrate/table/run.h"
#include "machine/plate/pictures.h"
#include <Eigen/Geometry>
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Of the dots that may be missing or wrong: plates get dirty.
constexpr int kMaxTableOutliers = 20;  ///< one in this number
/// Places along each side of the plate at which two maps are compared.
constexpr int kCompared = 11;

/// Place of the farthest dot, from the middle of the plate along the machine's axes.
Eigen::Vector2d half_sides_mm(const CalibrationPlate& plate) {
  Eigen::AlignedBox2d box;
  if (plate.poses.empty()) return Eigen::Vector2d::Zero();
  for (const PlateDot& dot : plate.dots()) {
    box.extend(place_in(plate.poses.front(), dot.place).in_mm());
  }
  return 0.5 * box.sizes();
}

/// Value in which drift is watched: the affine part of the stage's error at the plate's corner.
///
///   corner x = scale_x h_x + squareness h_y,   corner y = scale_y h_y,   h half of the plate
LedgerValues table_corner(const Eigen::Vector2d& half_mm,
                          const Eigen::Vector3d& scales_and_squareness,
                          const Eigen::Matrix3d& cov) {
  Eigen::Matrix<double, 2, 3> by_parameters;
  by_parameters << half_mm.x(), 0, half_mm.y(), 0, half_mm.y(), 0;
  return {by_parameters * scales_and_squareness, by_parameters * cov * by_parameters.transpose()};
}

LedgerValues table_corner(const Eigen::Vector2d& half_mm, const TableGeometry& geometry) {
  const std::array<int, 3> rows = {
      TableGeometry::ScaleX, TableGeometry::ScaleY, TableGeometry::Squareness};
  return table_corner(half_mm, geometry.value(rows), geometry.cov(rows, rows));
}

/// By how much two maps differ, at most.
struct MapChange {
  double error_mm = 0;  ///< of places
  /// Of what the spindle-camera offset has taken up of it: an offset that was calibrated with the
  /// one map is so wrong with the other.
  double offset_mm = 0;
};

/// Over the earlier map's rectangle.
MapChange change_of(const TableMap& before,
                    const TableMap& after,
                    const Displacement<frame::Machine>& offset) {
  MapChange change;
  const TableGrid& grid = before.grid();
  const auto differ_mm = [&](const Position<frame::Machine>& at) -> Eigen::Vector2d {
    return after.error_mm(at) - before.error_mm(at);
  };
  for (int i = 0; i < kCompared * kCompared; ++i) {
    const Eigen::Vector2d part = Eigen::Vector2d(i % kCompared, i / kCompared) / (kCompared - 1.0);
    const auto at =
        position_mm<frame::Machine>(grid.low_mm + part.cwiseProduct(grid.high_mm - grid.low_mm));
    const double error_mm = differ_mm(at).norm();
    const double offset_mm = (differ_mm(at) - differ_mm(at - offset)).norm();
    // One that is no number has to fail.
    if (!(error_mm <= change.error_mm)) change.error_mm = error_mm;
    if (!(offset_mm <= change.offset_mm)) change.offset_mm = offset_mm;
  }
  return change;
}

/// True if jobs that the one map let through go on with the other; commands differ a little from
/// night to night.
bool covers(const TableGrid& grid, const TableGrid& before) {
  constexpr double kSlack_mm = 1;
  return (grid.low_mm.array() <= before.low_mm.array() + kSlack_mm).all() &&
         (grid.high_mm.array() >= before.high_mm.array() - kSlack_mm).all();
}

class TableKind final : public Calibration {
 public:
  /// In     file: that is installed
  TableKind(std::shared_ptr<MachineConfig> config,
            const NightlyConfig& nightly,
            CalibrationPlate plate,
            std::filesystem::path file)
      : config_(std::move(config)),
        plate_(std::move(plate)),
        file_(std::move(file)),
        limits_(nightly.limits),
        half_mm_(half_sides_mm(plate_)) {}

  LedgerKey key() const override { return table_key(*config_); }
  std::vector<std::string> axes() const override { return {"corner x", "corner y"}; }
  std::filesystem::path file() const override { return file_; }
  std::optional<Eigen::VectorXd> present() const override {
    const auto calibration = read_table_calibration(file_);
    if (!calibration) return std::nullopt;
    return table_corner(half_mm_, calibration->geometry).value;
  }
  int n_qualities() const override { return 1; }
  NightlyConfig held_to(const NightlyConfig& nightly) const override {
    NightlyConfig out = nightly;
    out.limits.max_outliers =
        std::max(out.limits.max_outliers, static_cast<int>(plate_.n_dots()) / kMaxTableOutliers);
    return out;
  }
  std::optional<LedgerValues> value_of(const LedgerEntry& entry) const override;
  Expected<CalibrationResult> measure(const CalibrationDevices& devices,
                                      const RecordWords& words) override;
  Expected<std::chrono::sys_seconds> date_of(const std::string& bytes,
                                             const std::string& name) const override {
    return internal::date_by(parse_table_calibration, bytes, name);
  }

 protected:
  std::string_view thing() const override { return "a table"; }

 private:
  Expected<TableRun> look(const CalibrationDevices& devices, int& n_missed) const;
  Expected<void> take_back_correction(TableData& data) const;
  std::vector<NightGate> gates_of(const TableRun& run) const;

  std::shared_ptr<MachineConfig> config_;
  CalibrationPlate plate_;
  std::filesystem::path file_;
  NightLimits limits_;
  Eigen::Vector2d half_mm_;
};

std::optional<LedgerValues> TableKind::value_of(const LedgerEntry& entry) const {
  constexpr std::array<std::string_view, 3> kNames = {"scale_x", "scale_y", "squareness"};
  const auto found = values_of(entry.record, kNames);
  if (!found) return std::nullopt;
  return table_corner(half_mm_, found->value, found->cov);
}

Expected<TableRun> TableKind::look(const CalibrationDevices& devices, int& n_missed) const {
  PANELCAL_TRY(const MarkSights seen, look_at_plate(*config_, devices, plate_));
  n_missed = static_cast<int>(seen.missed.size());
  TableSights sights = table_sights(*config_, seen);
  PANELCAL_CHECK(take_back_correction(sights.data));
  PANELCAL_CHECK(add_inputs({config_->camera_file, plate_.file}, sights.inputs));
  return calibrate_table(*config_, std::move(sights));
}

/// With a map in force the stage was sent to places; what the fit needs is what it was told, so
/// that its map has the table's whole error and not what the other left.
Expected<void> TableKind::take_back_correction(TableData& data) const {
  const auto& table = config_->walk.table;
  if (!table) return {};
  for (PlateView& view : data.views) {
    const auto command = table->command_for(view.axis_at);
    if (!command) return failure(table->refusal(view.axis_at));
    view.axis_at = *command;
  }
  return {};
}

/// Of the whole map; its axes are what is affine.
std::vector<NightGate> TableKind::gates_of(const TableRun& run) const {
  using internal::limit_gate;
  std::vector<NightGate> gates = {
      limit_gate(
          "map", run.calibration.sigma.in_mm(), limits_.sigma, "sigma of the map is {}, limit {}"),
      internal::reason_gate("looks", refusal(run), "the looks fit the map")};
  const auto before = read_table_calibration(file_);
  if (!before) return gates;
  const MapChange change =
      change_of(before->map, run.calibration.map, config_->spindle_camera.offset);
  gates.push_back(limit_gate("change",
                             change.error_mm,
                             limits_.change,
                             "the map is up to {} from the one in force, limit {}"));
  gates.push_back({"extent",
                   covers(run.calibration.map.grid(), before->map.grid()),
                   "the map is to reach as far as the one in force"});
  if (!config_->walk.table) return gates;
  gates.push_back(
      limit_gate("offset",
                 change.offset_mm,
                 limits_.sigma,
                 "with the map the spindle-camera offset would be up to {} wrong, limit {}"));
  return gates;
}

Expected<CalibrationResult> TableKind::measure(const CalibrationDevices& devices,
                                               const RecordWords& words) {
  int n_missed = 0;
  PANELCAL_TRY(const TableRun run, look(devices, n_missed));
  CalibrationResult out;
  PANELCAL_TRY(out.draft, table_draft(*config_, run, words));
  const LedgerValues found = table_corner(half_mm_, run.fit.geometry);
  out.result.point.value = found.value;
  out.result.point.cov = found.cov;
  out.result.used = "looks";
  out.result.n_used = static_cast<int>(run.sights.data.seen.size());
  out.result.n_outliers = n_missed + static_cast<int>(run.left_out.size());
  out.spreads =
      internal::fit_spread({"looks about the table's fit", "mm", 0, run.fit.degrees_of_freedom},
                           run.fit.rms_mm,
                           run.sights.data.seen.size());
  out.result.further = gates_of(run);
  out.report = internal::lines_of(report(run));
  return out;
}

}  // namespace

std::unique_ptr<Calibration> table_kind(std::shared_ptr<MachineConfig> config,
                                        const NightlyConfig& nightly,
                                        CalibrationPlate plate,
                                        std::filesystem::path file) {
  return std::make_unique<TableKind>(std::move(config), nightly, std::move(plate), std::move(file));
}

namespace internal {

Expected<Calibrations> table_calibrations(LedgerKind /*kind*/,
                                          const std::shared_ptr<MachineConfig>& config,
                                          const NightlyConfig& nightly) {
  const Missing missing = {nightly, "[nightly] calibrates the table, and "};
  if (nightly.is_simulated) {
    return missing("the virtual machine has no plate", "camera = \"URI\" of a real machine");
  }
  if (!config->camera) return missing("there is no camera", "[camera] calibration");
  PANELCAL_TRY(CalibrationPlate plate, read_plate(nightly.table.plate));
  if (plate.tags || plate.poses.size() != 1) {
    return missing("the plate does not lie in one known way", "a plate's file with one [[pose]]");
  }
  if (!plate.is_certified) {
    return missing("the plate is not certified: in one pose its errors are the table's",
                   "certified = true");
  }
  const std::filesystem::path& stated = nightly.table.file;
  const std::filesystem::path& file = config->table_file.empty() ? stated : config->table_file;
  if (file.empty()) {
    return missing("nothing names its calibration", "[table] calibration, or [nightly.table] file");
  }
  if (!stated.empty() && stated != file) {
    return missing("[table] calibration is another file than [nightly.table] file", "one of them");
  }
  return only_calibration(table_kind(config, nightly, std::move(plate), file));
}

}  // namespace internal

}  // namespace panelcal
