// SPDX-License-Identifier: Apache-2.0
#include "tools/cli/output_paths.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include "machine/files/machine_files.h"
#include "machine/nightly/record/night_files.h"
#include "program/sieb_meyer/sections/subprograms.h"
#include <fmt/format.h>

namespace panelcal {
namespace {

using Path = std::filesystem::path;

constexpr const char* kPictureList = "images.csv";

bool is_output(const FileOption& file) {
  return file.use == FileUse::Output || file.use == FileUse::OutputFolder ||
         file.use == FileUse::SynthFolder;
}

Expected<void> refuse(const Options& options, std::string what) {
  return failure({Code::OutputInUse,
                  {options.command_name, 0, 0},
                  std::move(what),
                  "a file of its own for each output"});
}

/// Files appear whole under their names: a device or a pipe cannot be replaced.
Expected<void> check_replaceable(const Options& options, const std::string& output) {
  std::error_code ignored;
  const auto status = std::filesystem::status(output, ignored);
  if (!std::filesystem::exists(status) || std::filesystem::is_regular_file(status) ||
      std::filesystem::is_directory(status)) {
    return {};
  }
  return failure({Code::Usage,
                  {options.command_name, 0, 0},
                  quoted(output) + " is a device or a pipe",
                  "a regular file, or - for standard output"});
}

std::string_view installed_key(const Options& options) {
  const auto* const calibrate = std::get_if<CalibrateOptions>(&options.command);
  return calibrate != nullptr && calibrate->install ? calibrate->installed_key : std::string_view();
}

bool is_picture_folder(const Path& folder) {
  std::error_code ignored;
  return std::filesystem::exists(folder / kPictureList, ignored);
}

/// Of an earlier synth all pictures go, whatever they are: none of them may be in use.
Expected<void> check_synth_folder(const Options& options,
                                  const FileRegister& files,
                                  const Path& folder) {
  std::error_code error;
  for (std::filesystem::directory_iterator at(folder, error), end; !error && at != end;
       at.increment(error)) {
    const Path& file = at->path();
    const bool is_picture =
        file.extension() == ".png" || file.extension() == ".csv" || file.extension() == ".json";
    if (!is_picture) continue;
    if (const auto use = files.use_of(file)) {
      return refuse(options, fmt::format("{} is {}", quoted(file.string()), *use));
    }
  }
  return {};
}

/// True if two names lead to one file.
bool is_same_file(const Path& one, const Path& other) {
  FileRegister files;
  files.add(one, "");
  return files.use_of(other).has_value();
}

}  // namespace

std::string extension_of(const Path& path) {
  std::string extension = path.extension().string();
  std::ranges::transform(extension, extension.begin(), [](char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  });
  return extension;
}

Expected<void> check_extension(const std::string& command,
                               const std::string& name,
                               std::string_view extension) {
  if (name.empty() || extension_of(name) == extension) return {};
  return failure({Code::Usage,
                  {command, 0, 0},
                  "no format belongs to the output's name " + quoted(name),
                  "a name that ends in " + std::string(extension)});
}

FileRegister files_in_use(const Options& options) {
  FileRegister files;
  for (const FileOption& file : options.files) {
    if (file.path.empty()) continue;
    switch (file.use) {
      case FileUse::Read:
        files.add(file.path, file.what);
        break;
      case FileUse::Machine:
        add_machine_files(file.path, files, installed_key(options));
        // A night knows which one is its own (tools/nightly).
        if (!std::holds_alternative<NightlyOptions>(options.command)) {
          const auto night_files = find_night_files(file.path);
          if (night_files) add_night_records(night_files->reports, files);
        }
        break;
      case FileUse::Ledger:
        add_ledger(file.path, file.what, files);
        break;
      case FileUse::Camera:
        add_camera(file.path, file.what, files);
        break;
      case FileUse::Pictures:
        files.add_folder(file.path, file.what);
        break;
      case FileUse::Output:
      case FileUse::OutputFolder:
      case FileUse::SynthFolder:
        break;
    }
  }
  return files;
}

Expected<void> check_output(const Options& options, const FileRegister& files, const Path& output) {
  if (const auto use = files.use_of(output)) {
    return refuse(options, fmt::format("{} is {}", quoted(output.string()), *use));
  }
  // A link leads to where the output is written.
  std::error_code ignored;
  const Path real = std::filesystem::weakly_canonical(std::filesystem::absolute(output), ignored);
  if (is_picture_folder(real.parent_path())) {
    return refuse(options, quoted(output.string()) + " is in a folder of pictures");
  }
  return {};
}

Expected<void> check_outputs(const Options& options, const FileRegister& files) {
  std::vector<std::string> taken;
  for (const FileOption& file : options.files) {
    const std::string& output = file.path;
    if (!is_output(file) || output.empty()) continue;
    const auto is_this = [&](const std::string& other) {
      return other == output || (other != "-" && output != "-" && is_same_file(other, output));
    };
    if (std::ranges::any_of(taken, is_this)) {
      return refuse(options, quoted(output) + " is named twice on the command line");
    }
    taken.push_back(output);
    // Standard output is no input, whatever it is called.
    if (output == "-") continue;
    PANELCAL_CHECK(check_replaceable(options, output));
    PANELCAL_CHECK(check_output(options, files, output));
    if (file.use == FileUse::SynthFolder) {
      PANELCAL_CHECK(check_synth_folder(options, files, output));
    } else if (is_picture_folder(output)) {
      return refuse(options, quoted(output) + " is a folder of pictures");
    }
  }
  return {};
}

bool add_pattern_files(const Program& program, FileRegister& files) {
  const std::string& beside = program.reading.format_beside.file;
  const bool has_subprograms = program.dialect == Dialect::SiebMeyer;
  if (beside.empty() && program.patterns.empty() && !has_subprograms) return false;
  if (!beside.empty()) files.add(beside, "the number format of the drill files beside it");
  for (const auto& [name, text] : program.patterns) files.add(text.file, "a stored pattern");
  if (has_subprograms) {
    for (const Path& file : sieb_meyer::files_read_for_subprograms(
             program.source.bytes, program.reading.pattern_folders)) {
      files.add(file, "a file of subprograms");
    }
  }
  return true;
}

Expected<void> check_patterns(const Options& options, const Program& program, FileRegister& files) {
  return add_pattern_files(program, files) ? check_outputs(options, files) : Expected<void>();
}

}  // namespace panelcal
