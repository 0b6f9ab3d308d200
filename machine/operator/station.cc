// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/station.h"

#include <algorithm>
#include <array>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "machine/config/machine_config.h"
#include "machine/devices/cameras/without_password.h"
#include "machine/operator/command.h"
#include "machine/operator/desk.h"
#include "machine/operator/opened_program.h"
#include "machine/operator/programs.h"
#include <fmt/format.h>

namespace panelcal {

using internal::Command;
using internal::Desk;
using internal::JobState;
using internal::Order;
using internal::refused;
using internal::Screen;
using internal::ScreenJob;

namespace {

/// New files of the folder of programs show after this time.
constexpr std::chrono::milliseconds kProgramsInterval{2000};

Expected<void> check_settings(const StationSettings& settings) {
  const auto n_sources =
      std::ranges::count_if(std::array{settings.camera, settings.images, settings.machine_driver},
                            [](const std::string& text) { return !text.empty(); });
  if (n_sources == 1) return {};
  return failure({Code::Usage,
                  {"panelcal serve", 0, 0},
                  fmt::format("{} sources of pictures", n_sources),
                  "one of --camera, --images and --machine-driver"});
}

std::string source_words(const StationSettings& settings) {
  if (!settings.camera.empty()) return "the camera " + without_password(settings.camera);
  if (!settings.images.empty()) return "pictures in " + settings.images;
  return "the simulated machine of " + settings.machine_file.string();
}

Expected<void> make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error) return {};
  return failure({Code::DeviceWrite, {folder.string(), 0, 0}, error.message(), "a folder"});
}

}  // namespace

class Station::Impl {
 public:
  Impl(StationSettings settings, Screen screen)
      : settings_(std::move(settings)),
        desk_(std::move(screen)),
        thread_([this] { run_machine(); }) {}
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    desk_.close();
    thread_.join();
  }

  Desk& desk() { return desk_; }
  std::filesystem::path programs() const { return settings_.jobs_folder / "programs"; }

  Expected<void> carry_out(Command command) {
    switch (command.order) {
      case Order::Open:
        return open(command.name);
      case Order::Close:
        return close();
      default:
        return failure(refused("not available yet", "open or close"));
    }
  }

  Expected<void> add_program(const std::string& name, std::string_view bytes) {
    const bool is_open =
        desk_.read([&](const Screen& screen) { return screen.job && screen.job->program == name; });
    if (is_open) {
      return failure(refused("program " + quoted(name) + " is open", "the job closed first"));
    }
    PANELCAL_CHECK(internal::store_program(programs(), name, bytes));
    list_programs();
    return {};
  }

 private:
  void list_programs() {
    auto programs = internal::list_programs(this->programs());
    const bool is_new =
        desk_.read([&](const Screen& screen) { return screen.programs != programs; });
    if (is_new) desk_.change([&](Screen& screen) { screen.programs = std::move(programs); });
  }

  /// The machine thread.
  void run_machine() {
    while (!desk_.is_closing()) {
      desk_.wait_for_work(kProgramsInterval);
      list_programs();
    }
  }

  /// Touches no device, so that the thread that asks does it.
  Expected<void> open(const std::string& name) {
    PANELCAL_CHECK(internal::check_name(name));
    PANELCAL_CHECK(desk_.read([](const Screen& screen) { return check_may_open(screen); }));
    PANELCAL_TRY(
        const internal::OpenedProgram opened,
        internal::open_program(settings_.machine_file, programs() / name, settings_.clock()));
    ScreenJob job = internal::checked_job(opened, next_job_id(), name);
    return desk_.try_change([&](Screen& screen) -> Expected<void> {
      PANELCAL_CHECK(check_may_open(screen));
      screen.machine = opened.machine.name;
      screen.job = std::move(job);
      return {};
    });
  }

  static Expected<void> check_may_open(const Screen& screen) {
    if (!screen.job) return {};
    if (is_running(screen.job->state)) {
      return failure(refused("a job is running", "open when it has ended"));
    }
    if (screen.job->state != JobState::Resumable) return {};
    return failure(
        refused("job " + screen.job->id + " was interrupted", "resume, or close it first"));
  }

  Expected<void> close() {
    return desk_.try_change([](Screen& screen) -> Expected<void> {
      if (!screen.job) return failure(refused("no job is open", "open"));
      if (is_running(screen.job->state)) {
        return failure(refused("a job is running", "stop before close"));
      }
      screen.job.reset();
      return {};
    });
  }

  /// "2026-11-27-1", the first of the day that no folder has.
  std::string next_job_id() const {
    const std::string day = iso_8601(settings_.clock()).substr(0, 10);
    for (int i = 1;; ++i) {
      const std::string id = fmt::format("{}-{}", day, i);
      std::error_code error;
      if (!std::filesystem::exists(settings_.jobs_folder / id, error)) return id;
    }
  }

  StationSettings settings_;
  Desk desk_;
  std::thread thread_;  ///< last, since it uses the others
};

Station::Station(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {
}
Station::~Station() = default;

Expected<std::unique_ptr<Station>> Station::create(StationSettings settings) {
  PANELCAL_CHECK(check_settings(settings));
  if (!settings.clock) settings.clock = system_clock();
  PANELCAL_TRY(const MachineConfig machine, read_machine_config(settings.machine_file));
  PANELCAL_CHECK(make_folder(settings.jobs_folder / "programs"));
  Screen screen;
  screen.machine = machine.name;
  screen.source = source_words(settings);
  screen.programs = internal::list_programs(settings.jobs_folder / "programs");
  auto impl = std::make_unique<Impl>(std::move(settings), std::move(screen));
  return std::unique_ptr<Station>(new Station(std::move(impl)));
}

Station::State Station::state() const {
  return impl_->desk().state();
}

void Station::wait(std::uint64_t state_number,
                   std::uint64_t frame_number,
                   std::chrono::milliseconds at_most) const {
  impl_->desk().wait(state_number, frame_number, at_most);
}

std::shared_ptr<const Frame> Station::frame() const {
  return impl_->desk().frame();
}

void Station::set_watched(bool is_watched) {
  impl_->desk().set_watched(is_watched);
}

Expected<void> Station::command(std::string_view json, const std::string& who) {
  PANELCAL_TRY(Command command, internal::parse_command(json, who));
  return impl_->carry_out(std::move(command));
}

Expected<void> Station::add_program(const std::string& name, std::string_view bytes) {
  return impl_->add_program(name, bytes);
}

Expected<std::string> Station::job_file(const std::string& job_id, const std::string& name) const {
  return failure(refused("file " + quoted(name) + " of job " + quoted(job_id), "a job's file"));
}

}  // namespace panelcal
