// SPDX-License-Identifier: Apache-2.0
#include "tools/locate/answer.h"

#include <utility>

#include "machine/job/facts/sections.h"
#include "tools/cli/facts_output.h"
#include "tools/cli/provenance.h"

namespace panelcal::internal {

Answer locate_answer(const LocateCommandOptions& options,
                     CommandContext& context,
                     const facts::Json& pictures,
                     const DiagnosticLog& log,
                     std::string text) {
  const auto document = [&] {
    constexpr int kLocateVersion = 1;
    facts::Json out = facts::envelope("locate", kLocateVersion);
    const auto& [row, command_line] = command_line_row(context.options);
    out.update({{"tool", options.tool ? facts::Json(*options.tool) : facts::Json()},
                {"pictures", pictures},
                {"messages", facts::messages_json(log.kept())},
                {"provenance", {{row, command_line}}}});
    return facts::text(out);
  };
  return state_facts(context, options.facts, {}, document, {std::move(text), exit_code(log)});
}

}  // namespace panelcal::internal
