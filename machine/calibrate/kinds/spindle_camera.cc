// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/kinds/spindle_camera.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <string_view>
#include <utility>

#include "calib/base/fields/noted_head.h"
#include "calib/base/files/atomic_file.h"
#include "calib/camera/calibration/calibration_file.h"
#include "machine/calibrate/kinds/coupon_scatter.h"
#include "machine/calibrate/kinds/parts.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using internal::date_by;
using internal::lines_of;

SpindleAt spindle_of(const MachineConfig& config) {
  return {config.spindle_setting.spindle, config.spindle_setting.station};
}

SpindleQuality quality_of(const SpindleCameraFit& fit) {
  const auto in_um = [](const ScatterEstimate& scatter) {
    return std::array<double, 2>{scatter.sigma[0].in_um(), scatter.sigma[1].in_um()};
  };
  SpindleQuality quality;
  quality.n_holes = fit.n_used;
  quality.n_looks = fit.n_views;
  quality.n_left_out = fit.n_outliers();
  quality.wander_um = in_um(fit.wander);
  if (fit.is_separated) quality.repeatability_um = in_um(fit.repeatability);
  for (std::size_t axis = 0; axis < 2; ++axis) {
    if (!fit.backlash[axis].is_determined) continue;
    quality.backlash_um[axis] = fit.backlash[axis].value.in_um();
  }
  return quality;
}

std::string coupon_provenance(const MachineConfig& config, const SpindleCameraRun& run) {
  return fmt::format("{} holes of coupon {}, rows from {}, tool {}; {}",
                     run.places.size(),
                     config.coupon ? quoted(config.coupon->name) : "?",
                     run.i_row + 1,
                     config.coupon ? config.coupon->drill_tool : 0,
                     run.fit.summary());
}

/// Everything of this kind that is in force, spindle by spindle.
Expected<std::vector<LedgerEntry>> spindles_in_force(const MachineConfig& config,
                                                     const Ledger& ledger) {
  PANELCAL_TRY(std::vector<LedgerEntry> entries, ledger.all_in_force(machine_name(config)));
  std::erase_if(entries, [](const LedgerEntry& entry) {
    return entry.record.key.kind != LedgerKind::SpindleCamera;
  });
  return entries;
}

/// Takes one spindle's offset over from `from`; false if it is not there.
bool take_over(SpindleAt at, const SpindleCalibration& from, SpindleCalibration& all) {
  const SpindleCameraOffset* const offset = from.offsets.find(at);
  if (offset == nullptr) return false;
  all.offsets.set(at, *offset);
  const auto record = from.records.find(at);
  all.records[at] =
      record == from.records.end() ? SpindleOffsetRecord{from.date, {}} : record->second;
  all.date = std::max(all.date, from.date_of(at));
  return true;
}

void add_words(std::string words, std::string& provenance) {
  if (!provenance.empty()) provenance += "; ";
  provenance += words;
}

/// Adds what an entry has on its own spindle.
Expected<void> add_entry(const LedgerEntry& entry,
                         const std::string& result,
                         SpindleCalibration& all) {
  const std::string where = fmt::format("ledger entry {}", entry.id);
  PANELCAL_TRY(const SpindleCalibration found, parse_spindle_calibration(result, where));
  for (const auto& [at, offset] : found.offsets.all()) {
    if (subject(at) != entry.record.key.subject) continue;
    take_over(at, found, all);
    add_words(fmt::format("{} of {}: {}", subject(at), where, found.provenance), all.provenance);
    return {};
  }
  return failure({Code::CalibrationInvalid,
                  {where, 0, 0},
                  "its result does not have " + quoted(entry.record.key.subject),
                  "the offset of that spindle"});
}

/// Adds spindles that the file has and the ledger does not have: an operator found them before
/// there was a ledger, and no message stated that they are wrong.
void add_others(const std::string& present, SpindleCalibration& all) {
  const auto found = parse_spindle_calibration(present, "");
  // A damaged file is what the ledger is there for.
  if (!found) return;
  for (const auto& [at, offset] : found->offsets.all()) {
    if (all.offsets.find(at) != nullptr) continue;
    take_over(at, *found, all);
    add_words(subject(at) + " as it was in the file", all.provenance);
  }
}

bool is_same_offset(const SpindleCameraOffset& a, const SpindleCameraOffset& b) {
  return a.offset.in_mm() == b.offset.in_mm() && a.cov_mm2 == b.cov_mm2;
}

