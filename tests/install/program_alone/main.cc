// SPDX-License-Identifier: Apache-2.0
#include <panelcal/program/judge/tally.h>
#include <panelcal/program/walk/walk.h>

int main() {
  panelcal::DiagnosticLog log;
  const auto job =
      panelcal::load_program({"job", "M48\nMETRIC,TZ\nT1C0.8\n%\nT1\nX1.0Y2.0\nM30\n"}, log);
  panelcal::NominalSource source;
  const auto survey = panelcal::survey(job, {}, source, log);
  panelcal::Tally tally;
  panelcal::execute(job, {}, survey, tally, log);
  return tally.n_holes() == 1 && !log.has_errors() ? 0 : 1;
}
