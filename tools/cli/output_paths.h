// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "calib/base/expected.h"
#include "machine/files/file_register.h"
#include "program/walk/program.h"
#include "tools/cli/options/options.h"

namespace panelcal {

/// Of a file's name, in small letters: formats belong to ".SVG" as to ".svg".
std::string extension_of(const std::filesystem::path& path);

/// Fails  usage, of `command` such as "panelcal plan": no `extension` at a name that is not empty
Expected<void> check_extension(const std::string& command,
                               const std::string& name,
                               std::string_view extension);

/// The inputs of a command line, and the files that its machine.toml names but those that
/// `--install` puts in force.
FileRegister files_in_use(const Options& options);

/// No output may replace a file in use or another output, or stand in a folder of pictures that is
/// not synth's own; `-` is standard output, which only one may have.
///
/// Fails  output-in-use, in the name of the command
/// See    tests/tools/output_files_test.py
Expected<void> check_outputs(const Options& options, const FileRegister& files);

/// The same of a file that the command line names by its folder only.
Expected<void> check_output(const Options& options,
                            const FileRegister& files,
                            const std::filesystem::path& output);

/// Notes the files that only the program names: stored patterns, subprograms, and nc_param.txt
/// beside it.
///
/// Out    false if there are none
bool add_pattern_files(const Program& program, FileRegister& files);

/// The same once a program is read: the stored patterns that it names are files in use too, and so
/// is nc_param.txt beside it.
Expected<void> check_patterns(const Options& options, const Program& program, FileRegister& files);

}  // namespace panelcal