/// See spindles_by_hand.
Expected<bool> is_by_hand(const MachineConfig& config,
                          const Ledger& ledger,
                          const SpindleCalibration& file,
                          SpindleAt at) {
  const LedgerKey key = {machine_name(config), LedgerKind::SpindleCamera, subject(at)};
  PANELCAL_TRY(const std::optional<LedgerEntry> in_force, ledger.in_force(key));
  if (!in_force) return false;
  PANELCAL_TRY(const std::vector<LedgerEntry> entries, installed_entries(ledger, key));
  for (const LedgerEntry& entry : entries) {
    PANELCAL_TRY(const std::string result, ledger.result(entry.id));
    const auto installed = parse_spindle_calibration(result, "");
    const SpindleCameraOffset* const offset = installed ? installed->offsets.find(at) : nullptr;
    if (offset != nullptr && is_same_offset(*offset, *file.offsets.find(at))) return false;
  }
  return is_since_the_ledger(entries, *in_force, file.date_of(at));
}

/// Exactly symmetric, as a covariance has to be.
SpindleCameraOffset symmetric_offset(const SpindleCameraRun& run) {
  SpindleCameraOffset offset = run.fit.offset;
  offset.cov_mm2 = 0.5 * (run.fit.offset.cov_mm2 + run.fit.offset.cov_mm2.transpose());
  return offset;
}

/// The run's offset as a calibration file of this one spindle.
SpindleCalibration spindle_camera_calibration(const MachineConfig& config,
                                              const SpindleCameraRun& run,
                                              const RecordWords& words) {
  const SpindleAt at = spindle_of(config);
  SpindleCalibration calibration;
  calibration.offsets.set(at, symmetric_offset(run));
  calibration.date = words.date;
  calibration.provenance = words.software + ": " + coupon_provenance(config, run);
  calibration.records.emplace(at, SpindleOffsetRecord{words.date, quality_of(run.fit)});
  return calibration;
}

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

class SpindleCameraKind final : public Calibration {
 public:
  explicit SpindleCameraKind(std::shared_ptr<MachineConfig> config) : config_(std::move(config)) {}

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
  Expected<CalibrationResult> measure(const CalibrationDevices& devices,
                                      const RecordWords& words) override;
  Expected<std::chrono::sys_seconds> date_of(const std::string& bytes,
                                             const std::string& name) const override {
    return date_by(parse_spindle_calibration, bytes, name);
  }
  Expected<std::optional<std::string>> text_in_force(const Ledger& ledger) const override;
  Expected<std::string> by_hand(const Ledger& ledger) const override;

 protected:
  std::string_view thing() const override { return "an offset"; }
  Expected<void> begin_there(const Ledger& ledger) override;

 private:
  std::shared_ptr<MachineConfig> config_;
};

Expected<std::vector<SelfTestCheck>> SpindleCameraKind::check() const {
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

std::optional<LedgerValues> SpindleCameraKind::value_of(const LedgerEntry& entry) const {
  constexpr std::array<std::string_view, 2> kNames = {"offset_x", "offset_y"};
  for (const std::string_view name : kNames) {
    const auto i = entry.record.find(name);
    if (i && entry.record.parameters[*i].unit != "mm") return std::nullopt;
  }
  return values_of(entry.record, kNames);
}

Expected<CalibrationResult> SpindleCameraKind::measure(const CalibrationDevices& devices,
                                                       const RecordWords& words) {
  PANELCAL_TRY(std::vector<LedgerInput> inputs, spindle_camera_inputs(*config_));
  PictureLevels levels;
  CalibrationDevices observed = devices;
  observed.taken_by = {fixed_clock(words.date), words.asked_by, words.software};
  observed.observer = [&](const SeenView& seen) {
    if (devices.observer) devices.observer(seen);
    levels.add(seen);
  };
  PANELCAL_TRY(const SpindleCameraRun run, calibrate_spindle_camera(*config_, observed));
  CalibrationResult out;
  out.result = spindle_camera_result(run);
  out.spreads = coupon_scatter(run);
  out.levels = levels.levels();
  out.holes = coupon_holes(run);
  out.report = lines_of(report_text(run));
  PANELCAL_TRY(out.draft, spindle_camera_draft(*config_, run, words, std::move(inputs)));
  return out;
}

Expected<std::optional<std::string>> SpindleCameraKind::text_in_force(const Ledger& ledger) const {
  PANELCAL_TRY(const std::vector<LedgerEntry> entries, spindles_in_force(*config_, ledger));
  std::optional<std::string> text;
  if (entries.empty()) return text;
  SpindleCalibration all;
  for (const LedgerEntry& entry : entries) {
    PANELCAL_TRY(text, ledger.result(entry.id));
    PANELCAL_CHECK(add_entry(entry, *text, all));
  }
  add_others(read_file(file(), kMaxCalibrationBytes).value_or(""), all);
  if (all.offsets.all().size() == 1) return text;
  const LedgerEntry& newest = *std::ranges::max_element(entries, {}, &LedgerEntry::id);
  return internal::with_noted_head(spindle_calibration_text(all),
                                   {internal::NotedHead::Use::Head, newest.id, newest.hash});
}

Expected<std::string> SpindleCameraKind::by_hand(const Ledger& ledger) const {
  PANELCAL_TRY(const std::vector<SpindleAt> spindles, spindles_by_hand(*config_, ledger));
  if (spindles.empty()) return std::string();
  std::string words = "an offset of ";
  for (const SpindleAt& at : spindles) words += (at == spindles.front() ? "" : ", ") + subject(at);
  return words;
}

Expected<void> SpindleCameraKind::begin_there(const Ledger& ledger) {
  PANELCAL_TRY(const std::optional<LedgerEntry> in_force, ledger.in_force(key()));
  if (!in_force) return {};
  SpindleSetting& setting = config_->spindle_setting;
  PANELCAL_TRY(setting.calibration, read_spindle_calibration(setting.file));
  return select_spindle(*config_, {setting.spindle, setting.station});
}

}  // namespace

