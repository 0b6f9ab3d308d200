// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/checks/warm_up.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "calib/drift/amount.h"
#include "calib/drift/rest_to_come.h"
#include "machine/nightly/checks/mark_look.h"
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace panelcal {
namespace {

/// Between two moves, so that the machine is moved and not hurried.
constexpr Time kPause = seconds(5);
/// At most this number of times the mark is looked at in the whole time, that often each time.
constexpr int kMostSamples = 60;
constexpr int kLooksEach = 3;
/// Fewer tell nothing of an exponential.
constexpr std::size_t kFewest = 6;
/// No camera sees better; a simulation without noise has no scatter.
constexpr Length kLeastSigma = um(0.01);

/// Two places, far apart, that the stage can certainly reach.
Expected<std::array<Position<frame::Machine>, 2>> ends_of(const MachineConfig& config,
                                                          const NightlyConfig& nightly) {
  if (config.travel) {
    const Displacement<frame::Machine> way = config.travel->high - config.travel->low;
    return std::array{config.travel->low + 0.25 * way, config.travel->low + 0.75 * way};
  }
  if (config.coupon) {
    const auto places = places_of_row(*config.coupon, 0);
    return std::array{places.front(), places.back()};
  }
  return failure({Code::ConfigValue,
                  nightly.place,
                  "[nightly] warm_up_s is given, and the travel of the stage is missing",
                  "[machine] travel_low_mm and travel_high_mm"});
}

std::string minutes(Time time) {
  constexpr double kMinute_s = 60;
  return fmt::format("{:.1f} min", time.in_s() / kMinute_s);
}

std::string why_not_warm(NightWarmUp& seen) {
  if (seen.looks.size() < kFewest) {
    return fmt::format("the mark was seen {} times, and {} are needed", seen.looks.size(), kFewest);
  }
  std::string reason;
  seen.fit = fit_warm_up(seen.looks, seen.limit.in_mm(), &reason);
  if (!seen.fit) return reason;
  const double most_mm = most_to_come(seen.looks);
  if (most_mm <= seen.limit.in_mm()) return {};
  return fmt::format("the looks allow that {} is still to come, limit {}",
                     amount(most_mm, "mm"),
                     amount(seen.limit.in_mm(), "mm"));
}

/// The looks at the mark of one warm-up.
class WarmUpLooks {
 public:
  static Expected<WarmUpLooks> make(const MachineConfig& config,
                                    const NightlyConfig& nightly,
                                    const CalibrationDevices& devices) {
    if (!devices.now) {
      return failure({Code::ConfigValue,
                      nightly.place,
                      "[nightly] warm_up_limit_um: devices without a clock",
                      "devices with a clock"});
    }
    PANELCAL_TRY(MarkLooker looker, MarkLooker::make(config, nightly, devices.observer));
    return WarmUpLooks(std::move(looker), *nightly.warm_up_limit, devices);
  }

  Time since_start() const { return devices_.now() - start_; }

  /// Looks where the last time is long enough ago, and says whether the machine is warm.
  Expected<bool> look(Time interval) {
    if (last_ && since_start() < *last_ + interval) return false;
    last_ = since_start();
    std::vector<Eigen::Vector2d> places_mm;
    Time middle;
    for (int i = 0; i < kLooksEach; ++i) {
      PANELCAL_TRY(const MarkSighting look, looker_.look(devices_));
      middle = middle + (1.0 / kLooksEach) * since_start();
      if (look.place_mm) places_mm.push_back(*look.place_mm);
    }
    if (places_mm.size() < kLooksEach) return false;
    add(middle, places_mm);
    judge_warm_up(seen_);
    return seen_.is_warm;
  }

  NightWarmUp end() {
    judge_warm_up(seen_);
    return std::move(seen_);
  }

 private:
  WarmUpLooks(MarkLooker looker, Length limit, const CalibrationDevices& devices)
      : looker_(std::move(looker)), devices_(devices), start_(devices.now()) {
    seen_.limit = limit;
  }

  /// Of all looks the scatter about the means is one.
  void add(Time time, const std::vector<Eigen::Vector2d>& places_mm) {
    Eigen::Vector2d mean_mm = Eigen::Vector2d::Zero();
    for (const Eigen::Vector2d& p : places_mm) mean_mm += p / kLooksEach;
    for (const Eigen::Vector2d& p : places_mm) squares_mm2_ += (p - mean_mm).squaredNorm();
    seen_.looks.push_back({time, mean_mm, 0});
    const double degrees = 2.0 * (kLooksEach - 1) * static_cast<double>(seen_.looks.size());
    const double sigma_mm = std::sqrt(squares_mm2_ / degrees / kLooksEach);
    for (WarmUpSample& sample : seen_.looks) {
      sample.sigma = std::max(kLeastSigma.in_mm(), sigma_mm);
    }
  }

  MarkLooker looker_;
  const CalibrationDevices& devices_;
  Time start_;
  std::optional<Time> last_;
  double squares_mm2_ = 0;
  NightWarmUp seen_;
};

}  // namespace

void judge_warm_up(NightWarmUp& seen) {
  const std::string why = why_not_warm(seen);
  seen.is_warm = why.empty();
  if (!why.empty()) {
    seen.text = "it is not known that the machine is warm: " + why;
  } else if (!seen.fit->is_seen) {
    seen.text = fmt::format("no warming up is seen in {}: less than {} may still be to come",
                            minutes(seen.looks.back().since_start),
                            amount(seen.limit.in_mm(), "mm"));
  } else {
    seen.text = fmt::format("warm after {}: then less than {} of {} were still to come",
                            minutes(seen.fit->wait),
                            amount(seen.limit.in_mm(), "mm"),
                            amount(seen.fit->cold_offset.norm(), "mm"));
  }
}

SelfTestCheck warm_up_check(const NightWarmUp& seen) {
  SelfTestCheck check;
  check.name = "warm-up";
  check.passed = seen.is_warm;
  check.text = seen.text;
  check.limit = seen.limit.in_mm();
  check.unit = "mm";
  if (!seen.fit || !seen.fit->is_seen) return check;
  const double t_s = seen.looks.back().since_start.in_s();
  check.value = seen.fit->cold_offset.norm() * std::exp(-t_s / seen.fit->time_constant.in_s());
  return check;
}

Expected<std::string> last_warm_up(const Ledger& ledger, const std::string& machine) {
  PANELCAL_TRY(const auto last, ledger.list({machine, LedgerKind::Night, "night"}, 1));
  if (last.empty()) return std::string();
  PANELCAL_TRY(const std::string text, ledger.result(last.front().id));
  const auto night = nlohmann::json::parse(text, nullptr, false);
  const auto word = [](const nlohmann::json& object, const char* key) {
    return object.is_object() && object.contains(key) && object[key].is_string()
               ? object[key].get<std::string>()
               : std::string();
  };
  if (!night.is_object() || !night.contains("warm_up")) return std::string();
  return fmt::format("night of {}: {}", word(night, "night"), word(night["warm_up"], "text"));
}

std::string warm_up_json(const NightWarmUp& seen) {
  nlohmann::ordered_json looks = nlohmann::ordered_json::array();
  for (const WarmUpSample& look : seen.looks) {
    looks.push_back({look.since_start.in_s(), look.value[0], look.value[1], look.sigma});
  }
  nlohmann::ordered_json json = {{"limit_mm", seen.limit.in_mm()},
                                 {"warm", seen.is_warm},
                                 {"text", seen.text},
                                 {"looks", std::move(looks)}};
  json["fit"] = nlohmann::ordered_json();
  if (seen.fit && seen.fit->is_seen) {
    const WarmUp& fit = *seen.fit;
    json["fit"] = {{"warm_mm", {fit.warm[0], fit.warm[1]}},
                   {"cold_offset_mm", {fit.cold_offset[0], fit.cold_offset[1]}},
                   {"time_constant_s", fit.time_constant.in_s()},
                   {"time_constant_sigma_s", fit.time_constant_sigma.in_s()},
                   {"wait_s", fit.wait.in_s()},
                   {"wait_sigma_s", fit.wait_sigma.in_s()}};
  }
  return json.dump(-1, ' ', true, nlohmann::ordered_json::error_handler_t::replace);
}

Expected<WarmUpRun> warm_up(const MachineConfig& config,
                            const NightlyConfig& nightly,
                            const CalibrationDevices& devices,
                            const Clock& clock) {
  WarmUpRun out;
  if (!(nightly.warm_up > seconds(0))) return out;
  PANELCAL_TRY(const auto ends, ends_of(config, nightly));
  std::optional<WarmUpLooks> looks;
  if (nightly.warm_up_limit) {
    PANELCAL_TRY(WarmUpLooks made, WarmUpLooks::make(config, nightly, devices));
    looks.emplace(std::move(made));
  }
  const Time interval = std::max(kPause, (1.0 / kMostSamples) * nightly.warm_up);
  const std::chrono::sys_seconds started = clock();
  const auto n_moves = static_cast<long>(std::ceil(nightly.warm_up.in_s() / kPause.in_s()));
  double waited_s = 0;
  const auto passed_s = [&] {
    const double by_clock_s = static_cast<double>((clock() - started).count());
    return std::max(by_clock_s, devices.wait ? waited_s : 0.0);
  };
  for (long i = 0; i < n_moves && passed_s() < nightly.warm_up.in_s(); ++i) {
    if (looks) {
      PANELCAL_TRY(const bool is_warm, looks->look(interval));
      if (is_warm) break;
    }
    PANELCAL_CHECK(devices.stage.move_to(ends[static_cast<std::size_t>(i % 2)]));
    const double pause_s = std::min(kPause.in_s(), nightly.warm_up.in_s() - waited_s);
    if (devices.wait) devices.wait(seconds(pause_s));
    waited_s += pause_s;
  }
  if (looks) out.seen = looks->end();
  out.waited = seconds(passed_s());
  return out;
}

}  // namespace panelcal
