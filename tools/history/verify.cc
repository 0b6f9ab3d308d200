// SPDX-License-Identifier: Apache-2.0
#include "tools/history/verify.h"

#include <algorithm>
#include <system_error>
#include <utility>
#include <vector>

#include "calib/base/amount.h"
#include "machine/nightly/record/night_files.h"
#include "machine/nightly/record/noted_heads.h"
#include "tools/cli/output_paths.h"
#include "tools/cli/provenance.h"
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace panelcal::history {
namespace {

namespace fs = std::filesystem;

/// Of machine.toml those that are there; of the command line all, which have to be.
Expected<std::vector<fs::path>> named_files(const HistoryOptions& options) {
  std::vector<fs::path> files(options.against.begin(), options.against.end());
  if (options.machine_file.empty()) return files;
  PANELCAL_TRY(const NightFiles named, find_night_files(options.machine_file));
  for (const fs::path& file : named.that_note_the_head()) {
    std::error_code ignored;
    if (fs::exists(file, ignored)) files.push_back(file);
  }
  return files;
}

std::string verify_text(const LedgerHead& head, const NotingFiles& held) {
  std::string text = fmt::format("{} entries, undamaged; head {}\n", head.id, head.hash);
  if (!held.noted.empty()) {
    const auto newest = std::ranges::max_element(
        held.noted, {}, [](const NotedFile& file) { return file.head.id; });
    text += fmt::format("held against {} with a noted head; the newest is {}, of entry {}\n",
                        amount(held.noted.size(), "file"),
                        quoted(newest->file.string(), 200),
                        newest->head.id);
  }
  if (held.n_without > 0) text += amount(held.n_without, "file") + " without a head\n";
  return text;
}

}  // namespace

Expected<AnswerPart> verify_answer(const HistoryOptions& options,
                                   CommandContext& context,
                                   const Ledger& ledger) {
  PANELCAL_TRY(const std::vector<fs::path> named, named_files(options));
  PANELCAL_TRY(const std::vector<fs::path> files, files_below(named));
  for (const fs::path& file : files) {
    context.files.add(file, "a file that the ledger is held against");
  }
  PANELCAL_CHECK(check_outputs(context.options, context.files));
  PANELCAL_TRY(const LedgerHead head, ledger.verify());
  PANELCAL_TRY(const NotingFiles held, read_noting_files(files));
  PANELCAL_TRY(const std::vector<std::string> missing, missing_entries(ledger, held.noted));
  if (!missing.empty()) {
    return failure({Code::LedgerCutOff,
                    {options.ledger, 0, 0},
                    fmt::format("{}", fmt::join(missing, "; ")),
                    "every entry that was there when these files were written"});
  }
  return AnswerPart{verify_text(head, held), verify_facts(head, held)};
}

}  // namespace panelcal::history
