// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/night_order.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <system_error>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/ledger/ledger.h"
#include "machine/calibrate/kinds/kinds.h"
#include "machine/config/machine_config.h"
#include "machine/nightly/nightly.h"
#include "machine/nightly/record/night_lock.h"
#include "machine/operator/orders.h"
#include "machine/sources/device_set.h"
#include "program/walk/probing.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal::internal {
namespace {

constexpr std::string_view kNight = "night";
/// A screen shows no more.
constexpr std::size_t kMaxHistory = 200;
constexpr std::size_t kMaxLines = 1000;

Expected<MachineConfig> machine_with_nights(const StationSettings& settings) {
  PANELCAL_TRY(MachineConfig config, read_machine_config(settings.machine_file));
  if (config.nightly) return config;
  return failure({Code::ConfigValue,
                  {settings.machine_file.string(), 0, 0},
                  "missing table [nightly]",
                  "a table [nightly] (docs/howto/nightly.md)"});
}

Expected<void> require_ledger(const MachineConfig& config) {
  std::error_code ignored;
  const bool is_there =
      !config.ledger_file.empty() && std::filesystem::exists(config.ledger_file, ignored);
  if (is_there) return {};
  return failure({Code::ConfigValue,
                  {config.file.string(), 0, 0},
                  "the machine has no ledger",
                  "[ledger] file, and a calibration that it knows"});
}

Expected<void> check_stop(const Desk& desk) {
  if (!desk.must_stop()) return {};
  return failure({Code::Interrupted, {"panelcal serve", 0, 0}, "a person has stopped it", ""});
}

/// A camera until a person stops the calibration, which then ends as where a device fails.
class StoppedCamera final : public CameraDevice {
 public:
  StoppedCamera(CameraDevice& camera, const Desk& desk) : camera_(camera), desk_(desk) {}

  Expected<Image> take() override {
    PANELCAL_CHECK(check_stop(desk_));
    return camera_.take();
  }
  std::string name() const override { return camera_.name(); }
  std::optional<PictureSize> size() const override { return camera_.size(); }
  int n_retaken() const override { return camera_.n_retaken(); }
  std::vector<Diagnostic> risks() const override { return camera_.risks(); }
  bool can_set(CameraSetting setting) const override { return camera_.can_set(setting); }
  std::optional<double> value(CameraSetting setting) const override {
    return camera_.value(setting);
  }
  Expected<void> set(CameraSetting setting, double value) override {
    return camera_.set(setting, value);
  }

 private:
  CameraDevice& camera_;
  const Desk& desk_;
};

/// The same of the stage: a movement that has begun ends.
class StoppedStage final : public Stage {
 public:
  StoppedStage(Stage& stage, const Desk& desk) : stage_(stage), desk_(desk) {}

  Expected<Position<frame::Machine>> move_to(const Position<frame::Machine>& spindle) override {
    PANELCAL_CHECK(check_stop(desk_));
    return stage_.move_to(spindle);
  }
  bool can_set(CameraSetting setting) const override { return stage_.can_set(setting); }
  Expected<void> set(CameraSetting setting, double value) override {
    return stage_.set(setting, value);
  }

 private:
  Stage& stage_;
  const Desk& desk_;
};

/// The same of the probe, which drives to its places itself.
class StoppedProbe final : public ProbeSource {
 public:
  StoppedProbe(ProbeSource& probe, const Desk& desk) : probe_(probe), desk_(desk) {}

  Expected<ProbeReading> probe(const ProbeRequest& request) override {
    PANELCAL_CHECK(check_stop(desk_));
    return probe_.probe(request);
  }
  Expected<void> finish() override { return probe_.finish(); }

 private:
  ProbeSource& probe_;
  const Desk& desk_;
};

/// The same of the spindle.
class StoppedSpindle final : public Spindle {
 public:
  StoppedSpindle(Spindle& spindle, const Desk& desk) : spindle_(spindle), desk_(desk) {}