std::string subject(SpindleAt at) {
  return fmt::format("spindle {} station {}", at.spindle, at.station);
}

LedgerKey spindle_camera_key(const MachineConfig& config) {
  return {machine_name(config), LedgerKind::SpindleCamera, subject(spindle_of(config))};
}

Expected<LedgerDraft> spindle_camera_draft(const MachineConfig& config,
                                           const SpindleCameraRun& run,
                                           const RecordWords& words,
                                           std::vector<LedgerInput> inputs) {
  LedgerDraft draft;
  LedgerRecord& record = draft.record;
  record = record_of(spindle_camera_key(config), words);
  record.inputs = std::move(inputs);
  const SpindleCameraOffset offset = symmetric_offset(run);
  const Eigen::Vector2d& offset_mm = offset.offset.in_mm();
  record.parameters = {{"offset_x", offset_mm.x(), "mm"}, {"offset_y", offset_mm.y(), "mm"}};
  record.covariance = offset.cov_mm2;
  draft.result = spindle_calibration_text(spindle_camera_calibration(config, run, words));
  // A calibration that is not readable must not come into force.
  PANELCAL_CHECK(parse_spindle_calibration(draft.result, "the calibration"));
  return draft;
}

Expected<std::vector<LedgerInput>> spindle_camera_inputs(const MachineConfig& config) {
  std::vector<LedgerInput> inputs;
  PANELCAL_CHECK(add_inputs({config.file, config.camera_file}, inputs));
  return inputs;
}

NightResult spindle_camera_result(const SpindleCameraRun& run) {
  const SpindleCameraOffset offset = symmetric_offset(run);
  NightResult result;
  result.point.value = offset.offset.in_mm();
  result.point.cov = offset.cov_mm2;
  result.n_used = run.fit.n_used;
  // A hole that was not even seen is no better than one that does not fit.
  result.n_outliers = static_cast<int>(run.places.size()) - run.fit.n_used;
  result.structure_chance = structure_chance(run.fit);
  return result;
}

Expected<std::vector<SpindleAt>> spindles_by_hand(const MachineConfig& config,
                                                  const Ledger& ledger) {
  std::vector<SpindleAt> by_hand;
  const auto file = read_spindle_calibration(config.spindle_setting.file);
  if (!file) return by_hand;
  for (const auto& [at, offset] : file->offsets.all()) {
    PANELCAL_TRY(const bool is_this_one, is_by_hand(config, ledger, *file, at));
    if (is_this_one) by_hand.push_back(at);
  }
  return by_hand;
}

std::unique_ptr<Calibration> spindle_camera_kind(std::shared_ptr<MachineConfig> config) {
  return std::make_unique<SpindleCameraKind>(std::move(config));
}

namespace internal {

Expected<Calibrations> spindle_camera_calibrations(LedgerKind /*kind*/,
                                                   const std::shared_ptr<MachineConfig>& config,
                                                   const NightlyConfig& nightly) {
  const Missing missing = {nightly, "[nightly] calibrates the spindle-camera offset, and "};
  if (!config->coupon) return missing("there is no coupon to drill", "[coupon]");
  if (config->coupon->has_entry_material && !nightly.is_simulated) {
    return missing("its coupon needs entry material, and no person lays it on at night",
                   "[coupon] entry_material = false");
  }
  if (!config->camera) return missing("there is no camera", "[camera] calibration");
  if (config->spindle_setting.file.empty()) {
    return missing("no file is named to install it in", "[spindle] calibration");
  }
  if (!config->vision_tools.contains(config->coupon->vision_tool)) {
    return missing(fmt::format("there is no vision tool {}", config->coupon->vision_tool),
                   "a [[vision.tool]] of that number");
  }
  return only_calibration(spindle_camera_kind(config));
}

}  // namespace internal

}  // namespace panelcal
