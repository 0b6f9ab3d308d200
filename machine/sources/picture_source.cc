// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/picture_source.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

#include "vision/picture/files/image_io.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

int tool_of(const MeasurementRequest& request, const View& view) {
  const std::vector<int>& tools = request.settings.tools;
  const auto i = static_cast<std::size_t>(view.i_tool);
  return i < tools.size() ? tools[i] : 0;
}

/// A row without a tool serves any.
bool serves(const PictureRow& row, const MeasurementRequest& request, const View& view) {
  const std::optional<double>& zoom = request.settings.zoom;
  // A calibration holds for one zoom: a picture taken at another one has other millimetres.
  if (row.zoom && zoom && *row.zoom != *zoom) return false;
  return !row.tool || request.settings.tools.empty() || *row.tool == tool_of(request, view);
}

std::string view_words(const MeasurementRequest& request, const View& view) {
  return view.i_view == 0 ? describe(request)
                          : fmt::format("{}, view {}", describe(request), view.i_view + 1);
}

}  // namespace

Expected<PictureSource> PictureSource::create(const MachineConfig& config,
                                              PictureFolder folder,
                                              PictureObserver observer,
                                              Executor* executor) {
  PANELCAL_TRY(VisionProcedure procedure, VisionProcedure::create(config, std::move(observer)));
  return PictureSource(config, std::move(procedure), std::move(folder), executor);
}

PictureSource::PictureSource(const MachineConfig& config,
                             VisionProcedure procedure,
                             PictureFolder folder,
                             Executor* executor)
    : procedure_(std::move(procedure)),
      folder_(std::move(folder)),
      form_(config.picture_form),
      table_(config.walk.table),
      taken_with_(config.spindle_camera),
      job_(config) {
  for (std::size_t i = 0; i < folder_.rows.size(); ++i) {
    if (const auto seq = folder_.rows[i].seq) rows_by_seq_[*seq].push_back(i);
  }
  if (executor == nullptr) return;
  look_ahead_ = std::make_unique<internal::LookAhead>(*executor, procedure_.locator(), form_);
}

Position<frame::Machine> PictureSource::axis_of(const PictureRow& row) const {
  if (table_ == nullptr) return row.axis + shift_;
  const auto command = taken_with_.spindle_to_see(row.axis);
  return taken_with_.optical_axis(table_->nearest_place_of(command)) + shift_;
}

Expected<void> PictureSource::check_is_on_table(const PictureRow& row) const {
  if (table_ == nullptr) return {};
  const auto command = taken_with_.spindle_to_see(row.axis);
  if (table_->place_of(command)) return {};
  Diagnostic refusal = table_->refusal(command);
  return failure(
      problem(refusal.code, row.line, std::move(refusal.what), std::move(refusal.expected)));
}

Diagnostic PictureSource::problem(Code code,
                                  int line,
                                  std::string what,
                                  std::string expected) const {
  return {code,
          {(folder_.folder / "images.csv").string(), line, line > 0 ? 1 : 0},
          std::move(what),
          std::move(expected)};
}

Expected<void> PictureSource::check_number_of_rows(const MeasurementRequest& request) const {
  const auto found = rows_by_seq_.find(request.seq);
  if (rows_by_seq_.empty()) {
    if (request.settings.inspections <= 1) return {};
    return failure(problem(
        Code::PictureMismatch,
        0,
        fmt::format("{} asks for {} pictures", describe(request), request.settings.inspections),
        "a seq column that states which pictures belong together"));
  }
  if (found == rows_by_seq_.end()) {
    return failure(problem(Code::PictureMissing,
                           0,
                           fmt::format("no picture has seq {}", request.seq),
                           "a picture of " + describe(request)));
  }
  const std::optional<std::size_t> n_wanted = procedure_.n_pictures(request);
  if (!n_wanted || found->second.size() == *n_wanted) return {};
  return failure(
      problem(Code::PictureMismatch,
              folder_.rows[found->second.back()].line,
              fmt::format("{} picture(s) have seq {}", found->second.size(), request.seq),
              fmt::format("{}, as many as {}inspections of {}",
                          *n_wanted,
                          request.settings.delta ? "views and " : "",
                          describe(request))));
}

Expected<std::size_t> PictureSource::next_row_of_seq(const MeasurementRequest& request,
                                                     const View& view) {
  const std::vector<std::size_t>& rows = rows_by_seq_[request.seq];
  std::size_t& n_shown = n_shown_by_seq_[request.seq];
  if (n_shown == rows.size()) {
    return failure(problem(Code::PictureMissing,
                           rows.empty() ? 0 : folder_.rows[rows.back()].line,
                           fmt::format("{} picture(s) have seq {}", rows.size(), request.seq),
                           "one more, of " + view_words(request, view)));
  }
  const std::size_t i_row = rows[n_shown++];
  const PictureRow& row = folder_.rows[i_row];
  if (serves(row, request, view)) return i_row;
  return failure(problem(
      Code::PictureMismatch,
      row.line,
      fmt::format("the picture of {} is for another vision tool or zoom",
                  view_words(request, view)),
      fmt::format("vision tool {}{}",
                  tool_of(request, view),
                  request.settings.zoom ? fmt::format(", zoom {}", *request.settings.zoom) : "")));
}