  bool can_drill() const override { return spindle_.can_drill(); }
  Expected<void> drill(int tool) override {
    PANELCAL_CHECK(check_stop(desk_));
    return spindle_.drill(tool);
  }

 private:
  Spindle& spindle_;
  const Desk& desk_;
};

/// A warm-up waits for minutes.
void wait_unless_stopped(const CalibrationDevices& devices, Time time, const Desk& desk) {
  constexpr Time kPiece = seconds(0.5);
  for (Time left = time; left > seconds(0) && !desk.must_stop(); left = left - kPiece) {
    if (devices.wait) devices.wait(std::min(left, kPiece));
  }
}

Expected<NightRecord> calibrate(const StationSettings& settings,
                                const std::string& kind,
                                const std::string& who,
                                std::function<void(std::string_view)> progress,
                                const Desk& desk) {
  PANELCAL_TRY(MachineConfig config, machine_with_nights(settings));
  NightlyConfig nightly = *config.nightly;
  if (kind != kNight) nightly.calibrate = {kind};
  if (config.ledger_file.empty()) return failure(require_ledger(config).error());
  // Before a device is opened: another run may be using it.
  PANELCAL_TRY(const NightLock lock, NightLock::take(config.ledger_file, settings.clock()));
  PANELCAL_TRY(const DeviceSet devices,
               settings.camera.empty() ? DeviceSet::simulated(config, settings.clock())
                                       : DeviceSet::live(config, settings.camera));
  const CalibrationDevices all = devices.devices();
  StoppedCamera camera(all.camera, desk);
  StoppedSpindle spindle(all.spindle, desk);
  StoppedStage stage(all.stage, desk);
  std::optional<StoppedProbe> probe;
  if (all.probe != nullptr) probe.emplace(*all.probe, desk);
  CalibrationDevices stopped = {stage,
                                spindle,
                                camera,
                                [&](Time time) { wait_unless_stopped(all, time, desk); },
                                all.prompt,
                                all.observer,
                                all.now,
                                probe ? &*probe : nullptr,
                                all.taken_by};
  std::vector<std::string> notes;
  for (const Diagnostic& risk : devices.risks()) notes.push_back(risk.text());
  return run_nightly({.config = config,
                      .nightly = nightly,
                      .devices = std::move(stopped),
                      .clock = settings.clock,
                      .software = settings.software,
                      .asked_by = who,
                      .is_again = kind != kNight,
                      .progress = std::move(progress),
                      .lock = &lock,
                      .notes = std::move(notes)});
}

}  // namespace

Expected<void> take_calibration(const StationSettings& settings,
                                const std::string& kind,
                                Screen& screen) {
  PANELCAL_CHECK(check_idle(screen));
  if (!settings.images.empty()) {
    return failure(refused("recorded pictures calibrate nothing", "--camera or --machine-driver"));
  }
  std::vector<std::string_view> known = {kNight};
  for (const CalibrationWords& one : calibration_words()) known.push_back(one.word);
  if (std::ranges::find(known, kind) == known.end()) {
    return failure(refused("kind " + quoted(kind), fmt::format("{}", fmt::join(known, ", "))));
  }
  screen.calibration.emplace();
  screen.calibration->kind = kind;
  screen.calibration->state = "running";
  return {};
}

void run_calibration(const StationSettings& settings,
                     const std::string& kind,
                     const std::string& who,
                     Desk& desk) {
  const auto add = [&](std::string_view line) {
    desk.change([&](Screen& screen) {
      std::vector<std::string>& lines = screen.calibration->lines;
      if (lines.size() < kMaxLines) lines.emplace_back(line);
    });
  };
  const Expected<NightRecord> record = calibrate(settings, kind, who, add, desk);
  bool has_page = false;
  if (record && settings.night_page) {
    const std::filesystem::path folder = settings.jobs_folder / kNight;
    std::error_code ignored;
    std::filesystem::create_directories(folder, ignored);  // writing says why it cannot
    const auto kept = write_file(folder / "report.html", settings.night_page(*record));
    if (!kept) add(kept.error().text());
    has_page = kept.has_value();
  }
  std::vector<ScreenHistory> history = history_of(settings);
  desk.change([&](Screen& screen) {
    ScreenCalibration& calibration = *screen.calibration;
    const bool is_done = record && record->outcome != NightOutcome::Failed;
    calibration.state = is_done ? "done" : "failed";
    calibration.verdict = record ? record->verdict : record.error().text();
    calibration.has_page = has_page;
    screen.history = std::move(history);
  });
}

