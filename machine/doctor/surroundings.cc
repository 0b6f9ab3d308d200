// SPDX-License-Identifier: Apache-2.0
// Programs, files and the disk that machine.toml names.
#include <cstdlib>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>

#include "calib/ledger/ledger.h"
#include "machine/doctor/checks.h"
#include "machine/nightly/checks/self_test.h"
#include "machine/nightly/record/night_lock.h"
#include <fmt/format.h>
#include <unistd.h>

namespace panelcal::doctor {
namespace {

namespace fs = std::filesystem;

bool is_executable(const fs::path& file) {
  std::error_code ignored;
  return fs::is_regular_file(file, ignored) && ::access(file.c_str(), X_OK) == 0;
}

/// The file that a program's name means, as run_program finds it; empty: none.
fs::path program_file(const std::string& program) {
  if (program.find('/') != std::string::npos) {
    return is_executable(program) ? fs::path(program) : fs::path();
  }
  const char* const path = std::getenv("PATH");
  std::string_view rest = path == nullptr ? "/bin:/usr/bin" : path;
  while (true) {
    const std::string_view folder = rest.substr(0, rest.find(':'));
    const fs::path file = fs::path(folder.empty() ? "." : folder) / program;
    if (is_executable(file)) return file;
    if (folder.size() == rest.size()) return {};
    rest.remove_prefix(folder.size() + 1);
  }
}

void check_program(std::string_view key, const CommandWords& words, Findings& findings) {
  if (words.empty()) return;
  const std::string subject = "program " + std::string(key);
  if (const fs::path file = program_file(words.front()); !file.empty()) {
    return findings.ok(subject, file.string());
  }
  const bool is_path = words.front().find('/') != std::string::npos;
  findings.fail(
      subject,
      quoted(words.front()) + (is_path ? " cannot be executed" : " is in no folder of PATH"),
      is_path ? "an executable file, as seen from the folder that panelcal is started in"
              : "install it, or name it by its path");
}

/// Where nothing stands yet, the folder that it would be made in.
bool is_writable(fs::path path) {
  std::error_code ignored;
  const bool is_there = fs::exists(path, ignored);
  while (!path.empty() && !fs::exists(path, ignored)) path = path.parent_path();
  if (path.empty()) path = ".";
  return (is_there || fs::is_directory(path, ignored)) && ::access(path.c_str(), W_OK) == 0;
}

void check_writable(const std::string& subject, const fs::path& path, Findings& findings) {
  if (is_writable(path)) return findings.ok(subject, path.string() + " can be written");
  findings.fail(subject,
                path.string() + " cannot be written by this user",
                "a folder that this user may write to");
}

void check_ledger_file(const fs::path& file, Findings& findings) {
  constexpr const char* kSubject = "ledger";
  // SQLite makes its journal beside it.
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  if (!is_writable(file) || !is_writable(folder)) {
    return check_writable(kSubject, is_writable(file) ? folder : file, findings);
  }
  if (const std::string holder = NightLock::holder(file); !holder.empty()) {
    findings.warn(kSubject, "in use: " + holder, "wait until it has ended");
  }
  std::error_code ignored;
  if (!fs::exists(file, ignored)) {
    return findings.ok(kSubject, file.string() + " is not there yet: it will be begun");
  }
  const Expected<LedgerHead> head =
      Ledger::open_to_read(file).and_then([](const Ledger& ledger) { return ledger.verify(); });
  if (!head) return findings.add(kSubject, head.error());
  findings.ok(kSubject, fmt::format("{}: {} entries, all hashes right", file.string(), head->id));
}

}  // namespace

void check_programs(const MachineConfig& config, Findings& findings) {
  const StageCommands& stage = config.stage;
  check_program("[machine] stage_command", stage.move, findings);
  check_program("[machine] drill_command", stage.drill, findings);
  check_program("[machine] lamp_command", stage.lamp, findings);
  check_program("[machine] zoom_command", stage.zoom, findings);
  check_program("[machine] focus_command", stage.focus, findings);
  check_program("[machine] probe_command", stage.probe, findings);
  if (!config.nightly) return;
  check_program("[nightly] temperature_command", config.nightly->temperature_command, findings);
}

void check_files(const MachineConfig& config, Findings& findings) {
  if (!config.ledger_file.empty()) check_ledger_file(config.ledger_file, findings);
  if (config.nightly) {
    if (!config.nightly->reports.empty()) {
      check_writable("reports", config.nightly->reports, findings);
    }
    if (!config.ledger_file.empty()) return;  // the night says it of the ledger's disk
  }
  const SelfTestCheck disk = check_disk(config.file, NightlyConfig().min_disk_mb);
  if (disk.passed) return findings.ok("disk", disk.text);
  findings.fail("disk", disk.text, "remove what is not needed");
}

}  // namespace panelcal::doctor
