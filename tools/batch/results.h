// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>

#include "calib/base/expected.h"
#include "tools/batch/store/store.h"
#include "tools/batch/work/result_files.h"
#include "tools/cli/commands.h"

namespace panelcal::batch {

/// Makes the store of a batch or of its shard, under another name first: it is whole or not there.
///
/// Fails  device-write
Expected<Store> begin_store(const ResultFolder& folder, const StoredBatch& batch);

/// Opens the store in a folder of results, for queries alone.
///
/// Fails  usage: there is none
Expected<Store> open_results_of(const std::string& folder);

/// Checks that results are those of the batch that is wanted.
///
/// In     folder: stands in the diagnostic; clock: that the options ask for; may be empty
/// Fails  usage: another manifest, other options or another time
Expected<void> check_same_batch(const StoredBatch& stored,
                                const StoredBatch& wanted,
                                const std::string& folder,
                                const std::string& clock);

/// Puts the stores of all shards that are there into the batch's own, and removes them.
///
/// Out    the number of jobs; a merge that was ended goes on with a second call
/// Fails  output-in-use (a shard is still at work); usage (one of another batch); device-write
/// See    tests/tools/batch_shard_test.py
Expected<std::int64_t> gather_shards(Store& store, const ResultFolder& folder);

/// The work of this start of a batch.
struct DoneNow {
  std::int64_t n_jobs = 0;
  double seconds = 0;
};

/// The files of an answer's facts.
struct AnswerFiles {
  FactsFiles facts;
  std::string metrics = {};  ///< for Prometheus; empty: none
};

/// Says and states what a batch has come to; the exit code is that of all jobs that are done.
Expected<Answer> answer_of(Store& store,
                           const DoneNow& now,
                           const AnswerFiles& files,
                           CommandContext& context);

}  // namespace panelcal::batch
