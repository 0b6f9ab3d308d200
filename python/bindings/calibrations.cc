// SPDX-License-Identifier: Apache-2.0
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include "calib/base/clock.h"
#include "calib/ledger/ledger.h"
#include "calib/spindle/fit.h"
#include "machine/calibrate/calibration_record.h"
#include "machine/calibrate/camera/run.h"
#include "machine/calibrate/table/run.h"
#include "machine/config/plate/plate.h"
#include "machine/look/mark_sights.h"
#include "machine/plate/pictures.h"
#include "python/bindings/convert.h"
#include "python/bindings/machine.h"
#include "tools/cli/process/version.h"
#include "vision/picture/files/folder.h"
#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

namespace panelcal::python {
namespace {

using Path = std::filesystem::path;

/// A calibration from data, as a file and in words. Nothing is installed.
struct Calibrated {
  std::string text;  ///< of the calibration file
  std::string report;
  std::string refusal;  ///< empty: nothing speaks against it
  double chi_square = 0;
  double degrees_of_freedom = 0;
  double excess = 1;
};

RecordWords words_of(const std::string& clock) {
  const auto date = clock.empty() ? system_clock()() : from_iso_8601(clock);
  if (!date) {
    raise({Code::Usage,
           {"panelcal.calibrate", 0, 0},
           "clock = " + quoted(clock),
           "a date and a time in UTC, such as 2026-11-21T02:00:00Z"});
  }
  return {.date = *date, .software = std::string("panelcal ") + kVersion};
}

template <class Run>
Calibrated calibrated(const MachineConfig& config, const Run& run, LedgerDraft draft) {
  return {.text = value_of(text_with_head(config, std::move(draft.result))),
          .report = report(run),
          .refusal = refusal(run),
          .chi_square = run.fit.chi_square,
          .degrees_of_freedom = static_cast<double>(run.fit.degrees_of_freedom),
          .excess = run.excess};
}

Calibrated camera(const Machine& machine,
                  const Path& images,
                  const std::optional<Path>& plate_file,
                  std::optional<int> tool,
                  std::optional<double> focal_px,
                  const std::string& clock) {
  const MachineConfig& config = *machine.config;
  const RecordWords words = words_of(clock);
  CameraRunOptions options;
  if (tool) options.views.tool = *tool;
  options.focal_px = focal_px;
  const auto look = [&]() -> Expected<CameraRun> {
    if (!plate_file) {
      PANELCAL_TRY(const PictureFolder folder, read_picture_folder(images));
      return calibrate_camera(config, folder, options);
    }
    PANELCAL_TRY(const CalibrationPlate plate, read_plate(*plate_file));
    PANELCAL_TRY(const auto folders, read_plate_folders(images, plate));
    PANELCAL_TRY(MarkSights sights, look_at_plate(config, plate, folders));
    PANELCAL_CHECK(correct_views(config, sights));
    PANELCAL_TRY(LedgerInput input, input_of(*plate_file, kMaxPlateBytes));
    sights.inputs.push_back(std::move(input));
    return fit_camera_run(config, std::move(sights), options);
  };
  const CameraRun run = value_of(look());
  return calibrated(config, run, value_of(camera_draft(config, run, words)));
}

Calibrated table(const Machine& machine,
                 const Path& plate_file,
                 const std::optional<Path>& images,
                 const std::optional<Path>& measurements,
                 const std::string& clock) {
  const MachineConfig& config = *machine.config;
  const RecordWords words = words_of(clock);
  if (images.has_value() == measurements.has_value()) {
    raise_usage("calibrate_table", "images and measurements", "one of the two");
  }
  const auto look = [&]() -> Expected<TableRun> {
    PANELCAL_TRY(const CalibrationPlate plate, read_plate(plate_file));
    TableSights sights;
    if (measurements) {
      PANELCAL_TRY(sights, read_plate_looks(*measurements, config, plate));
    } else {
      PANELCAL_TRY(const auto folders, read_plate_folders(*images, plate));
      PANELCAL_TRY(const MarkSights seen, look_at_plate(config, plate, folders));
      sights = table_sights(config, seen);
      PANELCAL_CHECK(add_inputs({config.camera_file}, sights.inputs));
    }
    PANELCAL_TRY(LedgerInput input, input_of(plate_file, kMaxPlateBytes));
    sights.inputs.push_back(std::move(input));
    return calibrate_table(config, std::move(sights));
  };
  const TableRun run = value_of(look());
  return calibrated(config, run, value_of(table_draft(config, run, words)));
}

/// Looks at drilled holes, a row each, that say which hole they are of.
std::vector<CouponHole> holes_of(const Doubles& drilled_mm,
                                 const py::array_t<std::int64_t>& hole,
                                 const Doubles& spindle_mm,
                                 const Doubles& seen_mm,
                                 const Doubles& covariance) {
  const auto drilled = points_of(drilled_mm, "drilled_mm");
  const auto spindle = points_of(spindle_mm, "spindle_mm");
  const auto seen = points_of(seen_mm, "seen_mm");
  const auto cov = covariances_of(covariance, seen.size(), "cov_mm2");
  if (spindle.size() != seen.size() || hole.ndim() != 1 ||
      static_cast<std::size_t>(hole.size()) != seen.size()) {
    raise_usage("calibrate_spindle_camera",
                fmt::format("{} looks, {} places of the spindle, {} numbers of holes",
                            seen.size(),
                            spindle.size(),
                            hole.size()),
                "as many of each");
  }
  std::vector<CouponHole> holes;
  for (const Eigen::Vector2d& place : drilled) {
    holes.push_back({.drilled = position_mm<frame::Machine>(place)});
  }
  for (std::size_t i = 0; i < seen.size(); ++i) {
    const std::int64_t of = hole.at(static_cast<py::ssize_t>(i));
    if (of < 0 || of >= static_cast<std::int64_t>(holes.size())) {
      raise_usage("calibrate_spindle_camera",
                  fmt::format("a look at hole {}", of),
                  fmt::format("0 to {}", static_cast<std::int64_t>(holes.size()) - 1));
    }
    holes[static_cast<std::size_t>(of)].views.push_back(
        {.spindle = position_mm<frame::Machine>(spindle[i]),
         .seen = {position_mm<frame::Optical>(seen[i]), cov[i]}});
  }
  return holes;
}

py::dict spindle_camera(const Doubles& drilled_mm,
                        const py::array_t<std::int64_t>& hole,
                        const Doubles& spindle_mm,
                        const Doubles& seen_mm,
                        const Doubles& covariance) {
  const std::vector<CouponHole> holes = holes_of(drilled_mm, hole, spindle_mm, seen_mm, covariance);
  const SpindleCameraFitResult result = [&] {
    const py::gil_scoped_release release;
    return fit_spindle_camera(holes);
  }();
  if (!result.fit) {
    raise({Code::CalibrationData,
           {"panelcal.calibrate_spindle_camera", 0, 0},
           panelcal::text(result.failure),
           ""});
  }
  const SpindleCameraFit& fit = *result.fit;
  py::list outliers;
  for (std::size_t i = 0; i < fit.holes.size(); ++i) {
    if (fit.holes[i].is_outlier) outliers.append(i);
  }
  py::dict out;
  out["offset_mm"] = matrix_of(fit.offset.offset.in_mm());
  out["cov_mm2"] = matrix_of(fit.offset.cov_mm2);
  out["wander_um"] = py::make_tuple(fit.wander.sigma[0].in_um(), fit.wander.sigma[1].in_um());
  out["repeatability_um"] =
      py::make_tuple(fit.repeatability.sigma[0].in_um(), fit.repeatability.sigma[1].in_um());
  out["outliers"] = outliers;
  out["chi_square"] = fit.chi_square;
  out["degrees_of_freedom"] = fit.n_free;
  out["report"] = text(fit.report());
  return out;
}

/// The entries of a ledger, each as one line of JSON.
py::list history(const Path& ledger) {
  std::vector<std::string> lines;
  {
    const py::gil_scoped_release release;
    const Ledger opened = value_of(Ledger::open_to_read(ledger));
    value_of(opened.for_each({}, [&](const LedgerEntry& entry) -> Expected<void> {
      lines.push_back(ledger_entry_json(entry));
      return {};
    }));
  }
  py::list out;
  for (const std::string& line : lines) out.append(text(line));
  return out;
}

}  // namespace

void bind_calibrations(py::module_& module) {
  py::class_<Calibrated>(module, "Calibrated")
      .def_property_readonly("text", [](const Calibrated& self) { return text(self.text); })
      .def_property_readonly("report", [](const Calibrated& self) { return text(self.report); })
      .def_property_readonly("refusal", [](const Calibrated& self) { return text(self.refusal); })
      .def_readonly("chi_square", &Calibrated::chi_square)
      .def_readonly("degrees_of_freedom", &Calibrated::degrees_of_freedom)
      .def_readonly("excess", &Calibrated::excess);
  module.def("calibrate_camera",
             &camera,
             py::arg("machine"),
             py::arg("images"),
             py::arg("plate"),
             py::arg("tool"),
             py::arg("focal_px"),
             py::arg("clock"),
             py::call_guard<py::gil_scoped_release>());
  module.def("calibrate_table",
             &table,
             py::arg("machine"),
             py::arg("plate"),
             py::arg("images"),
             py::arg("measurements"),
             py::arg("clock"),
             py::call_guard<py::gil_scoped_release>());
  module.def("calibrate_spindle_camera",
             &spindle_camera,
             py::arg("drilled_mm"),
             py::arg("hole"),
             py::arg("spindle_mm"),
             py::arg("seen_mm"),
             py::arg("covariance"));
  module.def("history", &history, py::arg("ledger"));
}

}  // namespace panelcal::python
