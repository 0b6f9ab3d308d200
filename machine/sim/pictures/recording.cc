// SPDX-License-Identifier: Apache-2.0
#include "machine/sim/pictures/recording.h"

#include <string>
#include <utility>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include "machine/devices/table_stage.h"
#include "machine/look/view_taker.h"
#include "machine/look/vision_procedure.h"
#include "machine/sim/pictures/synth_folder.h"
#include "machine/sim/truth.h"
#include "vision/picture/files/image_io.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

std::string picture_name(const MeasurementRequest& request, const View& view) {
  std::string name = fmt::format("{:04}", request.seq);
  if (view.i_view > 0) name += fmt::format("_view{}", view.i_view + 1);
  if (view.i_inspection > 0) name += fmt::format("_{}", view.i_inspection + 1);
  return name + ".png";
}

/// The virtual machine, with a copy of every picture kept in a folder.
class RecordingSource final : public MeasurementSource, public ViewTaker {
 public:
  RecordingSource(const MachineConfig& config,
                  SimMachine& machine,
                  const std::filesystem::path& folder)
      : config_(config),
        machine_(machine),
        procedure_(machine.procedure()),
        folder_(folder),
        begun_with_(machine.offset()) {}

  Expected<Measurement> measure(const MeasurementRequest& request) override {
    return machine_.measure(request, *this);
  }

  Expected<std::optional<FocusResult>> focus(const MeasurementRequest& request) override {
    return procedure_.focus(request, *this);
  }

  /// Of what a job learns from its own holes pictures can tell later; G39 is only passed on.
  Expected<std::optional<CalibrationAnswer>> calibrate(const CalibrationOrder& order) override {
    if (!order.correction) return std::nullopt;
    return machine_.calibrate(order);
  }

  DrilledPanel* drilled_panel() override { return machine_.drilled_panel(); }

  Expected<TakenPicture> take(const MeasurementRequest& request, const View& view) override {
    PANELCAL_TRY(TakenPicture picture, machine_.take(request, view));
    if (request.seq < 0) return picture;  // of an autofocus: no answer to a request
    picture.name = picture_name(request, view);
    PANELCAL_CHECK(write_png(folder_ / picture.name, picture.image));
    PictureRow row;
    row.line = static_cast<int>(rows_.size()) + 2;  // behind the header
    row.file = picture.name;
    const auto learned = machine_.offset().offset - begun_with_.offset;
    PANELCAL_TRY(row.axis, listed_from_axis(config_, picture.axis - learned));
    const std::vector<int>& tools = request.settings.tools;
    row.tool = tools[static_cast<std::size_t>(view.i_tool)];
    row.zoom = request.settings.zoom;
    row.z = view.focus_z;
    row.seq = static_cast<int>(request.seq);
    rows_.push_back(std::move(row));
    return picture;
  }

  std::vector<PictureRow> take_rows() { return std::move(rows_); }

 private:
  const MachineConfig& config_;
  SimMachine& machine_;
  VisionProcedure procedure_;
  const std::filesystem::path& folder_;
  SpindleCameraOffset begun_with_;
  std::vector<PictureRow> rows_;
};

}  // namespace

Expected<Recording> record_pictures(const Program& program,
                                    const MachineConfig& config,
                                    SimMachine& machine,
                                    const std::filesystem::path& folder,
                                    DiagnosticLog& log) {
  PANELCAL_CHECK(internal::prepare_synth_folder(folder));
  RecordingSource source(config, machine, folder);
  Recording recording;
  recording.survey = survey(program, config.walk, source, log);
  recording.rows = source.take_rows();
  PANELCAL_CHECK(write_truth_json(folder / "truth.json", machine.truth()));
  PANELCAL_CHECK(write_file(folder / "images.csv", format_images_csv(recording.rows)));
  std::vector<std::string> names = {"images.csv", "truth.json"};
  for (const PictureRow& row : recording.rows) names.push_back(row.file);
  PANELCAL_CHECK(internal::finish_synth_folder(folder, std::move(names)));
  return recording;
}

}  // namespace panelcal
