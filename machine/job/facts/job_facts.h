// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "machine/job/facts/input.h"

namespace panelcal {

/// The facts of a job as one JSON document: verdict with its grounds and the next step, targets,
/// fits with their covariances, gates, causes, every place with shift, sigma and risk, tolerance,
/// depths, error budget, messages and origin. Reports and other programs show it.
///
/// Out    as share/schema/job.schema.json, with a line end; the same bytes for the same input
/// Cost   O(measurements + places); a million places take about 60 MB
/// See    tests/machine/job/facts/job_facts_test.cc
std::string job_facts(const JobFactsInput& input);

/// The pictures that these facts name: JPEG bytes by name.
std::map<std::string, std::string> job_pictures(const JobFactsInput& input);

}  // namespace panelcal
