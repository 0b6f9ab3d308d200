// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/measuring.h"

#include <algorithm>
#include <functional>
#include <iterator>
#include <limits>
#include <memory>
#include <optional>
#include <utility>

#include "calib/correction/spindle_camera.h"
#include "machine/devices/command_probe.h"
#include "machine/devices/command_spindle.h"
#include "machine/look/camera_views.h"
#include "machine/look/vision_procedure.h"
#include "machine/sim/sim_machine.h"
#include "machine/sim/simulated_probe.h"
#include "machine/sources/live_source.h"
#include "machine/sources/measurement_file_source.h"
#include "machine/sources/picture_source.h"
#include "machine/sources/probe_file_source.h"
#include "program/walk/pad_collector.h"
#include "tools/cli/operator_prompt.h"
#include "tools/report/models.h"
#include "vision/picture/folder.h"
#include "vision/show/overlay.h"
#include <fmt/format.h>

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
  Expected<std::optional<FocusResult>> focus(const MeasurementRequest& request) override {
    console_.progress(fmt::format("focusing ({}, line {})", request.command, request.line));
    return source_.focus(request);
  }
  Expected<std::optional<CalibrationAnswer>> calibrate(const CalibrationOrder& order) override {
    console_.progress(fmt::format("calibrating ({}, line {})", order.command, order.line));
    return source_.calibrate(order);
  }

 private:
  MeasurementSource& source_;
  std::size_t n_targets_;
  Console& console_;
};

/// For a program that measures nothing: no offset matters to it, so that none is calibrated.
class NoTargets final : public MeasurementSource {
 public:
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    return panel_.measure(request);
  }

 private:
  NominalSource panel_;
};

class ProbeProgress final : public ProbeSource {
 public:
  ProbeProgress(ProbeSource& source, std::size_t n_probes, Console& console)
      : source_(source), n_probes_(n_probes), console_(console) {}

  Expected<ProbeReading> probe(const ProbeRequest& request) override {
    console_.progress(fmt::format("probing place {} of {} ({}, line {})",
                                  request.seq + 1,
                                  n_probes_,
                                  request.command,
                                  request.line));
    return source_.probe(request);
  }

 private:
  ProbeSource& source_;
  std::size_t n_probes_;
  Console& console_;
};

template <class Source>
struct Open {
  std::unique_ptr<Source> source;
  std::function<Expected<void>()> check_after;  ///< may be empty
  std::string words;                            ///< empty: no question
  std::function<std::string()> remark = {};     ///< what to tell people afterwards; may be empty
};
using OpenSource = Open<MeasurementSource>;
using OpenProbes = Open<ProbeSource>;

std::string words_of_sim(const MachineConfig& config) {
  return "the simulated machine of " + config.file.string();
}

template <class Source>
Expected<OpenSource> opened(Expected<Source> source, std::string words) {
  if (!source) return failure(std::move(source).error());
  return OpenSource{std::make_unique<Source>(*std::move(source)), {}, std::move(words)};
}

/// Whether the program has holes drilled into the coupon.
bool drills_coupon(const Survey& nominal) {
  return std::ranges::any_of(nominal.calibrations, [](const CalibrationAnswer& calibration) {
    return !calibration.order.correction.has_value();
  });
}

Expected<OpenSource> open_camera_source(const std::string& address,
                                        const MachineConfig& config,
                                        const Survey& nominal,
                                        Console& console,
                                        PictureObserver observer) {
  Prompt prompt;
  if (config.coupon && config.coupon->has_entry_material && drills_coupon(nominal)) {
    PANELCAL_TRY(prompt, operator_prompt("panelcal run", console));
  }
  PANELCAL_TRY(std::unique_ptr<CameraViews> views, open_camera_views(config, address));
  const CameraDevice& camera = views->camera();
  auto spindle = std::make_unique<CommandSpindle>(config.stage.drill, config.stage.limit);
  PANELCAL_TRY(
      OpenSource open,
      opened(
          LiveSource::create(
              config, std::move(views), std::move(spindle), std::move(prompt), std::move(observer)),
          "the camera " + camera.name()));
  // Lives as long as the source.
  open.remark = [&camera] {
    return camera.n_retaken() == 0 ? std::string()
                                   : fmt::format("{} frame(s) were lost on the way and taken again",
                                                 camera.n_retaken());
  };
  return open;
}

