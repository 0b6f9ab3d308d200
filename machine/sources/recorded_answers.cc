// SPDX-License-Identifier: Apache-2.0
#include "machine/sources/recorded_answers.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal::internal {
namespace {

/// Recorded and requested nominals come from the same arithmetic; this only forgives printing.
constexpr double kSameNominal_mm = 1e-6;

std::string nominal_text(const Position<frame::Nominal>& nominal) {
  return fmt::format("nominal [{}, {}]", nominal.in_mm().x(), nominal.in_mm().y());
}

/// The property in which a recorded request differs from the program's, in words of each.
struct RequestDifference {
  std::string recorded;
  std::string requested;
};

std::optional<RequestDifference> difference(const RequestIdentity& recorded,
                                            const RequestIdentity& requested) {
  const auto differs = [](std::string_view what, const auto& a, const auto& b) {
    return RequestDifference{fmt::format("{} {}", what, a), fmt::format("{} {}", what, b)};
  };
  if (recorded.command != requested.command) {
    return differs("command", quoted(recorded.command), quoted(requested.command));
  }
  if (!is_same_pattern(recorded.pattern, requested.pattern)) {
    return differs("file", pattern_text(recorded.pattern), pattern_text(requested.pattern));
  }
  if (recorded.line != requested.line) return differs("line", recorded.line, requested.line);
  if (recorded.tool != requested.tool) {
    return differs(recorded.tool_words, recorded.tool, requested.tool);
  }
  if (recorded.path != requested.path) {
    return differs("path",
                   fmt::format("[{}]", fmt::join(recorded.path, ",")),
                   fmt::format("[{}]", fmt::join(requested.path, ",")));
  }
  const Displacement<frame::Nominal> apart = recorded.nominal - requested.nominal;
  // Written so that a NaN differs.
  if (!(apart.in_mm().norm() <= kSameNominal_mm)) {
    return RequestDifference{nominal_text(recorded.nominal), nominal_text(requested.nominal)};
  }
  return std::nullopt;
}

}  // namespace

RequestIdentity identity(const MeasurementRequest& request) {
  const std::vector<int>& tools = request.settings.tools;
  return {request.command,
          request.pattern(),
          request.line,
          "vision tool",
          tools.empty() ? 0 : tools.front(),
          request.path,
          request.nominal};
}

RequestIdentity identity(const ProbeRequest& request) {
  return {request.command,
          request.pattern(),
          request.line,
          "tool",
          request.tool,
          request.path,
          request.nominal};
}

Diagnostic missing_answer(const std::string& file, std::string number, std::string wanted) {
  return {Code::MeasurementMissing, {file, 0, 0}, std::move(number), std::move(wanted)};
}

Diagnostic unused_answer(const std::string& file, int line, const std::string& request) {
  return {Code::MeasurementMismatch,
          {file, line, 1},
          "the program does not ask for " + request,
          "only what the program asks for"};
}

std::optional<Diagnostic> other_request(const RequestIdentity& recorded,
                                        const RequestIdentity& requested,
                                        const std::string& number,
                                        const Place& place) {
  const auto differs = difference(recorded, requested);
  if (!differs) return std::nullopt;
  return Diagnostic{Code::MeasurementMismatch,
                    place,
                    fmt::format("{} has {}", number, differs->recorded),
                    differs->requested + ", as the program has it"};
}

}  // namespace panelcal::internal
