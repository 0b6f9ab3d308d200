// SPDX-License-Identifier: Apache-2.0
#include "program/sieb_meyer/sections/subprograms.h"

#include <algorithm>
#include <array>
#include <set>
#include <system_error>
#include <utility>

#include "program/text/gaps.h"

namespace panelcal::sieb_meyer {
namespace {

bool is_subprogram_file(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  return extension == ".SS5" || extension == ".ss5";
}

/// All files of a folder that may hold subprograms, in alphabetical order.
std::vector<std::filesystem::path> subprogram_files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> files;
  std::error_code error;
  for (std::filesystem::directory_iterator it(folder.empty() ? "." : folder, error), end;
       !error && it != end;
       it.increment(error)) {
    std::error_code ignored;
    if (!is_subprogram_file(it->path()) || !it->is_regular_file(ignored)) continue;
    files.push_back(folder / it->path().filename());
  }
  std::ranges::sort(files);
  return files;
}

using FilesRead = std::set<std::filesystem::path>;

std::optional<SourceText> read_if_it_has(const std::filesystem::path& path,
                                         std::string_view name,
                                         FilesRead& files_read) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) return std::nullopt;
  files_read.insert(path);
  auto text = read_source_with_digest(path);
  if (!text || !find_subprogram(text->bytes, name)) return std::nullopt;
  return *std::move(text);
}

std::optional<SourceText> read_subprogram(const std::string& name,
                                          const std::vector<std::filesystem::path>& folders,
                                          FilesRead& files_read) {
  constexpr std::array<std::string_view, 3> kExtensions = {".SS5", ".ss5", ""};
  for (const std::filesystem::path& folder : folders) {
    for (const std::string_view extension : kExtensions) {
      auto text = read_if_it_has(folder / (name + std::string(extension)), name, files_read);
      if (text) return text;
    }
    for (const std::filesystem::path& path : subprogram_files(folder)) {
      if (auto text = read_if_it_has(path, name, files_read)) return text;
    }
  }
  return std::nullopt;
}

struct CalledName {
  std::string_view name;
  std::size_t offset = 0;  ///< of its M99
};

/// The names behind M99, in order of appearance.
std::vector<CalledName> called_names(std::string_view bytes) {
  constexpr std::string_view kCall = "M99";
  std::vector<CalledName> names;
  for (auto at = bytes.find(kCall); at != std::string_view::npos; at = bytes.find(kCall, at)) {
    const std::size_t offset = at;
    at += kCall.size();
    std::string_view rest = bytes.substr(at, bytes.find_first_of("\r\n", at) - at);
    rest = trimmed(rest);
    if (rest.empty() || rest.front() != ',') continue;
    const std::string_view name = trimmed(rest.substr(1));
    if (is_subprogram_name(name)) names.push_back({name, offset});
  }
  return names;
}

}  // namespace

bool is_subprogram_name(std::string_view name) {
  constexpr std::string_view kOthers = "-_.+#$%&";
  return !name.empty() && name.size() <= 128 && name.front() != '.' &&
         std::ranges::all_of(name, [&](char c) {
           return (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                  kOthers.find(c) != kOthers.npos;
         });
}

std::optional<SubprogramText> find_subprogram(std::string_view bytes, std::string_view name) {
  LineCursor cursor(bytes);
  std::optional<SubprogramText> found;
  while (!cursor.at_end()) {
    const std::size_t offset = cursor.offset();
    const std::string_view text = trimmed(cursor.next().text);
    if (text.empty() || (text.front() != '@' && text.front() != '$')) continue;
    if (found) {
      found->end = offset;
      return found;
    }
    if (text.front() == '@' && trimmed(text.substr(1)) == name) {
      found = SubprogramText{cursor.place(), bytes.size()};
    }
  }
  return found;
}

std::optional<std::size_t> find_call(std::string_view bytes, std::string_view name) {
  const std::vector<CalledName> calls = called_names(bytes);
  const auto found = std::ranges::find(calls, name, &CalledName::name);
  return found == calls.end() ? std::nullopt : std::optional(found->offset);
}

bool is_cut_off(std::string_view bytes, const SubprogramText& body) {
  return body.end == bytes.size() && !ends_in_line_end(bytes);
}

namespace {

using Subprograms = std::map<std::string, SourceText, std::less<>>;

Subprograms read_all_subprograms(std::string_view program,
                                 const std::vector<std::filesystem::path>& folders,
                                 FilesRead& files_read) {
  constexpr std::size_t kMostSubprograms = 1000;
  Subprograms found;
  std::vector<std::string> wanted;
  for (const CalledName& called : called_names(program)) wanted.emplace_back(called.name);
  std::set<std::string> tried;
  for (std::size_t i = 0; i < wanted.size() && found.size() < kMostSubprograms; ++i) {
    if (!tried.insert(wanted[i]).second) continue;
    auto text = read_subprogram(wanted[i], folders, files_read);
    if (!text) continue;
    const auto body = find_subprogram(text->bytes, wanted[i]);
    const std::string_view lines =
        std::string_view(text->bytes).substr(body->begin.offset, body->end - body->begin.offset);
    for (const CalledName& called : called_names(lines)) wanted.emplace_back(called.name);
    found.emplace(wanted[i], *std::move(text));
  }
  return found;
}

}  // namespace

std::map<std::string, SourceText, std::less<>> read_subprograms(
    std::string_view program, const std::vector<std::filesystem::path>& folders) {
  FilesRead files_read;
  return read_all_subprograms(program, folders, files_read);
}

std::vector<std::filesystem::path> files_read_for_subprograms(
    std::string_view program, const std::vector<std::filesystem::path>& folders) {
  FilesRead files_read;
  read_all_subprograms(program, folders, files_read);
  return {files_read.begin(), files_read.end()};
}

}  // namespace panelcal::sieb_meyer