Expected<OpenSource> open_source(const RunOptions& options,
                                 const MachineConfig& config,
                                 const Program& program,
                                 const Survey& nominal,
                                 Console& console,
                                 PictureObserver observer) {
  const std::size_t n_targets = nominal.measurements.size();
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
  // Without targets no camera is needed.
  if (!options.camera.empty() && n_targets > 0) {
    return open_camera_source(options.camera, config, nominal, console, std::move(observer));
  }
  if (options.machine_driver == "sim" && (n_targets > 0 || !config.sim)) {
    return opened(SimMachine::create(config, program, std::move(observer)), words_of_sim(config));
  }
  if (n_targets == 0) return OpenSource{std::make_unique<NoTargets>(), {}, ""};
  return failure({Code::Usage,
                  {"panelcal run", 0, 0},
                  "the program measures targets, and there is no SOURCE",
                  "--images, --camera, --measurements or --machine-driver"});
}

std::string places(std::size_t n) {
  return fmt::format("{} place{}", n, n == 1 ? "" : "s");
}

Expected<OpenProbes> open_probes(const RunOptions& options,
                                 const MachineConfig& config,
                                 std::size_t n_probes) {
  if (!options.probes.empty()) {
    PANELCAL_TRY(RecordedProbes recorded, read_probes(options.probes));
    auto source = std::make_unique<ProbeFileSource>(std::move(recorded));
    ProbeFileSource* const file = source.get();
    return OpenProbes{std::move(source),
                      [file] { return file->check_all_used(); },
                      "recorded probe readings in " + options.probes};
  }
  if (n_probes == 0) return OpenProbes{std::make_unique<NominalProbeSource>(), {}, ""};
  if (options.machine_driver == "sim") {
    if (!config.sim) {
      return failure({Code::ConfigValue,
                      {config.file.string(), 0, 0},
                      "[sim] is missing, which describes the virtual machine",
                      "[sim]"});
    }
    PANELCAL_TRY(SimulatedProbe probe, SimulatedProbe::create(config.sim->surface));
    return OpenProbes{std::make_unique<SimulatedProbe>(std::move(probe)), {}, words_of_sim(config)};
  }
  if (!options.camera.empty() && !config.stage.probe.empty()) {
    return OpenProbes{std::make_unique<CommandProbe>(config.stage), {}, "the machine's probe"};
  }
  return failure({Code::Usage,
                  {"panelcal run", 0, 0},
                  fmt::format("the program probes the surface at {}, and there is no source of "
                              "readings",
                              places(n_probes)),
                  "--probes, --machine-driver, or --camera with [machine] probe_command"});
}

std::string source_words(const OpenSource& source, const OpenProbes& probes) {
  if (source.words.empty() && probes.words.empty()) return "no targets";
  if (probes.words.empty() || source.words == probes.words) return source.words;
  return source.words.empty() ? probes.words : source.words + " and " + probes.words;
}

ReportView report_view(const SeenView& seen) {
  ReportView view;
  view.i_view = seen.view.i_view;
  // The two have the same words.
  view.status = *measurement_status_from_name(name(seen.detection.status));
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
    view.seen_mm.push_back(in_work(seen.detection.best->center_optical->position));
  }
  return view;
}

std::string focus_summary(const Survey& survey) {
  std::string out;
  for (const FocusResult& focus : survey.focus) {
    if (!focus.is_found) continue;
    out += fmt::format("focused at ({:.4f}, {:.4f}) mm (line {}): z = {:.4f} mm, sigma {:.1f} um\n",
                       focus.request.expected.in_mm().x(),
                       focus.request.expected.in_mm().y(),
                       focus.request.line,
                       focus.z.in_mm(),
                       focus.sigma.in_um());
  }
  return out;
}

/// They count for this job; the text says how to keep one.
std::string calibrations_summary(const Survey& survey) {
  constexpr std::size_t kMost = 20;
  const std::size_t n = survey.calibrations.size();
  std::string out;
  for (std::size_t i = 0; i < std::min(n, kMost); ++i) {
    const CalibrationAnswer& calibration = survey.calibrations[i];
    out += fmt::format(
        "{} (line {}): {}\n", calibration.order.command, calibration.order.line, calibration.text);
  }
  if (n > kMost) out += fmt::format("and {} more calibrations\n", n - kMost);
  if (n == 0) return out;
  return out +
         "calibrated for this job only: `panelcal calibrate spindle-camera --install` is for "
         "later ones\n";
}

