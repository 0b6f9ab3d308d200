// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "machine/operator/settings.h"
#include "machine/operator/shown_state.h"

namespace panelcal {

/// The machine with one job at a time, for the screens of the people who operate it.
///
/// One thread, the machine thread, owns camera, stage and source; nothing else touches a device.
/// It measures by correct(); where a target is not found, ambiguous or rejected it asks, and goes
/// on by the answer. The state of a job is on disk before a screen shows it: after a kill it is
/// resumable.
///
/// All methods may be called from any thread.
/// See    tests/machine/operator/station_test.cc; share/schema/screen.schema.json
class Station {
 public:
  /// Fails  usage (not exactly one source); what read_machine_config reports; device-write
  static Expected<std::unique_ptr<Station>> create(StationSettings settings);
  Station(const Station&) = delete;
  Station& operator=(const Station&) = delete;
  /// Waits for the movement under way, and closes the devices. A job that measures stays
  /// resumable.
  ~Station();

  using State = ShownState;
  State state() const;
  /// Waits until the state or the picture is newer than these, or the time is over.
  void wait(std::uint64_t state_number,
            std::uint64_t frame_number,
            std::chrono::milliseconds at_most) const;
  std::shared_ptr<const Frame> frame() const;  ///< null: none yet
  /// Live pictures are taken only while a screen looks.
  void set_watched(bool is_watched);

  /// Carries out one command of the person who holds the controls: {"do": ...}. It has begun, and
  /// the state shows it, when this returns.
  ///
  /// Fails  json-syntax; usage (unknown, malformed, or unsuitable now): then nothing has changed;
  ///        of "open", what read_job reports
  Expected<void> command(std::string_view json, const std::string& who);

  /// Stores an uploaded program, whole or not at all. One of this name is replaced, but not the one
  /// that a job is open on.
  ///
  /// Fails  usage (a name of other characters than letters, digits and `._-`; too large; in use);
  ///        device-write
  Expected<void> add_program(const std::string& name, std::string_view bytes);

  /// A file of a job: "report.html", "output", "facts.json", "measurements.jsonl" or
  /// "picture-SEQ.jpg"; of "night", the last calibration that was made here, "report.html".
  ///
  /// Fails  usage (another name); file-unreadable
  Expected<std::string> job_file(const std::string& job_id, const std::string& name) const;

 private:
  class Impl;
  explicit Station(std::unique_ptr<Impl> impl);

  std::unique_ptr<Impl> impl_;
};

}  // namespace panelcal
