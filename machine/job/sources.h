// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "calib/base/executor.h"
#include "calib/base/expected.h"
#include "machine/calibrate/spindle/calibration.h"
#include "machine/config/machine_config.h"
#include "machine/look/view_taker.h"
#include "machine/look/vision_procedure.h"
#include "program/model/measurement.h"
#include "program/walk/probing.h"
#include "program/walk/survey.h"

namespace panelcal {

/// The sources of a job.
struct JobSources {
  std::shared_ptr<MeasurementSource> targets;  ///< never null
  std::shared_ptr<ProbeSource> probes;         ///< never null
  std::string
      words;  ///< origin of the answers, in words for people: "recorded measurements in a.jsonl"
  std::function<std::string()> remark = {};  ///< for people, after the measuring; may be empty
  /// Shows the panel to a person, between the requests; null: nothing can (a recording). Lives as
  /// long as `targets`.
  ViewTaker* eye = nullptr;
  /// CameraDevice::risks of the camera, after the measuring; may be empty.
  std::function<std::vector<Diagnostic>()> risks = {};
};

/// Opens the sources of a program that was checked.
///
/// In     nominal: what a perfect panel would be asked
using OpenJobSources = std::function<Expected<JobSources>(const Survey& nominal)>;

/// The sources that a person chose; empty texts: not this one.
struct SourceChoice {
  std::string command;         ///< as diagnostics name it
  std::string images;          ///< a folder of pictures
  std::string measurements;    ///< a file of recorded measurements
  std::string camera;          ///< the address of a live camera
  std::string machine_driver;  ///< "sim"
  std::string probes;          ///< a file of recorded probe readings
  bool uncorrected = false;    ///< the program measures no target, and that is meant
  PictureObserver observer = {};
  Executor* executor = nullptr;  ///< looks at recorded pictures ahead; outlives the sources
  /// Gives the way to ask a person for something; called only if a person is needed.
  std::function<Expected<Prompt>()> prompt = {};
  TakenBy taken_by = {};  ///< rows of the coupon, for the ledger
};

/// Opens the sources that were chosen.
///
/// A source that the program does not use shows that this is another program than a person had in
/// mind, or that its targets are lost: only SourceChoice::uncorrected writes it as it is. Targets
/// use any source, orders to calibrate too, probes a camera or a machine.
///
/// Fails  usage (the program has targets or probes and no source answers them, or a source and uses
///        it for nothing; uncorrected, and it has targets); what making the sources reports
/// See    tests/machine/job/sources_test.cc
Expected<JobSources> open_sources(const SourceChoice& choice,
                                  const MachineConfig& machine,
                                  const Survey& nominal);

}  // namespace panelcal
