// SPDX-License-Identifier: Apache-2.0
#include "machine/files/file_register.h"

#include <algorithm>
#include <system_error>
#include <utility>

#include <sys/stat.h>

namespace panelcal {

namespace fs = std::filesystem;

std::optional<FileRegister::Identity> FileRegister::identity_of(const fs::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return std::nullopt;
  return Identity{status.st_dev, status.st_ino};
}

FileRegister::Entry FileRegister::entry_of(const fs::path& file, std::string what) {
  std::error_code error;
  const fs::path named = fs::absolute(file == "-" ? fs::path("/dev/stdin") : file, error);
  Entry entry{fs::weakly_canonical(named, error), identity_of(named), std::move(what)};
  if (error) entry.place = named.lexically_normal();
  // "images/" is "images".
  if (!entry.place.has_filename()) entry.place = entry.place.parent_path();
  return entry;
}

bool FileRegister::holds(const Entry& folder, const Entry& file) {
  for (fs::path above = file.place.parent_path();; above = above.parent_path()) {
    if (above == folder.place || (folder.identity && identity_of(above) == folder.identity)) {
      return true;
    }
    if (above == above.parent_path()) break;
  }
  if (!file.identity) return false;
  // Another name of a file that lies there: a hard link to it, or what a link there leads to.
  std::error_code error;
  for (fs::recursive_directory_iterator at(folder.place, error), end; !error && at != end;
       at.increment(error)) {
    if (identity_of(at->path()) == file.identity) return true;
  }
  return false;
}

void FileRegister::add(const fs::path& file, std::string what) {
  files_.push_back(entry_of(file, std::move(what)));
}

void FileRegister::add_folder(const fs::path& folder, std::string what) {
  folders_.push_back(entry_of(folder, std::move(what)));
}

std::optional<std::string> FileRegister::use_of(const fs::path& output) const {
  const Entry asked = entry_of(output, "");
  const auto is_asked = [&](const Entry& entry) {
    return entry.place == asked.place || (entry.identity && entry.identity == asked.identity);
  };
  if (const auto file = std::ranges::find_if(files_, is_asked); file != files_.end()) {
    return file->what;
  }
  const auto is_around = [&](const Entry& entry) { return is_asked(entry) || holds(entry, asked); };
  if (const auto folder = std::ranges::find_if(folders_, is_around); folder != folders_.end()) {
    return "in " + folder->what;
  }
  return std::nullopt;
}

}  // namespace panelcal
