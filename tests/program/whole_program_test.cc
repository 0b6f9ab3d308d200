// SPDX-License-Identifier: Apache-2.0
// A program is whole or it is not executed: wherever a file is cut off, it is refused, or loses
// nothing but what follows its end. With --accept-unterminated it may lose its last lines.
#include <algorithm>
#include <cctype>
#include <filesystem>
#include <iostream>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "calib/base/files/atomic_file.h"
#include <gtest/gtest.h>

#include "tests/fuzz/sieb_meyer_entry.h"
#include "tests/program/prefix_trial.h"
#include "tests/support/folders.h"

namespace panelcal {
namespace {

using test::PrefixTrial;
using test::WholeFile;
namespace fs = std::filesystem;

const fs::path kSources = test::source_folder();
/// Enough for every byte of what is written by hand.
constexpr std::size_t kMostPrefixes = 300;

std::vector<fs::path> files_below(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  std::ranges::sort(files);
  return files;
}

bool is_program_name(std::string_view name) {
  constexpr std::string_view kExtensions[] = {".exc", ".drl", ".s5", ".sm5"};
  return std::ranges::any_of(kExtensions, [&](auto end) { return name.ends_with(end); });
}

std::string bytes_of(const fs::path& path) {
  auto bytes = read_file(path);
  EXPECT_TRUE(bytes) << path;
  return bytes ? *std::move(bytes) : "";
}

/// The bytes of an escaped section (tests/golden/README.md).
std::string unescaped(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '\\') {
      out += text[i];
      continue;
    }
    const char c = text[++i];
    if (c == 'r') out += '\r';
    if (c == '\\') out += '\\';
    if (c == 'x') {
      out += static_cast<char>(std::stoi(std::string(text.substr(i + 1, 2)), nullptr, 16));
      i += 2;
    }
  }
  return out;
}

struct NamedText {
  std::string name;
  std::string bytes;
};

/// The `--- in NAME ---` sections of a golden case.
std::vector<NamedText> inputs_of(std::string_view text) {
  std::vector<NamedText> inputs;
  LineCursor cursor(text);
  std::string name;
  std::size_t begin = 0;
  const auto close = [&](std::size_t end) {
    if (name.empty()) return;
    const std::string_view section = text.substr(begin, end - begin);
    const std::size_t escaped = name.find(", escaped");
    inputs.push_back({name.substr(0, escaped),
                      escaped == name.npos ? std::string(section) : unescaped(section)});
  };
  while (!cursor.at_end()) {
    const std::size_t at = cursor.offset();
    const std::string_view line = cursor.next().text;
    if (!line.starts_with("--- ") || !line.ends_with(" ---")) continue;
    close(at);
    const std::string_view title = line.substr(4, line.size() - 8);
    name = title.starts_with("in ") ? std::string(title.substr(3)) : "";
    begin = cursor.offset();
  }
  close(text.size());
  return inputs;
}

/// The programs of a case, each with the other inputs as patterns that it may call.
std::vector<WholeFile> programs_of_case(const fs::path& path) {
  std::vector<WholeFile> programs;
  const std::vector<NamedText> inputs = inputs_of(bytes_of(path));
  std::map<std::string, SourceText, std::less<>> patterns;
  for (const NamedText& input : inputs) {
    patterns.emplace(input.name, SourceText{input.name, input.bytes});
    if (input.name.ends_with(".SS5")) patterns.merge(fuzz::subprograms_of(input.bytes));
  }
  for (const NamedText& input : inputs) {
    if (!is_program_name(input.name)) continue;
    programs.push_back({{path.stem().string() + "/" + input.name, input.bytes}, patterns});
  }
  return programs;
}

/// Tells the figures too, since a trial of nothing would pass.
void expect_whole_or_refused(const std::vector<WholeFile>& files) {
  PrefixTrial trial;
  std::set<std::string_view> seen;
  for (const WholeFile& file : files) {
    if (seen.insert(file.source.bytes).second) test::try_prefixes(file, kMostPrefixes, trial);
  }
  std::cout << trial.n_files << " files, " << trial.n_whole << " of them whole; "
            << trial.n_prefixes << " prefixes, " << trial.n_as_whole << " with the whole job, "
            << trial.n_accepted << " accepted with the option\n";
  EXPECT_GT(trial.n_whole, 0U);
  EXPECT_GT(trial.n_prefixes, 50 * trial.n_files);
  for (const std::string& complaint : trial.complaints) ADD_FAILURE() << complaint;
}

TEST(WholeProgram, OfEveryGoldenCaseIsWholeOrRefused) {
  std::vector<WholeFile> files;
  for (const fs::path& path : files_below(kSources / "tests" / "golden")) {
    if (path.extension() == ".case") {
      for (WholeFile& file : programs_of_case(path)) files.push_back(std::move(file));
    } else if (is_program_name(path.filename().string())) {
      files.push_back({{path.filename().string(), bytes_of(path)}, {}});
    }
  }
  EXPECT_GT(files.size(), 200U);
  expect_whole_or_refused(files);
}

TEST(WholeProgram, OfTheManualsAndTheDemoIsWholeOrRefused) {
  std::vector<WholeFile> files;
  const std::map<std::string, SourceText, std::less<>> patterns = {
      {"LOGO", {"LOGO", bytes_of(kSources / "tests/program/data/LOGO")}}};
  for (const char* folder : {"tests/program/data", "tests/fuzz/corpus", "datasets/demo"}) {
    for (const fs::path& path : files_below(kSources / folder)) {
      const std::string name = path.filename().string();
      if (!is_program_name(name)) continue;
      std::string bytes = bytes_of(path);
      if (name.ends_with(".sm5")) {  // subprograms follow, in the fuzzers' files only
        bytes = fuzz::split_input(bytes).program;
      }
      files.push_back({{name, std::move(bytes)}, patterns});
    }
  }
  EXPECT_GT(files.size(), 50U);
  expect_whole_or_refused(files);
}

}  // namespace
}  // namespace panelcal
