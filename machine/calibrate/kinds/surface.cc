// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/drift/amount.h"
#include "machine/calibrate/kinds/kinds.h"
#include "machine/calibrate/kinds/parts.h"
#include "machine/calibrate/surface/change.h"
#include "machine/calibrate/surface/record.h"
#include "machine/calibrate/surface/run.h"
#include "machine/look/mark_sights.h"
#include "surface/map/file.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Of the places that may be left out or not touched: tables get dirty.
constexpr int kMaxSurfaceOutliers = 20;  ///< one in this number
/// Smaller chances than this say that the table changed.
constexpr double kSignificant = 0.01;

LedgerValues value_of_figures(const SurfaceFigures& figures) {
  return {figures.value_mm, figures.cov_mm2};
}

std::string part_words(const DifferencePart& part) {
  return fmt::format("{} (chance {:.2g})",
                     part.chance < kSignificant ? "more than probes scatter" : "as probes scatter",
                     part.chance);
}

/// Height to which tilt lifts a corner above the middle.
double tilted_mm(const MapDifference& d) {
  constexpr double kMicrometresAMetre = 1e-6;
  return kMicrometresAMetre *
         (std::abs(d.tilt_x.value) * d.half_mm.x() + std::abs(d.tilt_y.value) * d.half_mm.y());
}

/// Greatest height by which bow and twist lift or lower an edge or a corner against the middle.
double bowed_mm(const MapDifference& d) {
  const double x = d.bow_x_um->value, y = d.bow_y_um->value, twist = d.twist_um->value;
  return um(std::max({std::abs(x), std::abs(y), std::abs(x + y) + std::abs(twist)})).in_mm();
}

/// The table's own surface, of a backing plate or a reference plate that stays on the machine.
class SurfaceKind final : public Calibration {
 public:
  SurfaceKind(std::shared_ptr<MachineConfig> config, const NightlyConfig& nightly)
      : config_(std::move(config)), surface_(nightly.surface) {}

  LedgerKey key() const override { return surface_key(*config_); }
  std::vector<std::string> axes() const override {
    return {"offset", "tilt x", "tilt y", "bow x", "bow y", "twist"};
  }
  std::filesystem::path file() const override { return surface_.file; }
  std::optional<Eigen::VectorXd> present() const override {
    const auto stored = read_map_file(file());
    if (!stored) return std::nullopt;
    const auto figures = figures_of(stored->map, area_of(surface_));
    if (!figures) return std::nullopt;
    return figures->value_mm;
  }
  Expected<std::vector<SelfTestCheck>> check() const override;
  int n_qualities() const override { return surface_.n_repeats > 1 ? 1 : 0; }
  NightlyConfig held_to(const NightlyConfig& nightly) const override;
  /// Of another area's heights nothing compares.
  std::optional<LedgerValues> value_of(const LedgerEntry& entry) const override {
    const auto figures = figures_of(entry);
    if (!figures || figures->area != area_of(surface_)) return std::nullopt;
    return value_of_figures(*figures);
  }
  Expected<CalibrationResult> measure(const CalibrationDevices& devices,
                                      const RecordWords& words) override;
  /// A map has no date: one that was never installed may always be a person's.
  Expected<std::chrono::sys_seconds> date_of(const std::string& bytes,
                                             const std::string& name) const override {
    PANELCAL_CHECK(parse_map_file(bytes, name));
    return std::chrono::sys_seconds::max();
  }

 protected:
  std::string_view thing() const override { return "a map"; }

 private:
  int n_places() const { return surface_.n_columns * surface_.n_rows; }
  NightGate limit(std::string_view what,
                  double value_mm,
                  Length limit,
                  const std::string& how_sure) const;
  std::vector<NightGate> gates_of(const SurfaceRun& run,
                                  const std::optional<Expected<SurfaceChange>>& change) const;
  std::vector<NightGate> gates_of(const SurfaceChange& change) const;

  std::shared_ptr<MachineConfig> config_;
  NightSurface surface_;
};

Expected<std::vector<SelfTestCheck>> SurfaceKind::check() const {
  for (const Eigen::Vector2d& corner_mm : {surface_.low_mm, surface_.high_mm}) {
    if (is_in_travel(*config_, position_mm<frame::Machine>(corner_mm))) continue;
    return failure({Code::ConfigValue,
                    {config_->file.string(), 0, 0},
                    fmt::format("[nightly.surface] reaches to ({:g}, {:g}), which is outside of "
                                "the travel",
                                corner_mm.x(),
                                corner_mm.y()),
                    "low_mm and high_mm inside of it"});
  }
  return std::vector<SelfTestCheck>{};
}

NightlyConfig SurfaceKind::held_to(const NightlyConfig& nightly) const {
  NightlyConfig out = nightly;
  out.limits.sigma = surface_.sigma.in_mm();
  // Of all figures together; each by itself, and each place, has its own gate.
  const double most_mm = std::max({surface_.offset, surface_.tilt, surface_.bow}).in_mm();
  out.limits.change = std::sqrt(double{SurfaceFigures::kSize}) * most_mm;
  out.limits.min_used = std::max(out.limits.min_used, n_places() / 2);
  out.limits.max_outliers = std::max(out.limits.max_outliers, n_places() / kMaxSurfaceOutliers);
  return out;
}

