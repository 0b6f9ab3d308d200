// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "machine/job/summary/truth_comparison.h"
#include "program/judge/job_verdict.h"

namespace panelcal {

/// The figures of one tool's places, as tables show them. Actual figures are against truth, of
/// holes alone.
struct ToolRow {
  int tool = 0;
  const JobVerdict::ToolFigures* predicted = nullptr;
  const ErrorStatistics* actual = nullptr;  ///< null without truth, and of a tool without holes
};
std::vector<ToolRow> tool_rows(const JobVerdict& verdict, const TruthComparison* truth);

/// "1.67"; "-" where there is no tolerance or no scatter.
std::string cpk_text(const RadialFigures& figures, std::optional<Length> tolerance);

/// The same of predicted figures; "none" where the job's risks are not known.
std::string cpk_text(const JobVerdict::ToolFigures& tool, const RiskBasis& basis);

/// A table with one row a tool, and the verdict in one line behind it.
std::string verdict_summary(const JobVerdict& verdict, const TruthComparison* truth);

}  // namespace panelcal
