// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "calib/base/json/facts.h"
#include "tools/batch/store/store.h"

namespace panelcal::batch {

/// The facts of a batch, as share/schema/batch.schema.json describes them: how many jobs were
/// drilled, held and failed and why, what was found, errors against truth beside what their
/// covariances predict, whether chi squares are as they should be, throughput, conditions and
/// drift. What a time of day or a number of threads decides stands in `sessions` alone.
///
/// Fails  as Store
/// Cost   O(targets), in memory that does not grow with them
/// See    tests/tools/batch_test.py
Expected<facts::Json> batch_facts(Store& store);

/// The same facts in words, for a terminal.
std::string batch_text(const facts::Json& facts);

}  // namespace panelcal::batch
