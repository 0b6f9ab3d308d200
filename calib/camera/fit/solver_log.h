// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace panelcal {

/// Keeps warnings of the solver (Ceres) off standard error, for the rest of the process: what a fit
/// came to is in its result. They go through a logger that is one a process (glog), so a library
/// may not decide; a program whose standard error has another use calls this first.
///
/// See    tests/calib/camera/fit/solver_log_test.cc
void silence_solver_log();

}  // namespace panelcal