Expected<std::size_t> PictureSource::nearest_row(const MeasurementRequest& request,
                                                 const View& view) const {
  PANELCAL_TRY(const ZoomedCamera camera, procedure_.locator().camera_of(request));
  std::optional<std::size_t> nearest;
  double least_mm = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < folder_.rows.size(); ++i) {
    const double distance_mm = (axis_of(folder_.rows[i]) - view.axis).in_mm().norm();
    if (!serves(folder_.rows[i], request, view) || !(distance_mm < least_mm)) continue;
    least_mm = distance_mm;
    nearest = i;
  }
  if (nearest && camera.pixel_of(view.axis, axis_of(folder_.rows[*nearest]))) return *nearest;
  std::string what = "no picture shows " + view_words(request, view);
  if (nearest) {
    what += fmt::format(
        "; the nearest, {}, is {:.3f} mm away", quoted(folder_.rows[*nearest].file), least_mm);
  }
  return failure(problem(
      Code::PictureMissing,
      0,
      std::move(what),
      fmt::format(
          "one taken near ({:.4f}, {:.4f}) mm", view.axis.in_mm().x(), view.axis.in_mm().y())));
}

TakenPicture PictureSource::not_read(std::size_t i_row) const {
  const PictureRow& row = folder_.rows[i_row];
  return {{}, axis_of(row), row.file, folder_.path_of(row).string()};
}

Expected<TakenPicture> PictureSource::take(const MeasurementRequest& request, const View& view) {
  PANELCAL_TRY(const std::size_t i_row,
               rows_by_seq_.empty() ? nearest_row(request, view) : next_row_of_seq(request, view));
  const PictureRow& row = folder_.rows[i_row];
  PANELCAL_CHECK(check_is_on_table(row));
  if (look_ahead_) {
    if (auto picture = look_ahead_->take(i_row)) {
      // G39,SPOP may have moved the offset since the picture was foreseen.
      if (*picture) (*picture)->axis = axis_of(row);
      return *std::move(picture);
    }
  }
  return internal::read_picture(not_read(i_row), form_);
}

std::vector<internal::ForeseenPicture> PictureSource::foreseen(
    const std::vector<MeasurementRequest>& requests) const {
  std::vector<internal::ForeseenPicture> pictures;
  for (const MeasurementRequest& request : requests) {
    const auto looks = procedure_.first_looks(request);
    if (!looks) continue;
    const auto rows = rows_by_seq_.find(request.seq);
    for (std::size_t i = 0; i < looks->size(); ++i) {
      const Look& look = (*looks)[i];
      std::optional<std::size_t> i_row;
      if (rows_by_seq_.empty()) {
        if (const auto nearest = nearest_row(request, look.view)) i_row = *nearest;
      } else if (rows != rows_by_seq_.end() && i < rows->second.size()) {
        i_row = rows->second[i];
      }
      if (i_row) pictures.push_back({*i_row, request, look, not_read(*i_row)});
    }
  }
  return pictures;
}

void PictureSource::foresee(RequestForecast forecast) {
  if (!look_ahead_) return;
  forecast_ = std::move(forecast);
  look_ahead_->plan(foreseen(forecast_()));
}

Expected<Measurement> PictureSource::measure(const MeasurementRequest& request) {
  // First, so that a program that cannot be measured is not blamed on the folder.
  PANELCAL_CHECK(procedure_.locator().check(request));
  PANELCAL_CHECK(check_number_of_rows(request));
  n_shown_by_seq_[request.seq] = 0;
  if (look_ahead_ && forecast_ && look_ahead_->is_outdated(request)) {
    look_ahead_->plan(foreseen(forecast_()));
  }
  PANELCAL_TRY(Measurement measurement, procedure_.measure(request, *this));
  return job_.complete(std::move(measurement));
}

Expected<std::optional<CalibrationAnswer>> PictureSource::calibrate(const CalibrationOrder& order) {
  if (!order.correction) return std::nullopt;
  const SpindleCameraOffset before = job_.offset();
  PANELCAL_TRY(std::optional<CalibrationAnswer> answer, job_.correct(order));
  shift_ = shift_ + (job_.offset().offset - before.offset);
  return answer;
}

}  // namespace panelcal
