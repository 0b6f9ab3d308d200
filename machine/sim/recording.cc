// SPDX-License-Identifier: Apache-2.0
#include "panelcal/machine/sim/recording.h"

#include <string>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "panelcal/calib/base/atomic_file.h"
#include "panelcal/vision/image_io.h"

namespace panelcal {
namespace {

std::string picture_name(const MeasurementRequest& request, int i) {
  if (i == 0) return fmt::format("{:04}.png", request.seq);
  return fmt::format("{:04}_{}.png", request.seq, i + 1);
}

/// The virtual machine, with a copy of every picture kept in a folder.
class RecordingSource final : public MeasurementSource {
 public:
  RecordingSource(const SimMachine& machine, const std::filesystem::path& folder)
      : machine_(machine), folder_(folder) {}

  Expected<Measurement> measure(const MeasurementRequest& request) override {
    PANELCAL_TRY(const int n_pictures, SimMachine::inspections_of(request));
    return machine_.locator().measure(
        request, n_pictures, [&](int i) { return take_picture(request, i); });
  }

  std::vector<PictureRow> take_rows() { return std::move(rows_); }

 private:
  Expected<TakenPicture> take_picture(const MeasurementRequest& request, int i) {
    PANELCAL_TRY(TakenPicture picture, machine_.take_picture(request, i));
    picture.name = picture_name(request, i);
    PANELCAL_CHECK(write_png(folder_ / picture.name, picture.image));
    PictureRow row;
    row.line = static_cast<int>(rows_.size()) + 2;  // behind the header
    row.file = picture.name;
    row.axis = picture.axis;
    row.tool = request.settings.tools.front();
    row.seq = static_cast<int>(request.seq);
    rows_.push_back(std::move(row));
    return picture;
  }

  const SimMachine& machine_;
  const std::filesystem::path& folder_;
  std::vector<PictureRow> rows_;
};

Expected<void> prepare_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!error) std::filesystem::remove(folder / "images.csv", error);
  if (!error) return {};
  return failure({Code::DeviceWrite,
                  {folder.string(), 0, 0},
                  "cannot be made a picture folder: " + error.message(),
                  ""});
}

}  // namespace

Expected<Recording> record_pictures(const Program& program,
                                    const MachineConfig& config,
                                    const SimMachine& machine,
                                    const std::filesystem::path& folder,
                                    DiagnosticLog& log) {
  PANELCAL_CHECK(prepare_folder(folder));
  RecordingSource source(machine, folder);
  Recording recording;
  recording.survey = survey(program, config.walk, source, log);
  recording.rows = source.take_rows();
  PANELCAL_CHECK(write_file(folder / "images.csv", format_images_csv(recording.rows)));
  return recording;
}

}  // namespace panelcal