Expected<void> roll_back(const StationSettings& settings,
                         const std::string& kind,
                         std::int64_t to,
                         const std::string& reason,
                         const std::string& who) {
  PANELCAL_TRY(MachineConfig config, machine_with_nights(settings));
  PANELCAL_CHECK(require_ledger(config));
  const auto known = ledger_kind(kind);
  if (!known) {
    return failure(
        refused("kind " + quoted(kind), fmt::format("{}", fmt::join(ledger_kind_words(), ", "))));
  }
  PANELCAL_TRY(const NightLock lock, NightLock::take(config.ledger_file, settings.clock()));
  PANELCAL_TRY(Ledger ledger, Ledger::open(config.ledger_file, settings.clock));
  PANELCAL_TRY(const LedgerEntry entry, ledger.entry(to));
  const LedgerKey& key = entry.record.key;
  if (key.kind != *known || key.machine != config.name) {
    return failure(refused(
        fmt::format(
            "entry {} is of {} of {}", to, word(key.kind), quoted(std::string_view(key.machine))),
        fmt::format("one of {} of {}", kind, config.name)));
  }
  PANELCAL_CHECK(ledger.roll_back({key, to, reason, who, settings.software}));
  // The ledger says what is in force; the file follows, now or with the next night.
  NightlyConfig nightly = *config.nightly;
  nightly.calibrate = {kind};
  PANELCAL_TRY(const NightCalibrations calibrations, NightCalibrations::make(config, nightly));
  for (const Calibration* const calibration : calibrations.all()) {
    if (calibration->key() != key || !calibration->has_file()) continue;
    PANELCAL_CHECK(calibration->write_in_force(ledger));
  }
  return {};
}

std::vector<std::string> kinds_of(const StationSettings& settings) {
  std::vector<std::string> out;
  const auto config = machine_with_nights(settings);
  if (!config || config->ledger_file.empty() || !settings.images.empty()) return out;
  out.emplace_back(kNight);
  for (const CalibrationWords& one : calibration_words()) {
    NightlyConfig nightly = *config->nightly;
    nightly.calibrate = {std::string(one.word)};
    if (NightCalibrations::make(*config, nightly)) out.emplace_back(one.word);
  }
  return out;
}

std::vector<ScreenHistory> history_of(const StationSettings& settings) {
  std::vector<ScreenHistory> out;
  const auto config = read_machine_config(settings.machine_file);
  if (!config || !require_ledger(*config)) return out;
  const auto ledger = Ledger::open_to_read(config->ledger_file);
  if (!ledger) return out;
  const auto entries = ledger->list({.machine = config->name, .last = kMaxHistory});
  const auto in_force = ledger->all_in_force(config->name);
  if (!entries || !in_force) return out;
  for (const LedgerEntry& entry : *entries) {
    const LedgerRecord& record = entry.record;
    const bool is_in_force =
        std::ranges::find(*in_force, entry.id, &LedgerEntry::id) != in_force->end();
    std::string words =
        fmt::format("{}, {}, by {}", record.key.subject, word(record.verdict), record.asked_by);
    if (!record.reason.empty()) words += ": " + record.reason;
    out.push_back({std::string(word(record.key.kind)),
                   std::to_string(entry.id),
                   iso_8601(entry.time),
                   is_in_force,
                   std::move(words)});
  }
  std::ranges::reverse(out);
  return out;
}

}  // namespace panelcal::internal
