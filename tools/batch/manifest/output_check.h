// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "calib/base/expected.h"
#include "tools/batch/manifest/manifest.h"

namespace panelcal::batch {

/// No output of a job may replace an input of any job, a file that a machine names, or an output of
/// another one; and no input may stand where the batch keeps its results.
///
/// In     results: the folder of the results; other_outputs: such as of --json; may be empty
/// Fails  output-in-use, usage (no format belongs to an output's name), at the manifest's line
/// See    tests/tools/batch_test.py
Expected<void> check_job_outputs(const Manifest& manifest,
                                 const std::filesystem::path& results,
                                 const std::vector<std::string>& other_outputs,
                                 bool has_format);

}  // namespace panelcal::batch
