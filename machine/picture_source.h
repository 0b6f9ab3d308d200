// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "panelcal/calib/base/expected.h"
#include "panelcal/machine/machine_config.h"
#include "panelcal/machine/picture_locator.h"
#include "panelcal/program/measurement.h"
#include "panelcal/vision/picture_folder.h"

namespace panelcal {

/// Answers requests from a folder of recorded pictures.
///
/// If any row of images.csv has a seq, pictures are chosen by seq: exactly as many as `$uvis,insp`
/// asks for. Otherwise the picture whose optical axis stood nearest to the expected
/// place is taken, among those of the request's vision tool or of none. The lamp, zoom and search
/// settings of a request are orders to a camera that takes pictures; here the pictures are already
/// taken.
class PictureSource final : public MeasurementSource {
 public:
  /// Fails  config-value (no [camera])
  static Expected<PictureSource> create(const MachineConfig& config,
                                        PictureFolder folder,
                                        PictureObserver observer = {});

  /// Fails  picture-missing; picture-mismatch (size, vision tool); vision-tool-undefined;
  ///        not-supported; what reading a picture reports
  Expected<Measurement> measure(const MeasurementRequest& request) override;

 private:
  PictureSource(PictureLocator locator, PictureFolder folder);
  Expected<std::vector<std::size_t>> rows_of_seq(const MeasurementRequest& request) const;
  Expected<std::vector<std::size_t>> nearest_row(const MeasurementRequest& request) const;
  /// In images.csv; line 0 is the file as a whole.
  Diagnostic problem(Code code, int line, std::string what, std::string expected) const;

  PictureLocator locator_;
  PictureFolder folder_;
  std::map<std::int64_t, std::vector<std::size_t>> rows_by_seq_;  ///< empty: no row has a seq
};

}  // namespace panelcal
