// SPDX-License-Identifier: Apache-2.0
#include "machine/calibrate/calibration_record.h"

#include <algorithm>
#include <array>
#include <system_error>
#include <utility>
#include <vector>

#include "calib/base/fields/noted_head.h"
#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "calib/camera/calibration/calibration_file.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

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
Expected<std::vector<LedgerEntry>> in_force(const MachineConfig& config, const Ledger& ledger) {
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

/// Text that the file should have; empty if nothing is in force.
Expected<std::string> text_in_force(const MachineConfig& config,
                                    const Ledger& ledger,
                                    const std::string& present) {
  PANELCAL_TRY(const std::vector<LedgerEntry> entries, in_force(config, ledger));
  if (entries.empty()) return std::string();
  SpindleCalibration all;
  std::string result;
  for (const LedgerEntry& entry : entries) {
    PANELCAL_TRY(result, ledger.result(entry.id));
    PANELCAL_CHECK(add_entry(entry, result, all));
  }
  add_others(present, all);
  if (all.offsets.all().size() == 1) return result;
  const LedgerEntry& newest = *std::ranges::max_element(entries, {}, &LedgerEntry::id);
  return internal::with_noted_head(spindle_calibration_text(all),
                                   {internal::NotedHead::Use::Head, newest.id, newest.hash});
}

}  // namespace

LedgerRecord record_of(LedgerKey key, const RecordWords& words) {
  LedgerRecord record;
  record.key = std::move(key);
  record.verdict = words.verdict;
  record.reason = words.reason;
  record.asked_by = words.asked_by;
  record.software = words.software;
  record.temperature_degC = words.temperature_degC;
  return record;
}

Expected<LedgerDraft> draft_of(const MachineConfig& config,
                               LedgerKey key,
                               const RecordWords& words) {
  LedgerDraft draft;
  draft.record = record_of(std::move(key), words);
  if (!config.file.empty()) {
    PANELCAL_TRY(LedgerInput input, input_of(config.file));
    draft.record.inputs.push_back(std::move(input));
  }
  return draft;
}

Expected<LedgerInput> input_of(const std::filesystem::path& file) {
  PANELCAL_TRY(const std::string bytes, read_file(file, kMaxCalibrationBytes));
  return LedgerInput{file.filename().string(), sha256(bytes), bytes.size()};
}

Expected<void> note_head(const Ledger& ledger, LedgerDraft& draft) {
  constexpr std::array<LedgerKind, 4> kWithFile = {
      LedgerKind::SpindleCamera, LedgerKind::Camera, LedgerKind::Table, LedgerKind::Surface};
  if (std::ranges::find(kWithFile, draft.record.key.kind) == kWithFile.end()) return {};
  PANELCAL_TRY(const LedgerHead head, ledger.head());
  draft.result = internal::with_noted_head(
      std::move(draft.result), {internal::NotedHead::Use::RecordedAfter, head.id, head.hash});
  return {};
}

Expected<std::string> text_with_head(const MachineConfig& config, std::string text) {
  std::error_code ignored;
  if (config.ledger_file.empty() || !std::filesystem::exists(config.ledger_file, ignored)) {
    return text;
  }
  PANELCAL_TRY(const Ledger ledger, Ledger::open_to_read(config.ledger_file));
  PANELCAL_TRY(const LedgerHead head, ledger.head());
  return internal::with_noted_head(std::move(text),
                                   {internal::NotedHead::Use::Head, head.id, head.hash});
}

Expected<std::vector<LedgerEntry>> installed_entries(const Ledger& ledger, const LedgerKey& key) {
  LedgerFilter filter;
  filter.machine = key.machine;
  filter.kind = key.kind;
  filter.subject = key.subject;
  PANELCAL_TRY(std::vector<LedgerEntry> entries, ledger.list(filter));
  std::erase_if(entries, [](const LedgerEntry& entry) {
    return entry.record.verdict != LedgerVerdict::Installed;
  });
  return entries;
}

bool is_since_the_ledger(const std::vector<LedgerEntry>& installed,
                         const LedgerEntry& in_force,
                         std::chrono::sys_seconds date) {
  return installed.size() != 1 || date > in_force.time;
}

std::string by_whom(const RecordWords& words) {
  std::string out;
  if (!words.asked_by.empty()) out += ", for " + words.asked_by;
  if (!words.software.empty()) out += ", by " + words.software;
  return out;
}

std::string subject(SpindleAt at) {
  return fmt::format("spindle {} station {}", at.spindle, at.station);
}

LedgerKey spindle_camera_key(const MachineConfig& config) {
  return {machine_name(config), LedgerKind::SpindleCamera, subject(spindle_of(config))};
}

SpindleCalibration spindle_camera_calibration(const MachineConfig& config,
                                              const SpindleCameraRun& run,
                                              const RecordWords& words) {
  const SpindleAt at = spindle_of(config);
  SpindleCalibration calibration;
  // Exactly symmetric, as a covariance has to be.
  SpindleCameraOffset offset = run.fit.offset;
  offset.cov_mm2 = 0.5 * (run.fit.offset.cov_mm2 + run.fit.offset.cov_mm2.transpose());
  calibration.offsets.set(at, offset);
  calibration.date = words.date;
  calibration.provenance = words.software + ": " + coupon_provenance(config, run);
  calibration.records.emplace(at, SpindleOffsetRecord{words.date, quality_of(run.fit)});
  return calibration;
}

Expected<LedgerDraft> spindle_camera_draft(const MachineConfig& config,
                                           const SpindleCameraRun& run,
                                           const RecordWords& words) {
  LedgerDraft draft;
  LedgerRecord& record = draft.record;
  record = record_of(spindle_camera_key(config), words);
  for (const std::filesystem::path& file : {config.file, config.camera_file}) {
    if (file.empty()) continue;
    PANELCAL_TRY(LedgerInput input, input_of(file));
    record.inputs.push_back(std::move(input));
  }
  const Eigen::Vector2d& offset_mm = run.fit.offset.offset.in_mm();
  record.parameters = {{"offset_x", offset_mm.x(), "mm"}, {"offset_y", offset_mm.y(), "mm"}};
  record.covariance = 0.5 * (run.fit.offset.cov_mm2 + run.fit.offset.cov_mm2.transpose());
  draft.result = spindle_calibration_text(spindle_camera_calibration(config, run, words));
  // A calibration that is not readable must not come into force.
  PANELCAL_CHECK(parse_spindle_calibration(draft.result, "the calibration"));
  return draft;
}

Expected<bool> install_spindle_camera(const MachineConfig& config, const Ledger& ledger) {
  const std::filesystem::path& file = config.spindle_setting.file;
  if (file.empty()) {
    return failure({Code::ConfigValue,
                    {config.file.string(), 0, 0},
                    "[spindle] names no calibration, so that nothing can be installed",
                    "[spindle] calibration = \"NAME.cal.json\""});
  }
  const Expected<std::string> present = read_file(file, kMaxCalibrationBytes);
  PANELCAL_TRY(const std::string text, text_in_force(config, ledger, present.value_or("")));
  if (text.empty() || (present && *present == text)) return false;
  PANELCAL_CHECK(write_file(file, text));
  return true;
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

}  // namespace panelcal
