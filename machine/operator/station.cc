// SPDX-License-Identifier: Apache-2.0
#include "machine/operator/station.h"

#include <algorithm>
#include <array>
#include <exception>
#include <optional>
#include <system_error>
#include <thread>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "machine/config/machine_config.h"
#include "machine/devices/cameras/patient_camera.h"
#include "machine/devices/cameras/without_password.h"
#include "machine/operator/command.h"
#include "machine/operator/desk.h"
#include "machine/operator/folder_lock.h"
#include "machine/operator/job_folder.h"
#include "machine/operator/night_order.h"
#include "machine/operator/opened_program.h"
#include "machine/operator/operated_job.h"
#include "machine/operator/orders.h"
#include "machine/operator/picture_feed.h"
#include "machine/operator/programs.h"
#include "machine/operator/regular_file.h"
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
/// At most ten live pictures a second.
constexpr std::chrono::milliseconds kLiveInterval{100};
constexpr std::chrono::milliseconds kOpeningInterval{2000};
constexpr Time kPatience = seconds(5);
constexpr std::size_t kMaxJobFileBytes = std::size_t{1} << 30;

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

std::string words_of_source(const StationSettings& settings) {
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
  Impl(StationSettings settings, internal::FolderLock lock, Screen screen)
      : settings_(std::move(settings)),
        lock_(std::move(lock)),
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
      case Order::Start:
      case Order::Resume:
        return desk_.try_change([&](Screen& screen) -> Expected<void> {
          PANELCAL_CHECK(command.order == Order::Start ? internal::take_start(screen)
                                                       : internal::take_resume(screen));
          desk_.give_work(std::move(command));
          return {};
        });
      case Order::Stop:
        return desk_.try_change([&](Screen& screen) -> Expected<void> {
          PANELCAL_CHECK(internal::take_stop(screen));
          desk_.stop();
          return {};
        });
      case Order::Answer:
        return desk_.try_change([&](Screen& screen) -> Expected<void> {
          PANELCAL_CHECK(internal::take_answer(screen, command.answer));
          if (command.answer.choice == internal::Choice::Stop) desk_.stop();
          if (command.answer.choice != internal::Choice::Stop) desk_.answer(command.answer);
          return {};
        });
      case Order::Jog:
        return desk_.try_change([&](Screen& screen) -> Expected<void> {
          PANELCAL_CHECK(internal::take_jog(screen, command.by_mm));
          desk_.jog(command.by_mm);
          return {};
        });
      case Order::Write:
        return write_output(command.name);
      case Order::Calibrate:
        return desk_.try_change([&](Screen& screen) -> Expected<void> {
          PANELCAL_CHECK(internal::take_calibration(settings_, command.name, screen));
          desk_.give_work(std::move(command));
          return {};
        });
      case Order::RollBack:
        return roll_back(command);
    }
    return {};
  }

  Expected<std::string> job_file(const std::string& id, const std::string& name) const {
    const bool is_night = id == "night" && name == "report.html";
    if (!is_night && !(internal::is_job_id(id) && internal::is_job_file(name))) {
      return failure(refused("file " + quoted(name) + " of job " + quoted(id), "a file of a job"));
    }
    return internal::read_regular(settings_.jobs_folder / id, name, kMaxJobFileBytes);
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
  void look_for_programs() {
    const auto now = std::chrono::steady_clock::now();
    if (now - last_look_ < kProgramsInterval / 2) return;
    last_look_ = now;
    list_programs();
  }

  void list_programs() {
    auto programs = internal::list_programs(this->programs());
    const bool is_new =
        desk_.read([&](const Screen& screen) { return screen.programs != programs; });
    if (is_new) desk_.change([&](Screen& screen) { screen.programs = std::move(programs); });
  }

  /// The machine thread.
  void run_machine() {
    while (!desk_.is_closing()) {
      const bool is_live = !settings_.camera.empty() && desk_.is_watched();
      const auto work = desk_.wait_for_work(is_live ? until_next_live() : kProgramsInterval);
      if (work) {
        camera_.reset();
        carry_out_safely(*work);
      } else if (!desk_.is_closing()) {
        show_live(is_live);
        look_for_programs();
      }
    }
    camera_.reset();
  }

  /// The time that a picture takes counts.
  std::chrono::milliseconds until_next_live() {
    const auto now = std::chrono::steady_clock::now();
    next_live_ = std::clamp(next_live_ + kLiveInterval, now, now + kLiveInterval);
    return std::chrono::ceil<std::chrono::milliseconds>(next_live_ - now);
  }

  /// A bug of ours, or a lack of memory, ends the work and not the station.
  void carry_out_safely(const Command& work) {
    try {
      carry_out_work(work);
    } catch (const std::exception& problem) {
      const std::string words = std::string("internal error, please report: ") + problem.what();
      desk_.change([&](Screen& screen) {
        if (screen.job && is_running(screen.job->state)) {
          screen.job->state = JobState::Failed;
          screen.job->question.reset();
          screen.job->verdict = internal::ScreenVerdict{false, words};
        }
        if (screen.calibration && screen.calibration->state == "running") {
          screen.calibration->state = "failed";
          screen.calibration->verdict = words;
        }
      });
    }
  }

  void carry_out_work(const Command& work) {
    if (work.order == Order::Calibrate) {
      return internal::run_calibration(settings_, work.name, work.who, desk_);
    }
    const ScreenJob job = desk_.read([](const Screen& screen) { return *screen.job; });
    const bool is_resumed = work.order == Order::Resume;
    const internal::JobOrder order{
        job.id, job.program, is_resumed ? std::string() : job.program_sha256, is_resumed, work.who};
    internal::run_job(settings_, order, desk_);
  }

  /// What the camera sees while nothing runs; a camera that is lost is opened again.
  void show_live(bool is_live) {
    if (!is_live) return camera_.reset();
    if (camera_ == nullptr) {
      const auto now = std::chrono::steady_clock::now();
      if (now < next_opening_) return;
      next_opening_ = now + kOpeningInterval;
      auto camera = open_patient_camera(settings_.camera, kPatience);
      if (!camera) return;
      camera_ = *std::move(camera);
    }
    const auto picture = camera_->take();
    if (!picture) return camera_.reset();
    internal::show_plain(desk_, *picture);
  }

  /// Touches no device, so that the thread that asks does it.
  Expected<void> open(const std::string& name) {
    PANELCAL_CHECK(internal::check_name(name));
    PANELCAL_CHECK(desk_.read(internal::check_open));
    // No link leads to another file, and no pipe keeps a screen waiting.
    PANELCAL_CHECK(internal::read_regular(programs(), name, kMaxProgramBytes));
    PANELCAL_TRY(
        const internal::OpenedProgram opened,
        internal::open_program(settings_.machine_file, programs() / name, settings_.clock()));
    ScreenJob job = internal::checked_job(opened, next_job_id(), name);
    return desk_.try_change([&](Screen& screen) -> Expected<void> {
      PANELCAL_CHECK(internal::check_open(screen));
      screen.machine = opened.machine.name;
      screen.job = std::move(job);
      return {};
    });
  }

  Expected<void> close() {
    std::string id;
    PANELCAL_CHECK(desk_.try_change([&](Screen& screen) -> Expected<void> {
      const bool has_folder = screen.job && screen.job->state != JobState::Checked;
      if (has_folder) id = screen.job->id;
      return internal::take_close(screen);
    }));
    if (id.empty()) return {};
    // One that failed before it had a folder has none to close.
    Expected<internal::JobFolder> folder = internal::JobFolder::open(settings_.jobs_folder, id);
    return folder ? folder->close() : Expected<void>();
  }

  /// Touches no device.
  Expected<void> roll_back(const Command& command) {
    PANELCAL_CHECK(desk_.read(internal::check_idle));
    PANELCAL_CHECK(
        internal::roll_back(settings_, command.name, command.to, command.reason, command.who));
    auto history = internal::history_of(settings_);
    desk_.change([&](Screen& screen) { screen.history = std::move(history); });
    return {};
  }

  Expected<void> write_output(const std::string& name) {
    PANELCAL_CHECK(
        desk_.read([&](const Screen& screen) { return internal::check_write(screen, name); }));
    const std::string id = desk_.read([](const Screen& screen) { return screen.job->id; });
    PANELCAL_TRY(internal::JobFolder folder, internal::JobFolder::open(settings_.jobs_folder, id));
    PANELCAL_TRY(const std::string bytes, read_file(folder.file("output"), kMaxJobFileBytes));
    PANELCAL_CHECK(write_file(folder.file(name), bytes));
    PANELCAL_CHECK(folder.add_output(name));
    desk_.change([&](Screen& screen) {
      if (!screen.job || screen.job->id != id) return;
      screen.job->outputs = folder.record().outputs;
      screen.job->verdict->words =
          internal::with_output_name(folder.record().verdict, screen.job->outputs);
    });
    return {};
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
  internal::FolderLock lock_;
  Desk desk_;
  // The machine thread's alone:
  std::unique_ptr<CameraDevice> camera_;  ///< open while nothing runs and a screen looks
  std::chrono::steady_clock::time_point next_opening_{};
  std::chrono::steady_clock::time_point next_live_{};
  std::chrono::steady_clock::time_point last_look_{};  ///< for new programs
  std::thread thread_;                                 ///< last, since it uses the others
};

Station::Station(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {
}
Station::~Station() = default;

Expected<std::unique_ptr<Station>> Station::create(StationSettings settings) {
  PANELCAL_CHECK(check_settings(settings));
  if (!settings.clock) settings.clock = system_clock();
  if (settings.software.empty()) settings.software = "panelcal serve";
  PANELCAL_TRY(const MachineConfig machine, read_machine_config(settings.machine_file));
  PANELCAL_CHECK(make_folder(settings.jobs_folder / "programs"));
  PANELCAL_TRY(internal::FolderLock lock, internal::FolderLock::take(settings.jobs_folder));
  Screen screen;
  screen.machine = machine.name;
  screen.source = words_of_source(settings);
  screen.programs = internal::list_programs(settings.jobs_folder / "programs");
  screen.job = internal::last_job(settings);
  screen.kinds = internal::kinds_of(settings);
  screen.history = internal::history_of(settings);
  auto impl = std::make_unique<Impl>(std::move(settings), std::move(lock), std::move(screen));
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
  return impl_->job_file(job_id, name);
}

}  // namespace panelcal
