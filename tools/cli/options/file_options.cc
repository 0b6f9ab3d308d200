// SPDX-License-Identifier: Apache-2.0
// Like command_line.cc it includes CLI11: seconds to compile.
#include "tools/cli/options/file_options.h"

#include <algorithm>
#include <array>
#include <string_view>

#include <CLI/CLI.hpp>

namespace panelcal {
namespace {

struct Row {
  std::string_view option;
  FileUse use;
  std::string_view what;  ///< of inputs: "FILE is ..."
};

constexpr auto kFileOptions = std::to_array<Row>({
    {"PROGRAM", FileUse::Read, "the program"},
    {"--program", FileUse::Read, "the program"},
    {"MANIFEST", FileUse::Read, "the manifest"},
    {"GCODE", FileUse::Read, "the program"},
    {"MAP", FileUse::Read, "the map"},
    {"PROBES", FileUse::Read, "a file of probes"},
    {"MODEL", FileUse::Read, "the camera model"},
    {"CALIBRATION", FileUse::Read, "the calibration"},
    {"IMAGE", FileUse::Read, "a picture that is looked at"},
    {"RESULTS", FileUse::Read, "the folder of the results"},
    {"PLACE", FileUse::Read, "the list of places"},
    {"PADS", FileUse::Read, "the file of pads"},
    {"ALIGNMENT", FileUse::Read, "the alignment"},
    {"--align", FileUse::Read, "the alignment"},
    {"-m,--machine", FileUse::Machine, ""},
    {"-l,--ledger", FileUse::Ledger, "the ledger"},
    {"--against", FileUse::Pictures, "the files of --against"},
    {"--camera", FileUse::Camera, "the pictures of --camera"},
    {"--certificate", FileUse::Read, "the certificate"},
    {"--images", FileUse::Pictures, "the pictures of --images"},
    {"--key", FileUse::Read, "the key of the certificate"},
    {"--measurements", FileUse::Read, "the file of --measurements"},
    {"--plate", FileUse::Read, "the file of --plate"},
    {"--probes", FileUse::Read, "the file of --probes"},
    {"--store", FileUse::Read, "the database of --store"},
    {"--surface", FileUse::Read, "the file of --surface"},
    {"--sweep", FileUse::Read, "the file of --sweep"},
    {"--truth", FileUse::Read, "the file of --truth"},
    {"--voids-of", FileUse::Read, "a program of --voids-of"},
    {"--zones", FileUse::Read, "the file of --zones"},
    {"-o,--output", FileUse::Output, ""},
    {"--json", FileUse::Output, ""},
    {"--jobs", FileUse::OutputFolder, ""},
    {"--linuxcnc", FileUse::OutputFolder, ""},
    {"--overlay", FileUse::OutputFolder, ""},
    {"--metrics", FileUse::Output, ""},
    {"--report", FileUse::Output, ""},
    {"--save-measurements", FileUse::Output, ""},
    {"--save-probes", FileUse::Output, ""},
    {"--token-file", FileUse::Output, ""},
});

/// "-m,--machine", as registered; of arguments, their word.
std::string registered_name(const CLI::Option& option) {
  return option.get_positional() ? option.get_name(true) : option.get_name(false, true);
}

const Row* file_row_of(const CLI::Option& option) {
  const auto row = std::ranges::find(kFileOptions, registered_name(option), &Row::option);
  const bool is_flag = option.get_items_expected_max() == 0;
  return is_flag || row == kFileOptions.end() ? nullptr : &*row;
}

/// synth makes a folder of pictures, batch one of results.
FileUse use_by(const CLI::App& command, FileUse use) {
  if (use != FileUse::Output) return use;
  if (command.get_name() == "synth") return FileUse::SynthFolder;
  return command.get_name() == "batch" ? FileUse::OutputFolder : use;
}

void add_options(const CLI::App& app, std::vector<FileOption>& files) {
  for (const CLI::Option* const option : app.get_options()) {
    const Row* const row = file_row_of(*option);
    if (row == nullptr) continue;
    for (const std::string& path : option->results()) {
      files.push_back({use_by(app, row->use), path, std::string(row->what)});
    }
  }
  for (const CLI::App* const below : app.get_subcommands([](const CLI::App*) { return true; })) {
    // Groups of options have no name.
    if (below->get_name().empty() || below->parsed()) add_options(*below, files);
  }
}

}  // namespace

std::vector<FileOption> file_options(const CLI::App& app) {
  std::vector<FileOption> files;
  add_options(app, files);
  return files;
}

bool names_file(const CLI::Option& option) {
  return file_row_of(option) != nullptr;
}

}  // namespace panelcal