KnownPads pads_of(const Program& program, const WalkOptions& walk, const Survey& nominal) {
  PadCollector collector(nominal);
  DiagnosticLog said_already;
  execute(program, walk, nominal, collector, said_already);
  return collector.take();
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
                                          const Survey& nominal,
                                          Console& console,
                                          DiagnosticLog& log) {
  MeasuringResult result;
  PictureObserver observer;
  if (!options.report.empty()) {
    observer = [&result](const SeenView& seen) {
      ReportView view = report_view(seen);
      // A picture that cannot be drawn is only missing from the report.
      if (auto png = encode_overlay(seen.picture.image, seen.detection)) {
        if (seen.detection.best) view.crop_png = *png;
        result.crops_png[seen.request.seq] = *std::move(png);
      }
      result.views[seen.request.seq].push_back(std::move(view));
    };
  }
  WalkOptions walk = config.walk;
  walk.max_operations = options.max_operations;
  const std::size_t n_targets = nominal.measurements.size();
  const std::size_t n_probes = nominal.probes.size();
  PANELCAL_TRY(const OpenProbes open_probe, open_probes(options, config, n_probes));
  PANELCAL_TRY(const OpenSource open,
               open_source(options, config, program, nominal, console, std::move(observer)));
  walk.known_pads = [&program, &config, &nominal, known = std::optional<KnownPads>()]() mutable {
    if (!known) known = pads_of(program, config.walk, nominal);
    return &*known;
  };
  walk.base_limits = share_false_alarm(walk.base_limits, nominal.series.size());
  walk.nested_limits = share_false_alarm(walk.nested_limits, nominal.series.size());
  ProgressSource source(*open.source, n_targets, console);
  ProbeProgress probes(*open_probe.source, n_probes, console);
  result.survey = survey(program, walk, source, probes, log);
  console.end_progress();
  if (const std::string remark = open.remark ? open.remark() : ""; !remark.empty()) {
    console.say(remark);
  }
  if (open.check_after && !log.has_errors()) PANELCAL_CHECK(open.check_after());
  if (open_probe.check_after && !log.has_errors()) PANELCAL_CHECK(open_probe.check_after());
  result.source = source_words(open, open_probe);
  return result;
}

namespace {

/// Empty for a program that probes nothing.
std::string probes_summary(const Survey& survey) {
  if (survey.probes.empty()) return {};
  double low_mm = std::numeric_limits<double>::infinity();
  double high_mm = -low_mm;
  for (const ProbeReading& reading : survey.probes) {
    for (const HeightEstimate& height : reading.heights) {
      low_mm = std::min(low_mm, height.height.in_mm());
      high_mm = std::max(high_mm, height.height.in_mm());
    }
  }
  const auto n_found = std::ranges::count(survey.probes, ProbeStatus::Found, &ProbeReading::status);
  std::string out = fmt::format("probed {}, {} found", places(survey.probes.size()), n_found);
  if (n_found > 0) {
    out += fmt::format(", surface from {:.4f} to {:.4f} mm above the table", low_mm, high_mm);
  }
  for (const FilledNode& node : survey.filled_nodes) {
    const HeightEstimate& height = node.heights.front();
    out += fmt::format(
        "\nnot probed, {}: ({:.4f}, {:.4f}) mm of the grid, {:.4f} mm high, sigma "
        "{:.1f} um",
        name(node.source),
        node.place.in_mm().x(),
        node.place.in_mm().y(),
        height.height.in_mm(),
        height.sigma.in_um());
  }
  return out + "\n";
}

}  // namespace

namespace {

/// Of series that a gate refuses and no diagnostic explains.
std::string causes_summary(const Survey& survey) {
  std::string out;
  for (const SeriesResult& series : survey.series) {
    if (!series.fault || series.fault->is_resolved || series.fault->false_alarm > 0) continue;
    out += fmt::format("likely cause (series of line {}): {}\n", series.line, series.fault->text());
  }
  return out;
}

}  // namespace

std::string fits_summary(const Survey& survey) {
  std::string out = focus_summary(survey) + calibrations_summary(survey);
  auto to = std::back_inserter(out);
  const auto n_found =
      std::ranges::count(survey.measurements, MeasurementStatus::Found, &Measurement::status);
  if (!survey.measurements.empty() || survey.probes.empty()) {
    fmt::format_to(to, "measured {} targets, {} found\n", survey.measurements.size(), n_found);
  }
  out += probes_summary(survey);
  out += causes_summary(survey);
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
    if (series.is_smooth()) {
      fmt::format_to(to, "panel (line {}): {}\n", series.line, model_text(series));
    }
    out += report::model_line(series);
    if (series.layer_spread) {
      fmt::format_to(to,
                     "panel (line {}): layers of a target at most {:.3f} um apart\n",
                     series.line,
                     series.layer_spread->in_um());
    }
  }
  if (n_nested > 0) {
    fmt::format_to(to, "{} nested fits, worst residual {:.3f} um\n", n_nested, worst_nested_um);
    out += report::nested_models_line(survey);
  }
  return out;
}

}  // namespace panelcal
