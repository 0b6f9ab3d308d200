// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/facts_output.h"

#include <algorithm>

namespace panelcal {

Answer state_facts(CommandContext& context,
                   const FactsFiles& files,
                   const std::string& title,
                   const std::function<std::string()>& document,
                   Answer answer,
                   const PagePictures& pictures) {
  if (!files.any()) return answer;
  const std::string facts = document();
  const auto write = [&](const std::string& file, const std::string& bytes) {
    const Expected<void> done = context.output.write_to(file, bytes);
    if (done) return;
    context.console.print(done.error());
    answer.code = std::max(answer.code, exit_code(done.error()));
  };
  if (!files.json.empty()) write(files.json, facts);
  if (!files.report.empty()) write(files.report, page_html(title, facts, pictures));
  if (files.use_standard_output()) answer.text.clear();
  return answer;
}

}  // namespace panelcal
