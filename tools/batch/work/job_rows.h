// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "machine/job/result.h"
#include "machine/look/picture_locator.h"
#include "machine/sim/truth.h"
#include "tools/batch/manifest/manifest.h"
#include "tools/batch/store/outcome.h"

namespace panelcal::batch {

/// The row of table picture_quality for a picture that was looked at; `i` counts those of the job.
StoredRow picture_row(std::int64_t job, std::int64_t i, const SeenView& seen);

/// Puts rows of targets, fits and holes into an outcome. Errors against truth are measured minus
/// true place of each target that shows both coordinates.
///
/// In     truth: null where it is not known
void put_result(const JobResult& result, const Truth* truth, JobOutcome& outcome);

/// Puts the job's own row and its diagnostics into an outcome, whose state and exit code follow
/// from the log.
struct JobHead {
  std::string machine_name;
  std::string clock;
  std::string output;  ///< empty: none was written
};
void put_head(const ManifestJob& job,
              const JobHead& head,
              const JobResult* result,
              const DiagnosticLog& log,
              JobOutcome& outcome);

}  // namespace panelcal::batch
