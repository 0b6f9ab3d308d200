// SPDX-License-Identifier: Apache-2.0
#include <cstdio>
#include <vector>

#include <panelcal/panelcal.h>

/// Keeps the holes of a job, as its operations pass.
struct Holes final : panelcal::OperationSink {
  void put(const panelcal::Operation& operation) override {
    if (const auto* hole = std::get_if<panelcal::Drill>(&operation.what)) all.push_back(*hole);
  }
  std::vector<panelcal::Drill> all;
};

/// holes PROGRAM MACHINE.TOML PICTURES: where to drill, from work zero, in mm.
int main(int n, char** arguments) {
  if (n != 4) return 2;
  const auto refuse = [](const panelcal::Diagnostic& problem) {
    std::fprintf(stderr, "%s\n", problem.text().c_str());
    return 1;
  };
  const auto machine = panelcal::read_machine_config(arguments[2]);
  if (!machine) return refuse(machine.error());
  const auto job = panelcal::read_job(arguments[1], *machine, panelcal::system_clock()());
  if (!job) return refuse(job.error());
  const auto open = [&](const panelcal::Survey& asked) {
    return panelcal::open_sources({.images = arguments[3]}, *machine, asked);
  };
  Holes holes;
  const auto result = panelcal::correct(*job, open, *machine, {.operations = &holes});
  if (!result) return refuse(result.error());
  if (!result->may_be_drilled()) return refuse(result->refusal());
  for (const panelcal::Drill& hole : holes.all) {
    std::printf(
        "T%d X%.4f Y%.4f\n", hole.tool, hole.commanded.in_mm().x(), hole.commanded.in_mm().y());
  }
}
