// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "calib/spindle/calibration_file.h"
#include "machine/calibrate/calibration_record.h"
#include "machine/nightly/calibrations/coupon_scatter.h"
#include "machine/nightly/calibrations/night_calibrations.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// Geometric means over all looks that found their hole.
class PictureLevels {
 public:
  void add(const SeenView& seen) {
    if (seen.detection.status != DetectionStatus::Found || !seen.detection.best) return;
    const TargetFit& fit = *seen.detection.best;
    const double contrast = std::abs(fit.contrast) / seen.picture.image.full_scale();
    if (!(contrast > 0) || !(fit.blur_px > 0)) return;
    ++n_;
    log_contrast_ += std::log(contrast);
    log_blur_ += std::log(fit.blur_px);
  }

  std::vector<NightLevel> levels() const {
    if (n_ == 0) return {};
    return {{"contrast of holes", "1", std::exp(log_contrast_ / n_), true},
            {"edge blur of holes", "px", std::exp(log_blur_ / n_), false}};
  }

 private:
  int n_ = 0;
  double log_contrast_ = 0;
  double log_blur_ = 0;
};

/// The chance of the larger of two trends, that of two tests.
std::optional<double> structure_chance(const SpindleCameraFit& fit) {
  std::optional<double> least;
  int n = 0;
  for (const auto& trend : {fit.over_coupon, fit.over_picture}) {
    if (!trend) continue;
    ++n;
    least = least ? std::min(*least, trend->chance) : trend->chance;
  }
  if (!least) return std::nullopt;
  return std::min(1.0, n * *least);
}

class SpindleCameraNight final : public NightCalibration {
 public:
  explicit SpindleCameraNight(std::shared_ptr<MachineConfig> config) : config_(std::move(config)) {}

  LedgerKey key() const override { return spindle_camera_key(*config_); }
  std::vector<std::string> axes() const override { return {"x", "y"}; }
  std::filesystem::path file() const override { return config_->spindle_setting.file; }

  std::optional<Eigen::VectorXd> present() const override {
    if (!config_->spindle_setting.is_calibrated) return std::nullopt;
    return config_->spindle_camera.offset.in_mm();
  }

  Expected<std::vector<SelfTestCheck>> check() const override;
  Expected<int> used_up() const override {
    PANELCAL_TRY(const UsedRows used, used_rows(*config_));
    return used.count();
  }
  int n_qualities() const override { return kMostCouponSpreads + 2; }
  std::optional<LedgerValues> value_of(const LedgerEntry& entry) const override;
  Expected<NightMeasurement> measure(const CalibrationDevices& devices,
                                     const RecordWords& words) override;
  Expected<bool> is_installed(const Ledger& ledger) const override;
  Expected<std::string> by_hand(const Ledger& ledger) const override;
  Expected<bool> install(const Ledger& ledger) override;

 private:
  std::shared_ptr<MachineConfig> config_;
};

Expected<std::vector<SelfTestCheck>> SpindleCameraNight::check() const {
  const Coupon& coupon = *config_->coupon;
  PANELCAL_TRY(const UsedRows used, used_rows(*config_));
  SelfTestCheck rows;
  rows.name = "coupon";
  rows.value = std::max(0, coupon.rows - used.count());
  rows.limit = coupon.rows_per_run;
  rows.unit = "rows";
  rows.passed = *rows.value >= *rows.limit;
  rows.text = free_rows_text(coupon, used.count());
  if (const std::string missing = missing_rows_text(coupon, used); !missing.empty()) {
    rows.text += "; " + missing;
  }
  return std::vector{rows};
}

std::optional<LedgerValues> SpindleCameraNight::value_of(const LedgerEntry& entry) const {
  constexpr std::array<std::string_view, 2> kNames = {"offset_x", "offset_y"};
  for (const std::string_view name : kNames) {
    const auto i = entry.record.find(name);
    if (i && entry.record.parameters[*i].unit != "mm") return std::nullopt;
  }
  return values_of(entry.record, kNames);
}

