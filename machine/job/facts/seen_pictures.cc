// SPDX-License-Identifier: Apache-2.0
#include "machine/job/facts/seen_pictures.h"

#include <utility>

#include "calib/correction/spindle_camera.h"
#include "vision/show/target_picture.h"

namespace panelcal {
namespace {

SeenPicture seen_picture(const SeenView& seen) {
  SeenPicture view;
  view.i_view = seen.view.i_view;
  // The two have the same words.
  view.status = *measurement_status_from_name(name(seen.detection.status));
  view.reason = seen.detection.reason;
  const auto in_work = [&](const Position<frame::Optical>& place) -> Eigen::Vector2d {
    return (machine_from_optical(seen.picture.axis, place) - seen.request.work_zero).in_mm();
  };
  const double right_px = seen.camera.width_px - 0.5;
  const double bottom_px = seen.camera.height_px - 0.5;
  for (const auto& [x_px, y_px] : {std::pair(-0.5, -0.5),
                                   std::pair(right_px, -0.5),
                                   std::pair(right_px, bottom_px),
                                   std::pair(-0.5, bottom_px)}) {
    view.frame_mm.push_back(in_work(seen.camera.mapping(position_px(x_px, y_px))));
  }
  if (seen.detection.best && seen.detection.best->center_optical) {
    view.seen_mm = in_work(seen.detection.best->center_optical->position);
  }
  return view;
}

}  // namespace

PictureObserver SeenPictures::observer() {
  return [this](const SeenView& seen) {
    SeenPicture view = seen_picture(seen);
    if (cuts_out) {
      // A picture that cannot be cut out is only missing from the report.
      auto picture = target_picture(seen.picture.image, seen.detection);
      if (picture) view.picture = *std::move(picture);
    }
    by_seq[seen.request.seq].push_back(std::move(view));
  };
}

}  // namespace panelcal
