// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "calib/base/expected.h"
#include "machine/look/picture_locator.h"

// Not installed: several pictures of one view.
namespace panelcal::internal {

/// Pictures of one view and what each of them shows, added up one at a time; see VisionProcedure.
class Inspections {
 public:
  /// Precondition: sight.is_found().
  void add(TakenPicture picture, Sight sight);

  /// The joint result. Rejected if the mean picture does not show what each of them does:
  /// then the panel or the camera moved between them.
  ///
  /// Precondition: 2 or more
  /// Fails  as PictureLocator::look
  Expected<Sight> result(const PictureLocator& locator,
                         const MeasurementRequest& request,
                         const Look& look) const;

 private:
  std::optional<TakenPicture> sum_;  ///< its pixels are sums; empty if pictures cannot be added up
  Sight first_;
  std::vector<PositionEstimate<frame::Actual>> places_;
};

}  // namespace panelcal::internal
