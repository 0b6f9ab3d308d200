// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "calib/base/executor.h"
#include "calib/base/expected.h"
#include "machine/calibrate/spindle/job_calibration.h"
#include "machine/config/machine_config.h"
#include "machine/look/view_taker.h"
#include "machine/look/vision_procedure.h"
#include "machine/sources/look_ahead.h"
#include "program/model/measurement.h"
#include "vision/picture/files/folder.h"
#include "vision/picture/picture_form.h"

namespace panelcal {

/// Shows recorded pictures of a panel, and answers requests from them.
///
/// If any row of images.csv has a seq, the rows of a request's seq are shown in the order of the
/// list, one each time: view after view, and within a view inspection after inspection; there have
/// to be exactly as many as are asked for, except in a search, which ends where it finds the
/// target. Otherwise the picture whose optical axis stood nearest to the view's is shown, among
/// those of the request's vision tool or of none. The lamp and focus settings of a request are
/// orders to a camera that takes pictures; here the pictures are already taken.
///
/// images.csv says where the axis was sent to; with a [table] it stood where the map says.
class PictureSource final : public MeasurementSource, public ViewTaker {
 public:
  /// In     executor: looks at pictures before they are asked for; outlives the source; may be null
  /// Fails  config-value (no [camera])
  static Expected<PictureSource> create(const MachineConfig& config,
                                        PictureFolder folder,
                                        PictureObserver observer = {},
                                        Executor* executor = nullptr);

  void foresee(RequestForecast forecast) override;
  /// Fails  picture-missing; picture-mismatch (size, vision tool, number); travel-exceeded; what
  ///        VisionProcedure::measure and reading a picture report
  Expected<Measurement> measure(const MeasurementRequest& request) override;
  /// G39,SPOP and its kin move where later pictures were taken. Nothing is drilled: G39 is
  /// only passed on.
  Expected<std::optional<CalibrationAnswer>> calibrate(const CalibrationOrder& order) override;

  /// Fails  picture-missing; picture-mismatch; travel-exceeded; what reading a picture reports
  Expected<TakenPicture> take(const MeasurementRequest& request, const View& view) override;

 private:
  PictureSource(const MachineConfig& config,
                VisionProcedure procedure,
                PictureFolder folder,
                Executor* executor);
  /// Pictures that the requests will show, as far as they can be predicted.
  std::vector<internal::ForeseenPicture> foreseen(
      const std::vector<MeasurementRequest>& requests) const;
  TakenPicture not_read(std::size_t i_row) const;
  /// Place of the optical axis, with the offset in force.
  Position<frame::Machine> axis_of(const PictureRow& row) const;
  /// Refuses a picture that was taken where the table's map does not reach.
  Expected<void> check_is_on_table(const PictureRow& row) const;
  Expected<void> check_number_of_rows(const MeasurementRequest& request) const;
  Expected<std::size_t> next_row_of_seq(const MeasurementRequest& request, const View& view);
  Expected<std::size_t> nearest_row(const MeasurementRequest& request, const View& view) const;
  /// In images.csv; line 0 is the file as a whole.
  Diagnostic problem(Code code, int line, std::string what, std::string expected) const;

  VisionProcedure procedure_;
  PictureFolder folder_;
  PictureForm form_;
  std::shared_ptr<const TableCorrection> table_;  ///< may be null
  SpindleCameraOffset taken_with_;
  JobCalibration job_;
  Displacement<frame::Machine> shift_;  ///< of the offset since the pictures were taken
  std::map<std::int64_t, std::vector<std::size_t>> rows_by_seq_;  ///< empty: no row has a seq
  std::map<std::int64_t, std::size_t> n_shown_by_seq_;
  RequestForecast forecast_;
  std::unique_ptr<internal::LookAhead> look_ahead_;  ///< null without an executor
};

}  // namespace panelcal
