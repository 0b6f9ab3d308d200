// SPDX-License-Identifier: Apache-2.0
#include "machine/devices/cameras/fresh_frame.h"

#include <cmath>
#include <deque>

#include <gtest/gtest.h>

namespace panelcal::internal {
namespace {

/// A camera that exposes frame after frame and a driver that keeps the oldest ones, in simulated
/// time.
class BufferedCamera {
 public:
  BufferedCamera(int n_kept, double period_s, double decoding_s)
      : n_kept_(n_kept), period_s_(period_s), decoding_s_(decoding_s) {}

  void pass(double time_s) {
    now_s_ += time_s;
    while (next_end_s_ <= now_s_) {
      if (static_cast<int>(waiting_.size()) < n_kept_) waiting_.push_back(next_end_s_ - period_s_);
      next_end_s_ += period_s_;
    }
  }
  bool grab() {
    if (waiting_.empty()) pass(next_end_s_ - now_s_ + 1e-9);
    began_s_ = waiting_.front();
    waiting_.pop_front();
    pass(decoding_s_);
    return true;
  }
  Time now() const { return seconds(now_s_); }
  /// Time at which the exposure of the frame that was grabbed last began.
  double began_s() const { return began_s_; }

 private:
  int n_kept_;
  double period_s_;
  double decoding_s_;
  double now_s_ = 0;
  double next_end_s_ = 0.01;
  double began_s_ = 0;
  std::deque<double> waiting_;
};

TEST(FreshFrame, WasExposedAfterTheCallWhateverWasWaiting) {
  constexpr double kPeriod_s = 1.0 / 30;
  for (const int n_kept : {1, 4, 100}) {
    for (const double decoding_s : {0.0001, 0.01}) {
      for (double idle_s = 0.001; idle_s < 10; idle_s *= 1.37) {
        BufferedCamera camera(n_kept, kPeriod_s, decoding_s);
        camera.pass(idle_s);
        const double called_s = camera.now().in_s();
        ASSERT_EQ(
            grab_fresh_frame(
                seconds(kPeriod_s), [&] { return camera.grab(); }, [&] { return camera.now(); }),
            FreshFrame::Grabbed);
        EXPECT_GE(camera.began_s(), called_s) << n_kept << ' ' << decoding_s << ' ' << idle_s;
      }
    }
  }
}

/// Stamps of the begin and of the end of a frame, and every order of waiting frames.
TEST(StampedFrame, WasExposedAfterTheCallWhateverWasWaiting) {
  constexpr double kPeriod_s = 1.0 / 30;
  for (const int n_kept : {1, 4, 100}) {
    for (const double stamp_s : {0.0, kPeriod_s}) {
      for (double idle_s = 0.001; idle_s < 10; idle_s *= 1.37) {
        BufferedCamera camera(n_kept, kPeriod_s, 0.0001);
        camera.pass(idle_s);
        const double called_s = camera.now().in_s();
        ASSERT_EQ(grab_stamped_frame(
                      seconds(kPeriod_s),
                      seconds(kPeriod_s),
                      [&] { return camera.grab(); },
                      [&] { return seconds(camera.began_s() + stamp_s); },
                      [&] { return camera.now(); }),
                  FreshFrame::Grabbed);
        EXPECT_GE(camera.began_s(), called_s) << n_kept << ' ' << stamp_s << ' ' << idle_s;
        // The frame that is being exposed, and with a stamp of the begin the one behind it.
        EXPECT_LT(camera.began_s(), called_s + 2.1 * kPeriod_s);
      }
    }
  }
}

/// A driver that decodes slowly: by the time alone its waiting frames look fresh.
TEST(StampedFrame, AQueueOfOldFramesThatComeSlowlyIsPassedOver) {
  constexpr double kPeriod_s = 1.0 / 30;
  constexpr double kDecoding_s = 0.02;
  BufferedCamera camera(4, kPeriod_s, kDecoding_s);
  camera.pass(5);
  const double called_s = camera.now().in_s();
  ASSERT_EQ(grab_stamped_frame(
                seconds(kPeriod_s),
                seconds(kPeriod_s),
                [&] { return camera.grab(); },
                [&] { return seconds(camera.began_s()); },
                [&] { return camera.now(); }),
            FreshFrame::Grabbed);
  EXPECT_GE(camera.began_s(), called_s);

  BufferedCamera by_time(4, kPeriod_s, kDecoding_s);
  by_time.pass(5);
  ASSERT_EQ(grab_fresh_frame(
                seconds(kPeriod_s), [&] { return by_time.grab(); }, [&] { return by_time.now(); }),
            FreshFrame::Grabbed);
  EXPECT_LT(by_time.began_s(), called_s) << "the stamps were not needed";
}

TEST(StampedFrame, StampsOfAnotherClockAreNotBelieved) {
  constexpr double kPeriod_s = 1.0 / 30;
  for (const double offset_s : {-1e9, -30.0, 0.5, 1e9}) {
    BufferedCamera camera(4, kPeriod_s, 0.0001);
    camera.pass(60);
    const double called_s = camera.now().in_s();
    ASSERT_EQ(grab_stamped_frame(
                  seconds(kPeriod_s),
                  seconds(kPeriod_s),
                  [&] { return camera.grab(); },
                  [&] { return camera.now() + seconds(offset_s); },
                  [&] { return camera.now(); }),
              FreshFrame::Grabbed);
    EXPECT_GE(camera.began_s(), called_s) << offset_s;
  }
}

TEST(FreshFrame, ALostCameraIsSaid) {
  int n = 0;
  EXPECT_EQ(grab_fresh_frame(
                seconds(0.03), [&] { return ++n < 3; }, [] { return seconds(0); }),
            FreshFrame::Lost);
}

/// A recording that is served as fast as it can be read never becomes live.
TEST(FreshFrame, FramesThatNeverHaveToBeWaitedForAreRefused) {
  EXPECT_EQ(grab_fresh_frame(
                seconds(0.03), [] { return true; }, [] { return seconds(0); }),
            FreshFrame::Endless);
}

}  // namespace
}  // namespace panelcal::internal
