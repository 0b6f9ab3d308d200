// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "calib/base/expected.h"
#include "machine/operator/command.h"
#include "machine/operator/screen.h"

// Whether an order suits what the screen shows; what it changes there at once. A refused order has
// changed nothing.
namespace panelcal::internal {

/// No job and no calibration runs.
Expected<void> check_idle(const Screen& screen);
/// A program may be opened.
Expected<void> check_open(const Screen& screen);
Expected<void> take_close(Screen& screen);
/// The job that is checked becomes one that measures.
Expected<void> take_start(Screen& screen);
/// The same of a job that was interrupted, stopped, or failed.
Expected<void> take_resume(Screen& screen);
/// Closes the question, if one is open. A job or a calibration runs.
Expected<void> take_stop(Screen& screen);
/// Closes the question.
Expected<void> take_answer(Screen& screen, const Answer& answer);
Expected<void> take_jog(Screen& screen, const Eigen::Vector2d& by_mm);
/// A corrected program may be written, and by this name.
Expected<void> check_write(const Screen& screen, const std::string& name);

}  // namespace panelcal::internal
