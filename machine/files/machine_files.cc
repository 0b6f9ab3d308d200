// SPDX-License-Identifier: Apache-2.0
#include "machine/files/machine_files.h"

#include <algorithm>
#include <array>
#include <string>
#include <system_error>
#include <utility>

#include "calib/base/files/atomic_file.h"
#include "calib/base/json/facts.h"
#include "machine/config/machine_config.h"
#include "machine/config/settings/coupon_options.h"
#include "machine/config/toml/toml_table.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

namespace fs = std::filesystem;

/// Walks over the texts of a machine.toml.
class MachineFiles {
 public:
  MachineFiles(const fs::path& machine_toml, FileRegister& files, std::string_view except)
      : folder_(machine_toml.parent_path()),
        name_(machine_toml.filename().string()),
        files_(files),
        except_(except) {}

  void add_all(const toml::table& document) {
    // Those that a night makes, which need not exist yet.
    const auto ledger = document["ledger"]["file"].value<std::string>();
    if (ledger && !ledger->empty()) add_ledger(folder_ / *ledger, "the ledger of " + name_, files_);
    if (document.contains("coupon")) {
      const auto state = document["coupon"]["state"].value<std::string>();
      files_.add(folder_ / (state ? fs::path(*state) : Coupon().state_file),
                 "the coupon's state of " + name_);
    }
    add_table(document, "");
  }

  /// Of a text that is no TOML, whatever stands in quotes.
  void add_quoted(std::string_view text) {
    for (auto begin = text.find('"'); begin != text.npos; begin = text.find('"', begin + 1)) {
      const auto end = text.find_first_of("\"\n", begin + 1);
      if (end == text.npos) return;
      add_text(std::string(text.substr(begin + 1, end - begin - 1)), "a file of " + name_);
    }
  }

 private:
  void add_table(const toml::table& table, const std::string& path) {
    for (const auto& [key, node] : table) {
      add_node(node, path, std::string(key.str()));
    }
  }

  void add_node(const toml::node& node, const std::string& path, const std::string& key) {
    if (const toml::table* const table = node.as_table()) {
      add_table(*table, path.empty() ? key : path + "." + key);
    } else if (const toml::array* const array = node.as_array()) {
      for (const toml::node& element : *array) add_node(element, path, key);
    } else if (const auto text = node.value<std::string>()) {
      if (path + "." + key != except_)
        add_text(*text, fmt::format("[{}] {} of {}", path, key, name_));
    }
  }

  void add_text(const std::string& text, const std::string& what) {
    if (text.empty() || text.find('\0') != std::string::npos) return;
    add_camera(text, what, files_);
    // Programs of commands are looked for here, all other files beside machine.toml.
    for (const fs::path& file : {folder_ / text, fs::path(text)}) {
      std::error_code ignored;
      if (fs::is_regular_file(file, ignored)) files_.add(file, what);
    }
  }

  fs::path folder_;
  std::string name_;
  FileRegister& files_;
  std::string_view except_;
};

/// "2026-11-21" or "2026-11-21-2", as tools/nightly names them.
bool is_night_name(std::string_view stem) {
  constexpr std::string_view kDay = "0000-00-00";
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  if (stem.size() < kDay.size()) return false;
  for (std::size_t i = 0; i < kDay.size(); ++i) {
    if (kDay[i] == '-' ? stem[i] != '-' : !is_digit(stem[i])) return false;
  }
  stem.remove_prefix(kDay.size());
  return stem.empty() ||
         (stem.size() > 1 && stem[0] == '-' && std::ranges::all_of(stem.substr(1), is_digit));
}

constexpr std::string_view kNightFacts = "{\"facts\":\"night\",";
/// Of pages from before they carried their facts; a job's report began with the program.
constexpr std::string_view kHeading = "<h1>";
constexpr std::string_view kNightHeading = "<h1>Night of <b>";
constexpr std::size_t kMaxPageBytes = std::size_t{1} << 28;

/// A page that is damaged is a night's as well as another's.
bool is_page_of_something_else(const fs::path& file) {
  const auto page = read_file(file, kMaxPageBytes);
  if (!page) return false;
  const std::string_view document = facts::in_page(*page);
  if (!document.empty()) return !document.starts_with(kNightFacts);
  const std::size_t at = page->find(kHeading);
  return at != std::string::npos && !std::string_view(*page).substr(at).starts_with(kNightHeading);
}

}  // namespace

void add_machine_files(const fs::path& machine_toml, FileRegister& files, std::string_view except) {
  files.add(machine_toml, "the machine file");
  const Expected<std::string> text = read_file(machine_toml, kMaxConfigBytes);
  if (!text) return;
  MachineFiles machine(machine_toml, files, except);
  const auto document = internal::parse_toml({machine_toml.string(), std::string_view(*text)});
  if (document) {
    machine.add_all(*document);
  } else {
    machine.add_quoted(*text);
  }
}

bool is_night_record(const fs::path& file) {
  const std::string ending = file.extension().string();
  if (!is_night_name(file.stem().string())) return false;
  return ending == ".json" || (ending == ".html" && !is_page_of_something_else(file));
}

void add_night_records(const fs::path& reports, FileRegister& files, std::string_view except) {
  if (reports.empty()) return;
  std::error_code error;
  for (fs::directory_iterator at(reports, error), end; !error && at != end; at.increment(error)) {
    if (!is_night_record(at->path())) continue;
    if (!except.empty() && at->path().stem().string().starts_with(except)) continue;
    files.add(at->path(), "the record of a night");
  }
}

void add_ledger(const fs::path& ledger, const std::string& what, FileRegister& files) {
  files.add(ledger, what);
  constexpr std::array<std::pair<const char*, const char*>, 4> kBeside = {
      {{".lock", "the lock"},
       {"-journal", "the journal"},
       {"-wal", "the journal"},
       {"-shm", "the journal"}}};
  for (const auto& [ending, part] : kBeside) {
    fs::path beside = ledger;
    beside += ending;
    files.add(beside, fmt::format("{} of {}", part, what));
  }
}

void add_camera(std::string_view address, const std::string& what, FileRegister& files) {
  const auto rest_of = [&](std::string_view scheme) {
    return address.starts_with(scheme) ? fs::path(address.substr(scheme.size())) : fs::path();
  };
  if (const fs::path folder = rest_of("folder:"); !folder.empty()) files.add_folder(folder, what);
  if (const fs::path video = rest_of("video:"); !video.empty()) files.add(video, what);
}

}  // namespace panelcal
