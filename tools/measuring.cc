// SPDX-License-Identifier: Apache-2.0
#include "panelcal/tools/measuring.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <optional>
#include <utility>

#include <fmt/format.h>

#include "panelcal/machine/measurement_file_source.h"
#include "panelcal/machine/picture_source.h"
#include "panelcal/machine/sim/sim_machine.h"
#include "panelcal/vision/overlay.h"
#include "panelcal/vision/picture_folder.h"

namespace panelcal {
namespace {

/// Shows how far the survey is.
class ProgressSource final : public MeasurementSource {
 public:
  ProgressSource(MeasurementSource& source, std::size_t n_targets, Console& console)
      : source_(source), n_targets_(n_targets), console_(console) {}

  Expected<Measurement> measure(const MeasurementRequest& request) override {
    console_.progress(fmt::format("measuring target {} of {} ({}, line {})",
                                  request.seq + 1,
                                  n_targets_,
                                  request.command,
                                  request.line));
    return source_.measure(request);
  }

 private:
  MeasurementSource& source_;
  std::size_t n_targets_;
  Console& console_;
};

struct OpenSource {
  std::unique_ptr<MeasurementSource> source;
  std::function<Expected<void>()> check_after;  ///< may be empty
  std::string words;
};

template <class Source>
Expected<OpenSource> opened(Expected<Source> source, std::string words) {
  if (!source) return failure(std::move(source).error());
  return OpenSource{std::make_unique<Source>(*std::move(source)), {}, std::move(words)};
}

Expected<OpenSource> open_source(const RunOptions& options,
                                 const MachineConfig& config,
                                 const Program& program,
                                 std::size_t n_targets,
                                 PictureObserver observer) {
  if (!options.images.empty()) {
    PANELCAL_TRY(PictureFolder folder, read_picture_folder(options.images));
    return opened(PictureSource::create(config, std::move(folder), std::move(observer)),
                  "pictures in " + options.images);
  }
  if (!options.measurements.empty()) {
    PANELCAL_TRY(RecordedMeasurements recorded, read_measurements(options.measurements));
    auto source = std::make_unique<MeasurementFileSource>(std::move(recorded));
    MeasurementFileSource* const file = source.get();
    return OpenSource{std::move(source),
                      [file] { return file->check_all_used(); },
                      "recorded measurements in " + options.measurements};
  }
  if (options.machine_driver == "sim") {
    return opened(SimMachine::create(config, program, std::move(observer)),
                  "the simulated machine of " + config.file.string());
  }
  if (n_targets == 0) return OpenSource{std::make_unique<NominalSource>(), {}, "no targets"};
  return failure({Code::Usage,
                  {"panelcal run", 0, 0},
                  "the program measures targets, and there is no SOURCE",
                  "--images, --measurements or --machine-driver"});
}

double worst_residual_um(const SeriesResult& series) {
  double worst_mm = 0;
  const auto take = [&](const auto& residuals) {
    for (const auto& residual : residuals) worst_mm = std::max(worst_mm, residual.in_mm().norm());
  };
  if (series.base) take(series.base->residuals);
  if (series.nested) take(series.nested->residuals);
  return worst_mm * 1e3;
}

}  // namespace

Expected<MeasuringResult> measure_program(const RunOptions& options,
                                          const MachineConfig& config,
                                          const Program& program,
                                          std::size_t n_targets,
                                          Console& console,
                                          DiagnosticLog& log) {
  MeasuringResult result;
  PictureObserver observer;
  if (!options.report.empty()) {
    observer = [&result](const MeasurementRequest& request,
                         const Image& image,
                         const Detection& detection) {
      // A picture that cannot be drawn is only missing from the report.
      if (auto png = encode_overlay(image, detection))
        result.crops_png[request.seq] = *std::move(png);
    };
  }
  WalkOptions walk = config.walk;
  walk.max_operations = options.max_operations;
  PANELCAL_TRY(OpenSource open,
               open_source(options, config, program, n_targets, std::move(observer)));
  ProgressSource source(*open.source, n_targets, console);
  result.survey = survey(program, walk, source, log);
  console.end_progress();
  if (open.check_after && !log.has_errors()) PANELCAL_CHECK(open.check_after());
  result.source = std::move(open.words);
  return result;
}

std::string fits_summary(const Survey& survey) {
  std::string out;
  auto to = std::back_inserter(out);
  const auto n_found =
      std::ranges::count(survey.measurements, MeasurementStatus::Found, &Measurement::status);
  fmt::format_to(to, "measured {} targets, {} found\n", survey.measurements.size(), n_found);
  std::size_t n_nested = 0;
  double worst_nested_um = 0;
  for (const SeriesResult& series : survey.series) {
    if (series.nested) {
      ++n_nested;
      worst_nested_um = std::max(worst_nested_um, worst_residual_um(series));
    }
    if (!series.base) continue;
    const auto& map = series.base->map.map;
    const PanelDeformation panel = deformation_of(map.linear());
    fmt::format_to(
        to,
        "panel (line {}): turned {:+.4f} mrad, stretched {:+.1f} ppm in x and {:+.1f} ppm "
        "in y, worst residual {:.3f} um\n",
        series.line,
        panel.rotation_rad * 1e3,
        (panel.scale_x - 1) * 1e6,
        (panel.scale_y - 1) * 1e6,
        worst_residual_um(series));
  }
  if (n_nested > 0) {
    fmt::format_to(to, "{} nested fits, worst residual {:.3f} um\n", n_nested, worst_nested_um);
  }
  return out;
}

}  // namespace panelcal
