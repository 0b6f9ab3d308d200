// SPDX-License-Identifier: Apache-2.0
#include "machine/look/focus.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "vision/locate/focus.h"

namespace panelcal {
namespace {

constexpr int kCoarse = 11;
constexpr int kFine = 7;
constexpr int kRefinements = 2;
constexpr double kCloser = 3;

/// The pictures taken so far.
class Curve {
 public:
  Curve(const MeasurementRequest& request, const FocusRange& range, ViewTaker& taker)
      : request_(request), range_(range), taker_(taker) {
    view_.axis = request.expected_in_machine();
  }

  /// n heights evenly from `low` to `high`, as far as they are in the range.
  Expected<void> take(int n, Length low, Length high) {
    for (int i = 0; i < n; ++i) {
      const Length z = low + (static_cast<double>(i) / (n - 1)) * (high - low);
      if (z < range_.low || z > range_.high) continue;
      view_.focus_z = z;
      PANELCAL_TRY(const TakenPicture picture, taker_.take(request_, view_));
      ++view_.i_view;
      samples_.push_back({z, sharpness(picture.image)});
    }
    return {};
  }

  const std::vector<FocusSample>& samples() const { return samples_; }
  Length sharpest() const {
    return std::ranges::max_element(samples_, {}, &FocusSample::sharpness)->z;
  }

 private:
  const MeasurementRequest& request_;
  const FocusRange& range_;
  ViewTaker& taker_;
  View view_;
  std::vector<FocusSample> samples_;
};

}  // namespace

Expected<FocusResult> autofocus(const MeasurementRequest& request,
                                const FocusRange& range,
                                ViewTaker& taker) {
  Curve curve(request, range, taker);
  PANELCAL_CHECK(curve.take(kCoarse, range.low, range.high));
  Length step = (1.0 / (kCoarse - 1)) * (range.high - range.low);
  for (int i = 0; i < kRefinements; ++i) {
    step = (1 / kCloser) * step;
    const Length reach = (0.5 * (kFine - 1)) * step;
    const Length middle = curve.sharpest();
    PANELCAL_CHECK(curve.take(kFine, middle - reach, middle + reach));
  }
  FocusResult result;
  result.request = request;
  for (const FocusSample& s : curve.samples()) result.curve.push_back({s.z, s.sharpness});
  const auto peak = fit_focus_peak(curve.samples(), &result.reason);
  if (!peak) return result;
  result.is_found = true;
  result.z = peak->z;
  result.sigma = peak->sigma;
  return result;
}

}  // namespace panelcal
