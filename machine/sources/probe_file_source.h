// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/expected.h"
#include "machine/sources/recorded_answers.h"

namespace panelcal {

/// A reading as a file has it. The file does not know work zero, so request.work_zero is zero.
using RecordedProbe = internal::RecordedAnswers<ProbeReading>::Entry;

/// The readings of a run, in the order of their first lines.
struct RecordedProbes {
  std::string file;  ///< as diagnostics name it
  std::vector<RecordedProbe> probes;
};

/// Larger files are refused unread.
inline constexpr std::size_t kMaxProbeBytes = std::size_t{1} << 30;

/// Reads probe readings as to_json(ProbeReading) writes them: JSON Lines, one object a line.
///
/// A reading found has one line per Z axis, which agree but for `zaxis`, `height` and `sigma`; they
/// may come in any order and need not be neighbours. A reading not found is one line without these
/// keys. All of a request's keys are required, but file, L and depth. Numbers read back to the bit.
/// Blank lines are allowed.
///
/// Fails  file-unreadable; json-syntax; measurement-file (unknown, missing, misplaced or repeated
///        keys, wrong types, unknown status; lines of one probe that differ; a Z axis that is
///        missing or there twice; readings with different numbers of Z axes); measurement-invalid
///        (a sigma below 0): each with file:line:column
/// See    tests/machine/sources/probe_file_source_test.cc
Expected<RecordedProbes> read_probes(const std::filesystem::path& path);

/// The same from text; `file` stands in the diagnostics. Any bytes give a value or a diagnostic.
Expected<RecordedProbes> parse_probes(std::string_view text, const std::string& file);

/// Answers probe requests from recorded readings.
///
/// Requests are matched by their number; the recorded line, command, tool, path and nominal must be
/// the program's, or the file belongs to another program.
class ProbeFileSource final : public ProbeSource {
 public:
  explicit ProbeFileSource(RecordedProbes recorded);

  /// Fails  measurement-missing; measurement-mismatch
  Expected<ProbeReading> probe(const ProbeRequest& request) override;

  /// After a complete run: fails if the file has a reading that no command asked for.
  ///
  /// Fails  measurement-mismatch, at the first such line
  Expected<void> check_all_used() const { return answers_.check_all_used(); }
  Expected<void> finish() override { return check_all_used(); }

 private:
  internal::RecordedAnswers<ProbeReading> answers_;
};

}  // namespace panelcal
