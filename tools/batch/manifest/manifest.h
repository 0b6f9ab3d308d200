// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "calib/base/expected.h"

namespace panelcal::batch {

/// One job of a batch: a row of its manifest. Files are named as this process can open them.
struct ManifestJob {
  std::int64_t number = 0;  ///< from 1, its place among the jobs
  int line = 0;             ///< of the manifest; 0: of a folder
  std::string id;           ///< the name of its folder in the results
  std::string program;
  std::string machine;
  std::string images;        ///< a folder of pictures; or
  std::string measurements;  ///< a file of recorded measurements; neither: none are needed
  std::string probes;        ///< recorded probe readings; may be empty
  std::string truth;         ///< may be empty
  std::string clock;         ///< as `run --clock`; empty: that of the batch
  std::string output;        ///< empty: in the job's folder
  /// Columns that panelcal does not know, as they are written: conditions of an experiment.
  std::vector<std::pair<std::string, std::string>> factors;
};

struct Manifest {
  std::string file;    ///< or the pattern
  std::string sha256;  ///< of its bytes; of a pattern, of the jobs that it finds
  std::vector<ManifestJob> jobs;
};

/// A name of a folder on any file system, which no shell and no page reads otherwise.
bool is_job_id(std::string_view text);
inline constexpr std::string_view kJobIdWords =
    "at most 100 letters, digits, '.', '_' and '-', the first no point";

/// Values of columns that a manifest leaves out or empty.
struct ManifestDefaults {
  std::string machine;
};

/// Reads a manifest: CSV with a header (RFC 4180, without line breaks in fields) or, where it
/// begins with a brace, JSON Lines. `-` is standard input. Relative names count from the manifest's
/// folder.
///
/// Fails  file-unreadable; json-syntax; usage, with line and column: a column that is nearly a
/// known
///        one or comes twice, a row of another length, a job without program or machine or with two
///        sources, an id that is no name of a folder or comes twice, an output that comes twice
/// See    tests/tools/batch/manifest_test.cc; docs/howto/batch.md
Expected<Manifest> read_manifest(const std::string& path, const ManifestDefaults& defaults);
/// The same of text; `file` stands in the diagnostics, `folder` is where names count from.
Expected<Manifest> parse_manifest(std::string_view text,
                                  const std::string& file,
                                  const std::string& folder,
                                  const ManifestDefaults& defaults);

/// Finds a job in every folder that a shell's pattern names, in the order of their names. A folder
/// has one program (.exc .drl .ncd .nc .xln .s5 .sm .sm3), and may have machine.toml, pictures in
/// images/ or measurements.jsonl, probes.jsonl, and truth.json beside it or its pictures.
///
/// Fails  usage: no folder; a folder without a program, or with two
Expected<Manifest> find_job_folders(const std::string& pattern, const ManifestDefaults& defaults);

/// The numbers of n jobs, in their order: those whose ids have the smallest SHA-256, so that the
/// same jobs are taken on any machine and a larger sample holds the smaller one.
std::vector<std::int64_t> sample_of(const Manifest& manifest, std::size_t n);

}  // namespace panelcal::batch
