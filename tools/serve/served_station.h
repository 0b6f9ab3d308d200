// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <utility>

#include "machine/operator/station.h"
#include "tools/serve/served_machine.h"

namespace panelcal::serve {

/// The station of machine/operator as screens see it.
class ServedStation final : public ServedMachine {
 public:
  explicit ServedStation(std::unique_ptr<Station> station) : station_(std::move(station)) {}

  State state() const override {
    Station::State state = station_->state();
    return {state.number, std::move(state.json)};
  }
  Picture picture() const override {
    const auto frame = station_->frame();
    return frame == nullptr ? Picture{} : Picture{frame->number, frame->jpeg};
  }
  std::uint64_t picture_number() const override {
    const auto frame = station_->frame();
    return frame == nullptr ? 0 : frame->number;
  }
  void wait(std::uint64_t state_number,
            std::uint64_t picture_number,
            std::chrono::milliseconds at_most) const override {
    station_->wait(state_number, picture_number, at_most);
  }
  void set_watched(bool is_watched) override { station_->set_watched(is_watched); }
  Expected<void> command(std::string_view json, const std::string& who) override {
    return station_->command(json, who);
  }
  Expected<void> add_program(const std::string& name, std::string_view bytes) override {
    return station_->add_program(name, bytes);
  }
  Expected<std::string> job_file(const std::string& job_id,
                                 const std::string& name) const override {
    return station_->job_file(job_id, name);
  }

 private:
  std::unique_ptr<Station> station_;
};

}  // namespace panelcal::serve