NightGate SurfaceKind::limit(std::string_view what,
                             double value_mm,
                             Length limit,
                             const std::string& how_sure) const {
  return {"change",
          std::abs(value_mm) <= limit.in_mm(),
          fmt::format("{} by {}, {}; limit {}",
                      what,
                      amount(std::abs(value_mm), unit()),
                      how_sure,
                      amount(limit.in_mm(), unit()))};
}

std::vector<NightGate> SurfaceKind::gates_of(const SurfaceChange& change) const {
  const MapDifference& d = change.difference;
  std::vector<NightGate> gates = {
      limit("against the map in force the middle has moved",
            um(d.offset_um.value).in_mm(),
            surface_.offset,
            part_words(d.offset)),
      limit("tilt has moved the corners", tilted_mm(d), surface_.tilt, part_words(d.tilt))};
  if (d.bow) {
    gates.push_back(
        limit("bow and twist have moved the edges", bowed_mm(d), surface_.bow, part_words(*d.bow)));
  }
  const std::string where =
      fmt::format("({:.1f}, {:.1f})", change.greatest_at_mm.x(), change.greatest_at_mm.y());
  const std::string sigma = "sigma " + amount(change.greatest_mm.sigma, unit());
  if (change.greatest_probe.empty()) {
    gates.push_back(limit(fmt::format("the surface has moved most at {},", where),
                          change.greatest_mm.value,
                          surface_.anywhere,
                          fmt::format("{}, {}", sigma, part_words(d.all))));
  } else {
    gates.push_back(limit(fmt::format("the surface has moved most at {}, the probe at {} that is "
                                      "left out,",
                                      where,
                                      change.greatest_probe),
                          change.greatest_mm.value,
                          surface_.anywhere,
                          sigma));
  }
  return gates;
}

std::vector<NightGate> SurfaceKind::gates_of(
    const SurfaceRun& run, const std::optional<Expected<SurfaceChange>>& change) const {
  std::vector<NightGate> gates = {
      internal::limit_gate("map",
                           largest_sigma(run.stored.map, run.figures.area).in_mm(),
                           surface_.sigma.in_mm(),
                           "sigma of the map is up to {}, limit {}")};
  if (!change) return gates;
  if (*change) {
    std::ranges::move(gates_of(**change), std::back_inserter(gates));
  } else {
    gates.push_back({"change",
                     false,
                     "the change since the map in force is not known: " + change->error().what});
  }
  return gates;
}

Expected<CalibrationResult> SurfaceKind::measure(const CalibrationDevices& devices,
                                                 const RecordWords& words) {
  if (devices.probe == nullptr) {
    return failure({Code::NotSupported,
                    {config_->file.string(), 0, 0},
                    "[nightly] probes the surface, and this machine has no probe",
                    "[machine] probe_command"});
  }
  PANELCAL_TRY(SurfaceRun run, probe_surface(surface_, *devices.probe, words.software));
  std::optional<Expected<SurfaceChange>> change;
  // Only where there is no file there is nothing to compare with.
  if (std::filesystem::exists(file())) {
    const auto before = read_map_file(file());
    change = before ? change_between(*before, run.stored) : failure(before.error());
  }
  const std::optional<SurfaceChange> known =
      change && *change ? std::optional(**change) : std::nullopt;
  CalibrationResult out;
  PANELCAL_TRY(out.draft, surface_draft(*config_, run.stored, run.figures, known, words));
  const LedgerValues found = value_of_figures(run.figures);
  out.result.point.value = found.value;
  out.result.point.cov = found.cov;
  out.result.used = "probes";
  out.result.n_used = static_cast<int>(run.stored.map.kept().size());
  // A chip that is known has been looked at.
  out.result.n_outliers = static_cast<int>(run.missed.size() + run.stored.map.outliers().size()) -
                          (known ? known->n_known : 0);
  out.result.further = gates_of(run, change);
  if (run.degrees_of_freedom > 0 && run.reading_variance_mm2 > 0) {
    out.spreads = {{"readings of one place",
                    "mm",
                    run.reading_variance_mm2,
                    static_cast<double>(run.degrees_of_freedom)}};
  }
  out.report = internal::lines_of(report(run));
  out.surface = std::move(run.stored);
  return out;
}

}  // namespace

std::unique_ptr<Calibration> surface_kind(std::shared_ptr<MachineConfig> config,
                                          const NightlyConfig& nightly) {
  return std::make_unique<SurfaceKind>(std::move(config), nightly);
}

namespace internal {

Expected<Calibrations> surface_calibrations(LedgerKind /*kind*/,
                                            const std::shared_ptr<MachineConfig>& config,
                                            const NightlyConfig& nightly) {
  const Missing missing = {nightly, "[nightly] probes the surface, and "};
  if (nightly.surface.file.empty()) {
    return missing("[nightly] calibrates the surface, and [nightly.surface] is missing",
                   "[nightly.surface]");
  }
  if (nightly.is_simulated && !(config->sim && config->sim->table_surface)) {
    return missing("the virtual machine has no table to probe", "[sim.table_surface]");
  }
  if (!nightly.is_simulated && !config->can_probe()) {
    return missing(
        "this machine has no probe",
        "[machine] probe_command = [\"PROGRAM\", \"{x}\", \"{y}\"], or driver and probe_from_mm");
  }
  return only_calibration(surface_kind(config, nightly));
}

}  // namespace internal

}  // namespace panelcal
