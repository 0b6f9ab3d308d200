// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "tools/cli/commands.h"

namespace panelcal::synth {

/// Renders all points of a sweep, each in a folder of its own that appears whole, and then the
/// manifest: docs/formats/sweep.md. The bytes do not depend on the number of threads, nor on where
/// an earlier start was ended.
///
/// Fails  what read_sweep and machine_of report; output-in-use (the folder holds something else, or
///        a set of another sweep); device-write; interrupted
/// See    tests/tools/synth_sweep_test.py
Expected<Answer> run_sweep(const SynthOptions& options, CommandContext& context);

}  // namespace panelcal::synth
