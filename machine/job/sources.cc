// SPDX-License-Identifier: Apache-2.0
#include "machine/job/sources.h"

#include <algorithm>
#include <functional>
#include <optional>
#include <type_traits>
#include <utility>

#include "calib/base/amount.h"
#include "machine/devices/cameras/without_password.h"
#include "machine/devices/commands/command_spindle.h"
#include "machine/devices/controls/open/open_control.h"
#include "machine/look/camera_views.h"
#include "machine/sim/sim_machine.h"
#include "machine/sim/simulated_probe.h"
#include "machine/sources/live_source.h"
#include "machine/sources/measurement_file_source.h"
#include "machine/sources/picture_source.h"
#include "machine/sources/probe_file_source.h"
#include "vision/picture/files/folder.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

/// For a program that measures nothing: no offset matters to it, so that none is calibrated.
class NoTargets final : public MeasurementSource {
 public:
  Expected<Measurement> measure(const MeasurementRequest& request) override {
    return panel_.measure(request);
  }

 private:
  NominalSource panel_;
};

/// The option that names the source of the targets; empty: none.
std::string source_option(const SourceChoice& choice) {
  if (!choice.images.empty()) return "--images " + quoted(choice.images);
  if (!choice.measurements.empty()) return "--measurements " + quoted(choice.measurements);
  if (!choice.camera.empty()) return "--camera " + quoted(without_password(choice.camera));
  if (!choice.machine_driver.empty()) return "--machine-driver " + choice.machine_driver;
  return "";
}

/// A corrected program is expected where there is a source, and an uncorrected one only where a
/// person says so.
Expected<void> check_correction_is_meant(const SourceChoice& choice, const Survey& nominal) {
  const auto refuse = [&](std::string what, std::string expected) {
    return failure({Code::Usage, {choice.command, 0, 0}, std::move(what), std::move(expected)});
  };
  if (choice.uncorrected) {
    if (nominal.measurements.empty()) return {};
    return refuse(fmt::format("--uncorrected: the program measures a target in line {}",
                              nominal.measurements.front().request.line),
                  "no --uncorrected, or a program without targets");
  }
  const std::string option = source_option(choice);
  const bool can_probe = !choice.camera.empty() || !choice.machine_driver.empty();
  const bool is_used = !nominal.measurements.empty() || !nominal.calibrations.empty() ||
                       (can_probe && !nominal.probes.empty());
  if (option.empty() || is_used) return {};
  return refuse(option + ": the program measures no target",
                "a program with targets, or --uncorrected to write it as it is");
}

struct OpenTargets {
  std::shared_ptr<MeasurementSource> source;
  std::string words;  ///< empty: nothing is asked
  std::function<std::string()> remark = {};
  std::function<std::vector<Diagnostic>()> risks = {};
  ViewTaker* eye = nullptr;
  CameraViews* driven = nullptr;  ///< the eye, if it is a camera on a stage
};

struct OpenProbes {
  std::shared_ptr<ProbeSource> source;
  std::string words;
};

/// A probe on the machine that carries the camera, which then stands elsewhere.
class ProbeBesideCamera final : public ProbeSource {
 public:
  /// In     camera: lives as long as `targets`
  ProbeBesideCamera(std::shared_ptr<ProbeSource> probe,
                    std::shared_ptr<MeasurementSource> targets,
                    CameraViews* camera)
      : probe_(std::move(probe)), targets_(std::move(targets)), camera_(camera) {}

  Expected<ProbeReading> probe(const ProbeRequest& request) override {
    camera_->forget_place();
    return probe_->probe(request);
  }
  Expected<void> finish() override { return probe_->finish(); }

 private:
  std::shared_ptr<ProbeSource> probe_;
  std::shared_ptr<MeasurementSource> targets_;
  CameraViews* camera_;
};

std::string words_of_sim(const MachineConfig& machine) {
  return "the simulated machine of " + machine.file.string();
}

template <class Source>
Expected<OpenTargets> opened(Expected<Source> source, std::string words) {
  if (!source) return failure(std::move(source).error());
  auto targets = std::make_shared<Source>(*std::move(source));
  OpenTargets open{targets, std::move(words)};
  if constexpr (std::is_base_of_v<ViewTaker, Source>) open.eye = targets.get();
  return open;
}

/// True if the program has holes drilled into the coupon.
bool drills_coupon(const Survey& nominal) {
  return std::ranges::any_of(nominal.calibrations, [](const CalibrationAnswer& calibration) {
    return !calibration.order.correction.has_value();
  });
}

/// What drives the machine, opened once, when it is needed first.
class ControlOnDemand {
 public:
  explicit ControlOnDemand(const MachineConfig& machine) : machine_(&machine) {}
  Expected<OpenedControl> operator()() {
    if (!opened_) {
      PANELCAL_TRY(opened_, open_control(*machine_));
    }
    return *opened_;
  }
  /// Empty: it was not opened, or is no control.
  std::string words() const { return opened_ ? opened_->words : std::string(); }

 private:
  const MachineConfig* machine_;
  std::optional<OpenedControl> opened_;
};

