// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "tools/serve/served_machine.h"

namespace panelcal::serve {

/// A machine that notes what it was asked to do.
class FakeMachine final : public ServedMachine {
 public:
  State state() const override {
    const std::lock_guard lock(mutex_);
    return {number_, json_};
  }
  Picture picture() const override {
    const std::lock_guard lock(mutex_);
    return picture_;
  }
  std::uint64_t picture_number() const override { return picture().number; }

  void wait(std::uint64_t state_number,
            std::uint64_t picture_number,
            std::chrono::milliseconds at_most) const override {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, at_most, [&] {
      return number_ != state_number || picture_.number != picture_number;
    });
  }

  void set_watched(bool watched) override { is_watched = watched; }

  Expected<void> command(std::string_view json, const std::string& who) override {
    const std::lock_guard lock(mutex_);
    commands.emplace_back(json, who);
    return refusal;
  }

  Expected<void> add_program(const std::string& name, std::string_view bytes) override {
    const std::lock_guard lock(mutex_);
    programs.emplace_back(name, bytes);
    return refusal;
  }

  Expected<std::string> job_file(const std::string& job_id,
                                 const std::string& name) const override {
    if (job_id != "2026-11-27-1" && job_id != "night") {
      return failure({Code::FileUnreadable, {job_id, 0, 0}, "no such job", ""});
    }
    return "bytes of " + name;
  }

  void change(std::string json) {
    const std::lock_guard lock(mutex_);
    json_ = std::move(json);
    ++number_;
    changed_.notify_all();
  }
  void show(std::string jpeg) {
    const std::lock_guard lock(mutex_);
    picture_.jpeg = std::move(jpeg);
    ++picture_.number;
    changed_.notify_all();
  }
  std::size_t n_changes() const {
    const std::lock_guard lock(mutex_);
    return commands.size() + programs.size();
  }

  std::vector<std::pair<std::string, std::string>> commands;  ///< what, who
  std::vector<std::pair<std::string, std::string>> programs;  ///< name, bytes
  Expected<void> refusal;                                     ///< the answer to both
  std::atomic<bool> is_watched = false;

 private:
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::uint64_t number_ = 1;
  std::string json_ = R"({"facts":"screen","version":1})";
  Picture picture_;
};

}  // namespace panelcal::serve
