// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/live_source.h"

#include <utility>

namespace panelcal {

LiveSource::LiveSource(const MachineConfig& config,
                       VisionProcedure procedure,
                       std::unique_ptr<CameraViews> views,
                       std::unique_ptr<Spindle> spindle,
                       Prompt prompt)
    : procedure_(std::move(procedure)),
      views_(std::move(views)),
      spindle_(std::move(spindle)),
      prompt_(std::move(prompt)),
      job_(config) {
}

Expected<LiveSource> LiveSource::create(const MachineConfig& config,
                                        std::unique_ptr<CameraViews> views,
                                        std::unique_ptr<Spindle> spindle,
                                        Prompt prompt,
                                        PictureObserver observer) {
  PANELCAL_TRY(VisionProcedure procedure, VisionProcedure::create(config, std::move(observer)));
  return LiveSource(
      config, std::move(procedure), std::move(views), std::move(spindle), std::move(prompt));
}

Expected<Measurement> LiveSource::measure(const MeasurementRequest& request) {
  PANELCAL_TRY(Measurement measurement, procedure_.measure(request, *views_));
  return job_.complete(std::move(measurement));
}

Expected<std::optional<CalibrationAnswer>> LiveSource::calibrate(const CalibrationOrder& order) {
  if (order.correction) {
    PANELCAL_TRY(std::optional<CalibrationAnswer> answer, job_.correct(order));
    views_->set_offset(job_.offset());
    return answer;
  }
  if (spindle_ == nullptr || !spindle_->can_drill()) return std::nullopt;
  // With the light, the zoom and the focus that the program has set, as its targets are seen.
  MeasurementRequest request;
  request.seq = -1;
  request.line = order.line;
  request.command = order.command;
  request.settings.lamp = order.lamp;
  request.settings.zoom = order.zoom;
  View view;
  view.focus_z = procedure_.focus_z();
  PANELCAL_CHECK(views_->prepare(request, view));
  Expected<CalibrationAnswer> answer = job_.calibrate(order,
                                                      {views_->stage(),
                                                       *spindle_,
                                                       views_->camera(),
                                                       views_->wait(),
                                                       prompt_,
                                                       {},
                                                       {},
                                                       nullptr,
                                                       taken_by_});
  views_->forget_place();
  if (!answer) return failure(std::move(answer).error());
  views_->set_offset(job_.offset());
  return *std::move(answer);
}

}  // namespace panelcal
