// SPDX-License-Identifier: Apache-2.0
#include "panelcal/machine/picture_source.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "panelcal/vision/image_io.h"

namespace panelcal {
namespace {

/// A row without a tool serves any.
bool serves(const PictureRow& row, const MeasurementRequest& request) {
  const std::vector<int>& tools = request.settings.tools;
  const std::optional<double>& zoom = request.settings.zoom;
  // A calibration holds for one zoom: a picture taken at another one has other millimetres.
  if (row.zoom && zoom && *row.zoom != *zoom) return false;
  return !row.tool || tools.empty() || *row.tool == tools.front();
}

}  // namespace

Expected<PictureSource> PictureSource::create(const MachineConfig& config,
                                              PictureFolder folder,
                                              PictureObserver observer) {
  PANELCAL_TRY(PictureLocator locator, PictureLocator::create(config, std::move(observer)));
  return PictureSource(std::move(locator), std::move(folder));
}

PictureSource::PictureSource(PictureLocator locator, PictureFolder folder)
    : locator_(std::move(locator)), folder_(std::move(folder)) {
  for (std::size_t i = 0; i < folder_.rows.size(); ++i) {
    if (const auto seq = folder_.rows[i].seq) rows_by_seq_[*seq].push_back(i);
  }
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

Expected<std::vector<std::size_t>> PictureSource::rows_of_seq(
    const MeasurementRequest& request) const {
  const auto found = rows_by_seq_.find(request.seq);
  if (found == rows_by_seq_.end()) {
    return failure(problem(Code::PictureMissing,
                           0,
                           fmt::format("no picture has seq {}", request.seq),
                           "a picture of " + describe(request)));
  }
  std::vector<std::size_t> rows = found->second;
  for (const std::size_t i : rows) {
    const PictureRow& row = folder_.rows[i];
    if (serves(row, request)) continue;
    return failure(problem(
        Code::PictureMismatch,
        row.line,
        fmt::format("the picture of {} is for another vision tool or zoom", describe(request)),
        fmt::format(
            "vision tool {}{}",
            request.settings.tools.front(),
            request.settings.zoom ? fmt::format(", zoom {}", *request.settings.zoom) : "")));
  }
  const auto n_wanted = static_cast<std::size_t>(std::max(1, request.settings.inspections));
  if (rows.size() == n_wanted) return rows;
  return failure(
      problem(Code::PictureMismatch,
              folder_.rows[rows.back()].line,
              fmt::format("{} picture(s) have seq {}", rows.size(), request.seq),
              fmt::format("{}, as many as inspections of {}", n_wanted, describe(request))));
}

Expected<std::vector<std::size_t>> PictureSource::nearest_row(
    const MeasurementRequest& request) const {
  const Position<frame::Machine> expected = request.expected_in_machine();
  if (request.settings.inspections > 1) {
    return failure(problem(
        Code::PictureMismatch,
        0,
        fmt::format("{} asks for {} pictures", describe(request), request.settings.inspections),
        "a seq column that tells which pictures belong together"));
  }
  std::optional<std::size_t> nearest;
  double least_mm = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < folder_.rows.size(); ++i) {
    const double distance_mm = (folder_.rows[i].axis - expected).in_mm().norm();
    if (!serves(folder_.rows[i], request) || !(distance_mm < least_mm)) continue;
    least_mm = distance_mm;
    nearest = i;
  }
  if (nearest && locator_.pixel_of(expected, folder_.rows[*nearest].axis)) {
    return std::vector{*nearest};
  }
  std::string what = "no picture shows " + describe(request);
  if (nearest) {
    what += fmt::format(
        "; the nearest, {}, is {:.3f} mm away", quoted(folder_.rows[*nearest].file), least_mm);
  }
  return failure(problem(
      Code::PictureMissing,
      0,
      std::move(what),
      fmt::format(
          "one taken near ({:.4f}, {:.4f}) mm", expected.in_mm().x(), expected.in_mm().y())));
}

Expected<Measurement> PictureSource::measure(const MeasurementRequest& request) {
  // First, so that a program that cannot be measured is not blamed on the folder.
  PANELCAL_CHECK(locator_.target_of(request));
  PANELCAL_TRY(const std::vector<std::size_t> rows,
               rows_by_seq_.empty() ? nearest_row(request) : rows_of_seq(request));
  return locator_.measure(
      request, static_cast<int>(rows.size()), [&](int i) -> Expected<TakenPicture> {
        const PictureRow& row = folder_.rows[rows[static_cast<std::size_t>(i)]];
        PANELCAL_TRY(Image image, read_image(folder_.path_of(row)));
        return TakenPicture{std::move(image), row.axis, row.file, folder_.path_of(row).string()};
      });
}

}  // namespace panelcal
