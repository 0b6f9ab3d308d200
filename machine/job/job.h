// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <string>

#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "machine/job/request.h"
#include "machine/job/result.h"
#include "machine/job/sources.h"
#include "program/model/measurement.h"

namespace panelcal {

/// Reads a program and the stored patterns that it names, which are looked for beside it and where
/// the machine says. What is wrong in it stands in Job::reading.
///
/// In     path: `-` is standard input
/// Fails  file-unreadable
Expected<Job> read_job(const std::string& path,
                       const MachineConfig& machine,
                       std::chrono::sys_seconds now);

/// Measures a program's targets, fits them, holds the fits against their gates, corrects the whole
/// job and holds it against its tolerances: what `panelcal run` does.
///
/// The program is checked first, so that its mistakes are known before anything moves; one
/// measuring and one working walk follow. A program that asks for nothing is walked once.
///
/// In     machine: as read_machine_config() reads it; it ages here
/// Out    a result also if gates or tolerances refuse the job: ask may_be_drilled()
/// Fails  the first problem that kept the job from being measured (the program, the machine's file,
///        a source); all of them are in sinks.log
/// Cost   memory does not grow with the number of holes
/// Source CNC-7 manual, Part Program Vision Commands (two passes)
/// See    tests/machine/job/correct_test.cc; docs/overview.md
Expected<JobResult> correct(const Job& job,
                            const OpenJobSources& open,
                            const MachineConfig& machine,
                            const JobSinks& sinks = {});
/// The same with a source that is open already. A program that probes surfaces is refused.
Expected<JobResult> correct(const Job& job,
                            MeasurementSource& source,
                            const MachineConfig& machine,
                            const JobSinks& sinks = {});

}  // namespace panelcal