Expected<NightMeasurement> SpindleCameraNight::measure(const CalibrationDevices& devices,
                                                       const RecordWords& words) {
  PictureLevels levels;
  CalibrationDevices observed = devices;
  observed.taken_by = {fixed_clock(words.date), words.asked_by, words.software};
  observed.observer = [&](const SeenView& seen) {
    if (devices.observer) devices.observer(seen);
    levels.add(seen);
  };
  PANELCAL_TRY(const SpindleCameraRun run, calibrate_spindle_camera(*config_, observed));
  NightMeasurement out;
  out.result.point.value = run.fit.offset.offset.in_mm();
  out.result.point.cov = run.fit.offset.cov_mm2;
  out.result.n_used = run.fit.n_used;
  // A hole that was not even seen is no better than one that does not fit.
  out.result.n_outliers = static_cast<int>(run.places.size()) - run.fit.n_used;
  out.result.structure_chance = structure_chance(run.fit);
  out.spreads = coupon_scatter(run);
  out.levels = levels.levels();
  out.holes = coupon_holes(run);
  out.report = internal::lines_of(report_text(run));
  PANELCAL_TRY(out.draft, spindle_camera_draft(*config_, run, words));
  return out;
}

Expected<bool> SpindleCameraNight::is_installed(const Ledger& ledger) const {
  PANELCAL_TRY(const std::optional<LedgerEntry> in_force, ledger.in_force(key()));
  if (!in_force) return true;
  const auto value = value_of(*in_force);
  const Expected<SpindleCalibration> file = read_spindle_calibration(this->file());
  if (!file || !value) return false;
  const SpindleSetting& setting = config_->spindle_setting;
  const SpindleCameraOffset* offset = file->offsets.find({setting.spindle, setting.station});
  return offset != nullptr && offset->offset.in_mm() == Eigen::Vector2d(value->value) &&
         offset->cov_mm2 == Eigen::Matrix2d(value->cov);
}

Expected<std::string> SpindleCameraNight::by_hand(const Ledger& ledger) const {
  PANELCAL_TRY(const std::vector<SpindleAt> spindles, spindles_by_hand(*config_, ledger));
  if (spindles.empty()) return std::string();
  std::string words = "an offset of ";
  for (const SpindleAt& at : spindles) words += (at == spindles.front() ? "" : ", ") + subject(at);
  return words;
}

Expected<bool> SpindleCameraNight::install(const Ledger& ledger) {
  PANELCAL_TRY(const bool is_written, install_spindle_camera(*config_, ledger));
  PANELCAL_TRY(const std::optional<LedgerEntry> in_force, ledger.in_force(key()));
  if (!in_force) return is_written;
  SpindleSetting& setting = config_->spindle_setting;
  PANELCAL_TRY(setting.calibration, read_spindle_calibration(setting.file));
  PANELCAL_CHECK(select_spindle(*config_, {setting.spindle, setting.station}));
  return is_written;
}

}  // namespace

namespace internal {

Expected<std::unique_ptr<NightCalibration>> spindle_camera_night(
    std::shared_ptr<MachineConfig> config, const NightlyConfig& nightly) {
  const auto missing = [&](std::string what, std::string expected) {
    return failure({Code::ConfigValue, nightly.place, std::move(what), std::move(expected)});
  };
  const std::string needs = "[nightly] calibrates the spindle-camera offset, and ";
  if (!config->coupon) return missing(needs + "there is no coupon to drill", "[coupon]");
  if (config->coupon->has_entry_material && !nightly.is_simulated) {
    return missing(needs + "its coupon needs entry material, and no person lays it on at night",
                   "[coupon] entry_material = false");
  }
  if (!config->camera) return missing(needs + "there is no camera", "[camera] calibration");
  if (config->spindle_setting.file.empty()) {
    return missing(needs + "no file is named to install it in", "[spindle] calibration");
  }
  if (!config->vision_tools.contains(config->coupon->vision_tool)) {
    return missing(fmt::format("{}there is no vision tool {}", needs, config->coupon->vision_tool),
                   "a [[vision.tool]] of that number");
  }
  return std::make_unique<SpindleCameraNight>(std::move(config));
}

}  // namespace internal

}  // namespace panelcal
