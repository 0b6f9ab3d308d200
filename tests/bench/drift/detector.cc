// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/drift/detector.h"

#include "calib/base/statistics/distributions.h"
#include "calib/charts/run_length.h"
#include "calib/drift/monitor.h"

namespace panelcal::bench {
namespace {

constexpr double kWeight = 0.1;
constexpr double kAllowance = 0.25;
constexpr double kAllowanceOfScatter = 0.5;
constexpr double kMoved_mm = 0.006;
constexpr int kMinNightsOfScatter = 3;

int n_axes_of(Channel channel) {
  return channel == Channel::Offset ? 2 : 1;
}

/// As the nights judge them (machine/nightly/night_quality.cc).
DriftOptions options_of(Channel channel) {
  DriftOptions options;
  if (channel != Channel::Contrast) return options;
  options.priors.drift = 0.002;
  options.priors.repeatability = 0.005;
  options.priors.per_kelvin = 0.002;
  return options;
}

}  // namespace

Learner::Learner(Channel channel)
    : channel_(channel),
      model_(*DriftModel::make(n_axes_of(channel), options_of(channel))),
      spread_(*SpreadMonitor::make(1000, kMinNightsOfScatter)) {
}

Look Learner::add(const Year::Night& night) {
  Look look;
  if (channel_ == Channel::Scatter) {
    const WatchedSpread watched = *spread_.add(night.scatter);
    look.is_judged = watched.is_judged;
    look.scores = Eigen::VectorXd::Constant(1, watched.score);
    return look;
  }
  const DriftPoint& point = channel_ == Channel::Offset ? night.offset : night.contrast;
  look.is_judged = model_.has_enough();
  if (look.is_judged) look.scores = independent_scores(model_.predict(point), point.value);
  static_cast<void>(model_.add(point));
  if (channel_ == Channel::Offset) {
    look.here_mm = model_.forecast(point.time, std::nullopt).mean();
  }
  return look;
}

Detector::Detector(const Method& method, Channel channel, double nights)
    : looks_up_only_(channel == Channel::Scatter), watches_moves_(method.has_moved) {
  const int n_axes = n_axes_of(channel);
  const int n_others = static_cast<int>(method.has_average) + static_cast<int>(method.has_sum);
  const double share_of_night = n_others > 0 ? 0.5 : 1;
  const double left = method.has_night ? 1 - share_of_night : 1;
  if (method.has_night) {
    night_limit_ = looks_up_only_ ? normal_of_exceedance(share_of_night / nights)
                                  : ewma_limit(n_axes, 1, nights / share_of_night);
  }
  if (method.has_average) average_.emplace(n_axes, kWeight, n_others * nights / left);
  if (!method.has_sum) return;
  const CusumChart sum =
      looks_up_only_ ? CusumChart(Shift::Up, kAllowanceOfScatter, n_others * nights / left)
                     : CusumChart(Shift::Both, kAllowance, n_axes * n_others * nights / left);
  sums_.assign(static_cast<std::size_t>(n_axes), sum);
}

bool Detector::has_moved(const Look& look) {
  if (!watches_moves_ || look.here_mm.size() == 0) return false;
  if (!anchor_mm_) anchor_mm_ = look.here_mm;
  if (!((look.here_mm - *anchor_mm_).norm() > kMoved_mm)) return false;
  anchor_mm_ = look.here_mm;
  return true;
}

bool Detector::add(const Look& look) {
  if (!look.is_judged) return false;
  const double size = looks_up_only_ ? look.scores(0) : look.scores.norm();
  bool is_alarm = night_limit_ && size > *night_limit_;
  if (average_) is_alarm = average_->add(look.scores) || is_alarm;
  for (std::size_t i = 0; i < sums_.size(); ++i) {
    is_alarm = sums_[i].add(look.scores(static_cast<Eigen::Index>(i))) || is_alarm;
  }
  if (is_alarm) {
    if (average_) average_->restart();
    for (CusumChart& sum : sums_) sum.restart();
  }
  return has_moved(look) || is_alarm;
}

}  // namespace panelcal::bench
