// SPDX-License-Identifier: Apache-2.0
#include "machine/check/file_rules.h"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "calib/table/calibration_file.h"
#include "machine/files/machine_files.h"
#include "surface/map/file.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

namespace fs = std::filesystem;

/// A key that names a file which nights replace.
struct NightFile {
  std::string_view key;       ///< as StatedKeys has it
  std::string_view in_words;  ///< "file in [nightly.surface]"
  std::string_view content;   ///< "a map of the surface"
  const fs::path& file;
};

bool is_in_picture_folder(const fs::path& file) {
  std::error_code ignored;
  const fs::path real = fs::weakly_canonical(fs::absolute(file, ignored), ignored);
  return fs::exists(real.parent_path() / "images.csv", ignored);
}

/// The use that machine.toml has for the file under another key; nothing if there is none.
std::optional<std::string> other_use(const MachineConfig& config, const NightFile& of) {
  FileRegister files;
  add_machine_files(config.file, files, of.key);
  // Not there before the first night, when machine.toml's texts lead to no file.
  const fs::path& spindle = config.spindle_setting.file;
  if (!spindle.empty()) files.add(spindle, "[spindle] calibration");
  if (auto use = files.use_of(of.file)) return use;
  if (is_in_picture_folder(of.file)) return "in a folder of pictures";
  return std::nullopt;
}

/// In     is_content: what stands there is of the kind that the nights write
template <class IsContent>
void check_night_file(const MachineConfig& config,
                      const NightFile& night_file,
                      IsContent is_content,
                      const StatedKeys& keys,
                      DiagnosticLog& log) {
  if (night_file.file.empty()) return;
  const auto refuse = [&](std::string_view why) {
    log.add(
        {Code::ConfigValue,
         keys.place(night_file.key),
         fmt::format(
             "{} is {}, {}", night_file.in_words, quoted(night_file.file.filename().string()), why),
         fmt::format("a file of its own for {}, which nights replace", night_file.content)});
  };
  if (const auto use = other_use(config, night_file)) return refuse(*use);
  std::error_code ignored;
  if (!fs::exists(night_file.file, ignored) || is_content(night_file.file)) return;
  refuse(fmt::format("which is not {}", night_file.content));
}

void check_reports(const MachineConfig& config, const StatedKeys& keys, DiagnosticLog& log) {
  const fs::path& folder = config.nightly->reports;
  if (folder.empty()) return;
  const auto refuse = [&](std::string_view why) {
    log.add({Code::ConfigValue,
             keys.place("nightly.reports"),
             fmt::format("reports in [nightly] is {}, {}", quoted(folder.filename().string()), why),
             "a folder of its own for the nights' pages"});
  };
  FileRegister files;
  add_machine_files(config.file, files, "nightly.reports");
  std::error_code ignored;
  if (const auto use = files.use_of(folder)) return refuse(*use);
  if (fs::exists(folder, ignored) && !fs::is_directory(folder, ignored)) {
    return refuse("which is a file");
  }
  if (is_in_picture_folder(folder / "page")) refuse("a folder of pictures");
}

}  // namespace

void check_file_rules(const MachineConfig& config, const StatedKeys& keys, DiagnosticLog& log) {
  if (!config.nightly) return;
  check_reports(config, keys, log);
  check_night_file(
      config,
      {"nightly.surface.file",
       "file in [nightly.surface]",
       "the map of the surface",
       config.nightly->surface.file},
      [](const fs::path& file) { return read_map_file(file).has_value(); },
      keys,
      log);
  // Where [table] names it, it is the same file, and has been read.
  if (!config.table_file.empty()) return;
  check_night_file(
      config,
      {"nightly.table.file",
       "file in [nightly.table]",
       "the table's calibration",
       config.nightly->table.file},
      [](const fs::path& file) { return read_table_calibration(file).has_value(); },
      keys,
      log);
}

}  // namespace panelcal
