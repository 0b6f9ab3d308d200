// SPDX-License-Identifier: Apache-2.0
#include "machine/nightly/checks/self_test.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <system_error>
#include <utility>

#include "machine/nightly/checks/mark_look.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

constexpr int kLooks = 5;
/// Of a picture's pixels that may be overexposed: a reflection, but not a lamp set too high.
constexpr double kMostClipped = 0.02;

/// Results of the looks so far.
struct RepeatedLooks {
  std::vector<Eigen::Vector2d> places_mm;
  double log_contrast = 0;
  double log_blur = 0;
  double clipped = 0;
  std::string missed;
};

void add_look(const MarkSighting& look, RepeatedLooks& looks) {
  looks.clipped = std::max(looks.clipped, look.clipped_share);
  if (look.place_mm) {
    looks.places_mm.push_back(*look.place_mm);
  } else {
    looks.missed = look.missed;
  }
}

double variance_of(const std::vector<Eigen::Vector2d>& places_mm) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : places_mm) mean += p / static_cast<double>(places_mm.size());
  double sum = 0;
  for (const Eigen::Vector2d& p : places_mm) sum += (p - mean).squaredNorm();
  return sum / (2.0 * static_cast<double>(places_mm.size() - 1));
}

SelfTestCheck found_check(const RepeatedLooks& looks) {
  SelfTestCheck check;
  check.name = "mark";
  check.value = static_cast<double>(looks.places_mm.size());
  check.limit = kLooks;
  check.unit = "looks";
  check.passed = looks.places_mm.size() == kLooks;
  check.text = fmt::format("the mark was found in {} of {} looks{}{}",
                           looks.places_mm.size(),
                           kLooks,
                           check.passed ? "" : ": ",
                           check.passed ? "" : looks.missed);
  return check;
}

SelfTestCheck clipped_check(const RepeatedLooks& looks) {
  SelfTestCheck check;
  check.name = "overexposure";
  check.value = looks.clipped;
  check.limit = kMostClipped;
  check.unit = "1";
  check.passed = looks.clipped <= kMostClipped;
  check.text = fmt::format("{:.1f} % of the picture is overexposed, limit {:.1f} %",
                           100 * looks.clipped,
                           100 * kMostClipped);
  return check;
}

}  // namespace

SelfTestCheck check_disk(const std::filesystem::path& ledger, double min_mb) {
  const std::filesystem::path folder = ledger.has_parent_path() ? ledger.parent_path() : ".";
  SelfTestCheck check;
  check.name = "disk";
  check.limit = min_mb;
  check.unit = "MB";
  std::error_code error;
  const std::filesystem::space_info space = std::filesystem::space(folder, error);
  if (error) {
    check.passed = false;
    check.text = "the disk's room is not known: " + error.message();
    return check;
  }
  constexpr double kMega = 1e6;
  check.value = static_cast<double>(space.available) / kMega;
  check.passed = *check.value >= min_mb;
  check.text = fmt::format("{:.0f} MB are free, at least {:.0f} are needed", *check.value, min_mb);
  return check;
}

Expected<MarkLooks> test_mark(const MachineConfig& config,
                              const NightlyConfig& nightly,
                              const CalibrationDevices& devices) {
  RepeatedLooks looks;
  int n_seen = 0;
  const PictureObserver observer = [&](const SeenView& seen) {
    if (devices.observer) devices.observer(seen);
    if (seen.detection.status != DetectionStatus::Found || !seen.detection.best) return;
    const TargetFit& fit = *seen.detection.best;
    if (!(std::abs(fit.contrast) > 0) || !(fit.blur_px > 0)) return;
    ++n_seen;
    looks.log_contrast += std::log(std::abs(fit.contrast) / seen.picture.image.full_scale());
    looks.log_blur += std::log(fit.blur_px);
  };
  PANELCAL_TRY(const MarkLooker looker, MarkLooker::make(config, nightly, observer));
  for (int i = 0; i < kLooks; ++i) {
    PANELCAL_TRY(const MarkSighting look, looker.look(devices));
    add_look(look, looks);
  }
  MarkLooks out;
  out.checks = {found_check(looks), clipped_check(looks)};
  if (looks.places_mm.size() >= 2) {
    const auto degrees = static_cast<double>(2 * (looks.places_mm.size() - 1));
    out.quality.spreads = {{"looks at the mark", "mm", variance_of(looks.places_mm), degrees}};
  }
  if (n_seen > 0) {
    out.quality.levels = {
        {"contrast of the mark", "1", std::exp(looks.log_contrast / n_seen), true},
        {"edge blur of the mark", "px", std::exp(looks.log_blur / n_seen), false}};
  }
  return out;
}

}  // namespace panelcal
