// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/provenance.h"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <system_error>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/base/files/digest.h"
#include "calib/ledger/ledger.h"
#include "machine/devices/cameras/camera_uri.h"
#include "tools/cli/process/version.h"
#include "tools/gather/address.h"

namespace panelcal {

std::pair<std::string, std::string> command_line_row(const Options& options) {
  std::string command_line;
  bool is_number = false;
  for (const std::string& word : options.command_line) {
    // No result depends on the number of threads.
    const bool is_left_out = std::exchange(is_number, word == "--threads");
    if (is_left_out || is_number || word.starts_with("--threads=")) continue;
    // The path of panelcal's installation is no fact about the job.
    command_line += command_line.empty()
                        ? "panelcal"
                        : " " + gather::without_database_password(without_password(word));
  }
  return {"command line", command_line};
}

Provenance provenance_of(const Options& options,
                         const Program& program,
                         const std::vector<std::string>& files) {
  Provenance provenance = {{"made by", std::string("panelcal ") + kVersion},
                           command_line_row(options),
                           {"sha256 " + program.source.file, sha256(program.source.bytes)}};
  std::vector<std::string> read = {program.head->format_file};
  read.insert(read.end(), files.begin(), files.end());
  std::ranges::move(file_digests(read), std::back_inserter(provenance));
  return provenance;
}

Provenance file_digests(const std::vector<std::string>& files) {
  Provenance rows;
  for (const std::string& file : files) {
    if (file.empty()) continue;
    if (const auto bytes = read_file(file)) rows.emplace_back("sha256 " + file, sha256(*bytes));
  }
  return rows;
}

Provenance ledger_head_row(const std::filesystem::path& ledger) {
  std::error_code ignored;
  if (ledger.empty() || !std::filesystem::exists(ledger, ignored)) return {};
  const auto opened = Ledger::open_to_read(ledger);
  const auto head = opened ? opened->head() : Expected<LedgerHead>(failure(opened.error()));
  return {
      {"ledger head",
       head ? fmt::format("{} {}", head->id, head->hash) : "not known: " + head.error().text()}};
}

std::string asking_person(const std::string& given) {
  if (!given.empty()) return given;
  const char* user = std::getenv("USER");
  return user != nullptr && *user != '\0' ? user : "unknown";
}

std::vector<std::string> comment_lines(const Provenance& provenance) {
  std::vector<std::string> lines;
  for (const auto& [key, value] : provenance) lines.push_back(key + ": " + value);
  return lines;
}

std::string amount(const Tally& tally) {
  std::string text = amount(tally.n_holes(), "hole");
  if (tally.n_slots() > 0) text += ", " + amount(tally.n_slots(), "slot");
  if (tally.n_routs() > 0) text += ", " + amount(tally.n_routs(), "rout move");
  return text;
}

}  // namespace panelcal
