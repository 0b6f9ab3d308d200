// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace panelcal {

/// Purpose of an option's file.
enum class FileUse : std::uint8_t {
  Read,
  Machine,   ///< machine.toml, with all the files that it names
  Ledger,    ///< with its lock and journal
  Camera,    ///< a camera's address
  Pictures,  ///< a folder
  Output,
  OutputFolder,  ///< or a file: the command knows
  SynthFolder,   ///< of pictures
};

/// A file that the command line names.
struct FileOption {
  FileUse use = FileUse::Read;
  std::string path;
  std::string what;  ///< of inputs, in the sentence "FILE is ..."
};

/// The files that a parsed command line names, in the order of its options' registration.
///
/// One table says which option names a file and for what. An option that it lacks names none:
/// tests/tools/output_files_test.py tries every option that takes a text.
std::vector<FileOption> file_options(const CLI::App& app);

/// True if the option's value is a file or a folder.
bool names_file(const CLI::Option& option);

}  // namespace panelcal
