// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/cameras/fresh_frame.h"

namespace panelcal::internal {
namespace {

/// Of a period: decoding a waiting frame takes less, waiting for a new one more.
constexpr double kWaitedShare = 0.5;
constexpr int kWaited = 2;
/// Ten seconds of a fast camera.
constexpr int kMostFrames = 1000;
/// Older stamps are of another clock.
constexpr Time kOldestStamp = seconds(10);

}  // namespace

FreshFrame grab_fresh_frame(Time period,
                            const std::function<bool()>& grab,
                            const std::function<Time()>& now) {
  int n_waited = 0;
  for (int i = 0; i < kMostFrames; ++i) {
    const Time before = now();
    if (!grab()) return FreshFrame::Lost;
    if (n_waited == kWaited) return FreshFrame::Grabbed;
    n_waited = now() - before >= kWaitedShare * period ? n_waited + 1 : 0;
  }
  return FreshFrame::Endless;
}

FreshFrame grab_stamped_frame(Time period,
                              Time longest,
                              const std::function<bool()>& grab,
                              const std::function<Time()>& stamp,
                              const std::function<Time()>& now) {
  const Time called = now();
  for (int i = 0; i < kMostFrames; ++i) {
    if (!grab()) return FreshFrame::Lost;
    const Time stamped = stamp();
    const Time here = now();
    const bool is_believed = stamped <= here && here - stamped <= kOldestStamp;
    if (!is_believed) return grab_fresh_frame(period, grab, now);
    if (stamped - longest >= called) return FreshFrame::Grabbed;
  }
  return FreshFrame::Endless;
}

}  // namespace panelcal::internal
