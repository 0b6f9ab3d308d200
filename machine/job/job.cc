// SPDX-License-Identifier: Apache-2.0
#include "machine/job/job.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "machine/job/checked_program.h"

namespace panelcal {

Diagnostic JobResult::refusal() const {
  const auto is_error = [](const Diagnostic& diagnostic) {
    return diagnostic.severity() == Severity::Error;
  };
  const auto is_no_limit = [&](const Diagnostic& diagnostic) {
    return is_error(diagnostic) && info(diagnostic.code).fault != Fault::Gate;
  };
  const auto kept = log.kept();
  auto found = std::ranges::find_if(kept, is_no_limit);
  if (found == kept.end()) found = std::ranges::find_if(kept, is_error);
  if (found != kept.end()) return *found;
  return {Code::Internal, {}, "the job was not executed", ""};
}

Expected<Job> read_job(const std::string& path,
                       const MachineConfig& machine,
                       std::chrono::sys_seconds now) {
  Job job;
  std::optional<Program> program = read_program(path, machine.reading, job.reading);
  if (!program) return failure(job.reading.kept().front());
  job.program = *std::move(program);
  job.now = now;
  return job;
}

}  // namespace panelcal
