// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>

// Pages of `panelcal batch`: example, explanation and exit codes.
namespace panelcal::pages {

inline constexpr std::string_view kBatch = R"(Example
  $ cat jobs.csv
  id,program,machine,images,truth,noise
  a,panel.exc,machine.toml,a/images,a/images/truth.json,2
  b,panel.exc,machine.toml,b/images,b/images/truth.json,4
  $ panelcal batch jobs.csv -o results
  2 jobs: 2 drilled, 0 held, 0 failed; 2 now in 0.3 s
  $ panelcal batch show results
  $ panelcal batch report results -o page.html

Does each job as `panelcal run` does it, in one process on all cores. Columns: program; machine, or
-m; images or measurements; and id, probes, truth, clock, output where they are wanted. Any other
column is a factor of an experiment: it is kept, and errors are compared by its values. Names count
from the manifest's folder. A row may as well be a JSON object, a line each. --pattern 'jobs/*'
takes folders instead, each with a program and images/images.csv or measurements.jsonl.

The results are jobs/ID/corrected.drl (or where the column output says), jobs/ID/facts.json (as
`run --json` writes it, without pieces of pictures, with --places every hole) and store.sqlite, a
database of jobs, targets, fits, holes, diagnostics and pictures (docs/formats/store.md). They are
the same, byte for byte, for any number of threads. A job that fails is a row with its reason, and
stops no other one.

A batch that was ended, by kill -9 too, goes on with --resume where it was: files are on disk before
a row says that a job is done. A folder has one batch; a manifest that has changed is another one.
--only failed does those jobs again. --sample 100 takes a hundred jobs, later ones with --resume.

On a cluster: `--engine slurm --shards 64` submits an array whose tasks each do a part of the jobs,
follows it, submits again what ended before it was done, and puts the results together; they are
the same, byte for byte. The folder, the manifest and panelcal have to stand on a disk that all
nodes share. SBATCH_PARTITION, SBATCH_TIMELIMIT and such in the environment decide where the tasks
run. After a kill of this process --resume follows the same array. `--engine parallel | sh` does
it by GNU parallel; `--shard 3/8` is one part, for any other scheduler (docs/howto/cluster.md).
--store postgresql://drill@db/panelcal brings every job into a database of many batches besides, as it
is done; the results stay whole without it, and `panelcal batch push` brings what is missing there.
--metrics batch.prom writes what came of it for Prometheus (docs/howto/metrics.md).

Exit codes (over all jobs that are done; a shard ends with 0 when its jobs are done)
  0 all were drilled; 1 some were held by gates or tolerances; 2 some failed, or bad input or usage;
  3 some failed by a device, or the disk failed: the batch ended, go on with --resume;
  129, 130, 143 SIGHUP, SIGINT or SIGTERM came: what was done is kept, go on with --resume)";

inline constexpr std::string_view kBatchPush = R"(Example
  $ panelcal batch push results --store postgresql://drill@db.shop/panelcal
  30 jobs put into postgresql://drill@db.shop/panelcal
  $ psql -h db.shop -U drill panelcal -c 'SELECT * FROM panelcal.refusals'

Brings the jobs of a batch into a database that has those of many batches, with their targets, fits,
holes, diagnostics and pictures (docs/formats/gathered.md): PostgreSQL, or a file of SQLite. It makes
the tables where there are none. Jobs that are there as they are here are not sent again, so that a
push that was ended anywhere is finished by another one. PGPASSFILE, or ~/.pgpass, has passwords: on
the command line every user of the computer sees them.

Exit codes
  0 done; 2 bad input or usage; 3 the database cannot be reached or written)";

inline constexpr std::string_view kBatchMerge = R"(Example
  $ panelcal batch jobs.csv -o results --clock 2026-11-27T12:00:00 --shard 1/2
  $ panelcal batch jobs.csv -o results --clock 2026-11-27T12:00:00 --shard 2/2
  $ panelcal batch merge results
  30 jobs: 28 drilled, 1 held, 1 failed; 30 now in 0.1 s

Puts the stores of shards (RESULTS/shards/) into RESULTS/store.sqlite, and removes them. A shard
that is still at work is not touched: the command fails. Jobs that no shard has done are missing
afterwards; `panelcal batch ... --resume` does them. Started again after a kill, it goes on.

Exit codes
  as `panelcal batch`, over all jobs that are done)";

inline constexpr std::string_view kBatchReport = R"(Example
  $ panelcal batch report results -o page.html

One page: how many jobs were drilled and why the others were not, how many targets were found, a
histogram of errors against truth beside the predicted one, whether chi squares are as they should
be, errors by factor, the twenty worst targets with their pictures (as far as these are still
there), throughput. --json writes the same as one document (share/schema/batch.schema.json).

Exit codes
  0 done; 2 no results of a batch; 3 the page could not be written)";

inline constexpr std::string_view kBatchShow = R"(Example
  $ panelcal batch show results
  2 jobs of jobs.csv: 2 drilled, 0 held, 0 failed, 0 missing

Prints the same facts as words, also while the batch is running. Questions of your own:
  $ sqlite3 results/store.sqlite 'SELECT * FROM refusals'

Exit codes
  0 done; 2 no results of a batch)";

}  // namespace panelcal::pages