Expected<OpenTargets> open_camera(const SourceChoice& choice,
                                  const MachineConfig& machine,
                                  const Survey& nominal,
                                  ControlOnDemand& control) {
  Prompt prompt;
  if (machine.coupon && machine.coupon->has_entry_material && drills_coupon(nominal)) {
    if (!choice.prompt) {
      return failure({Code::Usage,
                      {choice.command, 0, 0},
                      "the coupon needs entry material, and there is no way to ask a person for it",
                      "a prompt"});
    }
    PANELCAL_TRY(prompt, choice.prompt());
  }
  PANELCAL_TRY(std::unique_ptr<CameraViews> views,
               open_camera_views(machine, choice.camera, std::ref(control)));
  CameraViews* const eye = views.get();
  const CameraDevice& camera = eye->camera();
  auto spindle = std::make_unique<CommandSpindle>(machine.stage.drill, machine.stage.limit);
  Expected<LiveSource> source = LiveSource::create(
      machine, std::move(views), std::move(spindle), std::move(prompt), choice.observer);
  if (source) source->set_taken_by(choice.taken_by);
  std::string words = "the camera " + camera.name();
  if (!control.words().empty()) words += " on " + control.words();
  PANELCAL_TRY(OpenTargets open, opened(std::move(source), std::move(words)));
  // Both live as long as the source.
  open.eye = eye;
  open.driven = eye;
  open.remark = [&camera] {
    return camera.n_retaken() == 0 ? std::string()
                                   : fmt::format("{} frame(s) were lost on the way and taken again",
                                                 camera.n_retaken());
  };
  open.risks = [&camera] { return camera.risks(); };
  return open;
}

Expected<OpenTargets> open_targets(const SourceChoice& choice,
                                   const MachineConfig& machine,
                                   const Survey& nominal,
                                   ControlOnDemand& control) {
  const std::size_t n_targets = nominal.measurements.size();
  if (choice.uncorrected) return OpenTargets{std::make_shared<NoTargets>(), ""};
  if (!choice.images.empty()) {
    PANELCAL_TRY(PictureFolder folder, read_picture_folder(choice.images));
    return opened(
        PictureSource::create(machine, std::move(folder), choice.observer, choice.executor),
        "pictures in " + choice.images);
  }
  if (!choice.measurements.empty()) {
    PANELCAL_TRY(RecordedMeasurements recorded, read_measurements(choice.measurements));
    return OpenTargets{std::make_shared<MeasurementFileSource>(std::move(recorded)),
                       "recorded measurements in " + choice.measurements};
  }
  if (!choice.camera.empty() && n_targets > 0)
    return open_camera(choice, machine, nominal, control);
  if (choice.machine_driver == "sim" && (n_targets > 0 || !machine.sim)) {
    Expected<SimMachine> source = SimMachine::create(machine, nominal, choice.observer);
    if (source) source->set_taken_by(choice.taken_by);
    return opened(std::move(source), words_of_sim(machine));
  }
  if (n_targets == 0) return OpenTargets{std::make_shared<NoTargets>(), ""};
  return failure({Code::Usage,
                  {choice.command, 0, 0},
                  "the program measures targets, and there is no SOURCE",
                  "--images, --camera, --measurements or --machine-driver"});
}

Expected<OpenProbes> open_probes(const SourceChoice& choice,
                                 const MachineConfig& machine,
                                 const Survey& nominal,
                                 ControlOnDemand& control) {
  if (!choice.probes.empty()) {
    PANELCAL_TRY(RecordedProbes recorded, read_probes(choice.probes));
    return OpenProbes{std::make_shared<ProbeFileSource>(std::move(recorded)),
                      "recorded probe readings in " + choice.probes};
  }
  const std::size_t n_probes = nominal.probes.size();
  if (n_probes == 0) return OpenProbes{std::make_shared<NominalProbeSource>(), ""};
  if (choice.machine_driver == "sim") {
    if (!machine.sim) {
      return failure({Code::ConfigValue,
                      {machine.file.string(), 0, 0},
                      "[sim] is missing, which describes the virtual machine",
                      "[sim]"});
    }
    PANELCAL_TRY(SimulatedProbe probe, SimulatedProbe::create(machine.sim->surface));
    return OpenProbes{std::make_shared<SimulatedProbe>(std::move(probe)), words_of_sim(machine)};
  }
  if (!choice.camera.empty() && machine.can_probe()) {
    PANELCAL_TRY(const OpenedControl opened, control());
    return OpenProbes{opened.probe, "the machine's probe"};
  }
  return failure(
      {Code::Usage,
       {choice.command, 0, 0},
       fmt::format("the program probes the surface at {}, and there is no source of "
                   "readings",
                   amount(n_probes, "place")),
       "--probes, --machine-driver, or --camera with [machine] probe_command or driver"});
}

std::string source_words(const OpenTargets& targets, const OpenProbes& probes) {
  if (targets.words.empty() && probes.words.empty()) return "no targets";
  if (probes.words.empty() || targets.words == probes.words) return targets.words;
  return targets.words.empty() ? probes.words : targets.words + " and " + probes.words;
}

}  // namespace

Expected<JobSources> open_sources(const SourceChoice& choice,
                                  const MachineConfig& machine,
                                  const Survey& nominal) {
  PANELCAL_CHECK(check_correction_is_meant(choice, nominal));
  ControlOnDemand control(machine);
  PANELCAL_TRY(OpenProbes probes, open_probes(choice, machine, nominal, control));
  PANELCAL_TRY(const OpenTargets targets, open_targets(choice, machine, nominal, control));
  if (targets.driven != nullptr && choice.probes.empty()) {
    probes.source =
        std::make_shared<ProbeBesideCamera>(probes.source, targets.source, targets.driven);
  }
  return JobSources{targets.source,
                    probes.source,
                    source_words(targets, probes),
                    targets.remark,
                    targets.eye,
                    targets.risks};
}

}  // namespace panelcal
