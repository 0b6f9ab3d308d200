// SPDX-License-Identifier: Apache-2.0
#pragma once

/// The front door: what a program needs that has panelcal correct a job.
///
///   read_machine_config()   the machine: what its file says
///   read_job()              the program, and what is wrong with it
///   open_sources()          pictures, a camera, recorded measurements, a simulated machine; or a
///                           MeasurementSource of your own
///   correct()               measures, fits, holds against gates and tolerances, corrects
///   JobResult               whether it may be drilled, and why not
///
/// See    docs/howto/library.md; docs/overview.md; tests/install/consumer

#include "calib/base/clock.h"
#include "calib/base/diagnostic.h"
#include "calib/base/expected.h"
#include "machine/config/machine_config.h"
#include "machine/job/job.h"
#include "machine/job/output/output.h"
#include "machine/job/sources.h"
#include "machine/job/summary/verdict_summary.h"
#include "machine/sources/measurement_file_source.h"
#include "machine/sources/probe_file_source.h"
#include "program/model/operation.h"
